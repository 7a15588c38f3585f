// The product of a matrix of rigid frames (frame_matrix.h) with a vector, for the instruction set in use.
#pragma once
#include <cstddef>
#include <cstdint>

#include "math/instruction_set.h"

namespace lappet {

// Of a block left of the diagonal: which row it stands in, transposed, and where.
struct FrameLeft {
  std::int32_t row, slot;
};

// What FrameMatrix holds, by rows. `blocks` ends with kFramePadding numbers that belong to none.
template <class Real>
struct FrameRows {
  std::size_t rows;
  const std::int32_t *start, *column, *left_start;
  const FrameLeft* left;
  const Real* blocks;
};
inline constexpr std::size_t kFramePadding = 2;

// Rows begin..end of y = A x.
template <class Real>
using FrameProduct = void (*)(const FrameRows<Real>&, std::size_t begin, std::size_t end, const Real* x, Real* y);

// Throws std::logic_error where the program holds no kernel for the set.
template <class Real>
FrameProduct<Real> frame_product(InstructionSet set);

// One per translation unit that is compiled for an instruction set.
#define LAPPET_FRAME_PRODUCT_OF(set)                   \
  void fill_frame_product_##set(FrameProduct<float>&); \
  void fill_frame_product_##set(FrameProduct<double>&);
LAPPET_FRAME_PRODUCT_OF(scalar)
LAPPET_FRAME_PRODUCT_OF(sse42)
LAPPET_FRAME_PRODUCT_OF(avx2)
LAPPET_FRAME_PRODUCT_OF(avx512)
LAPPET_FRAME_PRODUCT_OF(neon)
#undef LAPPET_FRAME_PRODUCT_OF

}  // namespace lappet
