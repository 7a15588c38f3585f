#include "solve/multigrid/coarse_matrix.h"

#include <algorithm>

#include "force/kernels/projected_stiffness_kernel.h"
#include "math/parallel.h"

namespace lappet {

template <class Real>
CoarseMatrix<Real>::CoarseMatrix(const CoarseLattice& lattice)
    : product_(coarse_product<Real>(choose_instruction_set())) {
  start_.push_back(0);
  left_start_.push_back(0);
  std::vector<Index> row;
  for (std::size_t n = 0; n < lattice.nodes; ++n) {
    row.clear();
    for (const Index corner : lattice.corners[n]) {
      const auto& nodes = lattice.cell_nodes[corner / 8];
      row.insert(row.end(), nodes.begin(), nodes.end());
    }
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    const auto diagonal = std::lower_bound(row.begin(), row.end(), to_index(n));
    column_.insert(column_.end(), diagonal, row.end());
    start_.push_back(to_index(column_.size()));
    left_start_.push_back(left_start_.back() + to_index(diagonal - row.begin()));
  }
  column_.shrink_to_fit();
  left_.resize(left_start_.back());
  std::vector<Index> next(left_start_.begin(), left_start_.end() - 1);
  for (std::size_t n = 0; n < lattice.nodes; ++n)
    for (Index s = start_[n] + 1; s < start_[n + 1]; ++s) left_[next[column_[s]]++] = {to_index(n), s};
}

template <class Real>
std::size_t CoarseMatrix<Real>::slot(Index row, Index column) const {
  const auto begin = column_.begin() + start_[row], end = column_.begin() + start_[row + 1];
  return std::lower_bound(begin, end, column) - column_.begin();
}

template <class Real>
void CoarseMatrix<Real>::set_zero() {
  blocks_.resize(36 * column_.size() + kCoarsePadding);
  for_each_index(blocks_.size(), [&](std::size_t i) { blocks_[i] = Real(0); });
}

template <class Real>
void CoarseMatrix<Real>::add(const CoarseLattice& lattice, std::size_t first_cell, std::span<const Real> cell_blocks) {
  const std::size_t end_cell = first_cell + cell_blocks.size() / kModePairSize;
  std::vector<Index> touched;
  for (std::size_t c = first_cell; c < end_cell; ++c)
    touched.insert(touched.end(), lattice.cell_nodes[c].begin(), lattice.cell_nodes[c].end());
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  for_each_row(touched.size(), [&](std::size_t row) {
    const Index n = touched[row];
    for (const Index corner : lattice.corners[n]) {
      const std::size_t cell = corner / 8;
      if (cell < first_cell || cell >= end_cell) continue;
      const int k = corner % 8;
      const Real* pairs = &cell_blocks[kModePairSize * (cell - first_cell)];
      for (int l = 0; l < 8; ++l) {
        const Index column = lattice.cell_nodes[cell][l];
        if (column < n) continue;
        Real* to = block(slot(n, column));
        if (l <= k) {
          const Real* from = pairs + 36 * pair_of(k, l);
          for (int e = 0; e < 36; ++e) to[e] += from[e];
        } else {
          const Real* from = pairs + 36 * pair_of(l, k);
          for (int a = 0; a < 6; ++a)
            for (int b = 0; b < 6; ++b) to[6 * a + b] += from[6 * b + a];
        }
      }
    }
  });
}

template <class Real>
void CoarseMatrix<Real>::multiply(std::span<const Real> x, std::span<Real> y) const {
  constexpr std::size_t kRows = 16;
  const CoarseRows<Real> matrix{rows(),       start_.data(), column_.data(), left_start_.data(),
                                left_.data(), blocks_.data()};
  for_each_chunk(
      rows(),
      [&](std::size_t, std::size_t begin, std::size_t end) { product_(matrix, begin, end, x.data(), y.data()); },
      kRows);
}

template <class Real>
double CoarseMatrix<Real>::largest_diagonal() const {
  double largest = 0.0;
  for (std::size_t n = 0; n < rows(); ++n)
    for (int i = 0; i < 6; ++i) largest = std::max(largest, double(diagonal(n)[7 * i]));
  return largest;
}

template class CoarseMatrix<float>;
template class CoarseMatrix<double>;

}  // namespace lappet
