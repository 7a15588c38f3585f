// Ties: hooks and sutures as linear functionals of the displacements, c(u) = sum_i w_i u_i + offset (mm).
//
// A hook is a spring, stiffness/2 |c|^2. A suture demands c = 0 and carries a multiplier lambda besides (augmented
// Lagrangian, lambda . c + stiffness/2 |c|^2), so that its gap closes whatever the ratio of stiffnesses.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/lattice.h"

namespace lappet {

struct Tie {
  std::vector<std::int32_t> nodes;  // distinct
  std::vector<double> weights;
  Vec3 offset = Vec3::Zero();
  double stiffness = 0.0;          // mN/mm
  bool exact = false;              // a suture
  Vec3 multiplier = Vec3::Zero();  // mN

  template <class Real>
  Vec3 value(std::span<const Real> u) const {
    Vec3 sum = offset;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto n = 3 * static_cast<std::size_t>(nodes[i]);
      sum += weights[i] * Vec3(static_cast<double>(u[n]), static_cast<double>(u[n + 1]), static_cast<double>(u[n + 2]));
    }
    return sum;
  }
  Vec3 force(const Vec3& c) const { return stiffness * c + multiplier; }
};

// From an embedded point to a place in space.
Tie make_hook(const Lattice& lattice, const EmbeddedPoint& anchor, const Vec3& target, double stiffness);
// Between two embedded points, a - b = separation.
Tie make_suture(const Lattice& lattice, const EmbeddedPoint& a, const EmbeddedPoint& b, const Vec3& separation,
                double stiffness, const Vec3& multiplier);
// Where an embedded point is.
template <class Real>
Vec3 displacement(const Lattice& lattice, const EmbeddedPoint& point, std::span<const Real> u) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 8; ++k) {
    const auto n = static_cast<std::size_t>(lattice.cell_nodes[static_cast<std::size_t>(point.cell)][k]);
    sum += point.weights[k] *
           Vec3(static_cast<double>(u[3 * n]), static_cast<double>(u[3 * n + 1]), static_cast<double>(u[3 * n + 2]));
  }
  return sum;
}
template <class Real>
Vec3 position(const Lattice& lattice, const EmbeddedPoint& point, std::span<const Real> u) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 8; ++k) {
    const auto n = static_cast<std::size_t>(lattice.cell_nodes[static_cast<std::size_t>(point.cell)][k]);
    sum += point.weights[k] *
           (lattice.node_rest[n] +
            Vec3(static_cast<double>(u[3 * n]), static_cast<double>(u[3 * n + 1]), static_cast<double>(u[3 * n + 2])));
  }
  return sum;
}

}  // namespace lappet
