#include "solve/multigrid/smoother.h"

#include <cmath>

namespace lappet {

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
  diagonal.set_from_storage([this](std::size_t n) { return system_.is_free(n); });
  struct Rows {
    std::span<const Index> nodes;
    std::vector<Eigen::Matrix3d> rows;
    double stiffness;
  };
  std::vector<Rows> constraints;
  const std::vector<PointConstraint>& points = system_.point_constraints();
  for (std::size_t t = 0; t < points.size(); ++t) {
    constraints.push_back({points[t].nodes, {}, points[t].stiffness});
    const Eigen::Matrix3d root = system_.point_roots()[t] / std::sqrt(points[t].stiffness);
    for (const double weight : points[t].weights) constraints.back().rows.push_back(weight * root);
  }
  diagonal.set_constraints(constraints);
  chebyshev_.resize();
}

template class Smoother<float>;
template class Smoother<double>;

}  // namespace lappet
