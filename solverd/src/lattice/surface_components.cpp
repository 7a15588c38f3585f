#include "lattice/surface_components.h"

#include <algorithm>
#include <cstddef>

namespace lappet {

SurfaceComponents find_components(const Surface& surface) {
  const std::size_t triangles = surface.triangles.size();
  // Half-edges bucketed by their smaller point.
  struct HalfEdge {
    std::int32_t high;
    std::uint32_t slot;  // 3 * triangle + edge
    bool forward;        // runs from the smaller to the larger point
  };
  std::vector<std::uint32_t> first(surface.points.size() + 1, 0);
  const auto ends = [&](std::size_t t, std::size_t k) {
    return std::pair{surface.triangles[t][k], surface.triangles[t][(k + 1) % 3]};
  };
  for (std::size_t t = 0; t < triangles; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = ends(t, k);
      ++first[static_cast<std::size_t>(std::min(a, b)) + 1];
    }
  for (std::size_t p = 1; p < first.size(); ++p) first[p] += first[p - 1];
  std::vector<HalfEdge> half(3 * triangles);
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::size_t t = 0; t < triangles; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = ends(t, k);
      half[next[static_cast<std::size_t>(std::min(a, b))]++] = {std::max(a, b), static_cast<std::uint32_t>(3 * t + k),
                                                                a < b};
    }

  SurfaceComponents result;
  result.neighbors.assign(triangles, {-1, -1, -1});
  for (std::size_t p = 0; p + 1 < first.size(); ++p) {
    const auto begin = half.begin() + first[p], end = half.begin() + first[p + 1];
    std::sort(begin, end, [](const HalfEdge& a, const HalfEdge& b) {
      return a.high != b.high ? a.high < b.high : a.slot < b.slot;
    });
    for (auto i = begin; i != end;) {
      auto j = i;
      while (j != end && j->high == i->high) ++j;
      if (j - i == 2 && i->forward != (i + 1)->forward) {
        result.neighbors[i->slot / 3][i->slot % 3] = static_cast<std::int32_t>((i + 1)->slot / 3);
        result.neighbors[(i + 1)->slot / 3][(i + 1)->slot % 3] = static_cast<std::int32_t>(i->slot / 3);
      }
      i = j;
    }
  }

  result.component.assign(triangles, -1);
  std::vector<std::int32_t> stack;
  for (std::size_t seed = 0; seed < triangles; ++seed) {
    if (result.component[seed] >= 0) continue;
    result.component[seed] = result.count;
    stack.push_back(static_cast<std::int32_t>(seed));
    while (!stack.empty()) {
      const auto t = static_cast<std::size_t>(stack.back());
      stack.pop_back();
      for (const std::int32_t n : result.neighbors[t])
        if (n >= 0 && result.component[static_cast<std::size_t>(n)] < 0) {
          result.component[static_cast<std::size_t>(n)] = result.count;
          stack.push_back(n);
        }
    }
    ++result.count;
  }
  return result;
}

}  // namespace lappet
