// Cuts a triangle so that sampling it evenly, with n^2 small triangles where n of them span its longest edge, costs
// what its area is worth: a long narrow one is cut across into compact pieces.
#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "lattice/surface.h"

namespace lappet {

struct FacePiece {
  std::array<Vec3, 3> at;
  std::array<int, 3> corner{0, 1, 2};  // which of the triangle's corners each of its own is; -1: none
  int n = 1;                           // small triangles along an edge

  double area() const { return 0.5 * (at[1] - at[0]).cross(at[2] - at[0]).norm(); }
  double edge(std::size_t k) const { return (at[(k + 1) % 3] - at[k]).norm(); }
  std::size_t longest_edge() const {
    const std::array<double, 3> length{edge(0), edge(1), edge(2)};
    return static_cast<std::size_t>(std::ranges::max_element(length) - length.begin());
  }
};

// Calls put(piece) for the pieces of a triangle; small triangles have edges of at most `edge`. There are at most about
// 8 area / edge^2 + 3 longest edge / edge + 64 of them.
template <class Put>
void for_each_piece(const std::array<Vec3, 3>& triangle, double edge, const Put& put) {
  constexpr double kFew = 8.0;    // along an edge: not worth a cut
  constexpr double kWaste = 8.0;  // small triangles for each edge^2 of area; where all sides are as long it takes 2.3
  constexpr double kNarrowest = 0.7;  // a square of this width has a diagonal of one edge
  const auto put_with_n = [&](FacePiece piece) {
    piece.n = std::max(1, int(std::ceil(piece.edge(piece.longest_edge()) / edge)));
    put(piece);
  };
  const FacePiece whole{triangle};
  const std::size_t longest = whole.longest_edge(), end = (longest + 1) % 3, top = (longest + 2) % 3;
  const double n = std::ceil(whole.edge(longest) / edge);
  if (n <= kFew || n * n * edge * edge <= kWaste * whole.area()) return put_with_n(whole);

  // Two right triangles at the foot of the height; each is cut into strips as wide as that is high.
  const Vec3 &from = triangle[longest], along = triangle[end] - from, &apex = triangle[top];
  const double part = std::clamp((apex - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
  const Vec3 foot = from + part * along;
  const int foot_corner = part <= 0.0 ? int(longest) : part >= 1.0 ? int(end) : -1;
  const double width = std::max((apex - foot).norm(), kNarrowest * edge);
  for (const std::size_t tip : {longest, end}) {
    if (foot_corner == int(tip)) continue;
    const Vec3 below = foot - triangle[tip], above = apex - triangle[tip];
    const int strips = std::max(1, int(std::ceil(below.norm() / width)));
    for (int k = 0; k < strips; ++k) {
      const double share = double(k) / strips, next_share = double(k + 1) / strips;
      const bool first = k == 0, last = k + 1 == strips;
      const Vec3 low = triangle[tip] + share * below, next_low = triangle[tip] + next_share * below;
      const Vec3 high = triangle[tip] + share * above,
                 next_high = last ? apex : Vec3(triangle[tip] + next_share * above);
      put_with_n({{low, next_low, next_high}, {first ? int(tip) : -1, last ? foot_corner : -1, last ? int(top) : -1}});
      if (!first) put_with_n({{low, next_high, high}, {-1, last ? int(top) : -1, -1}});
    }
  }
}

}  // namespace lappet
