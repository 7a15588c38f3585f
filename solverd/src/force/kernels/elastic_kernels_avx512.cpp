#include "force/kernels/elastic_kernels_instance.h"
#include "math/simd_number.h"

namespace lappet {

namespace {
using Float = xsimd::batch<float, xsimd::avx512bw>;
using Double = xsimd::batch<double, xsimd::avx512bw>;
}  // namespace

void fill_elastic_kernels_avx512(const SceneFeatures& features, ElasticKernels<float>& kernels) {
  fill_kernels<Float, Double>(features, kernels);
}
void fill_elastic_kernels_avx512(const SceneFeatures& features, ElasticKernels<double>& kernels) {
  fill_kernels<Double, Double>(features, kernels);
}

}  // namespace lappet
