// Sparse Cholesky (CHOLMOD) of a matrix of rigid modes with its constraints. The ordering is found on nodes, the
// analysis is kept while the pattern stays.
#pragma once
#include <cholmod.h>

#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "solve/multigrid/coarse_matrix.h"

namespace lappet {

struct NotDefiniteError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class CoarseCholesky {
 public:
  CoarseCholesky();
  ~CoarseCholesky();
  CoarseCholesky(const CoarseCholesky&) = delete;
  CoarseCholesky& operator=(const CoarseCholesky&) = delete;

  // Factors matrix + constraints + shift times the largest diagonal of the matrix, with a larger shift where that is
  // not definite, and releases the matrix's numbers. Throws NotDefiniteError if none helps.
  template <class Real>
  void factor(CoarseMatrix<Real>& matrix, std::span<const CoarseConstraint> constraints, double shift);
  // Six numbers a node.
  template <class Real>
  void solve(std::span<const Real> b, std::span<Real> x);
  // Frees the numbers of the factor, keeps the analysis.
  void release();
  std::size_t analyses() const { return analyses_; }
  std::size_t bytes() const;

 private:
  struct Free {
    cholmod_common* common;
    void operator()(cholmod_sparse* p) const { cholmod_free_sparse(&p, common); }
    void operator()(cholmod_factor* p) const { cholmod_free_factor(&p, common); }
    void operator()(cholmod_dense* p) const { cholmod_free_dense(&p, common); }
  };
  template <class T>
  using Owned = std::unique_ptr<T, Free>;
  template <class T>
  Owned<T> own(T* p) {
    return Owned<T>(p, Free{&common_});
  }

  void update_pattern(std::size_t nodes, std::span<const CoarseConstraint> constraints,
                      const std::function<std::span<const Index>(std::size_t)>& columns_of);
  void analyze(std::size_t nodes);
  template <class Real>
  void fill(const CoarseMatrix<Real>& matrix, std::span<const CoarseConstraint> constraints);
  Index entry(Index row, Index column) const;  // of the lower block pattern

  cholmod_common common_{};
  std::vector<Index> start_, row_;       // by block columns: rows >= column, ascending
  std::vector<Index> constraint_nodes_;  // the constraints the pattern was made for: sizes and nodes
  Owned<cholmod_sparse> matrix_;
  Owned<cholmod_factor> factor_;
  Owned<cholmod_dense> b_;
  cholmod_dense *x_ = nullptr, *y_ = nullptr, *e_ = nullptr;  // cholmod_solve2 keeps them
  std::size_t analyses_ = 0;
};

}  // namespace lappet
