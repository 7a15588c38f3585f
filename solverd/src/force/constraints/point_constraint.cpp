#include "force/constraints/point_constraint.h"

#include <algorithm>
#include <numeric>

namespace lappet {

namespace {

void add(const Lattice& lattice, const AnchorStencil& stencil, double sign, PointConstraint& constraint) {
  for (std::size_t k = 0; k < stencil.nodes.size(); ++k) {
    const Index node = stencil.nodes[k];
    constraint.offset += sign * stencil.weights[k] * lattice.node_rest[node];
    constraint.nodes.push_back(node);
    constraint.weights.push_back(sign * stencil.weights[k]);
  }
}

// Both ends of a suture may hold a node.
void merge(PointConstraint& constraint) {
  std::vector<std::size_t> order(constraint.nodes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return constraint.nodes[a] != constraint.nodes[b] ? constraint.nodes[a] < constraint.nodes[b] : a < b;
  });
  std::vector<Index> nodes;
  std::vector<double> weights;
  for (const std::size_t k : order)
    if (!nodes.empty() && nodes.back() == constraint.nodes[k]) {
      weights.back() += constraint.weights[k];
    } else {
      nodes.push_back(constraint.nodes[k]);
      weights.push_back(constraint.weights[k]);
    }
  constraint.nodes = std::move(nodes);
  constraint.weights = std::move(weights);
}

}  // namespace

PointConstraint make_hook(const Lattice& lattice, const AnchorStencil& anchor, const Vec3& target, double stiffness,
                          double max_stiffness) {
  PointConstraint constraint;
  constraint.stiffness = std::min(stiffness, max_stiffness);
  if (stiffness > max_stiffness) {
    constraint.exact = true;
    constraint.compliance = 1.0 / (stiffness - max_stiffness);
  }
  constraint.offset = -target;
  add(lattice, anchor, 1.0, constraint);
  return constraint;
}

PointConstraint make_suture(const Lattice& lattice, const AnchorStencil& a, const AnchorStencil& b,
                            const Vec3& separation, double stiffness) {
  PointConstraint constraint;
  constraint.stiffness = stiffness;
  constraint.exact = true;
  constraint.offset = -separation;
  add(lattice, a, 1.0, constraint);
  add(lattice, b, -1.0, constraint);
  merge(constraint);
  return constraint;
}

}  // namespace lappet
