#include "force/constraints/point_constraint.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lappet {

namespace {

void add(const Lattice& lattice, const AnchorStencil& stencil, double sign, Piece& piece) {
  for (std::size_t k = 0; k < stencil.nodes.size(); ++k) {
    const Index node = stencil.nodes[k];
    piece.offset += sign * stencil.weights[k] * lattice.node_rest[node];
    piece.nodes.push_back(node);
    piece.weights.push_back(sign * stencil.weights[k]);
  }
}

// Both ends of a piece may hold a node.
void merge(Piece& piece) {
  std::vector<std::size_t> order(piece.nodes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return piece.nodes[a] != piece.nodes[b] ? piece.nodes[a] < piece.nodes[b] : a < b;
  });
  std::vector<Index> nodes;
  std::vector<double> weights;
  for (const std::size_t k : order)
    if (!nodes.empty() && nodes.back() == piece.nodes[k]) {
      weights.back() += piece.weights[k];
    } else {
      nodes.push_back(piece.nodes[k]);
      weights.push_back(piece.weights[k]);
    }
  piece.nodes = std::move(nodes);
  piece.weights = std::move(weights);
}

// a - b, beyond `offset`.
Piece between(const Lattice& lattice, const AnchorStencil& a, const AnchorStencil& b, const Vec3& offset) {
  Piece piece;
  piece.offset = offset;
  add(lattice, a, 1.0, piece);
  add(lattice, b, -1.0, piece);
  merge(piece);
  return piece;
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

namespace {

// What a thread would pull with if nothing limited it.
double unlimited(const PointConstraint& constraint, std::span<const Vec3> c, const Vec3& multiplier) {
  double length = 0.0;
  for (const Vec3& piece : c) length += smoothed(piece) - kKnot;
  return constraint.stiffness * (length - constraint.thread->length) + multiplier[0];
}

// R of stiff along a unit direction and across it, where `along` is that direction, or shorter where it has none.
Eigen::Matrix3d root_of(const Vec3& along, double across, double stiff) {
  const double share = along.squaredNorm();
  if (share < 1e-12) return std::sqrt(across) * Eigen::Matrix3d::Identity();
  return std::sqrt(across) * Eigen::Matrix3d::Identity() +
         (std::sqrt(stiff) - std::sqrt(across)) / share * along * along.transpose();
}

// What is left of the pull of a suture beyond what its slack takes, z - P(z), as a share of it, z.
double beyond_slack(const PointConstraint& constraint, const Vec3& pull) {
  if (constraint.slack == 0.0) return 1.0;
  return std::max(1.0 - constraint.stiffness * constraint.slack / pull.norm(), 0.0);
}

}  // namespace

double PointConstraint::tension(std::span<const Vec3> c, const Vec3& multiplier) const {
  return std::clamp(unlimited(*this, c, multiplier), 0.0, thread->most);
}

std::vector<Vec3> PointConstraint::forces(std::span<const Vec3> c, const Vec3& multiplier) const {
  std::vector<Vec3> result;
  result.reserve(c.size());
  if (!thread) {
    const Vec3 pull = stiffness * c.front() + multiplier;
    result.emplace_back(beyond_slack(*this, pull) * pull);
    return result;
  }
  const double held = tension(c, multiplier);
  for (const Vec3& piece : c) result.emplace_back(held / smoothed(piece) * piece);
  return result;
}

// The integral of the tension over the length; like that of a spring with a multiplier, zero where the length is the
// rest length.
double PointConstraint::energy(std::span<const Vec3> c, const Vec3& multiplier) const {
  if (!thread) {
    const Vec3 pull = stiffness * c.front() + multiplier;
    return 0.5 * ((beyond_slack(*this, pull) * pull).squaredNorm() - multiplier.squaredNorm()) / stiffness;
  }
  const double pull = unlimited(*this, c, multiplier);
  const double held = std::clamp(pull, 0.0, thread->most);
  const double beyond = std::max(pull - thread->most, 0.0);
  return (0.5 * held * held + (beyond > 0.0 ? thread->most * beyond : 0.0) - 0.5 * multiplier[0] * multiplier[0]) /
         stiffness;
}

void PointConstraint::add_tangent(std::span<const Vec3> c, const Vec3& multiplier, PointTangent& tangent) const {
  if (!thread) {
    const Vec3 pull = stiffness * c.front() + multiplier;
    const double across = stiffness * beyond_slack(*this, pull);
    tangent.roots.push_back(root_of(pull.normalized(), across, across > 0.0 ? stiffness : 0.0));
    return;
  }
  const double held = tension(c, multiplier);
  const bool stretches = held > 0.0 && held < thread->most;
  for (const Vec3& piece : c) {
    const double length = smoothed(piece), across = held / length;
    const Vec3 along = piece / length;
    const double share = along.squaredNorm();  // of one piece, the stiffness along it is in its own root
    tangent.roots.push_back(
        root_of(along, across, across * (1.0 - share) + (stretches && !slides() ? stiffness * share : 0.0)));
    if (slides()) tangent.rows.emplace_back(stretches ? Vec3(std::sqrt(stiffness) * along) : Vec3(Vec3::Zero()));
  }
}

double PointConstraint::gap(std::span<const Vec3> c, const Vec3& multiplier) const {
  if (!thread) return (c.front() - compliance * multiplier).norm();
  return std::abs(tension(c, multiplier) - (1.0 + compliance * stiffness) * multiplier[0]) / stiffness;
}

std::vector<Index> PointConstraint::nodes() const {
  std::vector<Index> all;
  for (const Piece& piece : pieces) all.insert(all.end(), piece.nodes.begin(), piece.nodes.end());
  return all;
}

PointConstraint make_hook(const Lattice& lattice, const AnchorStencil& anchor, const Vec3& target, double stiffness,
                          double max_stiffness) {
  PointConstraint constraint;
  set_stiffness(stiffness, max_stiffness, constraint);
  Piece& piece = constraint.pieces.emplace_back();
  piece.offset = -target;
  add(lattice, anchor, 1.0, piece);
  return constraint;
}

PointConstraint make_suture(const Lattice& lattice, const AnchorStencil& a, const AnchorStencil& b,
                            const Vec3& separation, double stiffness) {
  PointConstraint constraint;
  constraint.stiffness = stiffness;
  constraint.exact = true;
  constraint.pieces.push_back(between(lattice, a, b, -separation));
  return constraint;
}

PointConstraint make_thread(const Lattice& lattice, std::span<const AnchorStencil* const> anchors, const Thread& thread,
                            double stiffness, double max_stiffness) {
  PointConstraint constraint;
  set_stiffness(stiffness, max_stiffness, constraint);
  constraint.thread = thread;
  for (std::size_t k = 0; k + 1 < anchors.size(); ++k)
    constraint.pieces.push_back(between(lattice, *anchors[k], *anchors[k + 1], Vec3::Zero()));
  return constraint;
}

}  // namespace lappet
