// The signed distance of rigid bones, each of which may move: that of the nearest bone, where the bones are now.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "force/constraints/signed_distance.h"

namespace lappet {

class BoneDistance {
 public:
  // At least one bone, all of one spacing; where they are at rest.
  explicit BoneDistance(std::vector<std::shared_ptr<const SignedDistance>> bones);

  // Moves the bones: rigid motions from rest (4x4, column vectors), one for each; none: all are at rest.
  void place(std::span<const Eigen::Matrix4d> motions);

  SignedDistance::Sample at(const Vec3& point) const;
  SignedDistance::Sample at_rest(const Vec3& point) const;
  double depth() const { return bones_.front()->depth(); }
  double spacing() const { return bones_.front()->spacing(); }
  std::size_t bytes() const;

 private:
  struct Placed {
    bool moved = false;
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  // from rest
    Vec3 offset = Vec3::Zero();
  };

  std::vector<std::shared_ptr<const SignedDistance>> bones_;
  std::vector<Placed> placed_;
};

}  // namespace lappet
