#include "solve/smoother.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "solve/vectors.h"

namespace lappet {

namespace {

// Chebyshev damps the part of the spectrum of D^-1 K above largest / (kRange degree); the coarse space has the rest.
constexpr double kRange = 4.0;
// Power iterations: many from a random start, few when the last vector is at hand. The estimate is from below.
constexpr int kFirstIterations = 15, kNextIterations = 5;
constexpr double kMargin = 1.15;

}  // namespace

template <class Real>
void Smoother<Real>::update() {
  const std::size_t n = system_.nodes();
  std::vector<double> blocks(9 * n);
  system_.elastic().diagonal_blocks(blocks);
  system_.for_each_push([&](const Push& push) {
    const auto& nodes = system_.lattice().cell_nodes[static_cast<std::size_t>(push.cell)];
    for (std::size_t k = 0; k < 8; ++k)
      Eigen::Map<Eigen::Matrix3d>(&blocks[9 * static_cast<std::size_t>(nodes[k])]) +=
          push.stiffness * push.weights[k] * push.weights[k] * push.direction * push.direction.transpose();
  });
  inverse_blocks_.assign(9 * n, Real(0));
  std::vector<std::uint8_t> tied(n, 0);
  for (const auto& tie : system_.ties())
    for (const std::int32_t node : tie.nodes)
      if (system_.is_free(static_cast<std::size_t>(node))) tied[static_cast<std::size_t>(node)] = 1;
  tied_nodes_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    if (tied[i]) tied_nodes_.push_back(static_cast<std::int32_t>(i));
    if (!system_.is_free(i) || tied[i]) continue;
    const Eigen::Matrix3d inverse = Eigen::Map<const Eigen::Matrix3d>(&blocks[9 * i]).inverse();
    for (int k = 0; k < 9; ++k)
      inverse_blocks_[9 * i + static_cast<std::size_t>(k)] = static_cast<Real>(inverse.data()[k]);
  }
  for (auto* v : {&residual_, &direction_, &divided_, &product_}) v->resize(3 * n);
  factor_tied_nodes();
  estimate_largest_eigenvalue();
}

template <class Real>
void Smoother<Real>::factor_tied_nodes() {
  if (tied_nodes_.empty()) return;
  std::unordered_map<std::int32_t, int> local;
  for (std::size_t i = 0; i < tied_nodes_.size(); ++i) local[tied_nodes_[i]] = static_cast<int>(i);
  std::vector<Eigen::Triplet<double>> entries;
  const auto& lattice = system_.lattice();
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    const auto& corners = lattice.cell_nodes[c];
    int index[8];
    bool any = false;
    for (std::size_t k = 0; k < 8; ++k) {
      const auto found = local.find(corners[k]);
      index[k] = found == local.end() ? -1 : found->second;
      any = any || index[k] >= 0;
    }
    if (!any) continue;
    const Matrix24 stiffness = system_.elastic().cell_stiffness(static_cast<std::int32_t>(c));
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        if (index[a] >= 0 && index[b] >= 0)
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
              entries.emplace_back(3 * index[a] + i, 3 * index[b] + j, stiffness(3 * a + i, 3 * b + j));
  }
  for (const auto& tie : system_.ties())
    for (std::size_t a = 0; a < tie.nodes.size(); ++a)
      for (std::size_t b = 0; b < tie.nodes.size(); ++b) {
        const auto ia = local.find(tie.nodes[a]), ib = local.find(tie.nodes[b]);
        if (ia == local.end() || ib == local.end()) continue;
        for (int i = 0; i < 3; ++i)
          entries.emplace_back(3 * ia->second + i, 3 * ib->second + i, tie.stiffness * tie.weights[a] * tie.weights[b]);
      }
  system_.for_each_push([&](const Push& push) {
    const auto& corners = lattice.cell_nodes[static_cast<std::size_t>(push.cell)];
    for (std::size_t a = 0; a < 8; ++a)
      for (std::size_t b = 0; b < 8; ++b) {
        const auto ia = local.find(corners[a]), ib = local.find(corners[b]);
        if (ia == local.end() || ib == local.end()) continue;
        const Eigen::Matrix3d block =
            push.stiffness * push.weights[a] * push.weights[b] * push.direction * push.direction.transpose();
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) entries.emplace_back(3 * ia->second + i, 3 * ib->second + j, block(i, j));
      }
  });
  const auto size = static_cast<Eigen::Index>(3 * tied_nodes_.size());
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  tied_.compute(matrix);
}

template <class Real>
void Smoother<Real>::divide(std::span<const Real> r, std::span<Real> z) const {
  for_each_index(system_.nodes(), [&](std::size_t n) {
    const Real* m = &inverse_blocks_[9 * n];
    const Real a = r[3 * n], b = r[3 * n + 1], c = r[3 * n + 2];
    z[3 * n] = m[0] * a + m[3] * b + m[6] * c;
    z[3 * n + 1] = m[1] * a + m[4] * b + m[7] * c;
    z[3 * n + 2] = m[2] * a + m[5] * b + m[8] * c;
  });
  if (tied_nodes_.empty()) return;
  Eigen::VectorXd local(static_cast<Eigen::Index>(3 * tied_nodes_.size()));
  for (std::size_t i = 0; i < tied_nodes_.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      local[static_cast<Eigen::Index>(3 * i + k)] =
          static_cast<double>(r[3 * static_cast<std::size_t>(tied_nodes_[i]) + k]);
  local = tied_.solve(local);
  for (std::size_t i = 0; i < tied_nodes_.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      z[3 * static_cast<std::size_t>(tied_nodes_[i]) + k] =
          static_cast<Real>(local[static_cast<Eigen::Index>(3 * i + k)]);
}

template <class Real>
void Smoother<Real>::estimate_largest_eigenvalue() {
  const std::size_t n = system_.nodes();
  int iterations = kNextIterations;
  if (eigenvector_.size() != 3 * n) {
    iterations = kFirstIterations;
    eigenvector_.resize(3 * n);
    std::uint32_t seed = 1;
    for (auto& value : eigenvector_) {
      seed = seed * 1664525u + 1013904223u;
      value = static_cast<Real>(seed >> 8) / static_cast<Real>(1u << 24) - Real(0.5);
    }
  }
  for (std::size_t i = 0; i < n; ++i)
    if (!system_.is_free(i)) eigenvector_[3 * i] = eigenvector_[3 * i + 1] = eigenvector_[3 * i + 2] = Real(0);
  double largest = 0.0;
  for (int k = 0; k < iterations; ++k) {
    const double length = std::sqrt(dot<Real>(eigenvector_, eigenvector_));
    if (!(length > 0.0)) break;
    scale<Real>(static_cast<Real>(1.0 / length), eigenvector_);
    system_.multiply(eigenvector_, product_);
    divide(product_, eigenvector_);
    largest = std::sqrt(dot<Real>(eigenvector_, eigenvector_));
  }
  // K is a sum of positive semidefinite cells of eight nodes: the eigenvalues of D^-1 K cannot exceed eight (ties:
  // nine).
  largest_ = std::min(kMargin * largest, 9.0);
}

template <class Real>
void Smoother<Real>::apply(std::span<const Real> b, std::span<Real> x) const {
  const double upper = largest_, lower = upper / (kRange * degree_);
  const double centre = 0.5 * (upper + lower), half = 0.5 * (upper - lower), sigma = centre / half;
  double rho = 1.0 / sigma;
  copy<Real>(b, residual_);
  divide(residual_, direction_);
  scale<Real>(static_cast<Real>(1.0 / centre), direction_);
  copy<Real>(direction_, x);
  for (int k = 1; k < degree_; ++k) {
    system_.multiply(direction_, product_);
    add<Real>(Real(-1), product_, residual_);
    divide(residual_, divided_);
    const double next = 1.0 / (2.0 * sigma - rho);
    combine<Real>(static_cast<Real>(next * rho), static_cast<Real>(2.0 * next / half), divided_, direction_);
    rho = next;
    add<Real>(Real(1), direction_, x);
  }
}

template class Smoother<float>;
template class Smoother<double>;

}  // namespace lappet
