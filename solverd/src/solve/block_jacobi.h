// The splitting D of a block-Jacobi iteration: Size x Size blocks per node, stored as packed symmetric inverses; the
// nodes that ties couple form one sparse block that is solved exactly, so that stiff sutures cost no iterations.
#pragma once
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
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

  void resize(std::size_t nodes) { inverse_.assign(kPacked * nodes, Real(0)); }
  std::size_t nodes() const { return inverse_.size() / kPacked; }
  // Blocks never set divide to zero.
  void set(std::size_t node, const Block& block) {
    const Block inverse = block.inverse();
    std::size_t k = kPacked * node;
    for (int i = 0; i < Size; ++i)
      for (int j = 0; j <= i; ++j) inverse_[k++] = static_cast<Real>(0.5 * (inverse(i, j) + inverse(j, i)));
  }
  // The exact block of some nodes, Size unknowns each in their order. The analysis is kept where `same_pattern`.
  void set_tied(std::span<const std::int32_t> nodes, const Eigen::SparseMatrix<double>& matrix, bool same_pattern) {
    tied_nodes_.assign(nodes.begin(), nodes.end());
    for (const std::int32_t n : nodes)
      std::fill_n(inverse_.begin() + static_cast<std::ptrdiff_t>(kPacked * static_cast<std::size_t>(n)), kPacked,
                  Real(0));
    if (tied_nodes_.empty()) return;
    if (!same_pattern) tied_.analyzePattern(matrix);
    tied_.factorize(matrix);
    tied_values_.resize(matrix.rows());
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
  // r -= q; d = scale D^-1 r; x += e + d
  void resume(Real scale, const Real* q, const Real* e, Real* r, Real* d, Real* x) const {
    pass([=](std::size_t i) { return r[i] -= q[i]; },
         [=](std::size_t i, Real z) {
           d[i] = scale * z;
           x[i] += e[i] + d[i];
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
    for (std::size_t i = 0; i < tied_nodes_.size(); ++i)
      for (std::size_t k = 0; k < kSize; ++k)
        tied_values_[static_cast<Eigen::Index>(kSize * i + k)] =
            double(r[kSize * static_cast<std::size_t>(tied_nodes_[i]) + k]);
    tied_values_ = tied_.solve(tied_values_);
    for (std::size_t i = 0; i < tied_nodes_.size(); ++i)
      for (std::size_t k = 0; k < kSize; ++k) {
        const std::size_t at = kSize * static_cast<std::size_t>(tied_nodes_[i]) + k;
        const Real value = scale * static_cast<Real>(tied_values_[static_cast<Eigen::Index>(kSize * i + k)]);
        d[at] += value;
        if (x) x[at] += value;
      }
  }

  std::vector<Real> inverse_;  // lower triangles by rows; zero at prescribed and tied nodes
  std::vector<std::int32_t> tied_nodes_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> tied_;
  mutable Eigen::VectorXd tied_values_;
};

}  // namespace lappet
