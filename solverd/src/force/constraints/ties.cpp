#include "force/constraints/ties.h"

#include <algorithm>
#include <numeric>

namespace lappet {

namespace {

void add(const Lattice& lattice, const Bite& bite, double sign, Tie& tie) {
  for (std::size_t k = 0; k < bite.nodes.size(); ++k) {
    const std::int32_t node = bite.nodes[k];
    tie.offset += sign * bite.weights[k] * lattice.node_rest[static_cast<std::size_t>(node)];
    tie.nodes.push_back(node);
    tie.weights.push_back(sign * bite.weights[k]);
  }
}

// Both ends of a suture may hold a node.
void merge(Tie& tie) {
  std::vector<std::size_t> order(tie.nodes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return tie.nodes[a] != tie.nodes[b] ? tie.nodes[a] < tie.nodes[b] : a < b;
  });
  std::vector<std::int32_t> nodes;
  std::vector<double> weights;
  for (const std::size_t k : order)
    if (!nodes.empty() && nodes.back() == tie.nodes[k]) {
      weights.back() += tie.weights[k];
    } else {
      nodes.push_back(tie.nodes[k]);
      weights.push_back(tie.weights[k]);
    }
  tie.nodes = std::move(nodes);
  tie.weights = std::move(weights);
}

}  // namespace

Tie make_hook(const Lattice& lattice, const Bite& anchor, const Vec3& target, double stiffness, double most) {
  Tie tie;
  tie.stiffness = std::min(stiffness, most);
  if (stiffness > most) {
    tie.exact = true;
    tie.compliance = 1.0 / (stiffness - most);
  }
  tie.offset = -target;
  add(lattice, anchor, 1.0, tie);
  return tie;
}

Tie make_suture(const Lattice& lattice, const Bite& a, const Bite& b, const Vec3& separation, double stiffness,
                const Vec3& multiplier) {
  Tie tie;
  tie.stiffness = stiffness;
  tie.exact = true;
  tie.multiplier = multiplier;
  tie.offset = -separation;
  add(lattice, a, 1.0, tie);
  add(lattice, b, -1.0, tie);
  merge(tie);
  return tie;
}

}  // namespace lappet
