#include "solve/system/penalty_rows.h"

#include <cmath>

#include "math/parallel.h"

namespace lappet {

namespace {

constexpr std::size_t kRows = 512;  // at a time

}  // namespace

template <class Real>
void PenaltyRows<Real>::set(std::span<const ContactPenalty> penalties, const SparseRows& added,
                            const SparseRows& taken_off, const Lattice& lattice) {
  row_start_.assign(1, 0);
  of_row_.clear();
  std::vector<std::uint32_t> count(lattice.node_rest.size() + 1, 0);
  for (const ContactPenalty& penalty : penalties) {
    const Vec3 along = std::sqrt(penalty.stiffness) * penalty.direction;
    for (std::size_t k = 0; k < 8; ++k) {
      const double weight = penalty.weights[k];
      if (weight == 0.0) continue;
      const auto node = static_cast<std::uint32_t>(lattice.cell_nodes[static_cast<std::size_t>(penalty.cell)][k]);
      of_row_.push_back({node,
                         {static_cast<Real>(weight * along[0]), static_cast<Real>(weight * along[1]),
                          static_cast<Real>(weight * along[2])}});
      ++count[node];
    }
    row_start_.push_back(static_cast<std::uint32_t>(of_row_.size()));
  }
  const auto add = [&](const SparseRows& some) {
    for (std::size_t row = 0; row < some.count(); ++row) {
      for (std::uint32_t k = some.start[row]; k < some.start[row + 1]; ++k) {
        const Vec3& factor = some.factors[k];
        const auto node = static_cast<std::uint32_t>(some.nodes[k]);
        of_row_.push_back(
            {node, {static_cast<Real>(factor[0]), static_cast<Real>(factor[1]), static_cast<Real>(factor[2])}});
        ++count[node];
      }
      row_start_.push_back(static_cast<std::uint32_t>(of_row_.size()));
    }
  };
  add(added);
  taken_off_ = row_start_.size() - 1;
  add(taken_off);
  along_.resize(row_start_.size() - 1);
  nodes_.clear();
  node_start_.assign(1, 0);
  for (std::uint32_t node = 0; node + 1 < count.size(); ++node) {
    if (count[node] == 0) continue;
    nodes_.push_back(node);
    node_start_.push_back(node_start_.back() + count[node]);
    count[node] = node_start_[node_start_.size() - 2];  // from here on: where its next entry goes
  }
  of_node_.resize(of_row_.size());
  for (std::uint32_t row = 0; row + 1 < row_start_.size(); ++row)
    for (std::uint32_t k = row_start_[row]; k < row_start_[row + 1]; ++k)
      of_node_[count[of_row_[k].other]++] = {row, of_row_[k].factor};
}

template <class Real>
void PenaltyRows<Real>::add_product(std::span<const Real> x, std::span<Real> y) const {
  if (along_.empty()) return;
  for_each_chunk(
      along_.size(),
      [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
          Real sum(0);
          for (std::uint32_t k = row_start_[row]; k < row_start_[row + 1]; ++k) {
            const auto& [node, factor] = of_row_[k];
            const Real* at = &x[3 * std::size_t{node}];
            sum += factor[0] * at[0] + factor[1] * at[1] + factor[2] * at[2];
          }
          along_[row] = row < taken_off_ ? sum : -sum;
        }
      },
      kRows);
  for_each_chunk(
      nodes_.size(),
      [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
          Real sum[3] = {};
          for (std::uint32_t k = node_start_[n]; k < node_start_[n + 1]; ++k) {
            const auto& [row, factor] = of_node_[k];
            for (std::size_t i = 0; i < 3; ++i) sum[i] += along_[row] * factor[i];
          }
          Real* to = &y[3 * std::size_t{nodes_[n]}];
          for (std::size_t i = 0; i < 3; ++i) to[i] += sum[i];
        }
      },
      kRows);
}

template <class Real>
std::size_t PenaltyRows<Real>::bytes() const {
  return (of_row_.size() + of_node_.size()) * sizeof(Entry) + along_.size() * sizeof(Real) +
         4 * (row_start_.size() + nodes_.size() + node_start_.size());
}

template class PenaltyRows<float>;
template class PenaltyRows<double>;

}  // namespace lappet
