// Compares every single kernel of an instruction set with its scalar double twin, on random, near-singular, inverted,
// repeated-singular-value and tiny inputs. Needs no test framework, so that it also runs under an emulator.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "kernel_twins.h"

namespace lappet {

struct TwinResult {
  std::string kernel;
  double tolerance = 0.0;
  std::size_t samples = 0;
  double worst = 0.0;   // error, relative to the size of the terms that the kernel adds up
  std::string where{};  // the worst sample
};

// What an error may be.
template <class Real>
inline constexpr double kTwinTolerance = sizeof(Real) == 4 ? 4e-6 : 1e-13;

// Part of the next one: gather and scatter, which move numbers without rounding.
template <class Real>
std::vector<TwinResult> compare_node_kernels(const KernelTwins<Real>& twins);

template <class Real>
std::vector<TwinResult> compare_kernel_twins(const KernelTwins<Real>& twins, const KernelTwins<double>& reference);

}  // namespace lappet
