// Point constraints: hooks and sutures as functions of linear functionals of the displacements, c(u) = sum_i w_i u_i +
// offset (mm).
//
// A hook is a spring, stiffness/2 |c|^2. A suture demands c = 0 and carries a multiplier lambda besides (augmented
// Lagrangian, lambda . c + stiffness/2 |c|^2), so that its gap closes whatever the ratio of stiffnesses. A hook that is
// much stiffer than tissue is such a constraint too, with a compliance s: it demands c = s lambda, where the penalty
// and lambda = c/s together pull as the spring does, (stiffness + 1/s) c. Rounding of displacements is not blown up to
// forces.
//
// A suture may have slack D: it demands |c| <= D, c in a ball. With z = c + lambda/stiffness and P(z) the point of the
// ball nearest to it, the augmented Lagrangian is stiffness/2 |z - P(z)|^2, and the multiplier moves on to the force,
// stiffness (z - P(z)), so that it falls again where less is to be held (Rockafellar 1976 for convex sets). For D = 0
// it is the same as above.
//
// A thread only pulls. It slides through its anchors, so it has one tension T: it goes by the sum L of the lengths
// |c_j| of its pieces, each between an anchor and the next and smoothed near zero, T = stiffness (L - length) + lambda,
// between zero and the most it is drawn with. Its energy is convex in L, and L in all c_j, so its tangent is never
// negative. That is T/|c_j| across each piece, and the stiffness along all of them at once: one row that couples every
// anchor of the thread.
#pragma once
#include <compare>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "lattice/anchor_stencil.h"
#include "lattice/node_field.h"

namespace lappet {

// Which hook or suture a point constraint is: its index in the frame's hooks or in the procedure's sutures.
struct ConstraintId {
  enum class Kind : std::uint8_t { kHook, kSuture };
  Kind kind = Kind::kHook;
  std::int32_t index = 0;
  auto operator<=>(const ConstraintId&) const = default;
};

struct Thread {
  double length = 0.0;                                    // at rest, mm
  double most = std::numeric_limits<double>::infinity();  // tension, mN
};

// From one point to another: one functional.
struct Piece {
  std::vector<Index> nodes;  // distinct
  std::vector<double> weights;
  Vec3 offset = Vec3::Zero();
  bool operator==(const Piece&) const = default;

  template <class Real>
  Vec3 value(std::span<const Real> u) const {
    Vec3 sum = offset;
    for (std::size_t i = 0; i < nodes.size(); ++i) sum += weights[i] * NodeField(u)[nodes[i]];
    return sum;
  }
};

// Of point constraints, one after the other: of each piece the root R of its own stiffness R^T R, and of each piece of
// a thread that has several a row r_j besides. The energy is half the sum of all |R_j dc_j|^2 and, once for each such
// thread, of (sum_j r_j . dc_j)^2.
struct PointTangent {
  std::vector<Eigen::Matrix3d> roots;
  std::vector<Vec3> rows;
  void clear() {
    roots.clear();
    rows.clear();
  }
};

struct PointConstraint {
  ConstraintId id;
  std::vector<Piece> pieces;  // one, but of a thread one for each two anchors that follow each other
  double stiffness = 0.0;     // mN/mm
  bool exact = false;         // a suture, a stiff hook
  double compliance = 0.0;    // mm/mN, of an exact point constraint: a suture has none
  double slack = 0.0;  // mm, of a suture between walls that may touch: how far its ends may be from what is demanded
  double walls_keep = 0.0;  // mm, of a suture between walls that touch: how far these may hold it open
  bool drawn = false;       // such a suture is to be closed wholly
  bool closed = false;      // and was when the search began, but for what its walls keep: it is drawn no further
  std::optional<Thread> thread;

  // c of each piece; what follows takes them. The multiplier (mN) is zero unless the constraint is exact; that of a
  // thread is a tension and the first number.
  template <class Real>
  std::vector<Vec3> values(std::span<const Real> u) const {
    std::vector<Vec3> c;
    c.reserve(pieces.size());
    for (const Piece& piece : pieces) c.push_back(piece.value(u));
    return c;
  }
  double energy(std::span<const Vec3> c, const Vec3& multiplier) const;
  // On each piece; that of a thread, which is the same in all of them, as a number.
  std::vector<Vec3> forces(std::span<const Vec3> c, const Vec3& multiplier) const;
  double tension(std::span<const Vec3> c, const Vec3& multiplier) const;
  void add_tangent(std::span<const Vec3> c, const Vec3& multiplier, PointTangent& tangent) const;
  bool slides() const { return pieces.size() > 1; }
  // What an exact point constraint leaves open, mm, and the multiplier that closes it further.
  double gap(std::span<const Vec3> c, const Vec3& multiplier) const;
  Vec3 next_multiplier(std::span<const Vec3> c, const Vec3& multiplier) const {
    const Vec3 pull = thread ? Vec3(tension(c, multiplier), 0.0, 0.0) : forces(c, multiplier).front();
    return pull / (1.0 + compliance * stiffness);
  }
  // All that any piece holds; with repetitions where there are several.
  std::vector<Index> nodes() const;
};

// From what a hook holds to a place in space. max_stiffness: up to which it is a plain spring, mN/mm.
PointConstraint make_hook(const Lattice& lattice, const AnchorStencil& anchor, const Vec3& target, double stiffness,
                          double max_stiffness = std::numeric_limits<double>::infinity());
// Between what a suture holds at either end, a - b = separation.
PointConstraint make_suture(const Lattice& lattice, const AnchorStencil& a, const AnchorStencil& b,
                            const Vec3& separation, double stiffness);
// A thread through what it holds at its anchors, two or more, in their order. max_stiffness: up to which it is a plain
// spring, mN/mm.
PointConstraint make_thread(const Lattice& lattice, std::span<const AnchorStencil* const> anchors, const Thread& thread,
                            double stiffness, double max_stiffness);
// How far an embedded point has moved, and where it is.
template <class Real>
Vec3 displacement(const Lattice& lattice, const EmbeddedPoint& point, std::span<const Real> u) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 8; ++k) sum += point.weights[k] * NodeField(u)[lattice.cell_nodes[point.cell][k]];
  return sum;
}
template <class Real>
Vec3 position(const Lattice& lattice, const EmbeddedPoint& point, std::span<const Real> u) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 8; ++k) {
    const Index n = lattice.cell_nodes[point.cell][k];
    sum += point.weights[k] * (lattice.node_rest[n] + NodeField(u)[n]);
  }
  return sum;
}
// Where what is held is, in the mean.
template <class Real>
Vec3 position(const Lattice& lattice, const AnchorStencil& stencil, std::span<const Real> u) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < stencil.nodes.size(); ++k) {
    const Index n = stencil.nodes[k];
    sum += stencil.weights[k] * (lattice.node_rest[n] + NodeField(u)[n]);
  }
  return sum;
}

}  // namespace lappet
