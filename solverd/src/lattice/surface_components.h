// Which triangles share an edge, and the connected components of a surface.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "lattice/surface.h"

namespace lappet {

struct SurfaceComponents {
  std::vector<std::array<Index, 3>> neighbors;  // across the edges (0,1), (1,2), (2,0); -1: none or several
  std::vector<Index> component;                 // per triangle
  std::int32_t count = 0;
};

// Pairs half-edges (a,b) with (b,a) by point index. An edge that more than two triangles share joins none of them, so
// bodies that merely touch along an edge stay apart.
SurfaceComponents find_components(const Surface& surface);

}  // namespace lappet
