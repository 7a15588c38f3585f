#include "solve/multigrid/frame_product.h"

#include <stdexcept>

namespace lappet {

template <class Real>
FrameProduct<Real> frame_product(InstructionSet set) {
  FrameProduct<Real> product = nullptr;
  switch (set) {
    case InstructionSet::kScalar:
      fill_frame_product_scalar(product);
      return product;
#if defined(__x86_64__)
    case InstructionSet::kSse42:
      fill_frame_product_sse42(product);
      return product;
    case InstructionSet::kAvx2:
      fill_frame_product_avx2(product);
      return product;
    case InstructionSet::kAvx512:
      fill_frame_product_avx512(product);
      return product;
#elif defined(__aarch64__)
    case InstructionSet::kNeon:
      fill_frame_product_neon(product);
      return product;
#endif
    default:
      throw std::logic_error("no product of frames was built for this instruction set");
  }
}

template FrameProduct<float> frame_product(InstructionSet);
template FrameProduct<double> frame_product(InstructionSet);

}  // namespace lappet
