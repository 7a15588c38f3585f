// A part of a tangent, sum_r (c_r . du)^2 / 2, by rows c_r over the nodes that each of them couples.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/surface.h"

namespace lappet {

struct SparseRows {
  std::vector<std::uint32_t> start{0};  // where each row begins, and the end
  std::vector<Index> nodes;             // of a row: distinct
  std::vector<Vec3> factors;            // sqrt(mN/mm)

  std::size_t count() const { return start.size() - 1; }
  std::size_t bytes() const { return 4 * start.size() + nodes.size() * (sizeof(Index) + sizeof(Vec3)); }
};

}  // namespace lappet
