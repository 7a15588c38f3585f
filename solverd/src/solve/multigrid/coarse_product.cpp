#include "solve/multigrid/coarse_product.h"

#include <stdexcept>

namespace lappet {

template <class Real>
CoarseProduct<Real> coarse_product(InstructionSet set) {
  CoarseProduct<Real> product = nullptr;
  switch (set) {
    case InstructionSet::kScalar:
      fill_coarse_product_scalar(product);
      return product;
#if defined(LAPPET_BUILT_SSE42)
    case InstructionSet::kSse42:
      fill_coarse_product_sse42(product);
      return product;
#endif
#if defined(LAPPET_BUILT_AVX2)
    case InstructionSet::kAvx2:
      fill_coarse_product_avx2(product);
      return product;
#endif
#if defined(LAPPET_BUILT_AVX512)
    case InstructionSet::kAvx512:
      fill_coarse_product_avx512(product);
      return product;
#endif
#if defined(LAPPET_BUILT_NEON)
    case InstructionSet::kNeon:
      fill_coarse_product_neon(product);
      return product;
#endif
    default:
      throw std::logic_error("no product of coarse matrices was built for this instruction set");
  }
}

template CoarseProduct<float> coarse_product(InstructionSet);
template CoarseProduct<double> coarse_product(InstructionSet);

}  // namespace lappet
