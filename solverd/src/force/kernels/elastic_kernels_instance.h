// Instantiates the elastic kernels for a pair of batches: Float (float lanes) and Double (double lanes). Included by
// one translation unit per instruction set.
#pragma once
#include "force/kernels/diagonal_kernel.h"
#include "force/kernels/elastic_kernels.h"
#include "force/kernels/product_kernel.h"
#include "force/kernels/projected_stiffness_kernel.h"
#include "force/kernels/state_kernel.h"
#include "force/materials/material_models.h"
#include "math/features.h"

namespace lappet {

// Calls body with std::integral_constant<bool> for each flag.
template <class Body>
inline void with_flags(const SceneFeatures& f, const Body& body) {
  const auto fourth = [&](auto one_point, auto fibers, auto prestretched) {
    if constexpr (kHasHeterogeneity)
      if (f.shares) return body(one_point, fibers, prestretched, std::true_type{});
    body(one_point, fibers, prestretched, std::false_type{});
  };
  const auto third = [&](auto one_point, auto fibers) {
    if constexpr (kHasPrestretch)
      if (f.prestretched) return fourth(one_point, fibers, std::true_type{});
    fourth(one_point, fibers, std::false_type{});
  };
  const auto second = [&](auto one_point) {
    if constexpr (kHasFibers || kHasMuscle)
      if (f.fibers) return third(one_point, std::true_type{});
    third(one_point, std::false_type{});
  };
  if (f.one_point)
    second(std::true_type{});
  else
    second(std::false_type{});
}

// Narrow: lanes of what is stored; Wide: the double lanes that evaluate in full precision.
template <class Narrow, class Wide, class Real>
inline void fill_kernels(const SceneFeatures& features, ElasticKernels<Real>& kernels) {
  constexpr int width = kLanes<Narrow>;
  kernels.lanes = width;
  with_flags(features, [&](auto one_point, auto fibers, auto prestretched, auto shares) {
    kernels.multiply = &multiply_groups<Narrow, one_point(), fibers(), prestretched(), shares()>;
    kernels.diagonal = &diagonal_groups<Narrow, one_point(), fibers(), prestretched(), shares()>;
    kernels.project = &project_cells<Narrow, one_point(), fibers(), prestretched(), shares()>;
    MaterialModels::with(features.model, [&]<class Model>() {
      kernels.evaluate = &evaluate_groups<Wide, Real, width, Model, one_point(), fibers(), prestretched(), shares()>;
      kernels.linearize = &linearize_groups<Narrow, Model, one_point(), fibers()>;
    });
  });
}

}  // namespace lappet
