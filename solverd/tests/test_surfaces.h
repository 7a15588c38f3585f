// Closed surfaces for tests, built without a CSG library.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "lattice/surface.h"

namespace lappet::test {

inline void append(Surface& to, const Surface& other) {
  const Index shift = to_index(to.points.size());
  to.points.insert(to.points.end(), other.points.begin(), other.points.end());
  for (const auto& t : other.triangles) to.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
}

// A polygon (counter-clockwise, simple) extruded along `axis` from `low` to `high`; its two coordinates are those after
// `axis` in cyclic order. Ear clipping, so that caps have the long thin triangles that real cuts have.
inline Surface prism(const std::vector<Eigen::Vector2d>& polygon, double low, double high, int axis = 2) {
  Surface result;
  const Index n = to_index(polygon.size());
  const Eigen::Index u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (const double end : {low, high})
    for (const auto& p : polygon) {
      Vec3 point;
      point[axis] = end;
      point[u] = p.x();
      point[v] = p.y();
      result.points.push_back(point);
    }
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t j = (i + 1) % n;
    result.triangles.push_back({i, j, j + n});
    result.triangles.push_back({i, j + n, i + n});
  }
  std::vector<std::int32_t> rest(polygon.size());
  for (std::int32_t i = 0; i < n; ++i) rest[i] = i;
  const auto at = [&](std::int32_t i) { return polygon[i]; };
  const auto area = [&](std::int32_t i, std::int32_t j, std::int32_t k) {
    const Eigen::Vector2d a = at(j) - at(i), b = at(k) - at(i);
    return a.x() * b.y() - a.y() * b.x();
  };
  while (rest.size() > 2) {
    bool clipped = false;
    for (std::size_t m = 0; m < rest.size() && !clipped; ++m) {
      const std::int32_t i = rest[(m + rest.size() - 1) % rest.size()], j = rest[m], k = rest[(m + 1) % rest.size()];
      if (area(i, j, k) <= 0.0) continue;
      bool ear = true;
      for (const std::int32_t o : rest)
        if (o != i && o != j && o != k && area(i, j, o) >= 0.0 && area(j, k, o) >= 0.0 && area(k, i, o) >= 0.0)
          ear = false;
      if (!ear) continue;
      result.triangles.push_back({i + n, j + n, k + n});
      result.triangles.push_back({k, j, i});
      rest.erase(rest.begin() + m);
      clipped = true;
    }
    if (!clipped) throw std::logic_error("test polygon is not simple");
  }
  return result;
}

inline Surface box(const Vec3& low, const Vec3& high) {
  return prism({{low.x(), low.y()}, {high.x(), low.y()}, {high.x(), high.y()}, {low.x(), high.y()}}, low.z(), high.z());
}

// Latitudes and longitudes.
inline Surface sphere(const Vec3& middle, double radius, int rings) {
  Surface result;
  const int around = 2 * rings;
  result.points.push_back(middle - radius * Vec3::UnitZ());
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < around; ++j) {
      const double a = std::numbers::pi * i / rings, b = 2.0 * std::numbers::pi * j / around;
      result.points.push_back(middle +
                              radius * Vec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), -std::cos(a)));
    }
  result.points.push_back(middle + radius * Vec3::UnitZ());
  const auto at = [&](int i, int j) { return 1 + (i - 1) * around + j % around; };
  const auto last = to_index(result.points.size()) - 1;
  for (int j = 0; j < around; ++j) {
    result.triangles.push_back({0, at(1, j + 1), at(1, j)});
    result.triangles.push_back({last, at(rings - 1, j), at(rings - 1, j + 1)});
    for (int i = 1; i + 1 < rings; ++i) {
      result.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      result.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  }
  return result;
}

// Every triangle into four, `times` times.
inline Surface refine(Surface surface, int times) {
  for (int step = 0; step < times; ++step) {
    Surface finer;
    finer.points = surface.points;
    std::vector<std::pair<std::pair<std::int32_t, std::int32_t>, std::int32_t>> edges;
    const auto middle = [&](std::int32_t a, std::int32_t b) {
      const std::pair key{std::min(a, b), std::max(a, b)};
      for (const auto& [edge, point] : edges)
        if (edge == key) return point;
      finer.points.push_back(0.5 * (surface.points[a] + surface.points[b]));
      edges.emplace_back(key, to_index(finer.points.size()) - 1);
      return edges.back().second;
    };
    for (const auto& [a, b, c] : surface.triangles) {
      const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.triangles.push_back({a, ab, ca});
      finer.triangles.push_back({ab, b, bc});
      finer.triangles.push_back({ca, bc, c});
      finer.triangles.push_back({ab, bc, ca});
    }
    surface = std::move(finer);
  }
  return surface;
}

// A slab cut through along a polyline from below y = 0 to above y = depth: the left and the right piece, `kerf` apart
// measured along x.
struct CutSlab {
  Surface surface;
  std::size_t left_points;  // the first points belong to the left piece
};
inline CutSlab cut_slab(double width, double depth, double height, const std::vector<Eigen::Vector2d>& cut,
                        double kerf) {
  std::vector<Eigen::Vector2d> left{{0.0, 0.0}}, right;
  for (const auto& p : cut) left.emplace_back(p.x() - 0.5 * kerf, p.y());
  left.emplace_back(0.0, depth);
  for (auto p = cut.rbegin(); p != cut.rend(); ++p) right.emplace_back(p->x() + 0.5 * kerf, p->y());
  right.emplace_back(width, 0.0);
  right.emplace_back(width, depth);
  std::rotate(right.begin(), right.end() - 2, right.end());
  CutSlab result;
  result.surface = prism(left, 0.0, height);
  result.left_points = result.surface.points.size();
  test::append(result.surface, prism(right, 0.0, height));
  return result;
}

}  // namespace lappet::test
