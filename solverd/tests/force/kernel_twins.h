// Single kernels behind plain functions, one table per instruction set: what kernel_twins_check.h compares with scalar
// doubles. Values lie as the kernels want them: in [value][lane], out [value][lane], 64-byte aligned.
#pragma once
#include <cstdint>

#include "force/kernels/elastic_arrays.h"
#include "force/materials/material_models.h"
#include "math/instruction_set.h"

namespace lappet {

template <class Real>
struct KernelTwins {
  using Function = void (*)(const Real* in, Real* out);
  int lanes = 1;
  Function roots = nullptr;       // x -> rough 1/x, rough 1/sqrt(x), 1/sqrt(x)
  Function svd = nullptr;         // F (9) -> U (9), sigma (3), V (9)
  Function products = nullptr;    // A (9), B (9) -> A B, A^T B, A B^T
  Function quaternion = nullptr;  // rotation (9) -> quaternion (4), and the rotation of that (9)
  Function eigen = nullptr;       // symmetric (6) -> values (3), vectors (9)
  Function definite3[2] = {};     // clamp, absolute: symmetric (6), floor -> symmetric (6)
  // By the registry's index: sigma (3), mu, lambda, mooney -> energy, p_hat (3), dpdf_hat (12)
  Function model[MaterialModels::kCount] = {};
  Function definite[2] = {};  // clamp, absolute: dpdf_hat (12), floor -> dpdf_hat (12)
  // I1, I4, k1, k2, dispersion, muscle, J, threshold -> energy, shear, along, curvature, muscle curvature, pressure,
  // bulk, volume
  Function fiber = nullptr;
  Function fiber_definite[2] = {};   // the same, made definite
  Function corners = nullptr;        // 8 corner values -> gradient sums (3), modes (4), and spread back (8)
  Function differential[2][2] = {};  // [fibers][prestretched]: tangent (20), sigma (3), fiber tangent (4),
                                     // material (17), dF (9) -> dP (9)
  Function corner_block[2][2] = {};  // the same with a gradient (3) for dF -> block (6)
  Function quadratic = nullptr;      // matrix (36), x (24) -> y (24)
  void (*gather)(const Real* field, const std::int32_t* index, Real* out) = nullptr;
  void (*scatter_add)(Real* field, const std::int32_t* index, const Real* values) = nullptr;
  void (*gather_block)(const GroupNodes&, const Real* field, Real* at) = nullptr;
  int (*scatter_block)(const GroupNodes&, const Real* sum, Real* field) = nullptr;  // how many lanes it told of
};

#define LAPPET_TWINS_OF(set)                         \
  void fill_kernel_twins_##set(KernelTwins<float>&); \
  void fill_kernel_twins_##set(KernelTwins<double>&);
LAPPET_TWINS_OF(scalar)
LAPPET_TWINS_OF(sse42)
LAPPET_TWINS_OF(avx2)
LAPPET_TWINS_OF(avx512)
LAPPET_TWINS_OF(neon)
#undef LAPPET_TWINS_OF

// Throws std::logic_error where the program holds none for the set.
template <class Real>
KernelTwins<Real> kernel_twins(InstructionSet set);

}  // namespace lappet
