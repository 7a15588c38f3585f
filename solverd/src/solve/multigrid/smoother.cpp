#include "solve/multigrid/smoother.h"

#include <algorithm>
#include <cmath>
#include <list>
#include <map>

namespace lappet {

// A row couples m nodes, more than the eight that Chebyshev's bound allows for (chebyshev.h): for any shares s_k of
// one, (sum_k f_k . x_k)^2 <= sum_k (f_k . x_k)^2 / s_k. With shares in proportion to |f_k| the blocks f_k f_k^T / (8
// s_k) keep the bound; where that is less than what the row has on its diagonal they take that.
template <class Real>
void Smoother<Real>::add_self_contact(std::span<Real> blocks) const {
  const SparseRows& rows = system_.self_contact_rows();
  for (std::size_t row = 0; row < rows.count(); ++row) {
    double whole = 0.0;
    for (std::uint32_t k = rows.start[row]; k < rows.start[row + 1]; ++k) whole += rows.factors[k].norm();
    for (std::uint32_t k = rows.start[row]; k < rows.start[row + 1]; ++k) {
      const Vec3& f = rows.factors[k];
      const double length = f.norm();
      if (!(length > 0.0)) continue;
      const double weight = std::max(1.0, whole / (kMaxEigenvalue * length));
      Real* block = &blocks[offset_of(6, rows.nodes[k])];
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) *block++ += Real(weight * f[i] * f[j]);
    }
  }
}

template <class Real>
void Smoother<Real>::update() {
  const std::size_t nodes = system_.nodes();
  // The blocks are gathered where their inverses go.
  auto& diagonal = chebyshev_.diagonal();
  diagonal.resize(nodes);
  const auto blocks = diagonal.storage();
  system_.elastic().diagonal_blocks(blocks);
  for (const ContactPenalty& penalty : system_.contact_penalties()) {
    const auto& corners = system_.lattice().cell_nodes[penalty.cell];
    const Vec3& d = penalty.direction;
    for (std::size_t k = 0; k < 8; ++k) {
      const double weight = penalty.stiffness * penalty.weights[k] * penalty.weights[k];
      Real* block = &blocks[offset_of(6, corners[k])];
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) *block++ += Real(weight * d[i] * d[j]);
    }
  }
  add_self_contact(blocks);
  diagonal.set_from_storage([this](std::size_t n) { return system_.is_free(n); });
  struct Rows {
    std::span<const Index> nodes;
    std::vector<Eigen::Matrix3d> rows;
    double stiffness;
  };
  std::vector<Rows> constraints;
  const std::vector<PointConstraint>& points = system_.point_constraints();
  std::list<std::vector<Index>> nodes_of_threads;
  const Eigen::Matrix3d* tangent = system_.point_tangent().roots.data();
  const Vec3* row = system_.point_tangent().rows.data();
  for (const PointConstraint& point : points) {
    for (const Piece& piece : point.pieces) {
      constraints.push_back({piece.nodes, {}, point.stiffness});
      const Eigen::Matrix3d root = *tangent++ / std::sqrt(point.stiffness);
      for (const double weight : piece.weights) constraints.back().rows.push_back(weight * root);
    }
    if (!point.slides()) continue;
    std::map<Index, Eigen::Matrix3d> along;  // the row of the whole thread, and two that are zero
    for (const Piece& piece : point.pieces) {
      const Vec3 own = *row++ / std::sqrt(point.stiffness);
      for (std::size_t k = 0; k < piece.nodes.size(); ++k)
        along.try_emplace(piece.nodes[k], Eigen::Matrix3d::Zero()).first->second.row(0) += piece.weights[k] * own;
    }
    std::vector<Index>& held = nodes_of_threads.emplace_back();
    std::vector<Eigen::Matrix3d> rows;
    for (const auto& [node, of_node] : along) {
      held.push_back(node);
      rows.push_back(of_node);
    }
    constraints.push_back({held, std::move(rows), point.stiffness});
  }
  diagonal.set_constraints(constraints);
  chebyshev_.resize();
}

template class Smoother<float>;
template class Smoother<double>;

}  // namespace lappet
