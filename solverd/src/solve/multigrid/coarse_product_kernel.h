// The product of a matrix of rigid modes with a vector, for each instruction set: eight numbers at a time, of which
// six belong to a block's row. Those beyond are what stands next in memory; nothing takes them.
#pragma once
#include <cstring>

#include "solve/multigrid/coarse_product.h"

namespace lappet {

// Number: names the instruction set that the translation unit is compiled for.
template <class Number, class Real>
void multiply_coarse_rows(const CoarseRows<Real>& m, std::size_t begin, std::size_t end, const Real* x, Real* y) {
  using Eight [[gnu::vector_size(8 * sizeof(Real))]] = Real;
  for (std::size_t n = begin; n < end; ++n) {
    Eight turned[6] = {}, sum[6] = {}, row, v;
    for (auto l = m.left_start[n]; l < m.left_start[n + 1]; ++l) {
      const Real* block = m.blocks + 36 * std::ptrdiff_t{m.left[l].slot};
      const Real* from = x + 6 * std::ptrdiff_t{m.left[l].row};
      for (int i = 0; i < 6; ++i) {
        std::memcpy(&row, block + 6 * i, sizeof(row));
        turned[i] += row * from[i];
      }
    }
    for (auto s = m.start[n]; s < m.start[n + 1]; ++s) {
      const Real* block = m.blocks + 36 * std::ptrdiff_t{s};
      const std::size_t column = m.column[s];
      v = Eight{};
      if (column + 1 < m.rows)
        std::memcpy(&v, x + 6 * column, sizeof(v));
      else
        std::memcpy(&v, x + 6 * column, 6 * sizeof(Real));
      for (int i = 0; i < 6; ++i) {
        std::memcpy(&row, block + 6 * i, sizeof(row));
        sum[i] += row * v;
      }
    }
    for (int i = 0; i < 6; ++i)
      y[6 * n + i] = (((turned[0][i] + turned[1][i]) + (turned[2][i] + turned[3][i])) + (turned[4][i] + turned[5][i])) +
                     (sum[i][0] + sum[i][1] + sum[i][2] + sum[i][3] + sum[i][4] + sum[i][5]);
  }
}

}  // namespace lappet
