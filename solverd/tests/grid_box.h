// A box whose faces are grids of triangles.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "box.h"

namespace lappet {

// edge: of the squares that are halved, mm; as many as fit best.
inline Surface grid_box(const Vec3& low, const Vec3& high, double edge) {
  Surface s;
  std::map<std::array<std::int64_t, 3>, Index> known;
  const auto vertex = [&](const Vec3& p) {
    const std::array<std::int64_t, 3> key{std::llround(p[0] * 1e4), std::llround(p[1] * 1e4), std::llround(p[2] * 1e4)};
    const auto [entry, inserted] = known.try_emplace(key, to_index(s.points.size()));
    if (inserted) s.points.push_back(p);
    return entry->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const bool top : {false, true}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const int nu = int(std::lround((high[u] - low[u]) / edge)), nv = int(std::lround((high[v] - low[v]) / edge));
      const auto at = [&](int i, int j) {
        Vec3 p;
        p[axis] = top ? high[axis] : low[axis];
        p[u] = low[u] + (high[u] - low[u]) * i / nu;
        p[v] = low[v] + (high[v] - low[v]) * j / nv;
        return vertex(p);
      };
      for (int i = 0; i < nu; ++i)
        for (int j = 0; j < nv; ++j) {
          const Index a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
          if (top) {
            s.triangles.push_back({a, b, c});
            s.triangles.push_back({a, c, d});
          } else {
            s.triangles.push_back({a, c, b});
            s.triangles.push_back({a, d, c});
          }
        }
    }
  return s;
}

}  // namespace lappet
