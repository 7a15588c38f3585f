#include "force/constraints/bone_distance.h"

#include <utility>

namespace lappet {

BoneDistance::BoneDistance(std::vector<std::shared_ptr<const SignedDistance>> bones)
    : bones_(std::move(bones)), placed_(bones_.size()) {}

void BoneDistance::place(std::span<const Eigen::Matrix4d> motions) {
  placed_.assign(bones_.size(), {});
  for (std::size_t k = 0; k < motions.size(); ++k) {
    if (motions[k].isIdentity(0.0)) continue;
    placed_[k] = {true, motions[k].topLeftCorner<3, 3>(), motions[k].topRightCorner<3, 1>()};
  }
}

SignedDistance::Sample BoneDistance::at(const Vec3& point) const {
  SignedDistance::Sample nearest{};
  for (std::size_t k = 0; k < bones_.size(); ++k) {
    const Placed& bone = placed_[k];
    SignedDistance::Sample sample =
        bones_[k]->at(bone.moved ? Vec3(bone.turn.transpose() * (point - bone.offset)) : point);
    if (k > 0 && !(sample.value < nearest.value)) continue;
    if (bone.moved) sample.gradient = bone.turn * sample.gradient;
    nearest = sample;
  }
  return nearest;
}

SignedDistance::Sample BoneDistance::at_rest(const Vec3& point) const {
  SignedDistance::Sample nearest = bones_.front()->at(point);
  for (std::size_t k = 1; k < bones_.size(); ++k)
    if (const SignedDistance::Sample sample = bones_[k]->at(point); sample.value < nearest.value) nearest = sample;
  return nearest;
}

std::size_t BoneDistance::bytes() const {
  std::size_t sum = 0;
  for (const auto& bone : bones_) sum += bone->bytes();
  return sum;
}

}  // namespace lappet
