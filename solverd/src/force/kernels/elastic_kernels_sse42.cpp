#include "force/kernels/elastic_kernels_instance.h"
#include "math/simd_number.h"

namespace lappet {

namespace {
using Float = xsimd::batch<float, xsimd::sse4_2>;
using Double = xsimd::batch<double, xsimd::sse4_2>;
}  // namespace

void fill_elastic_kernels_sse42(const SceneFeatures& features, ElasticKernels<float>& kernels) {
  fill_kernels<Float, Double>(features, kernels);
}
void fill_elastic_kernels_sse42(const SceneFeatures& features, ElasticKernels<double>& kernels) {
  fill_kernels<Double, Double>(features, kernels);
}

}  // namespace lappet
