// The contact penalties of a tangent, sum_p (c_p . du)^2 / 2, as sparse rows c_p over the nodes: every cell that lies
// on the bed has one, every pair of the surface that touches itself, and every product of the tangent takes them all.
//
// A product goes over the rows, each its own number c_p . x, and then over the nodes that they touch, each its own sum:
// both in parallel, the same for any number of threads.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "force/constraints/contact_penalty.h"
#include "force/constraints/sparse_rows.h"
#include "lattice/lattice.h"

namespace lappet {

template <class Real>
class PenaltyRows {
 public:
  // Penalties on cells of the lattice, and rows that are ready: those that are added, and those that are taken off.
  void set(std::span<const ContactPenalty> penalties, const SparseRows& added, const SparseRows& taken_off,
           const Lattice& lattice);
  // y += sum_p s_p c_p (c_p . x), s_p = -1 for what is taken off, else 1
  void add_product(std::span<const Real> x, std::span<Real> y) const;
  std::size_t bytes() const;

 private:
  struct Entry {
    std::uint32_t other;  // of a row: the node; of a node: the row
    std::array<Real, 3> factor;
  };

  std::size_t taken_off_ = 0;             // the first row that is taken off
  std::vector<std::uint32_t> row_start_;  // into the entries of the rows, and the end
  std::vector<Entry> of_row_;
  std::vector<std::uint32_t> nodes_;  // that rows touch, ascending
  std::vector<std::uint32_t> node_start_;
  std::vector<Entry> of_node_;
  mutable std::vector<Real> along_;  // c_p . x
};

extern template class PenaltyRows<float>;
extern template class PenaltyRows<double>;

}  // namespace lappet
