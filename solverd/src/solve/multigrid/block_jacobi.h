// The splitting D of a block-Jacobi iteration: Size x Size blocks B per node, stored as packed symmetric inverses, and
// constraints, D = B + sum_t s_t A_t^T A_t with three rows A_t each, so that stiff sutures cost no iterations
// (Woodbury):
//   D^-1 = B^-1 - B^-1 A^T (S^-1 + A B^-1 A^T)^-1 A B^-1
// Constraints couple in the matrix in the middle where they share nodes: it is as sparse as they are few.
#pragma once
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "math/index.h"
#include "math/parallel.h"

namespace lappet {

template <class Real, int Size>
class BlockJacobi {
 public:
  static constexpr std::size_t kSize = Size, kPacked = Size * (Size + 1) / 2;
  using Block = Eigen::Matrix<double, Size, Size>;

  void resize(std::size_t nodes) { inverse_.resize(kPacked * nodes); }
  std::size_t nodes() const { return inverse_.size() / kPacked; }
  // All of them before set_constraints.
  void set(std::size_t node, const Block& block) {
    const Block inverse = block.inverse();
    std::size_t k = kPacked * node;
    for (int i = 0; i < Size; ++i)
      for (int j = 0; j <= i; ++j) inverse_[k++] = Real(0.5 * (inverse(i, j) + inverse(j, i)));
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
        for (int j = i; j < 3; ++j) block(i, j) = block(j, i) = double(*entry++);
      set(n, block);
    });
  }
  std::span<Real> storage() { return inverse_; }
  // Constraints with members `nodes` (distinct), `rows` (3 x Size each) and `stiffness`.
  template <class Constraints>
  void set_constraints(const Constraints& constraints) {
    constrained_nodes_.clear();
    for (const auto& constraint : constraints)
      for (const Index n : constraint.nodes)
        if (is_set(n)) constrained_nodes_.push_back(n);
    std::sort(constrained_nodes_.begin(), constrained_nodes_.end());
    constrained_nodes_.erase(std::unique(constrained_nodes_.begin(), constrained_nodes_.end()),
                             constrained_nodes_.end());
    constrained_inverse_.resize(constrained_nodes_.size());
    constrained_z_.resize(constrained_nodes_.size());
    for (std::size_t t = 0; t < constrained_nodes_.size(); ++t) {
      Real* packed = &inverse_[offset_of(kPacked, constrained_nodes_[t])];
      for (int i = 0, k = 0; i < Size; ++i)
        for (int j = 0; j <= i; ++j, ++k)
          constrained_inverse_[t](i, j) = constrained_inverse_[t](j, i) = double(packed[k]);
      std::fill_n(packed, kPacked, Real(0));
    }
    constraint_start_.assign(1, 0);
    constraint_entries_.clear();
    std::vector<EntriesOfNode> of_node(constrained_nodes_.size());
    std::vector<Row> rows;
    std::vector<Eigen::Triplet<double>> middle;  // the lower half
    for (const auto& constraint : constraints) {
      const Index index = to_index(constraint_start_.size() - 1);
      for (std::size_t k = 0; k < constraint.nodes.size(); ++k) {
        const auto found = std::lower_bound(constrained_nodes_.begin(), constrained_nodes_.end(), constraint.nodes[k]);
        if (found == constrained_nodes_.end() || *found != constraint.nodes[k]) continue;
        const std::size_t local = found - constrained_nodes_.begin();
        of_node[local].emplace_back(index, rows.size());
        rows.push_back(constraint.rows[k]);
        constraint_entries_.push_back({local, constrained_inverse_[local] * constraint.rows[k].transpose()});
      }
      constraint_start_.push_back(constraint_entries_.size());
      for (int i = 0; i < 3; ++i)
        middle.emplace_back(3 * index + i, 3 * index + i, 1.0 / std::max(constraint.stiffness, kMinStiffness));
    }
    couple_constraints(of_node, rows, middle);
    const Eigen::Index size = 3 * (constraint_start_.size() - 1);
    constraint_values_.resize(size);
    if (constrained_nodes_.empty()) return;
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(middle.begin(), middle.end());
    middle_.compute(matrix);
  }
  std::size_t bytes() const { return inverse_.size() * sizeof(Real); }

  // One pass each:
  // r = b; d = scale D^-1 r; x = d
  void first(Real scale, const Real* b, Real* r, Real* d, Real* x) const {
    pass([=](std::size_t i) { return r[i] = b[i]; }, [=](std::size_t i, Real z) { x[i] = d[i] = scale * z; });
    solve_constrained(scale, r, d, x);
  }
  // r -= q; d = keep d + scale D^-1 r; x += d
  void next(Real keep, Real scale, const Real* q, Real* r, Real* d, Real* x) const {
    pass([=](std::size_t i) { return r[i] -= q[i]; },
         [=](std::size_t i, Real z) {
           d[i] = keep * d[i] + scale * z;
           x[i] += d[i];
         });
    solve_constrained(scale, r, d, x);
  }
  // r -= q; e = d, d = scale D^-1 r; x += e + d
  void resume(Real scale, const Real* q, Real* r, Real* d, Real* x) const {
    pass([=](std::size_t i) { return r[i] -= q[i]; },
         [=](std::size_t i, Real z) {
           const Real e = d[i];
           d[i] = scale * z;
           x[i] += e + d[i];
         });
    solve_constrained(scale, r, d, x);
  }
  // z = D^-1 r
  void divide(const Real* r, Real* z) const {
    pass([=](std::size_t i) { return r[i]; }, [=](std::size_t i, Real value) { z[i] = value; });
    solve_constrained(Real(1), r, z, nullptr);
  }

 private:
  using Row = Eigen::Matrix<double, 3, Size>;
  using EntriesOfNode = std::vector<std::pair<std::int32_t, std::size_t>>;  // constraint, entry

  // Adds A B^-1 A^T, its lower half. Two constraints share many nodes: their block is added up before it goes in.
  void couple_constraints(const std::vector<EntriesOfNode>& of_node, const std::vector<Row>& rows,
                          std::vector<Eigen::Triplet<double>>& middle) const {
    using Coupled = std::pair<std::int32_t, Eigen::Matrix3d>;
    std::vector<std::vector<Coupled>> coupled(constraint_start_.size() - 1);
    for (const auto& entries : of_node)
      for (const auto& [a, row] : entries)
        for (const auto& [b, gain] : entries) {
          if (b > a) continue;
          const Eigen::Matrix3d block = rows[row] * constraint_entries_[gain].gain;
          auto& of_a = coupled[static_cast<std::size_t>(a)];
          const auto found = std::ranges::find(of_a, b, &Coupled::first);
          if (found == of_a.end())
            of_a.emplace_back(b, block);
          else
            found->second += block;
        }
    for (std::int32_t a = 0; a < to_index(coupled.size()); ++a)
      for (const auto& [b, block] : coupled[static_cast<std::size_t>(a)])
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < (a == b ? i + 1 : 3); ++j) middle.emplace_back(3 * a + i, 3 * b + j, block(i, j));
  }

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
  // d += scale D^-1 r, x += the same, on constrained nodes
  void solve_constrained(Real scale, const Real* r, Real* d, Real* x) const {
    if (constrained_nodes_.empty()) return;
    const auto at = [&](std::size_t t) { return offset_of(kSize, constrained_nodes_[t]); };
    const auto force = [&](std::size_t t) {
      return Eigen::Map<const Eigen::Matrix<Real, Size, 1>>(r + at(t)).template cast<double>();
    };
    for (std::size_t t = 0; t < constrained_nodes_.size(); ++t) constrained_z_[t] = constrained_inverse_[t] * force(t);
    for (std::size_t t = 0; t + 1 < constraint_start_.size(); ++t) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (std::size_t k = constraint_start_[t]; k < constraint_start_[t + 1]; ++k)
        sum += constraint_entries_[k].gain.transpose() * force(constraint_entries_[k].node);
      constraint_values_.template segment<3>(3 * t) = sum;
    }
    constraint_values_ = middle_.solve(constraint_values_);
    for (std::size_t t = 0; t + 1 < constraint_start_.size(); ++t)
      for (std::size_t k = constraint_start_[t]; k < constraint_start_[t + 1]; ++k)
        constrained_z_[constraint_entries_[k].node] -=
            constraint_entries_[k].gain * constraint_values_.template segment<3>(3 * t);
    for (std::size_t t = 0; t < constrained_nodes_.size(); ++t)
      for (std::size_t i = 0; i < kSize; ++i) {
        const Real value = scale * Real(constrained_z_[t][i]);
        d[at(t) + i] += value;
        if (x) x[at(t) + i] += value;
      }
  }
  bool is_set(Index node) const { return inverse_[offset_of(kPacked, node)] != Real(0); }

  static constexpr double kMinStiffness = 1e-30;
  struct ConstraintEntry {
    std::size_t node;                     // among the constrained nodes
    Eigen::Matrix<double, Size, 3> gain;  // B^-1 A^T
  };

  std::vector<Real> inverse_;  // lower triangles by rows; zero at prescribed and constrained nodes
  std::vector<Index> constrained_nodes_;
  std::vector<Block> constrained_inverse_;
  std::vector<std::size_t> constraint_start_;  // per constraint, into the entries
  std::vector<ConstraintEntry> constraint_entries_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> middle_;
  mutable std::vector<Eigen::Matrix<double, Size, 1>> constrained_z_;
  mutable Eigen::VectorXd constraint_values_;
};

}  // namespace lappet
