#include "solve/system/system.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "lattice/node_field.h"
#include "math/disjoint_sets.h"
#include "math/features.h"
#include "math/parallel.h"
#include "math/rigid_motion.h"
#include "solve/system/vectors.h"

namespace lappet {

namespace {

// A suture that leaves its ends this many times its slack apart has closed: chosen, as its multiplier comes near to
// what holds them within it by smaller and smaller steps.
constexpr double kNearEnough = 1.25;
// The penalty of held faces, in Young's moduli per spacing; the multipliers do the rest.
constexpr double kHeldStiffness = 300.0;
// How much it may grow, chosen: that closes what slivers keep open, and a tilted bar takes longer with ten times more.
constexpr double kMaxHeldGrowth = 10.0;
// The weak bed of floating fragments, at each corner of so many cells at most, in Young's moduli times spacing. More
// cells share it: a finer lattice does not hold loose tissue back the more.
constexpr double kDrift = 1e-5, kDriftCells = 64.0;

std::vector<std::uint8_t> fixed_nodes(const Attachments& attachments) {
  std::vector<std::uint8_t> fixed;
  for (const std::int32_t group : attachments.node_group) fixed.push_back(group == kFixedGroup);
  return fixed;
}

}  // namespace

template <class Real>
System<Real>::System(const Lattice& lattice, CellMaterials materials, int quadrature, Attachments attachments,
                     std::int32_t retractors, BedStiffness bed, const Vec3& gravity, const Interrupt& interrupt)
    : elastic_(lattice, std::move(materials), quadrature, choose_instruction_set(), fixed_nodes(attachments),
               interrupt),
      attachments_(std::move(attachments)),
      bed_(bed),
      held_stiffness_(kHeldStiffness * elastic_.materials().table[0].youngs_modulus / lattice.settings.spacing),
      retractor_active_(static_cast<std::size_t>(retractors), 0),
      retractor_motion_(static_cast<std::size_t>(retractors), Eigen::Matrix4d::Identity()),
      free_(lattice.node_rest.size(), 1),
      node_scale_(lattice.node_rest.size()) {
  interrupt.check();
  if (gravity.squaredNorm() > 0) {
    // kg/m^3 * m/s^2 = N/m^3 = 1e-6 mN/mm^3
    gravity_force_.assign(3 * lattice.node_rest.size(), 0.0);
    const double h = lattice.settings.spacing;
    for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
      const Vec3 share = gravity * (elastic_.materials().density(c) * 1e-6 * h * h * h *
                                    static_cast<double>(lattice.cell_fill[c]) / 8.0);
      for (const std::int32_t n : lattice.cell_nodes[c])
        for (int i = 0; i < 3; ++i)
          gravity_force_[3 * static_cast<std::size_t>(n) + static_cast<std::size_t>(i)] += share[i];
    }
  }
  find_fragments();
  interrupt.check();
  clusters_ = ResidualClusters(lattice, elastic_.materials(), fragment_of_node_);
  interrupt.check();
  rebuild_constraints();
}

template <class Real>
const Contact* System<Real>::contact() const {
  return kHasContact ? contact_.get() : nullptr;
}

template <class Real>
void System<Real>::find_fragments() {
  DisjointSets fragments(free_.size());
  for (const auto& nodes : elastic_.lattice().cell_nodes)
    for (const Index n : nodes) fragments.unite(nodes[0], n);
  auto& root = fragment_of_node_;
  root.resize(free_.size());
  bool one = true;
  for (std::size_t n = 0; n < root.size(); ++n) {
    root[n] = fragments.find(to_index(n));
    one = one && root[n] == root[0];
  }
  if (one) root = {};
}

template <class Real>
void System<Real>::find_floating_cells() {
  const Lattice& lattice = elastic_.lattice();
  std::vector<std::uint8_t> held(free_.size(), 0);  // by fragment
  for (std::size_t n = 0; n < free_.size(); ++n)
    if (!free_[n]) held[fragment(n)] = 1;
  for (const auto& face : attachments_.face_constraints) {
    if (!acts(face) || (face.group == kBedGroup && !(bed_.shear > 0.0))) continue;
    const std::int32_t node = lattice.cell_nodes[static_cast<std::size_t>(face.cell)][0];
    held[fragment(static_cast<std::size_t>(node))] = 1;
  }
  if (!attachments_.rollers.empty()) mark_rolling_fragments(held);
  floating_cells_.clear();
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c)
    if (!held[fragment(static_cast<std::size_t>(lattice.cell_nodes[c][0]))])
      floating_cells_.push_back(static_cast<std::int32_t>(c));
  drift_stiffness_ = kDrift * elastic_.materials().table[0].youngs_modulus * lattice.settings.spacing *
                     std::min(1.0, kDriftCells / static_cast<double>(std::max<std::size_t>(floating_cells_.size(), 1)));
}

template <class Real>
void System<Real>::rebuild_constraints() {
  ++revision_;
  free_count_ = 0;
  prescribed_nodes_.clear();
  for (std::size_t n = 0; n < free_.size(); ++n) {
    const std::int32_t group = attachments_.node_group[n];
    free_[n] = group == kFree || (group >= 0 && !retractor_active_[static_cast<std::size_t>(group)]);
    free_count_ += free_[n];
    if (!free_[n]) prescribed_nodes_.push_back(static_cast<std::int32_t>(n));
  }
  find_floating_cells();
  has_held_faces_ = std::ranges::any_of(attachments_.face_constraints,
                                        [&](const auto& face) { return acts(face) && face.group != kBedGroup; });
  set_quadratics();
}

template <class Real>
void System<Real>::set_quadratics() {
  const Lattice& lattice = elastic_.lattice();
  std::vector<std::int32_t> of_cell;
  std::vector<Real> matrices;
  const auto matrix_of = [&](std::int32_t cell) {
    if (of_cell.empty()) of_cell.assign(lattice.cell_nodes.size(), -1);
    auto& index = of_cell[static_cast<std::size_t>(cell)];
    if (index < 0) {
      index = static_cast<std::int32_t>(matrices.size() / 64);
      matrices.resize(matrices.size() + 64, Real(0));
    }
    return 64 * static_cast<std::size_t>(index);
  };
  for (const auto& face : attachments_.face_constraints) {
    if (!acts(face)) continue;
    const bool held = face.group != kBedGroup;
    const std::size_t first = matrix_of(face.cell);
    const Eigen::Matrix<double, 8, 8> gram = face.matrix();
    for (std::size_t k = 0; k < 64; ++k)
      matrices[first + k] += static_cast<Real>((held ? held_stiffness() : bed_.shear) * gram.data()[k]);
  }
  for (const std::int32_t cell : floating_cells_) {
    const std::size_t first = matrix_of(cell);
    for (std::size_t k = 0; k < 8; ++k) matrices[first + 9 * k] += static_cast<Real>(drift_stiffness_);
  }
  elastic_.set_cell_quadratics(of_cell, matrices);
}

template <class Real>
void System<Real>::set_retractors(std::span<const std::int32_t> active, std::span<const Eigen::Matrix4d> motions) {
  std::vector<std::uint8_t> flags(retractor_active_.size(), 0);
  for (std::size_t i = 0; i < active.size(); ++i) {
    flags[static_cast<std::size_t>(active[i])] = 1;
    retractor_motion_[static_cast<std::size_t>(active[i])] = motions[i];
  }
  if (flags != retractor_active_) {
    retractor_active_ = std::move(flags);
    rebuild_constraints();
  }
}

template <class Real>
void System<Real>::set_point_constraints(std::vector<PointConstraint> constraints) {
  bool same = constraints.size() == point_constraints_.size();
  const auto holds_the_same = [](const Piece& a, const Piece& b) {
    return a.nodes == b.nodes && a.weights == b.weights;
  };
  for (std::size_t i = 0; same && i < constraints.size(); ++i)
    same = constraints[i].stiffness == point_constraints_[i].stiffness &&
           std::ranges::equal(constraints[i].pieces, point_constraints_[i].pieces, holds_the_same);
  point_constraints_ = std::move(constraints);
  std::set<ConstraintId> exact;
  for (const auto& constraint : point_constraints_)
    if (constraint.exact && !exact.insert(constraint.id).second)
      throw std::logic_error("two point constraints that hold exactly have the same id");
  has_sutures_ = !exact.empty();
  std::size_t pieces = 0, rows = 0;
  for (const auto& constraint : point_constraints_) {
    pieces += constraint.pieces.size();
    rows += constraint.slides() ? constraint.pieces.size() : 0;
  }
  point_tangent_.roots.assign(pieces, Eigen::Matrix3d::Zero());
  point_tangent_.rows.assign(rows, Vec3::Zero());
  if (std::exchange(held_growth_, 1.0) != 1.0) {
    same = false;
    set_quadratics();
  }
  if (!same) ++revision_;
}

template <class Real>
const PointConstraint& System<Real>::point_constraint(const ConstraintId& id) const {
  const auto found = std::ranges::find(point_constraints_, id, &PointConstraint::id);
  if (found == point_constraints_.end()) throw std::logic_error("no point constraint has this id");
  return *found;
}

template <class Real>
Vec3 System<Real>::held_displacement(std::int32_t group, std::size_t node) const {
  if (group < 0) return Vec3::Zero();
  const Vec3& rest = elastic_.lattice().node_rest[node];
  const auto& motion = retractor_motion_[static_cast<std::size_t>(group)];
  return motion.topLeftCorner<3, 3>() * rest + motion.topRightCorner<3, 1>() - rest;
}

template <class Real>
const Elastic<Real>& System<Real>::elastic_at(const Evaluation& at) const {
  if (at.number != evaluations_) throw std::logic_error("another state was evaluated since");
  return elastic_;
}

template <class Real>
void System<Real>::linearize(const Evaluation& at, PsdProjection how, PsdProjection contact) {
  (void)elastic_at(at);
  const Timed timed(work_.linearizations);
  elastic_.linearize(how);
  contact_penalties_ = at.contact_penalties;
  SparseRows taken_off;
  if (self_contact_) {  // without pairs while it is suspended
    self_contact_rows_ = self_contact_->rows(at.self_contact);
    self_contact_places_ = self_contact_->places(at.self_contact.pairs);
    if (contact == PsdProjection::kExact) taken_off = self_contact_->negative_rows(at.self_contact.pairs);
  }
  penalty_rows_.set(contact_penalties_, self_contact_rows_, taken_off, lattice());
  point_tangent_ = at.point_tangent;
  pressed_from_ = at.pressed;
  pressure_energy_from_ = at.pressure_energy;
  // A definite tangent knows nothing of what a pressure softens or stiffens.
  pressure_tangent_.clear();
  if (how == PsdProjection::kExact && !at.pressed.empty()) linearize_pressures();
}

template <class Real>
void System<Real>::multiply(std::span<const Real> x, std::span<Real> y) const {
  const Timed timed(work_.products);
  elastic_.multiply(x, y);
  penalty_rows_.add_product(x, y);
  multiply_point_constraints(x, y);
  if (!pressure_tangent_.empty()) multiply_pressure(x, y);
  for (const std::int32_t node : prescribed_nodes_)
    for (std::size_t i = 0; i < 3; ++i) y[3 * static_cast<std::size_t>(node) + i] = Real(0);
}

template <class Real>
void System<Real>::multiply_point_constraints(std::span<const Real> x, std::span<Real> y) const {
  const auto moved = [&](const Piece& piece) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < piece.nodes.size(); ++k) sum += piece.weights[k] * NodeField(x)[piece.nodes[k]];
    return sum;
  };
  const auto pull = [&](const Piece& piece, const Vec3& force) {
    for (std::size_t k = 0; k < piece.nodes.size(); ++k)
      for (int i = 0; i < 3; ++i)
        y[3 * static_cast<std::size_t>(piece.nodes[k]) + static_cast<std::size_t>(i)] +=
            static_cast<Real>(piece.weights[k] * force[i]);
  };
  const Eigen::Matrix3d* root = point_tangent_.roots.data();
  const Vec3* row = point_tangent_.rows.data();
  for (const PointConstraint& constraint : point_constraints_) {
    double all = 0.0;  // of a thread that slides
    if (constraint.slides())
      for (std::size_t j = 0; j < constraint.pieces.size(); ++j) all += row[j].dot(moved(constraint.pieces[j]));
    for (const Piece& piece : constraint.pieces) {
      Vec3 force = (root->transpose() * (*root * moved(piece))).eval();
      if (constraint.slides()) force += all * *row++;
      pull(piece, force);
      ++root;
    }
  }
}

template <class Real>
bool System<Real>::prescribed_increment(std::span<const Real> u, std::span<Real> increment) const {
  set_zero<Real>(increment);
  bool any = false;
  for (const std::int32_t node : prescribed_nodes_) {
    const auto n = static_cast<std::size_t>(node);
    if (attachments_.node_group[n] == kStillGroup) continue;
    const Vec3 target = held_displacement(attachments_.node_group[n], n);
    for (std::size_t i = 0; i < 3; ++i) {
      increment[3 * n + i] = static_cast<Real>(target[static_cast<int>(i)]) - u[3 * n + i];
      any = any || increment[3 * n + i] != Real(0);
    }
  }
  return any;
}

template <class Real>
std::vector<std::size_t> System<Real>::gripped_nodes(std::int32_t retractor) const {
  std::vector<std::size_t> gripped;
  for (std::size_t n = 0; n < free_.size(); ++n)
    if (attachments_.node_group[n] == retractor) gripped.push_back(n);
  for (const auto& face : attachments_.face_constraints)
    if (face.group == retractor)
      for (const std::int32_t n : elastic_.lattice().cell_nodes[static_cast<std::size_t>(face.cell)])
        gripped.push_back(static_cast<std::size_t>(n));
  return gripped;
}

template <class Real>
Eigen::Matrix4d System<Real>::motion_towards(const Eigen::Matrix4d& motion, double fraction, std::int32_t retractor,
                                             std::span<const Real> u) const {
  const auto gripped = gripped_nodes(retractor);
  if (gripped.size() < 3) return motion;
  Eigen::Matrix3Xd rest(3, gripped.size()), now(3, gripped.size());
  for (std::size_t k = 0; k < gripped.size(); ++k) {
    rest.col(static_cast<Eigen::Index>(k)) = elastic_.lattice().node_rest[gripped[k]];
    now.col(static_cast<Eigen::Index>(k)) = elastic_.lattice().node_rest[gripped[k]] + NodeField(u)[gripped[k]];
  }
  const Eigen::Matrix4d present = Eigen::umeyama(rest, now, false);
  return between_motions(present, motion, fraction, rest.rowwise().mean());
}

template <class Real>
double System<Real>::largest_gap(std::span<const Real> u, const Multipliers& multipliers, const Evaluation& at,
                                 Gaps which) const {
  const double gap = std::max(suture_gap(u, multipliers, which), held_gap(u));
  return contact() ? std::max(gap, at.contact.excess) : gap;
}

template <class Real>
double System<Real>::suture_gap(std::span<const Real> u, const Multipliers& multipliers, Gaps which) const {
  double gap = 0.0;
  for (const auto& constraint : point_constraints_) {
    if (!constraint.exact) continue;
    const double own = constraint.gap(constraint.values(u), multipliers.of(constraint));
    const bool kept_by_walls =
        self_contact() && (which == Gaps::kButWalls || (which == Gaps::kOpen && constraint.closed));
    if (kept_by_walls && own <= constraint.walls_keep) continue;
    gap = std::max(gap, which == Gaps::kAll ? own : own - kNearEnough * constraint.slack);
  }
  return gap;
}

template <class Real>
void System<Real>::leave_closed(std::span<const Real> u, const Multipliers& multipliers) {
  for (auto& constraint : point_constraints_)
    constraint.closed =
        constraint.drawn && constraint.gap(constraint.values(u), multipliers.of(constraint)) <= constraint.walls_keep;
}

template <class Real>
double System<Real>::held_gap(std::span<const Real> u) const {
  double gap = 0.0;
  for (const RollerRow& row : attachments_.rollers)
    if (acts(row)) gap = std::max(gap, std::abs(off(row, u)));
  if (!has_held_faces_) return gap;
  for (const auto& face : attachments_.face_constraints) {
    if (face.group == kBedGroup || !acts(face)) continue;
    const auto& nodes = elastic_.lattice().cell_nodes[static_cast<std::size_t>(face.cell)];
    double squared = 0.0;
    const Eigen::Matrix<double, 8, 8> gram = face.matrix();
    Vec3 off[8];
    for (std::size_t k = 0; k < 8; ++k) {
      const auto n = static_cast<std::size_t>(nodes[k]);
      off[k] = NodeField(u)[n] - held_displacement(face.group, n);
    }
    for (std::size_t a = 0; a < 8; ++a)
      for (std::size_t b = 0; b < 8; ++b)
        squared += gram(static_cast<int>(a), static_cast<int>(b)) * off[a].dot(off[b]);
    gap = std::max(gap, std::sqrt(std::max(squared, 0.0) / face.area));
  }
  return gap;
}

template <class Real>
void System<Real>::update(Multipliers& multipliers, std::span<const Real> u, const Evaluation& at) const {
  for (const auto& constraint : point_constraints_) {
    if (!constraint.exact) continue;
    const std::vector<Vec3> values = constraint.values(u);
    const Vec3 multiplier = multipliers.of(constraint);
    const double open = constraint.gap(values, multiplier);
    if (self_contact() && constraint.closed && open > constraint.slack && open <= constraint.walls_keep) continue;
    multipliers.of_constraint[constraint.id] = constraint.next_multiplier(values, multiplier);
  }
  if (contact()) contact()->update_pressures(at.contact, multipliers.of_contact_proxy);
  fit(multipliers);
  for (std::size_t r = 0; r < attachments_.rollers.size(); ++r)
    if (acts(attachments_.rollers[r]))
      multipliers.of_roller_row[r] += roller_stiffness() * off(attachments_.rollers[r], u);
  if (!has_held_faces_) return;
  std::vector<std::uint8_t> done(free_.size(), 0);
  for (const auto& face : attachments_.face_constraints) {
    if (face.group == kBedGroup || !acts(face)) continue;
    for (const std::int32_t node : elastic_.lattice().cell_nodes[static_cast<std::size_t>(face.cell)]) {
      const auto n = static_cast<std::size_t>(node);
      if (done[n]) continue;
      done[n] = 1;
      const Vec3 off = NodeField(u)[n] - held_displacement(face.group, n);
      for (int i = 0; i < 3; ++i)
        multipliers.of_held_node[3 * n + static_cast<std::size_t>(i)] += held_stiffness() * off[i];
    }
  }
}

template <class Real>
void System<Real>::stiffen_widest(double factor, std::span<const Real> u, const Multipliers& multipliers) {
  ++revision_;
  if (held_gap(u) > suture_gap(u, multipliers, Gaps::kAll)) {
    held_growth_ = std::min(factor * held_growth_, kMaxHeldGrowth);
    return set_quadratics();
  }
  for (PointConstraint& constraint : point_constraints_)
    if (constraint.exact && constraint.compliance == 0.0) constraint.stiffness *= factor;
}

template <class Real>
void System<Real>::fit(Multipliers& multipliers) const {
  if (auto& rows = multipliers.of_roller_row; rows.size() != attachments_.rollers.size())
    rows.assign(attachments_.rollers.size(), 0.0);
  auto& held = multipliers.of_held_node;
  if (!has_held_faces_)
    held.clear();
  else if (held.size() != 3 * free_.size())
    held.assign(3 * free_.size(), 0.0);
}

template <class Real>
bool System<Real>::is_clear_way(std::span<const Real> from, std::span<const Real> to) const {
  if (!self_contact_) return true;
  std::vector<Real> step(from.size());
  for_each_index(step.size(), [&](std::size_t i) { step[i] = to[i] - from[i]; });
  return self_contact_->template largest_step<Real>(from, step, 1.0) == 1.0;
}

template <class Real>
std::size_t System<Real>::bytes() const {
  return elastic_.bytes() + attachments_.face_constraints.size() * sizeof(FaceConstraint) +
         3 * free_.size() * 8 * (has_held_faces_ ? 2 : 1) + node_scale_.size() * 8 + gravity_force_.size() * 8 +
         free_.size() + clusters_.bytes() + penalty_rows_.bytes() + (contact_ ? contact_->bytes() : 0) +
         (self_contact_ ? self_contact_->bytes() + self_contact_rows_.bytes() : 0) +
         attachments_.rollers.size() * (sizeof(RollerRow) + 8) + traction_force_.size() * 8 +
         pressed_from_.size() * 2 * sizeof(FaceMotion) + pressure_tangent_.size() * sizeof(NodePairs) +
         (attachments_.ground ? attachments_.ground->bytes() : 0);
}

template class System<float>;
template class System<double>;

}  // namespace lappet
