// The kernels of one instruction set, chosen for what a scene holds: a material model, one or more quadrature points,
// fibers, prestretch, shares of cells. What is absent is not in the code that runs.
#pragma once
#include <cstdint>

#include "force/kernels/elastic_arrays.h"
#include "force/materials/material.h"
#include "math/instruction_set.h"

namespace lappet {

struct SceneFeatures {
  int model = 0;  // its place in MaterialModels
  bool one_point = true;
  bool fibers = false;  // or muscle
  bool prestretched = false;
  bool shares = false;  // some cell holds more than one material, or is filled in part
};

struct StateSums;

// All work on the groups begin..end and add to node arrays; ranges that share no node may run at the same time.
template <class Real>
struct ElasticKernels {
  using Evaluate = void (*)(const ElasticArrays<Real>&, std::int64_t begin, std::int64_t end, const Real* u,
                            double* gradient, double* magnitude, StateSums&);
  int lanes = 1;
  Evaluate evaluate = nullptr;  // in double
  void (*linearize)(const ElasticArrays<Real>&, std::int64_t begin, std::int64_t end, PsdProjection) = nullptr;
  void (*multiply)(const ElasticArrays<Real>&, std::int64_t begin, std::int64_t end, const Real* x, Real* y) = nullptr;
  void (*diagonal)(const ElasticArrays<Real>&, std::int64_t begin, std::int64_t end, Real* blocks) = nullptr;
  void (*project)(const ElasticArrays<Real>&, const std::int32_t* slots, const Real* weights, const Real* arms,
                  Real* blocks) = nullptr;
};

// Throws std::logic_error where the program holds no kernels for the set.
template <class Real>
ElasticKernels<Real> elastic_kernels(InstructionSet set, const SceneFeatures& features);

// One per translation unit that is compiled for an instruction set; see elastic_kernels_instance.h.
#define LAPPET_KERNELS_OF(set)                                                   \
  void fill_elastic_kernels_##set(const SceneFeatures&, ElasticKernels<float>&); \
  void fill_elastic_kernels_##set(const SceneFeatures&, ElasticKernels<double>&);
LAPPET_KERNELS_OF(scalar)
LAPPET_KERNELS_OF(sse42)
LAPPET_KERNELS_OF(avx2)
LAPPET_KERNELS_OF(avx512)
LAPPET_KERNELS_OF(neon)
#undef LAPPET_KERNELS_OF

}  // namespace lappet
