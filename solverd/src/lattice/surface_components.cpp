#include "lattice/surface_components.h"

#include <algorithm>

#include "math/groups.h"

namespace lappet {

namespace {

// The edge of a triangle as the triangle runs along it; number 3 * triangle + edge.
struct HalfEdge {
  Index low, high;  // points
  bool forward;     // runs from the lower to the higher point
};

HalfEdge half_edge(const Surface& surface, std::size_t number) {
  const auto& corners = surface.triangles[number / 3];
  const Index a = corners[number % 3], b = corners[(number + 1) % 3];
  return {std::min(a, b), std::max(a, b), a < b};
}

std::vector<std::array<Index, 3>> find_neighbors(const Surface& surface) {
  std::vector<Index> low(3 * surface.triangles.size());
  for (std::size_t i = 0; i < low.size(); ++i) low[i] = half_edge(surface, i).low;
  Groups of_point = group_by(low, surface.points.size());
  std::vector<std::array<Index, 3>> neighbors(surface.triangles.size(), {-1, -1, -1});
  const auto high = [&](Index i) { return half_edge(surface, i).high; };
  for (std::size_t p = 0; p < of_point.count(); ++p) {
    const auto begin = of_point.items.begin() + of_point.start[p], end = of_point.items.begin() + of_point.start[p + 1];
    std::stable_sort(begin, end, [&](Index a, Index b) { return high(a) < high(b); });
    for (auto i = begin; i != end;) {
      auto j = i;
      while (j != end && high(*j) == high(*i)) ++j;
      if (j - i == 2 && half_edge(surface, i[0]).forward != half_edge(surface, i[1]).forward) {
        neighbors[i[0] / 3][i[0] % 3] = i[1] / 3;
        neighbors[i[1] / 3][i[1] % 3] = i[0] / 3;
      }
      i = j;
    }
  }
  return neighbors;
}

}  // namespace

SurfaceComponents find_components(const Surface& surface) {
  SurfaceComponents result;
  result.neighbors = find_neighbors(surface);
  result.component.assign(surface.triangles.size(), -1);
  std::vector<Index> stack;
  for (std::size_t seed = 0; seed < surface.triangles.size(); ++seed) {
    if (result.component[seed] >= 0) continue;
    result.component[seed] = result.count;
    stack.push_back(to_index(seed));
    while (!stack.empty()) {
      const Index t = stack.back();
      stack.pop_back();
      for (const Index n : result.neighbors[t])
        if (n >= 0 && result.component[n] < 0) {
          result.component[n] = result.count;
          stack.push_back(n);
        }
    }
    ++result.count;
  }
  return result;
}

}  // namespace lappet
