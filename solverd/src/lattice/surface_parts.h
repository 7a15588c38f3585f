// Which triangles share an edge, and the connected parts of a surface.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "lattice/surface.h"

namespace lappet {

struct SurfaceParts {
  std::vector<std::array<std::int32_t, 3>> neighbours;  // across the edges (0,1), (1,2), (2,0); -1: none or several
  std::vector<std::int32_t> part;                       // per triangle
  std::int32_t count = 0;
};

// Pairs half-edges (a,b) with (b,a) by point index. An edge that more than two triangles share joins none of them, so
// bodies that merely touch along an edge stay apart.
SurfaceParts find_parts(const Surface& surface);

}  // namespace lappet
