// Sparse symmetric matrices of rigid modes: 6x6 blocks (three translations, three rotations) by rows, the upper
// triangle stored. A product reads each block twice, for its row and for its column; neighbors are near each other, so
// the second time it is in the cache.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "solve/multigrid/coarse_lattice.h"
#include "solve/multigrid/coarse_product.h"

namespace lappet {

// A stiff linear functional of rigid modes, c = sum_k rows_k q_k: a constraint of the fine lattice seen from a coarse
// one. Kept apart from the matrix, whose digits a very stiff constraint would eat.
struct CoarseConstraint {
  std::vector<Index> nodes;  // ascending
  std::vector<Eigen::Matrix<double, 3, 6>> rows;
  double stiffness = 0.0;  // mN/mm
};

// Gathers the rows of a constraint.
class ConstraintRows {
 public:
  void add(Index node, const Eigen::Matrix<double, 3, 6>& row) {
    const auto [entry, inserted] = rows_.try_emplace(node, row);
    if (!inserted) entry->second += row;
  }
  CoarseConstraint constraint(double stiffness) const {
    CoarseConstraint result;
    for (const auto& [node, row] : rows_) {
      result.nodes.push_back(node);
      result.rows.push_back(row);
    }
    result.stiffness = stiffness;
    return result;
  }

 private:
  std::map<Index, Eigen::Matrix<double, 3, 6>> rows_;
};

template <class Real>
class CoarseMatrix {
 public:
  // Couples the nodes of every cell. Holds no numbers before set_zero.
  explicit CoarseMatrix(const CoarseLattice& lattice);

  std::size_t rows() const { return start_.size() - 1; }
  // Calls body(column, block, is_turned) for the couplings of a row, columns ascending; a turned block is the transpose
  // of what stands there.
  template <class Body>
  void for_each(std::size_t row, const Body& body) const {
    for (auto l = left_start_[row]; l < left_start_[row + 1]; ++l) {
      const LeftBlock& left = left_[l];
      body(left.row, block(left.slot), true);
    }
    for (auto s = start_[row]; s < start_[row + 1]; ++s) body(column_[s], block(s), false);
  }
  // Of a row from its diagonal on, and the slot of the first.
  std::span<const Index> columns(std::size_t row) const {
    return std::span(column_).subspan(first(row), start_[row + 1] - start_[row]);
  }
  std::size_t first(std::size_t row) const { return start_[row]; }
  // Row-major 6x6.
  Real* block(std::size_t slot) { return &blocks_[36 * slot]; }
  const Real* block(std::size_t slot) const { return &blocks_[36 * slot]; }
  // The slot of a coupled pair, row <= column.
  std::size_t slot(Index row, Index column) const;
  const Real* diagonal(std::size_t row) const { return block(first(row)); }
  void set_zero();
  // Gives the numbers' memory back, until the next set_zero.
  void release() { blocks_ = {}; }
  // Adds the blocks (kModePairSize numbers each, as in projected_stiffness_kernel.h) of the coarse cells from
  // `first_cell` on. What is added cell after cell, in whatever batches, has the same bits.
  void add(const CoarseLattice& lattice, std::size_t first_cell, std::span<const Real> cell_blocks);
  void multiply(std::span<const Real> x, std::span<Real> y) const;
  double largest_diagonal() const;
  std::size_t bytes() const {
    return blocks_.size() * sizeof(Real) + 4 * (start_.size() + column_.size() + left_start_.size() + 2 * left_.size());
  }

 private:
  std::vector<Index> start_, column_;  // by rows, from the diagonal on
  std::vector<Index> left_start_;      // by rows, what stands left of the diagonal: blocks of other rows
  std::vector<LeftBlock> left_;
  std::vector<Real> blocks_;  // and kCoarsePadding more
  CoarseProduct<Real> product_;
};

extern template class CoarseMatrix<float>;
extern template class CoarseMatrix<double>;

}  // namespace lappet
