// Every kernel on every instruction set that this processor has against its scalar double twin.
#include "kernel_twins.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "fused_twins_check.h"
#include "kernel_twins_check.h"

namespace lappet {
namespace {

class KernelTwin : public ::testing::TestWithParam<InstructionSet> {
 protected:
  void expect_small(const std::vector<TwinResult>& results, const std::string& scene = {}) const {
    for (const auto& result : results) {
      EXPECT_GT(result.samples, 0U) << result.kernel;
      EXPECT_LE(result.worst, result.tolerance) << result.kernel << " at " << result.where << " " << scene;
      if (std::getenv("LAPPET_PRINT_TWINS") != nullptr)  // for whoever changes a kernel
        std::printf("%-8s %-50s %.2e of %.0e %s\n", std::string(name(GetParam())).c_str(), result.kernel.c_str(),
                    result.worst, result.tolerance, scene.c_str());
    }
  }
  template <class Real>
  void expect_agreement() const {
    const auto results =
        compare_kernel_twins(kernel_twins<Real>(GetParam()), kernel_twins<double>(InstructionSet::kScalar));
    EXPECT_GT(results.size(), 40U);
    expect_small(results);
  }
  template <class Real>
  void expect_fused_agreement() const {
    for (const auto& scene : fused_scenes())
      expect_small(compare_fused_twins(scene, elastic_kernels<Real>(GetParam(), scene.features),
                                       elastic_kernels<double>(InstructionSet::kScalar, scene.features)),
                   describe(scene));
  }
};

TEST_P(KernelTwin, SingleKernelsInFloatStayWithinFourMillionths) { expect_agreement<float>(); }
TEST_P(KernelTwin, SingleKernelsInDoubleStayWithinRounding) { expect_agreement<double>(); }
TEST_P(KernelTwin, FusedKernelsInFloatStayWithinFourMillionths) { expect_fused_agreement<float>(); }
TEST_P(KernelTwin, FusedKernelsInDoubleStayWithinRounding) { expect_fused_agreement<double>(); }

INSTANTIATE_TEST_SUITE_P(Sets, KernelTwin, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& info) { return std::string(name(info.param)); });

}  // namespace
}  // namespace lappet
