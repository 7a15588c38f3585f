// The triangle of a skin that is closest to a point.
#pragma once
#include <Eigen/Core>
#include <unsupported/Eigen/BVH>
#include <vector>

#include "lattice/surface.h"

namespace lappet {

// Of equally close triangles that with the smallest index. Keeps a reference to the skin, which must have triangles.
class SkinTree {
 public:
  struct Closest {
    Index triangle;
    double distance;
    Vec3 weights;  // of its corners at the closest point
  };
  explicit SkinTree(const Surface& skin);
  Closest closest(const Vec3& point) const;
  // The value at the closest point of what the skin's points have.
  Vec3 interpolate(const Closest& at, const std::vector<Vec3>& of_points) const;
  const Surface& skin() const { return skin_; }

 private:
  const Surface& skin_;
  Eigen::KdBVH<double, 3, Index> tree_;
};

}  // namespace lappet
