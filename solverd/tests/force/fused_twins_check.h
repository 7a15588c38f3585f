// Compares the fused kernels of an instruction set (forces, stabilization, differentials, diagonal blocks, with their
// gather and scatter) with their scalar double twins, on blocks whose lanes share nodes and miss cells. Needs no test
// framework, so that it also runs under an emulator.
#pragma once
#include "force/kernels/elastic_kernels.h"
#include "kernel_twins_check.h"

namespace lappet {

// What a scene is made of. points: 1, 4 or 8; mixed: materials differ from cell to cell.
struct FusedScene {
  SceneFeatures features;
  int points = 1;
  bool mixed = false;
};

// All of models x points x fibers x prestretch x mixed.
std::vector<FusedScene> fused_scenes();

// The kernels of `set` on every state of a cell (rest, random, inverted, flat, turned, uniformly stretched, tiny)
// against the scalar ones in double.
template <class Real>
std::vector<TwinResult> compare_fused_twins(const FusedScene& scene, const ElasticKernels<Real>& kernels,
                                            const ElasticKernels<double>& reference);

std::string describe(const FusedScene& scene);

}  // namespace lappet
