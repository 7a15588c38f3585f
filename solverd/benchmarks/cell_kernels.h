// The elastic kernels taken apart: what a part costs without the others, on plain arrays in the layout of
// force/kernels/elastic_arrays.h, for every instruction set. Neo-Hookean, one quadrature point, float.
#pragma once
#include <cstdint>

#include "force/kernels/elastic_arrays.h"
#include "math/instruction_set.h"

namespace lappet {

// What an array holds. Cells: [group][8 places][fields][lane]; block nodes: [group][27][3][lane].
enum class Content {
  kDeformation,    // F, 9 per cell
  kRotation,       // 9 per cell
  kQuaternion,     // 4 per cell
  kQuaternions,    // U and V, 8 per cell
  kSigma,          // 3 per cell
  kStress,         // P_hat, 3 per cell
  kTangent,        // kTangentFields per cell
  kStabilization,  // 1 per cell
  kBlockNodes,     // 81 per block
  kNothing
};
constexpr int numbers_per_block(Content content) {
  switch (content) {
    case Content::kDeformation:
    case Content::kRotation:
      return 8 * 9;
    case Content::kQuaternion:
      return 8 * 4;
    case Content::kQuaternions:
      return 8 * 8;
    case Content::kSigma:
    case Content::kStress:
      return 8 * 3;
    case Content::kTangent:
      return 8 * 20;
    case Content::kStabilization:
      return 8;
    case Content::kBlockNodes:
      return 81;
    case Content::kNothing:
      break;
  }
  return 0;
}

inline constexpr int kMaxArrays = 4;

struct CellKernel {
  const char* name;
  // What it reads and what it writes, in this order; each array is its own.
  Content in[kMaxArrays], out[kMaxArrays];
  // Works on the groups begin..end.
  void (*run)(const float* const* in, float* const* out, std::int64_t begin, std::int64_t end);
};

inline constexpr int kCellKernels = 8;

struct CellKernels {
  int lanes = 1;
  CellKernel kernels[kCellKernels];
  // Multiply-adds as fast as the set can: does `rounds` rounds and returns how many operations (2 each) that were.
  // What it computes goes to *result.
  double (*multiply_add_float)(std::int64_t rounds, float* result) = nullptr;
  double (*multiply_add_double)(std::int64_t rounds, double* result) = nullptr;
  // Nodes of the blocks to [group][27][3][lane] and back, adding.
  void (*gather)(const ElasticArrays<float>&, std::int64_t begin, std::int64_t end, const float* field,
                 float* at) = nullptr;
  void (*scatter)(const ElasticArrays<float>&, std::int64_t begin, std::int64_t end, const float* sum,
                  float* field) = nullptr;
};

// Throws std::logic_error where the program holds none for the set.
CellKernels cell_kernels(InstructionSet set);

// One per translation unit that is compiled for an instruction set; `counted` works on Counted<float>.
void fill_cell_kernels_scalar(CellKernels& kernels);
void fill_cell_kernels_sse42(CellKernels& kernels);
void fill_cell_kernels_avx2(CellKernels& kernels);
void fill_cell_kernels_avx512(CellKernels& kernels);
void fill_cell_kernels_neon(CellKernels& kernels);
void fill_cell_kernels_counted(CellKernels& kernels);

}  // namespace lappet
