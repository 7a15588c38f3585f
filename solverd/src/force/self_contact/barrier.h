// The energy that keeps surfaces apart: the clamped logarithmic barrier of Li et al. (2020, "Incremental Potential
// Contact", eq. 6), of the distance itself as in Li et al. (2023, "Convergent Incremental Potential Contact"). Per area
//   b(d) = -k D (d/D - 1)^2 ln(d/D) for 0 < d < D, else 0,
// D the distance from which on it acts, k a pressure: surfaces at half of D press on each other with 1.19 k, at 0.8 D
// with 0.14 k, at 0.1 D with 12 k. It is twice continuously differentiable.
#pragma once
#include <Eigen/Geometry>
#include <cmath>

#include "lattice/surface.h"

namespace lappet {

struct BarrierValue {
  double energy = 0.0;     // kPa mm
  double slope = 0.0;      // to the distance, kPa: minus the pressure
  double curvature = 0.0;  // kPa/mm, not negative
};

// distance > 0; reach: D, mm; stiffness: k, kPa.
inline BarrierValue barrier(double distance, double reach, double stiffness) {
  const double x = distance / reach;
  if (!(x < 1.0)) return {};
  const double log = std::log(x), off = x - 1.0;
  return {-stiffness * reach * off * off * log, -stiffness * (2.0 * off * log + off * off / x),
          -stiffness / reach * (2.0 * log + 4.0 * off / x - off * off / (x * x))};
}

// Takes the barrier of two edges to zero where they become parallel, as their distance has no gradient there (Li et al.
// 2020, sec. 5.1): m = (2 - c/e) c/e for c < e, c the squared norm of their cross product, e a thousandth of the
// product of their squared lengths at rest.
struct ParallelMollifier {
  static constexpr double kShare = 1e-3;
  double value = 1.0;
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();  // gradients to the two edges as vectors

  ParallelMollifier(const Vec3& edge, const Vec3& other, double squared_lengths_at_rest) {
    const Vec3 normal = edge.cross(other);
    const double least = kShare * squared_lengths_at_rest, share = normal.squaredNorm() / least;
    if (!(share < 1.0)) return;
    value = (2.0 - share) * share;
    const double slope = (2.0 - 2.0 * share) / least;
    first = 2.0 * slope * other.cross(normal);
    second = 2.0 * slope * normal.cross(edge);
  }
};

}  // namespace lappet
