// The product of a matrix of rigid modes (coarse_matrix.h) with a vector, for the instruction set in use.
#pragma once
#include <cstddef>
#include <cstdint>

#include "math/index.h"
#include "math/instruction_set.h"

namespace lappet {

// Of a block left of the diagonal: which row it stands in, transposed, and where.
struct LeftBlock {
  Index row, slot;
};

// What CoarseMatrix holds, by rows. `blocks` ends with kCoarsePadding numbers that belong to none.
template <class Real>
struct CoarseRows {
  std::size_t rows;
  const std::int32_t *start, *column, *left_start;
  const LeftBlock* left;
  const Real* blocks;
};
inline constexpr std::size_t kCoarsePadding = 2;

// Rows begin..end of y = A x.
template <class Real>
using CoarseProduct = void (*)(const CoarseRows<Real>&, std::size_t begin, std::size_t end, const Real* x, Real* y);

// Throws std::logic_error where the program holds no kernel for the set.
template <class Real>
CoarseProduct<Real> coarse_product(InstructionSet set);

// One per translation unit that is compiled for an instruction set.
#define LAPPET_COARSE_PRODUCT_OF(set)                    \
  void fill_coarse_product_##set(CoarseProduct<float>&); \
  void fill_coarse_product_##set(CoarseProduct<double>&);
LAPPET_COARSE_PRODUCT_OF(scalar)
LAPPET_COARSE_PRODUCT_OF(sse42)
LAPPET_COARSE_PRODUCT_OF(avx2)
LAPPET_COARSE_PRODUCT_OF(avx512)
LAPPET_COARSE_PRODUCT_OF(neon)
#undef LAPPET_COARSE_PRODUCT_OF

}  // namespace lappet
