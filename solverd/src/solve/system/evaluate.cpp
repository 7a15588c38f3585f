#include <algorithm>
#include <cmath>
#include <utility>

#include "lattice/node_field.h"
#include "math/parallel.h"
#include "solve/system/system.h"
#include "solve/system/vectors.h"

namespace lappet {

namespace {

// How deep a step may take what rests into the ground, in spacings: less than its field knows of.
constexpr double kMaxStridesIntoGround = 2.0;
constexpr int kMaxStrides = 64;  // of a step of what rests, in spacings

}  // namespace

// The forces of attached faces on the corners of their cells are found in parallel and added in order, a batch at a
// time. Returns their energy.
template <class Real>
double System<Real>::add_face_constraints(std::span<const Real> u, const Multipliers& multipliers,
                                          std::span<double> gradient) const {
  constexpr std::size_t kBatch = 8192;
  const auto& constraints = attachments_.face_constraints;
  std::vector<std::array<double, 25>> found(std::min(kBatch, constraints.size()));  // forces, energy
  double energy = 0.0;
  for (std::size_t first = 0; first < constraints.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, constraints.size() - first);
    for_each_row(count, [&](std::size_t f) {
      found[f].fill(0.0);
      if (acts(constraints[first + f])) evaluate_face_constraint(constraints[first + f], u, multipliers, found[f]);
    });
    for (std::size_t f = 0; f < count; ++f) {
      const auto& nodes = elastic_.lattice().cell_nodes[static_cast<std::size_t>(constraints[first + f].cell)];
      for (std::size_t a = 0; a < 8; ++a)
        for (std::size_t i = 0; i < 3; ++i) gradient[3 * static_cast<std::size_t>(nodes[a]) + i] += found[f][3 * a + i];
      energy += found[f][24];
    }
  }
  return energy;
}

template <class Real>
void System<Real>::evaluate_face_constraint(const FaceConstraint& face, std::span<const Real> u,
                                            const Multipliers& multipliers, std::array<double, 25>& out) const {
  const bool held = face.group != kBedGroup;
  const double stiffness = held ? held_stiffness() : bed_.shear;
  const auto& nodes = elastic_.lattice().cell_nodes[static_cast<std::size_t>(face.cell)];
  Eigen::Matrix<double, 3, 8> off, demand;  // demand: stiffness times the gap, and the multiplier
  for (int k = 0; k < 8; ++k) {
    const auto n = static_cast<std::size_t>(nodes[static_cast<std::size_t>(k)]);
    off.col(k) = NodeField(u)[n];
    if (held) off.col(k) -= held_displacement(face.group, n);
    demand.col(k) = stiffness * off.col(k);
    if (held && !multipliers.of_held_node.empty()) demand.col(k) += Vec3::Map(&multipliers.of_held_node[3 * n]);
  }
  const Eigen::Matrix<double, 8, 8> gram = face.matrix();
  Eigen::Map<Eigen::Matrix<double, 3, 8>>(out.data()) = demand * gram;
  out[24] = (off.cwiseProduct((demand - 0.5 * stiffness * off) * gram)).sum();
}

template <class Real>
Evaluation System<Real>::evaluate(std::span<const Real> u, const Multipliers& multipliers, Evaluation reused) {
  const Timed timed(work_.evaluations);
  Evaluation result = std::move(reused);
  result.number = ++evaluations_;
  result.gradient.resize(3 * free_.size());
  const ElasticState state = elastic_.evaluate(u, result.gradient, node_scale_);
  result.energy = state.energy;
  result.minimum_j = state.minimum_j;
  result.inverted = state.inverted;
  result.energy += add_face_constraints(u, multipliers, result.gradient);
  result.contact_penalties.clear();
  add_bed_faces(u, result);
  add_resting_faces(u, result);
  if (contact()) {
    contact()->template evaluate<Real>(u, multipliers.of_contact_proxy, free_, result.gradient,
                                       result.contact_penalties, result.contact);
    result.energy += result.contact.energy;
  }
  result.self_contact = {};
  if (self_contact()) {
    self_contact()->template evaluate<Real>(u, result.gradient, result.self_contact);
    result.energy += result.self_contact.energy;
  }
  add_point_constraints(u, multipliers, result);
  add_rollers(u, multipliers, result);
  add_drift(u, result);
  add_loads(u, result);
  if (!gravity_force_.empty())
    result.energy -= reduce<1>(gravity_force_.size(), [&, g = result.gradient.data()](std::size_t i, double* out) {
      out[0] = gravity_force_[i] * static_cast<double>(u[i]);
      g[i] -= gravity_force_[i];
    })[0];
  measure_residual(u, result);
  return result;
}

template <class Real>
void System<Real>::add_bed_faces(std::span<const Real> u, Evaluation& result) const {
  const double more = bed_.normal - bed_.shear;
  if (!(more > 0.0)) return;
  for (const auto& face : attachments_.attached) {
    const auto& nodes = elastic_.lattice().cell_nodes[static_cast<std::size_t>(face.cell)];
    double height = 0.0;
    for (std::size_t k = 0; k < 8; ++k) height += face.weights[k] * face.outward.dot(NodeField(u)[nodes[k]]);
    const double stiffness = more * face.area;
    result.contact_penalties.push_back({face.cell, face.weights, face.outward, stiffness});
    result.energy += 0.5 * stiffness * height * height;
    for (std::size_t k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i)
        result.gradient[3 * static_cast<std::size_t>(nodes[k]) + static_cast<std::size_t>(i)] +=
            stiffness * height * face.weights[k] * face.outward[i];
  }
}

template <class Real>
void System<Real>::add_resting_faces(std::span<const Real> u, Evaluation& result) const {
  for (const auto& face : attachments_.resting) {
    const auto& nodes = elastic_.lattice().cell_nodes[static_cast<std::size_t>(face.cell)];
    Vec3 now = face.rest;
    for (std::size_t k = 0; k < 8; ++k) now += face.weights[k] * NodeField(u)[nodes[k]];
    const auto [above, upward] = attachments_.ground->height(now);
    const double height = above - face.height;
    if (!(height < 0.0)) continue;
    const double stiffness = bed_.normal * face.area;
    result.contact_penalties.push_back({face.cell, face.weights, upward, stiffness});
    result.energy += 0.5 * stiffness * height * height;
    for (std::size_t k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i)
        result.gradient[3 * static_cast<std::size_t>(nodes[k]) + static_cast<std::size_t>(i)] +=
            stiffness * height * face.weights[k] * upward[i];
  }
}

template <class Real>
double System<Real>::largest_step(std::span<const Real> u, std::span<const Real> step, double most) const {
  if (contact()) most = contact()->template largest_step<Real>(u, step, most);
  if (self_contact()) most = self_contact()->template largest_step<Real>(u, step, most);
  const double stride = lattice().settings.spacing;
  for (const auto& face : attachments_.resting) {
    const auto& nodes = lattice().cell_nodes[static_cast<std::size_t>(face.cell)];
    Vec3 from = face.rest, move = Vec3::Zero();
    for (std::size_t k = 0; k < 8; ++k) {
      from += face.weights[k] * NodeField(u)[nodes[k]];
      move += face.weights[k] * NodeField(step)[nodes[k]];
    }
    const double length = move.norm();
    if (!(most * length > stride)) continue;
    const double lowest = std::min(-kMaxStridesIntoGround * stride, attachments_.ground->height(from).value);
    double clear = stride / length;  // some way at least
    for (int k = 1; clear < most && k <= kMaxStrides; ++k) {
      const double part = std::min(most, k * stride / length);
      if (attachments_.ground->height(from + part * move).value < lowest) break;
      clear = part;
    }
    most = std::min(most, clear);
  }
  return most;
}

template <class Real>
void System<Real>::add_point_constraints(std::span<const Real> u, const Multipliers& multipliers,
                                         Evaluation& result) const {
  result.point_tangent.clear();
  for (const auto& constraint : point_constraints_) {
    const std::vector<Vec3> c = constraint.values(u);
    const Vec3 multiplier = multipliers.of(constraint);
    const std::vector<Vec3> forces = constraint.forces(c, multiplier);
    result.energy += constraint.energy(c, multiplier);
    constraint.add_tangent(c, multiplier, result.point_tangent);
    for (std::size_t j = 0; j < c.size(); ++j) {
      const Piece& piece = constraint.pieces[j];
      for (std::size_t k = 0; k < piece.nodes.size(); ++k)
        for (int i = 0; i < 3; ++i)
          result.gradient[3 * static_cast<std::size_t>(piece.nodes[k]) + static_cast<std::size_t>(i)] +=
              piece.weights[k] * forces[j][i];
    }
  }
}

template <class Real>
void System<Real>::add_drift(std::span<const Real> u, Evaluation& result) const {
  for (const std::int32_t cell : floating_cells_)
    for (const std::int32_t node : elastic_.lattice().cell_nodes[static_cast<std::size_t>(cell)]) {
      const auto n = static_cast<std::size_t>(node);
      const Vec3 off = NodeField(u)[n];
      result.energy += 0.5 * drift_stiffness_ * off.squaredNorm();
      for (int i = 0; i < 3; ++i) result.gradient[3 * n + static_cast<std::size_t>(i)] += drift_stiffness_ * off[i];
    }
}

// The gradient of prescribed nodes is no residual but what holds them: it is set to zero.
template <class Real>
void System<Real>::measure_residual(std::span<const Real> u, Evaluation& result) {
  result.holding.resize(3 * prescribed_nodes_.size());
  for_each_index(prescribed_nodes_.size(), [&, g = result.gradient.data()](std::size_t k) {
    const std::size_t n = 3 * static_cast<std::size_t>(prescribed_nodes_[k]);
    for (std::size_t i = 0; i < 3; ++i) result.holding[3 * k + i] = std::exchange(g[n + i], 0.0);
  });
  const ResidualNorms norms = clusters_.norms<Real>(result.gradient, node_scale_, free_, u);
  result.residual = norms.residual;
  result.force_scale = norms.force_scale;
  result.relative_residual = norms.relative;
}

template double System<float>::add_face_constraints(std::span<const float>, const Multipliers&,
                                                    std::span<double>) const;
template void System<float>::evaluate_face_constraint(const FaceConstraint&, std::span<const float>, const Multipliers&,
                                                      std::array<double, 25>&) const;
template void System<float>::add_bed_faces(std::span<const float>, Evaluation&) const;
template void System<float>::add_resting_faces(std::span<const float>, Evaluation&) const;
template double System<float>::largest_step(std::span<const float>, std::span<const float>, double) const;
template void System<float>::add_point_constraints(std::span<const float>, const Multipliers&, Evaluation&) const;
template void System<float>::add_drift(std::span<const float>, Evaluation&) const;
template void System<float>::measure_residual(std::span<const float>, Evaluation&);
template Evaluation System<float>::evaluate(std::span<const float>, const Multipliers&, Evaluation);
template double System<double>::add_face_constraints(std::span<const double>, const Multipliers&,
                                                     std::span<double>) const;
template void System<double>::evaluate_face_constraint(const FaceConstraint&, std::span<const double>,
                                                       const Multipliers&, std::array<double, 25>&) const;
template void System<double>::add_bed_faces(std::span<const double>, Evaluation&) const;
template void System<double>::add_resting_faces(std::span<const double>, Evaluation&) const;
template double System<double>::largest_step(std::span<const double>, std::span<const double>, double) const;
template void System<double>::add_point_constraints(std::span<const double>, const Multipliers&, Evaluation&) const;
template void System<double>::add_drift(std::span<const double>, Evaluation&) const;
template void System<double>::measure_residual(std::span<const double>, Evaluation&);
template Evaluation System<double>::evaluate(std::span<const double>, const Multipliers&, Evaluation);

}  // namespace lappet
