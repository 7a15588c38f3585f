// The NEON kernels against their scalar double twins: a program of its own without a test framework, cross-compiled and
// run under an emulator where the processor has no NEON.
#include <cstdio>

#include "fused_twins_check.h"
#include "kernel_twins_check.h"

namespace {

using namespace lappet;

int failures = 0, checks = 0;

void expect_small(const std::vector<TwinResult>& results, const std::string& scene) {
  for (const auto& result : results) {
    ++checks;
    if (result.samples > 0 && result.worst <= result.tolerance) continue;
    ++failures;
    std::printf("%s %s: the error is %.3g instead of at most %.3g at %s\n", result.kernel.c_str(), scene.c_str(),
                result.worst, result.tolerance, result.where.c_str());
  }
}

// Every `step`-th of the fused scenes, which an emulator is slow at: a step without a common factor with the 24 scenes
// of a model meets every model, number of points and extra.
template <class Real>
void check(std::size_t step) {
  expect_small(
      compare_kernel_twins(kernel_twins<Real>(InstructionSet::kNeon), kernel_twins<double>(InstructionSet::kScalar)),
      "");
  const auto scenes = fused_scenes();
  for (std::size_t k = 0; k < scenes.size(); k += step)
    expect_small(compare_fused_twins(scenes[k], elastic_kernels<Real>(InstructionSet::kNeon, scenes[k].features),
                                     elastic_kernels<double>(InstructionSet::kScalar, scenes[k].features)),
                 describe(scenes[k]));
}

}  // namespace

int main() {
  check<float>(11);
  check<double>(23);
  std::printf("%d of %d comparisons of NEON kernels with scalar doubles failed\n", failures, checks);
  return failures == 0 ? 0 : 1;
}
