// How kernels read what a build of the daemon may be without: see math/features.h. Apart from the arrays themselves, so
// that of all other code only what does so depends on what is left out.
#pragma once
#include "force/kernels/elastic_arrays.h"
#include "math/features.h"

namespace lappet {

// Forced into their callers, since the units of all instruction sets share them.
template <class Real>
[[gnu::always_inline]] inline GroupNodes nodes_of(const ElasticArrays<Real>& arrays, std::int64_t group, int lanes) {
  const std::int64_t start = arrays.node_start[group], end = arrays.node_start[group + 1];
  return {arrays.nodes + start, lanes, !kHasMeshCells || end - start == std::int64_t{kBlockColumns} * lanes};
}
// The record of what a place, [group][place] as one number, is made of.
template <class Real>
[[gnu::always_inline]] inline const Real* material_of(const ElasticArrays<Real>& arrays, std::int64_t place) {
  return kHasHeterogeneity ? arrays.material + place * arrays.material_stride : arrays.material;
}

}  // namespace lappet
