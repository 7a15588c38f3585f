// The splitting D of a block-Jacobi iteration: Size x Size blocks B per node, stored as packed symmetric inverses, and
// ties, D = B + sum_t s_t A_t^T A_t with three rows A_t each, so that stiff sutures cost no iterations (Woodbury):
//   D^-1 = B^-1 - B^-1 A^T (S^-1 + A B^-1 A^T)^-1 A B^-1
// Ties couple in the matrix in the middle where they share nodes: it is as sparse as they are few.
#pragma once
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "math/parallel.h"

namespace lappet {

template <class Real, int Size>
class BlockJacobi {
 public:
  static constexpr std::size_t kSize = Size, kPacked = Size * (Size + 1) / 2;
  using Block = Eigen::Matrix<double, Size, Size>;

  void resize(std::size_t nodes) { inverse_.resize(kPacked * nodes); }
  std::size_t nodes() const { return inverse_.size() / kPacked; }
  // All of them before set_ties.
  void set(std::size_t node, const Block& block) {
    const Block inverse = block.inverse();
    std::size_t k = kPacked * node;
    for (int i = 0; i < Size; ++i)
      for (int j = 0; j <= i; ++j) inverse_[k++] = static_cast<Real>(0.5 * (inverse(i, j) + inverse(j, i)));
  }
  // Inverts the blocks that storage() holds by upper triangles, 00 01 02 11 12 22 each; those of nodes that are not
  // free divide to zero.
  template <class IsFree>
  void set_from_storage(const IsFree& is_free)
    requires(Size == 3)
  {
    for_each_index(nodes(), [&](std::size_t n) {
      const Real* entry = &inverse_[kPacked * n];
      if (!is_free(n)) {
        std::fill_n(&inverse_[kPacked * n], kPacked, Real(0));
        return;
      }
      Block block;
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) block(i, j) = block(j, i) = static_cast<double>(*entry++);
      set(n, block);
    });
  }
  std::span<Real> storage() { return inverse_; }
  // Ties with members `nodes` (distinct), `rows` (3 x Size each) and `stiffness`.
  template <class Ties>
  void set_ties(const Ties& ties) {
    tied_nodes_.clear();
    for (const auto& tie : ties)
      for (const std::int32_t n : tie.nodes)
        if (is_set(n)) tied_nodes_.push_back(n);
    std::sort(tied_nodes_.begin(), tied_nodes_.end());
    tied_nodes_.erase(std::unique(tied_nodes_.begin(), tied_nodes_.end()), tied_nodes_.end());
    tied_inverse_.resize(tied_nodes_.size());
    tied_z_.resize(tied_nodes_.size());
    for (std::size_t t = 0; t < tied_nodes_.size(); ++t) {
      Real* packed = &inverse_[kPacked * static_cast<std::size_t>(tied_nodes_[t])];
      for (int i = 0, k = 0; i < Size; ++i)
        for (int j = 0; j <= i; ++j, ++k) tied_inverse_[t](i, j) = tied_inverse_[t](j, i) = double(packed[k]);
      std::fill_n(packed, kPacked, Real(0));
    }
    tie_start_.assign(1, 0);
    tie_entries_.clear();
    std::vector<std::vector<std::pair<std::int32_t, std::size_t>>> of_node(tied_nodes_.size());  // tie, entry
    std::vector<Eigen::Matrix<double, 3, Size>> rows;
    std::vector<Eigen::Triplet<double>> middle;  // the lower half
    for (const auto& tie : ties) {
      const auto index = static_cast<std::int32_t>(tie_start_.size() - 1);
      for (std::size_t k = 0; k < tie.nodes.size(); ++k) {
        const auto found = std::lower_bound(tied_nodes_.begin(), tied_nodes_.end(), tie.nodes[k]);
        if (found == tied_nodes_.end() || *found != tie.nodes[k]) continue;
        const auto local = static_cast<std::size_t>(found - tied_nodes_.begin());
        of_node[local].emplace_back(index, rows.size());
        rows.push_back(tie.rows[k]);
        tie_entries_.push_back({local, tied_inverse_[local] * tie.rows[k].transpose()});
      }
      tie_start_.push_back(tie_entries_.size());
      for (int i = 0; i < 3; ++i)
        middle.emplace_back(3 * index + i, 3 * index + i, 1.0 / std::max(tie.stiffness, kLeastStiffness));
    }
    for (const auto& entries : of_node)
      for (const auto& [a, row] : entries)
        for (const auto& [b, gain] : entries) {
          if (b > a) continue;
          const Eigen::Matrix3d block = rows[row] * tie_entries_[gain].gain;
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < (a == b ? i + 1 : 3); ++j) middle.emplace_back(3 * a + i, 3 * b + j, block(i, j));
        }
    const auto size = static_cast<Eigen::Index>(3 * (tie_start_.size() - 1));
    tie_values_.resize(size);
    if (tied_nodes_.empty()) return;
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(middle.begin(), middle.end());
    middle_.compute(matrix);
  }
  std::size_t bytes() const { return inverse_.size() * sizeof(Real); }

  // One pass each:
  // r = b; d = scale D^-1 r; x = d
  void first(Real scale, const Real* b, Real* r, Real* d, Real* x) const {
    pass([=](std::size_t i) { return r[i] = b[i]; }, [=](std::size_t i, Real z) { x[i] = d[i] = scale * z; });
    solve_tied(scale, r, d, x);
  }
  // r -= q; d = keep d + scale D^-1 r; x += d
  void next(Real keep, Real scale, const Real* q, Real* r, Real* d, Real* x) const {
    pass([=](std::size_t i) { return r[i] -= q[i]; },
         [=](std::size_t i, Real z) {
           d[i] = keep * d[i] + scale * z;
           x[i] += d[i];
         });
    solve_tied(scale, r, d, x);
  }
  // r -= q; e = d, d = scale D^-1 r; x += e + d
  void resume(Real scale, const Real* q, Real* r, Real* d, Real* x) const {
    pass([=](std::size_t i) { return r[i] -= q[i]; },
         [=](std::size_t i, Real z) {
           const Real e = d[i];
           d[i] = scale * z;
           x[i] += e + d[i];
         });
    solve_tied(scale, r, d, x);
  }
  // z = D^-1 r
  void divide(const Real* r, Real* z) const {
    pass([=](std::size_t i) { return r[i]; }, [=](std::size_t i, Real value) { z[i] = value; });
    solve_tied(Real(1), r, z, nullptr);
  }

 private:
  template <class Read, class Write>
  void pass(const Read& read, const Write& write) const {
    for_each_chunk(nodes(), [&](std::size_t, std::size_t begin, std::size_t end) {
      const Real* m = &inverse_[kPacked * begin];
      for (std::size_t n = begin; n < end; ++n, m += kPacked) {
        Real r[kSize], z[kSize];
        for (std::size_t i = 0; i < kSize; ++i) {
          r[i] = read(kSize * n + i);
          z[i] = Real(0);
        }
        std::size_t k = 0;
        for (std::size_t i = 0; i < kSize; ++i)
          for (std::size_t j = 0; j <= i; ++j, ++k) {
            z[i] += m[k] * r[j];
            if (j < i) z[j] += m[k] * r[i];
          }
        for (std::size_t i = 0; i < kSize; ++i) write(kSize * n + i, z[i]);
      }
    });
  }
  // d += scale D^-1 r, x += the same, on tied nodes
  void solve_tied(Real scale, const Real* r, Real* d, Real* x) const {
    if (tied_nodes_.empty()) return;
    const auto at = [&](std::size_t t) { return kSize * static_cast<std::size_t>(tied_nodes_[t]); };
    const auto force = [&](std::size_t t) {
      return Eigen::Map<const Eigen::Matrix<Real, Size, 1>>(r + at(t)).template cast<double>();
    };
    for (std::size_t t = 0; t < tied_nodes_.size(); ++t) tied_z_[t] = tied_inverse_[t] * force(t);
    for (std::size_t t = 0; t + 1 < tie_start_.size(); ++t) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (std::size_t k = tie_start_[t]; k < tie_start_[t + 1]; ++k)
        sum += tie_entries_[k].gain.transpose() * force(tie_entries_[k].node);
      tie_values_.template segment<3>(static_cast<Eigen::Index>(3 * t)) = sum;
    }
    tie_values_ = middle_.solve(tie_values_);
    for (std::size_t t = 0; t + 1 < tie_start_.size(); ++t)
      for (std::size_t k = tie_start_[t]; k < tie_start_[t + 1]; ++k)
        tied_z_[tie_entries_[k].node] -=
            tie_entries_[k].gain * tie_values_.template segment<3>(static_cast<Eigen::Index>(3 * t));
    for (std::size_t t = 0; t < tied_nodes_.size(); ++t)
      for (std::size_t i = 0; i < kSize; ++i) {
        const Real value = scale * static_cast<Real>(tied_z_[t][static_cast<Eigen::Index>(i)]);
        d[at(t) + i] += value;
        if (x) x[at(t) + i] += value;
      }
  }
  bool is_set(std::int32_t node) const { return inverse_[kPacked * static_cast<std::size_t>(node)] != Real(0); }

  static constexpr double kLeastStiffness = 1e-30;
  struct TieEntry {
    std::size_t node;                     // among the tied nodes
    Eigen::Matrix<double, Size, 3> gain;  // B^-1 A^T
  };

  std::vector<Real> inverse_;  // lower triangles by rows; zero at prescribed and tied nodes
  std::vector<std::int32_t> tied_nodes_;
  std::vector<Block> tied_inverse_;
  std::vector<std::size_t> tie_start_;  // per tie, into the entries
  std::vector<TieEntry> tie_entries_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> middle_;
  mutable std::vector<Eigen::Matrix<double, Size, 1>> tied_z_;
  mutable Eigen::VectorXd tie_values_;
};

}  // namespace lappet
