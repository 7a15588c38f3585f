// Sparse matrices of rigid frames: 6x6 blocks (three translations, three rotations) by rows, both triangles stored.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "solve/coarse_lattice.h"

namespace lappet {

// A stiff linear functional of frames, c = sum_k rows_k q_k: a tie of the fine lattice seen from a coarse one. Kept
// apart from the matrix, whose digits a very stiff tie would eat.
struct FrameTie {
  std::vector<std::int32_t> nodes;  // ascending
  std::vector<Eigen::Matrix<double, 3, 6>> rows;
  double stiffness = 0.0;  // mN/mm
};

// Gathers the rows of a tie.
class TieRows {
 public:
  void add(std::int32_t node, const Eigen::Matrix<double, 3, 6>& row) {
    const auto [entry, inserted] = rows_.try_emplace(node, row);
    if (!inserted) entry->second += row;
  }
  FrameTie tie(double stiffness) const {
    FrameTie result;
    for (const auto& [node, row] : rows_) {
      result.nodes.push_back(node);
      result.rows.push_back(row);
    }
    result.stiffness = stiffness;
    return result;
  }

 private:
  std::map<std::int32_t, Eigen::Matrix<double, 3, 6>> rows_;
};

template <class Real>
class FrameMatrix {
 public:
  // Couples the nodes of every cell; zero.
  explicit FrameMatrix(const CoarseLattice& lattice);

  std::size_t rows() const { return row_start_.size() - 1; }
  std::span<const std::int32_t> columns(std::size_t row) const {
    return std::span(column_).subspan(static_cast<std::size_t>(row_start_[row]),
                                      static_cast<std::size_t>(row_start_[row + 1] - row_start_[row]));
  }
  std::size_t first(std::size_t row) const { return static_cast<std::size_t>(row_start_[row]); }
  // Row-major 6x6.
  Real* block(std::size_t slot) { return &blocks_[36 * slot]; }
  const Real* block(std::size_t slot) const { return &blocks_[36 * slot]; }
  // The slot of a coupled pair.
  std::size_t slot(std::int32_t row, std::int32_t column) const;
  const Real* diagonal(std::size_t row) const {
    return block(slot(static_cast<std::int32_t>(row), static_cast<std::int32_t>(row)));
  }
  void set_zero();
  // Adds the blocks (kFramePairSize numbers each, as in projected_stiffness_kernel.h) of the coarse cells from
  // `first_cell` on. What is added cell after cell, in whatever batches, has the same bits.
  void add(const CoarseLattice& lattice, std::size_t first_cell, std::span<const Real> cell_blocks);
  void multiply(std::span<const Real> x, std::span<Real> y) const;
  double largest_diagonal() const;
  std::size_t bytes() const { return blocks_.size() * sizeof(Real) + 4 * (row_start_.size() + column_.size()); }

 private:
  std::vector<std::int32_t> row_start_, column_;
  std::vector<Real> blocks_;
};

extern template class FrameMatrix<float>;
extern template class FrameMatrix<double>;

}  // namespace lappet
