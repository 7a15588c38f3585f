#include "session/bone_bodies.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/rigid_motion.h"

namespace lappet {

namespace {

// How far a bone moves in a load step, in spacings: what it meets is pushed out on the side that it comes from.
constexpr double kMaxBoneStep = 0.25;
constexpr double kMaxBoneSteps = 1024.0;

Eigen::Matrix4d motion_of(std::span<const Eigen::Matrix4d> motions, std::size_t body) {
  return body < motions.size() ? motions[body] : Eigen::Matrix4d(Eigen::Matrix4d::Identity());
}

}  // namespace

std::vector<Surface> bone_bodies(const SessionSettings& settings) {
  if (settings.bone_bodies.empty()) return {settings.bones};
  std::vector<Surface> bodies(static_cast<std::size_t>(settings.moving_bones()));
  for (std::size_t t = 0; t < settings.bones.triangles.size(); ++t)
    bodies[static_cast<std::size_t>(settings.bone_bodies[t])].triangles.push_back(settings.bones.triangles[t]);
  // Of the points each gets those that it uses, in the order in which it does.
  std::vector<std::pair<std::size_t, Index>> known(settings.bones.points.size());  // by body (from 1 on), the place
  for (std::size_t body = 0; body < bodies.size(); ++body)
    for (auto& triangle : bodies[body].triangles)
      for (Index& p : triangle) {
        auto& [of, place] = known[p];
        if (of != body + 1) {
          of = body + 1;
          place = to_index(bodies[body].points.size());
          bodies[body].points.push_back(settings.bones.points[p]);
        }
        p = place;
      }
  return bodies;
}

BoneWay::BoneWay(const SessionSettings& settings) : spacing_(settings.spacing) {
  if (settings.bone_bodies.empty()) return;
  for (const Surface& body : bone_bodies(settings)) boxes_.push_back(box_around(body));
}

int BoneWay::steps(std::span<const Eigen::Matrix4d> from, std::span<const Eigen::Matrix4d> to) const {
  double farthest = 0.0;
  for (std::size_t k = 0; k < boxes_.size(); ++k) {
    const Eigen::Matrix4d difference = motion_of(to, k) - motion_of(from, k);
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 point = boxes_[k].corner(static_cast<Box3::CornerType>(corner));
      farthest = std::max(farthest, (difference * point.homogeneous()).head<3>().norm());
    }
  }
  const double steps = std::ceil(farthest / (kMaxBoneStep * spacing_) - 1e-9);
  return static_cast<int>(std::clamp(steps, 1.0, kMaxBoneSteps));
}

std::vector<Eigen::Matrix4d> BoneWay::at(std::span<const Eigen::Matrix4d> from, std::span<const Eigen::Matrix4d> to,
                                         double fraction) const {
  std::vector<Eigen::Matrix4d> result;
  if (from.empty() && to.empty()) return result;
  for (std::size_t k = 0; k < boxes_.size(); ++k)
    result.push_back(between_motions(motion_of(from, k), motion_of(to, k), fraction, boxes_[k].center()));
  return result;
}

}  // namespace lappet
