// Quadrature on the trilinear unit cell: one point with stabilization (McAdams et al. 2011), four points (Patterson et
// al. 2012) or the eight Gauss points.
//
// Corner c sits at (c>>2 & 1, c>>1 & 1, c & 1). With one point the Laplacian part of the energy is integrated exactly:
// what the point misses is a sum over the four hourglass modes h_k, integral of |grad|^2 = sum_k kHourglass[k] (h_k .
// x)^2.
#pragma once
#include <array>
#include <cmath>
#include <vector>

namespace lappet {

struct QuadraturePoint {
  std::array<double, 24> gradient;  // row-major 3x8: dN_c/dX_j on the unit cell
  std::array<double, 3> position;   // in the unit cell
  double weight;                    // of the unit volume
};

inline constexpr std::array<std::array<int, 8>, 4> kHourglassModes = {{
    {1, 1, -1, -1, -1, -1, 1, 1},  // xy
    {1, -1, 1, -1, -1, 1, -1, 1},  // xz
    {1, -1, -1, 1, 1, -1, -1, 1},  // yz
    {-1, 1, 1, -1, 1, -1, -1, 1},  // xyz
}};
inline constexpr std::array<double, 4> kHourglass = {1.0 / 24, 1.0 / 24, 1.0 / 24, 1.0 / 48};

inline QuadraturePoint quadrature_point(double x, double y, double z, double weight) {
  QuadraturePoint point{};
  point.position = {x, y, z};
  point.weight = weight;
  for (int c = 0; c < 8; ++c) {
    const double sx = (c >> 2 & 1) ? 1 : -1, sy = (c >> 1 & 1) ? 1 : -1, sz = (c & 1) ? 1 : -1;
    const double fx = sx > 0 ? x : 1 - x, fy = sy > 0 ? y : 1 - y, fz = sz > 0 ? z : 1 - z;
    point.gradient[c] = sx * fy * fz;
    point.gradient[8 + c] = fx * sy * fz;
    point.gradient[16 + c] = fx * fy * sz;
  }
  return point;
}

// count: 1, 4 or 8.
inline std::vector<QuadraturePoint> quadrature_points(int count) {
  std::vector<QuadraturePoint> points;
  if (count == 1) {
    points.push_back(quadrature_point(0.5, 0.5, 0.5, 1.0));
  } else {
    const double a = std::sqrt(3.0) / 6;
    for (int c = 0; c < 8; ++c) {
      const int x = c >> 2 & 1, y = c >> 1 & 1, z = c & 1;
      if (count == 4 && (x ^ y ^ z) == 0) continue;  // every other Gauss point: a tetrahedron, exact for quadratics
      points.push_back(quadrature_point(0.5 + (x ? a : -a), 0.5 + (y ? a : -a), 0.5 + (z ? a : -a), 1.0 / count));
    }
  }
  return points;
}

}  // namespace lappet
