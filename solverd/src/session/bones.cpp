#include "session/bones.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lattice/refused.h"
#include "lattice/surface_box.h"

namespace lappet {

namespace {

// The penalty of contact, in Young's moduli per spacing; multipliers act where it is not enough.
constexpr double kContactPenalty = 10.0;
// The nodes of the bones' distance field, and how deep it knows distances, in spacings.
constexpr double kBoneSpacing = 0.5, kBoneDepth = 3.0;
// How far a bone moves in a load step, in spacings: what it meets is pushed out on the side that it comes from.
constexpr double kMaxBoneStep = 0.25;
constexpr double kMaxBoneSteps = 1024.0;
constexpr double kMaxRestPenetration = 0.5;  // in spacings

Eigen::Matrix4d motion_of(std::span<const Eigen::Matrix4d> motions, std::size_t body) {
  return body < motions.size() ? motions[body] : Eigen::Matrix4d(Eigen::Matrix4d::Identity());
}

}  // namespace

std::vector<Surface> bone_bodies(const SessionSettings& settings) {
  if (settings.bone_bodies.empty()) return {settings.bones};
  std::vector<Surface> bodies(static_cast<std::size_t>(settings.moving_bones()));
  for (Surface& body : bodies) body.points = settings.bones.points;
  for (std::size_t t = 0; t < settings.bones.triangles.size(); ++t)
    bodies[static_cast<std::size_t>(settings.bone_bodies[t])].triangles.push_back(settings.bones.triangles[t]);
  for (Surface& body : bodies) {  // of the points those that it uses
    std::vector<std::int32_t> place(body.points.size(), -1);
    std::vector<Vec3> used;
    for (auto& triangle : body.triangles)
      for (auto& p : triangle) {
        auto& own = place[static_cast<std::size_t>(p)];
        if (own < 0) own = static_cast<std::int32_t>(used.size()), used.push_back(body.points[p]);
        p = own;
      }
    body.points = std::move(used);
  }
  return bodies;
}

std::optional<BoneDistance> distance_to_bones(const SessionSettings& settings, const Interrupt& interrupt) {
  if (settings.bones.triangles.empty()) return std::nullopt;
  std::vector<std::shared_ptr<const SignedDistance>> fields;
  std::size_t left = settings.memory_budget;
  for (const Surface& body : bone_bodies(settings)) {
    fields.push_back(std::make_shared<const SignedDistance>(body, kBoneSpacing * settings.spacing,
                                                            kBoneDepth * settings.spacing, left, interrupt));
    left -= std::min(left, fields.back()->bytes());
  }
  return BoneDistance(std::move(fields));
}

int steps_of_bones(const SessionSettings& settings, std::span<const Eigen::Matrix4d> from,
                   std::span<const Eigen::Matrix4d> to) {
  if (settings.bone_bodies.empty() || (from.empty() && to.empty())) return 1;
  double farthest = 0.0;
  const std::vector<Surface> bodies = bone_bodies(settings);
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const Box3 box = box_around(bodies[k]);
    const Eigen::Matrix4d difference = motion_of(to, k) - motion_of(from, k);
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 point = box.corner(static_cast<Box3::CornerType>(corner));
      farthest = std::max(farthest, (difference * point.homogeneous()).head<3>().norm());
    }
  }
  const double steps = std::ceil(farthest / (kMaxBoneStep * settings.spacing) - 1e-9);
  return static_cast<int>(std::clamp(steps, 1.0, kMaxBoneSteps));
}

std::vector<Eigen::Matrix4d> bones_partway(const SessionSettings& settings, std::span<const Eigen::Matrix4d> from,
                                           std::span<const Eigen::Matrix4d> to, double fraction) {
  if (from.empty() && to.empty()) return {};
  std::vector<Eigen::Matrix4d> result;
  const std::vector<Surface> bodies = bone_bodies(settings);
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const Box3 box = box_around(bodies[k]);
    result.push_back(between_motions(motion_of(from, k), motion_of(to, k), fraction, box.center()));
  }
  return result;
}

std::unique_ptr<Contact> contact_with_bones(const BoneDistance& bones, const Lattice& lattice, const EpochInput& epoch,
                                            const SessionSettings& settings, const Interrupt& interrupt) {
  const double stiffness = kContactPenalty * settings.materials[0].youngs_modulus / settings.spacing;
  auto contact = std::make_unique<Contact>(bones, lattice, epoch.surface, epoch.fixed, stiffness, interrupt);
  auto [depth, where] = contact->deepest_at_rest();
  // Bone that tissue encloses touches none of its surface. The middles of full cells are tissue.
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    if (c % 4096 == 0) interrupt.check();
    if (lattice.cell_fill[c] < 1.0F) continue;
    const Vec3 middle =
        lattice.node_rest[static_cast<std::size_t>(lattice.cell_nodes[c][0])] + Vec3::Constant(0.5 * settings.spacing);
    if (const double inside = -bones.at_rest(middle).value; inside > depth) depth = inside, where = middle;
  }
  if (depth > kMaxRestPenetration * settings.spacing)
    throw RefusedError(
        ErrorCode::kInvalidInput,
        fmt::format("the tissue of epoch {} lies {}{:.3g} mm deep in bone near ({:.4g}, {:.4g}, {:.4g}) mm before "
                    "anything moves it; move the bone or the tissue apart (up to {:g} mm, half the spacing, is pushed "
                    "out)",
                    epoch.index, depth < bones.depth() * (1 - 1e-6) ? "" : "at least ", depth, where[0], where[1],
                    where[2], kMaxRestPenetration * settings.spacing));
  return contact;
}

}  // namespace lappet
