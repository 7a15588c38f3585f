#include "force/kernels/elastic_kernels.h"

#include <stdexcept>

namespace lappet {

template <class Real>
ElasticKernels<Real> elastic_kernels(InstructionSet set, const SceneFeatures& features) {
  ElasticKernels<Real> kernels;
  switch (set) {
    case InstructionSet::kScalar:
      fill_elastic_kernels_scalar(features, kernels);
      return kernels;
#if defined(LAPPET_BUILT_SSE42)
    case InstructionSet::kSse42:
      fill_elastic_kernels_sse42(features, kernels);
      return kernels;
#endif
#if defined(LAPPET_BUILT_AVX2)
    case InstructionSet::kAvx2:
      fill_elastic_kernels_avx2(features, kernels);
      return kernels;
#endif
#if defined(LAPPET_BUILT_AVX512)
    case InstructionSet::kAvx512:
      fill_elastic_kernels_avx512(features, kernels);
      return kernels;
#endif
#if defined(LAPPET_BUILT_NEON)
    case InstructionSet::kNeon:
      fill_elastic_kernels_neon(features, kernels);
      return kernels;
#endif
    default:
      throw std::logic_error("no kernels were built for this instruction set");
  }
}

template ElasticKernels<float> elastic_kernels(InstructionSet, const SceneFeatures&);
template ElasticKernels<double> elastic_kernels(InstructionSet, const SceneFeatures&);

}  // namespace lappet
