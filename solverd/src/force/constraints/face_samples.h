// Faces of the surface as samples: the middles of small triangles of equal area.
#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "lattice/lattice.h"

namespace lappet {

inline constexpr int kNoSide = 6;

// The side of its cell (0 to 5) that a point of a face lies on and the face with it; kNoSide: none.
inline int lattice_side(const EmbeddedPoint& point, const Vec3& normal) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(normal[axis]) < 1 - 1e-6) continue;
    double local = 0.0;
    for (int c = 0; c < 8; ++c)
      if (c >> (2 - axis) & 1) local += point.weights[static_cast<std::size_t>(c)];
    if (std::abs(local) < 1e-5) return 2 * axis;
    if (std::abs(local - 1.0) < 1e-5) return 2 * axis + 1;
  }
  return kNoSide;
}

// A triangle of the surface, with samples 0.4 spacings apart.
class SampledFace {
 public:
  SampledFace(const Surface& surface, Index triangle, double spacing)
      : a_(surface.points[surface.triangles[triangle][0]]),
        ab_(surface.points[surface.triangles[triangle][1]] - a_),
        ac_(surface.points[surface.triangles[triangle][2]] - a_) {
    const double longest = std::max({ab_.norm(), ac_.norm(), (ac_ - ab_).norm()});
    rows_ = std::max(1, int(std::ceil(longest / (0.4 * spacing))));
    const double area = 0.5 * ab_.cross(ac_).norm();
    has_area_ = area >= 1e-12 * spacing * spacing;
    sample_area_ = area / (rows_ * rows_);
  }

  bool has_area() const { return has_area_; }
  double sample_area() const { return sample_area_; }  // mm^2
  Vec3 normal() const { return ab_.cross(ac_).normalized(); }
  // Calls add(point) for each sample.
  template <class Add>
  void for_each(const Add& add) const {
    for (int i = 0; i < rows_; ++i)
      for (int j = 0; j < 2 * (rows_ - i) - 1; ++j) {  // the upright and inverted triangles of row i
        const bool inverted = j % 2 == 1;
        const double s = (j / 2 + (inverted ? 2.0 / 3 : 1.0 / 3)) / rows_;
        const double r = (i + (inverted ? 2.0 / 3 : 1.0 / 3)) / rows_;
        add(a_ + s * ab_ + r * ac_);
      }
  }

 private:
  Vec3 a_, ab_, ac_;
  int rows_ = 1;
  bool has_area_ = false;
  double sample_area_ = 0.0;
};

}  // namespace lappet
