#include "solve/smoother.h"

#include <unordered_map>

namespace lappet {

namespace {

// K is a sum of positive semidefinite cells (and pushes) that couple eight nodes each, and ties within the one block:
// by Cauchy and Schwarz no eigenvalue of D^-1 K exceeds eight. Single cells come near it where they are much stiffer
// than those around them, as at a suture's anchor, and an estimate from a few Lanczos steps misses them, the more
// surely the more nodes there are: Chebyshev's polynomial then blows up on them and the preconditioner is no longer
// definite.
constexpr double kLargestEigenvalue = 8.0;

}  // namespace

template <class Real>
void Smoother<Real>::update() {
  const std::size_t nodes = system_.nodes();
  std::vector<Real> blocks(6 * nodes);
  system_.elastic().diagonal_blocks(blocks);
  system_.for_each_push([&](const Push& push) {
    const auto& corners = system_.lattice().cell_nodes[static_cast<std::size_t>(push.cell)];
    const Vec3& d = push.direction;
    for (std::size_t k = 0; k < 8; ++k) {
      const double weight = push.stiffness * push.weights[k] * push.weights[k];
      Real* block = &blocks[6 * static_cast<std::size_t>(corners[k])];
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) *block++ += static_cast<Real>(weight * d[i] * d[j]);
    }
  });
  const bool same_ties = revision_ == system_.constraint_revision();
  if (!same_ties) find_tied_nodes();
  revision_ = system_.constraint_revision();
  auto& diagonal = chebyshev_.diagonal();
  diagonal.resize(nodes);
  for_each_index(nodes, [&](std::size_t n) {
    if (!system_.is_free(n)) return;
    Eigen::Matrix3d block;
    const Real* entry = &blocks[6 * n];
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) block(i, j) = block(j, i) = static_cast<double>(*entry++);
    diagonal.set(n, block);
  });
  factor_tied_nodes(same_ties);
  chebyshev_.set_largest_eigenvalue(kLargestEigenvalue);
}

template <class Real>
void Smoother<Real>::find_tied_nodes() {
  std::vector<std::int32_t> index(system_.nodes(), -1);
  for (const auto& tie : system_.ties())
    for (const std::int32_t node : tie.nodes)
      if (system_.is_free(static_cast<std::size_t>(node))) index[static_cast<std::size_t>(node)] = 0;
  tied_nodes_.clear();
  for (std::size_t n = 0; n < index.size(); ++n)
    if (index[n] == 0) {
      index[n] = static_cast<std::int32_t>(tied_nodes_.size());
      tied_nodes_.push_back(static_cast<std::int32_t>(n));
    }
  tied_cells_.clear();
  if (tied_nodes_.empty()) return;
  const auto& cells = system_.lattice().cell_nodes;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    TiedCell cell{static_cast<std::int32_t>(c), {}};
    bool any = false;
    for (std::size_t k = 0; k < 8; ++k) {
      cell.index[k] = index[static_cast<std::size_t>(cells[c][k])];
      any = any || cell.index[k] >= 0;
    }
    if (any) tied_cells_.push_back(cell);
  }
}

template <class Real>
void Smoother<Real>::factor_tied_nodes(bool same_pattern) {
  const auto size = static_cast<Eigen::Index>(3 * tied_nodes_.size());
  std::vector<Matrix24> stiffness(tied_cells_.size());
  for_each_row(tied_cells_.size(),
               [&](std::size_t c) { stiffness[c] = system_.elastic().cell_stiffness(tied_cells_[c].cell); });
  std::vector<Eigen::Triplet<double>> entries;  // the lower half
  const auto emplace = [&](std::int32_t row, std::int32_t column, double value) {
    if (row >= column) entries.emplace_back(row, column, value);
  };
  for (std::size_t c = 0; c < tied_cells_.size(); ++c) {
    const auto& index = tied_cells_[c].index;
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        if (index[static_cast<std::size_t>(a)] >= index[static_cast<std::size_t>(b)] &&
            index[static_cast<std::size_t>(b)] >= 0)
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
              emplace(3 * index[static_cast<std::size_t>(a)] + i, 3 * index[static_cast<std::size_t>(b)] + j,
                      stiffness[c](3 * a + i, 3 * b + j));
  }
  std::unordered_map<std::int32_t, std::int32_t> local;
  for (std::size_t i = 0; i < tied_nodes_.size(); ++i) local[tied_nodes_[i]] = static_cast<std::int32_t>(i);
  for (const auto& tie : system_.ties())
    for (std::size_t a = 0; a < tie.nodes.size(); ++a)
      for (std::size_t b = 0; b < tie.nodes.size(); ++b) {
        const auto row = local.find(tie.nodes[a]), column = local.find(tie.nodes[b]);
        if (row == local.end() || column == local.end()) continue;
        for (int i = 0; i < 3; ++i)
          emplace(3 * row->second + i, 3 * column->second + i, tie.stiffness * tie.weights[a] * tie.weights[b]);
      }
  system_.for_each_push([&](const Push& push) {
    const auto& corners = system_.lattice().cell_nodes[static_cast<std::size_t>(push.cell)];
    for (std::size_t a = 0; a < 8; ++a)
      for (std::size_t b = 0; b < 8; ++b) {
        const auto row = local.find(corners[a]), column = local.find(corners[b]);
        if (row == local.end() || column == local.end()) continue;
        const Eigen::Matrix3d block =
            push.stiffness * push.weights[a] * push.weights[b] * push.direction * push.direction.transpose();
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) emplace(3 * row->second + i, 3 * column->second + j, block(i, j));
      }
  });
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  chebyshev_.diagonal().set_tied(tied_nodes_, matrix, same_pattern);
}

template class Smoother<float>;
template class Smoother<double>;

}  // namespace lappet
