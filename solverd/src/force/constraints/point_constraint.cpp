#include "force/constraints/point_constraint.h"

#include <algorithm>
#include <cmath>
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

// A thread shorter than this has no direction: lengths are smoothed as sqrt(|c|^2 + kKnot^2) - kKnot.
constexpr double kKnot = 1e-3;  // mm

double smoothed(const Vec3& c) { return std::sqrt(c.squaredNorm() + kKnot * kKnot); }

// What is too stiff for a penalty goes to a multiplier.
void set_stiffness(double stiffness, double max_stiffness, PointConstraint& constraint) {
  constraint.stiffness = std::min(stiffness, max_stiffness);
  if (stiffness <= max_stiffness) return;
  constraint.exact = true;
  constraint.compliance = 1.0 / (stiffness - max_stiffness);
}

}  // namespace

double PointConstraint::tension(const Vec3& c, const Vec3& multiplier) const {
  const double pull = stiffness * (smoothed(c) - kKnot - thread->length) + multiplier[0];
  return std::clamp(pull, 0.0, thread->most);
}

Vec3 PointConstraint::force(const Vec3& c, const Vec3& multiplier) const {
  if (!thread) return stiffness * c + multiplier;
  return tension(c, multiplier) / smoothed(c) * c;
}

// The integral of the tension over the length; like that of a spring with a multiplier, zero where the length is the
// rest length.
double PointConstraint::energy(const Vec3& c, const Vec3& multiplier) const {
  if (!thread) return c.dot(0.5 * stiffness * c + multiplier);
  const double pull = stiffness * (smoothed(c) - kKnot - thread->length) + multiplier[0];
  const double held = std::clamp(pull, 0.0, thread->most);
  const double beyond = std::max(pull - thread->most, 0.0);
  return (0.5 * held * held + (beyond > 0.0 ? thread->most * beyond : 0.0) - 0.5 * multiplier[0] * multiplier[0]) /
         stiffness;
}

Eigen::Matrix3d PointConstraint::tangent_root(const Vec3& c, const Vec3& multiplier) const {
  if (!thread) return std::sqrt(stiffness) * Eigen::Matrix3d::Identity();
  const double length = smoothed(c), held = tension(c, multiplier);
  const bool stretches = held > 0.0 && held < thread->most;
  const Vec3 along = c / length;  // shorter than one near zero
  const double share = along.squaredNorm(), across = held / length;
  if (share < 1e-12) return std::sqrt(across) * Eigen::Matrix3d::Identity();
  const double stiff = across * (1.0 - share) + (stretches ? stiffness * share : 0.0);
  return std::sqrt(across) * Eigen::Matrix3d::Identity() +
         (std::sqrt(stiff) - std::sqrt(across)) / share * along * along.transpose();
}

double PointConstraint::gap(const Vec3& c, const Vec3& multiplier) const {
  if (!thread) return (c - compliance * multiplier).norm();
  return std::abs(tension(c, multiplier) - (1.0 + compliance * stiffness) * multiplier[0]) / stiffness;
}

PointConstraint make_hook(const Lattice& lattice, const AnchorStencil& anchor, const Vec3& target, double stiffness,
                          double max_stiffness) {
  PointConstraint constraint;
  set_stiffness(stiffness, max_stiffness, constraint);
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

PointConstraint make_thread(const Lattice& lattice, const AnchorStencil& a, const AnchorStencil& b,
                            const Thread& thread, double stiffness, double max_stiffness) {
  PointConstraint constraint;
  set_stiffness(stiffness, max_stiffness, constraint);
  constraint.thread = thread;
  add(lattice, a, 1.0, constraint);
  add(lattice, b, -1.0, constraint);
  merge(constraint);
  return constraint;
}

}  // namespace lappet
