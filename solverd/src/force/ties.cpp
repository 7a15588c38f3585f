#include "force/ties.h"

#include <algorithm>
#include <cmath>

namespace lappet {

namespace {

void add_point(const Lattice& lattice, const EmbeddedPoint& point, double sign, Tie& tie) {
  for (std::size_t k = 0; k < 8; ++k) {
    if (std::abs(point.weights[k]) < 1e-9) continue;
    const std::int32_t node = lattice.cell_nodes[static_cast<std::size_t>(point.cell)][k];
    tie.offset += sign * point.weights[k] * lattice.node_rest[static_cast<std::size_t>(node)];
    const auto found = std::find(tie.nodes.begin(), tie.nodes.end(), node);
    if (found == tie.nodes.end()) {
      tie.nodes.push_back(node);
      tie.weights.push_back(sign * point.weights[k]);
    } else {
      tie.weights[static_cast<std::size_t>(found - tie.nodes.begin())] += sign * point.weights[k];
    }
  }
}

}  // namespace

Tie make_hook(const Lattice& lattice, const EmbeddedPoint& anchor, const Vec3& target, double stiffness) {
  Tie tie;
  tie.stiffness = stiffness;
  tie.offset = -target;
  add_point(lattice, anchor, 1.0, tie);
  return tie;
}

Tie make_suture(const Lattice& lattice, const EmbeddedPoint& a, const EmbeddedPoint& b, const Vec3& separation,
                double stiffness, const Vec3& multiplier) {
  Tie tie;
  tie.stiffness = stiffness;
  tie.exact = true;
  tie.multiplier = multiplier;
  tie.offset = -separation;
  add_point(lattice, a, 1.0, tie);
  add_point(lattice, b, -1.0, tie);
  return tie;
}

}  // namespace lappet
