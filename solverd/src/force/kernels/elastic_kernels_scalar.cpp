#include "force/kernels/elastic_kernels_instance.h"

namespace lappet {

namespace {
using Float = float;
using Double = double;
}  // namespace

void fill_elastic_kernels_scalar(const SceneFeatures& features, ElasticKernels<float>& kernels) {
  fill_kernels<Float, Double>(features, kernels);
}
void fill_elastic_kernels_scalar(const SceneFeatures& features, ElasticKernels<double>& kernels) {
  fill_kernels<Double, Double>(features, kernels);
}

}  // namespace lappet
