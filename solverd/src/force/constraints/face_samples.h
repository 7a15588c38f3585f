// Faces of the surface as samples: the middles of small triangles of equal area.
#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "force/constraints/face_pieces.h"
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

// A triangle of the surface, with samples at most 0.4 spacings apart.
class SampledFace {
 public:
  SampledFace(const Surface& surface, Index triangle, double spacing) : edge_(kSampleEdge * spacing) {
    for (std::size_t k = 0; k < 3; ++k) at_[k] = surface.points[surface.triangles[triangle][k]];
    cross_ = (at_[1] - at_[0]).cross(at_[2] - at_[0]);
    has_area_ = 0.5 * cross_.norm() >= 1e-12 * spacing * spacing;
  }

  bool has_area() const { return has_area_; }
  Vec3 normal() const { return cross_.normalized(); }
  // Calls begin(area) for each piece of the face, mm^2 of each of its samples, and then add(point) for these.
  template <class Begin, class Add>
  void for_each(const Begin& begin, const Add& add) const {
    for_each_piece(at_, edge_, [&](const FacePiece& piece) {
      const int n = piece.n;
      const Vec3 first = piece.at[0], along = piece.at[1] - first, across = piece.at[2] - first;
      begin(piece.area() / (1.0 * n * n));
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < 2 * (n - i) - 1; ++j) {  // the upright and inverted triangles of row i
          const bool inverted = j % 2 == 1;
          const double s = (j / 2 + (inverted ? 2.0 / 3 : 1.0 / 3)) / n, r = (i + (inverted ? 2.0 / 3 : 1.0 / 3)) / n;
          add(first + s * along + r * across);
        }
    });
  }

 private:
  static constexpr double kSampleEdge = 0.4;  // spacings
  std::array<Vec3, 3> at_;
  Vec3 cross_;
  double edge_;
  bool has_area_ = false;
};

}  // namespace lappet
