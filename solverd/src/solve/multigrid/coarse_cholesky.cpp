#include "solve/multigrid/coarse_cholesky.h"

#include <algorithm>

#include "solve/multigrid/serial_blas.h"

namespace lappet {

namespace {

constexpr double kMaxShift = 1e-1, kNextShift = 1e-5, kShiftFactor = 100.0;

}  // namespace

CoarseCholesky::CoarseCholesky()
    : matrix_(nullptr, Free{&common_}), factor_(nullptr, Free{&common_}), b_(nullptr, Free{&common_}) {
  keep_blas_serial();
  cholmod_start(&common_);
  common_.print = 0;
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.quick_return_if_not_posdef = 1;
}

CoarseCholesky::~CoarseCholesky() {
  for (auto** dense : {&x_, &y_, &e_}) cholmod_free_dense(dense, &common_);
  b_.reset();
  factor_.reset();
  matrix_.reset();
  cholmod_finish(&common_);
}

Index CoarseCholesky::entry(Index row, Index column) const {
  const auto begin = row_.begin() + start_[column], end = row_.begin() + start_[column + 1];
  return to_index(std::lower_bound(begin, end, row) - row_.begin());
}

// Orders the nodes, spreads the order over their six unknowns and analyses the pattern.
void CoarseCholesky::analyze(std::size_t nodes) {
  ++analyses_;
  const auto graph = own(cholmod_allocate_sparse(nodes, nodes, row_.size(), 1, 1, -1, CHOLMOD_PATTERN, &common_));
  std::copy(start_.begin(), start_.end(), static_cast<int*>(graph->p));
  std::copy(row_.begin(), row_.end(), static_cast<int*>(graph->i));
  common_.nmethods = 0;
  common_.postorder = 1;
  const auto ordered = own(cholmod_analyze(graph.get(), &common_));
  std::vector<int> order(6 * nodes);
  for (std::size_t n = 0; n < nodes; ++n)
    for (int i = 0; i < 6; ++i) order[6 * n + i] = 6 * static_cast<const int*>(ordered->Perm)[n] + i;

  std::size_t entries = 0;
  for (std::size_t n = 0; n < nodes; ++n) entries += 36 * std::size_t(start_[n + 1] - start_[n]) - 15;
  matrix_ = own(cholmod_allocate_sparse(6 * nodes, 6 * nodes, entries, 1, 1, -1, CHOLMOD_REAL, &common_));
  auto* p = static_cast<int*>(matrix_->p);
  auto* rows = static_cast<int*>(matrix_->i);
  int next = 0;
  for (std::size_t n = 0; n < nodes; ++n)
    for (int c = 0; c < 6; ++c) {
      p[6 * n + c] = next;
      for (auto i = start_[n]; i < start_[n + 1]; ++i)
        for (int r = i == start_[n] ? c : 0; r < 6; ++r) rows[next++] = 6 * row_[i] + r;
    }
  p[6 * nodes] = next;
  common_.nmethods = 1;
  common_.method[0].ordering = CHOLMOD_GIVEN;
  factor_ = own(cholmod_analyze_p(matrix_.get(), order.data(), nullptr, 0, &common_));
  b_ = own(cholmod_allocate_dense(6 * nodes, 1, 6 * nodes, CHOLMOD_REAL, &common_));
}

// Makes the block pattern of the matrix with the constraints anew where either has changed.
void CoarseCholesky::update_pattern(std::size_t nodes, std::span<const CoarseConstraint> constraints,
                                    const std::function<std::span<const Index>(std::size_t)>& columns_of) {
  std::vector<Index> constraint_nodes;
  for (const auto& constraint : constraints) {
    constraint_nodes.push_back(-to_index(constraint.nodes.size()));
    constraint_nodes.insert(constraint_nodes.end(), constraint.nodes.begin(), constraint.nodes.end());
  }
  if (factor_ && constraint_nodes == constraint_nodes_) return;
  constraint_nodes_ = std::move(constraint_nodes);
  std::vector<std::vector<Index>> extra(nodes);
  for (const auto& constraint : constraints)
    for (auto node = constraint.nodes.begin(); node != constraint.nodes.end(); ++node)
      extra[*node].insert(extra[*node].end(), node, constraint.nodes.end());
  start_.assign(1, 0);
  row_.clear();
  for (std::size_t n = 0; n < nodes; ++n) {
    auto& rows = extra[n];
    for (const Index c : columns_of(n)) rows.push_back(c);
    std::sort(rows.begin(), rows.end());
    row_.insert(row_.end(), rows.begin(), std::unique(rows.begin(), rows.end()));
    start_.push_back(to_index(row_.size()));
  }
  analyze(nodes);
}

// Writes the matrix with the constraints where CHOLMOD has them, column by column of the lower triangle.
template <class Real>
void CoarseCholesky::fill(const CoarseMatrix<Real>& matrix, std::span<const CoarseConstraint> constraints) {
  auto* values = static_cast<double*>(matrix_->x);
  const auto* p = static_cast<const int*>(matrix_->p);
  std::fill_n(values, p[6 * matrix.rows()], 0.0);
  // Where entry (6 row + r, 6 column + c) of the lower triangle lies: the first block of a column lacks c rows above.
  const auto place = [&](std::size_t column, int c, Index entry, int r) {
    return p[6 * column + c] + 6 * (entry - start_[column]) + r - c;
  };
  for (std::size_t n = 0; n < matrix.rows(); ++n) {
    std::size_t slot = matrix.first(n);
    Index at = start_[n];
    for (const Index column : matrix.columns(n)) {
      const Real* block = matrix.block(slot++);
      while (row_[at] != column) ++at;
      // the block (n, column) is the transpose of (column, n)
      for (int c = 0; c < 6; ++c)
        for (int r = column == to_index(n) ? c : 0; r < 6; ++r) values[place(n, c, at, r)] = double(block[6 * c + r]);
    }
  }
  for (const auto& constraint : constraints)
    for (std::size_t a = 0; a < constraint.nodes.size(); ++a)
      for (std::size_t b = a; b < constraint.nodes.size(); ++b) {
        const Eigen::Matrix<double, 6, 6> block =
            constraint.stiffness * constraint.rows[b].transpose() * constraint.rows[a];
        const Index column = constraint.nodes[a], at = entry(constraint.nodes[b], column);
        for (int c = 0; c < 6; ++c)
          for (int r = a == b ? c : 0; r < 6; ++r) values[place(column, c, at, r)] += block(r, c);
      }
}

template <class Real>
void CoarseCholesky::factor(CoarseMatrix<Real>& matrix, std::span<const CoarseConstraint> constraints, double shift) {
  update_pattern(matrix.rows(), constraints, [&](std::size_t row) { return matrix.columns(row); });
  fill(matrix, constraints);
  const double largest = std::max(matrix.largest_diagonal(), 1e-30);
  const std::size_t unknowns = 6 * matrix.rows();
  matrix.release();
  auto* values = static_cast<double*>(matrix_->x);
  const auto* p = static_cast<const int*>(matrix_->p);
  for (double added = shift; added <= kMaxShift; added = std::max(kNextShift, kShiftFactor * added)) {
    for (std::size_t i = 0; i < unknowns; ++i) values[p[i]] += added * largest;
    cholmod_factorize(matrix_.get(), factor_.get(), &common_);
    if (common_.status == CHOLMOD_OK && factor_->minor == factor_->n) return;
  }
  throw NotDefiniteError("the coarse operator is not positive definite");
}

void CoarseCholesky::release() {
  if (factor_ && factor_->xtype != CHOLMOD_PATTERN)
    cholmod_change_factor(CHOLMOD_PATTERN, 1, 1, 1, 1, factor_.get(), &common_);
}

template <class Real>
void CoarseCholesky::solve(std::span<const Real> b, std::span<Real> x) {
  std::copy(b.begin(), b.end(), static_cast<double*>(b_->x));
  cholmod_solve2(CHOLMOD_A, factor_.get(), b_.get(), nullptr, &x_, nullptr, &y_, &e_, &common_);
  const auto* solution = static_cast<const double*>(x_->x);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = Real(solution[i]);
}

std::size_t CoarseCholesky::bytes() const { return factor_ ? std::size_t(8 * common_.lnz) : 0; }

template void CoarseCholesky::factor(CoarseMatrix<float>&, std::span<const CoarseConstraint>, double);
template void CoarseCholesky::factor(CoarseMatrix<double>&, std::span<const CoarseConstraint>, double);
template void CoarseCholesky::solve(std::span<const float>, std::span<float>);
template void CoarseCholesky::solve(std::span<const double>, std::span<double>);

}  // namespace lappet
