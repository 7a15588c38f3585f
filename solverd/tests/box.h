// Boxes for tests: surfaces whose sides are multiples of the spacing, epochs and frames made of them.
#pragma once
#include <Eigen/Geometry>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "lattice/lattice.h"
#include "session/program.h"

namespace lappet {

inline Surface box_surface(const Vec3& low, const Vec3& high) {
  Surface s;
  for (int c = 0; c < 8; ++c)
    s.points.emplace_back(c & 4 ? high[0] : low[0], c & 2 ? high[1] : low[1], c & 1 ? high[2] : low[2]);
  s.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                 {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  return s;
}

inline void append(Surface& to, const Surface& from) {
  const Index first = to_index(to.points.size());
  to.points.insert(to.points.end(), from.points.begin(), from.points.end());
  for (const auto& t : from.triangles) to.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

// Gives a flat face a vertex at `point`: the triangles that hold the point become a fan around it. Returns its index.
inline std::int32_t add_vertex(Surface& s, const Vec3& point) {
  std::vector<std::array<std::int32_t, 3>> kept;
  std::vector<std::array<std::int32_t, 2>> edges;
  for (const auto& t : s.triangles) {
    const Vec3 a = s.points[t[0]], b = s.points[t[1]], c = s.points[t[2]];
    const Vec3 n = (b - a).cross(c - a).normalized();
    const bool holds = std::abs((point - a).dot(n)) < 1e-9 && (b - a).cross(point - a).dot(n) > -1e-9 &&
                       (c - b).cross(point - b).dot(n) > -1e-9 && (a - c).cross(point - c).dot(n) > -1e-9;
    if (!holds) {
      kept.push_back(t);
      continue;
    }
    for (std::size_t i = 0; i < 3; ++i) edges.push_back({t[i], t[(i + 1) % 3]});
  }
  const Index middle = to_index(s.points.size());
  s.points.push_back(point);
  for (const auto& edge : edges) {
    bool inner = false;
    for (const auto& other : edges) inner = inner || (other[0] == edge[1] && other[1] == edge[0]);
    if (!inner) kept.push_back({edge[0], edge[1], middle});
  }
  s.triangles = kept;
  return middle;
}

inline Vec3 center(const Surface& s, std::size_t t) {
  return (s.points[s.triangles[t][0]] + s.points[s.triangles[t][1]] + s.points[s.triangles[t][2]]) / 3;
}

// An epoch whose triangles are labeled by where their centers are.
inline EpochInput make_epoch(const Surface& surface, const std::function<bool(const Vec3&)>& fixed,
                             const std::function<std::int32_t(const Vec3&)>& grip = {},
                             const std::function<bool(const Vec3&)>& bed = {}) {
  EpochInput epoch;
  epoch.surface = surface;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Vec3 c = center(surface, t);
    epoch.fixed.push_back(fixed && fixed(c));
    epoch.bed.push_back(bed && bed(c));
    epoch.grip.push_back(grip ? grip(c) : -1);
  }
  return epoch;
}

inline const std::atomic<bool> kNever{false};

inline Eigen::Matrix4d translation(const Vec3& t) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topRightCorner<3, 1>() = t;
  return m;
}

inline FrameInput pulled(std::vector<Vec3> translations) {
  FrameInput frame;
  frame.time = 1;
  for (std::size_t r = 0; r < translations.size(); ++r)
    frame.retractors.push_back({to_index(r), translation(translations[r])});
  return frame;
}

// Follows a point of the surface.
inline void add_landmark(EpochInput& epoch, const Vec3& point) {
  std::int32_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < epoch.surface.triangles.size(); ++t) {
    const auto& c = epoch.surface.triangles[t];
    const Vec3 a = epoch.surface.points[c[0]], b = epoch.surface.points[c[1]], d = epoch.surface.points[c[2]];
    const Vec3 n = (b - a).cross(d - a).normalized();
    const double off = std::abs((point - a).dot(n));
    const bool inside = (b - a).cross(point - a).dot(n) >= -1e-9 && (d - b).cross(point - b).dot(n) >= -1e-9 &&
                        (a - d).cross(point - d).dot(n) >= -1e-9;
    if (inside && off < least) {
      least = off;
      best = to_index(t);
    }
  }
  epoch.landmarks.push_back(point);
  epoch.landmark_triangles.push_back(best);
}

inline Vec3 landmark(const FrameOutput& output, std::size_t k) {
  return {output.landmarks[3 * k], output.landmarks[3 * k + 1], output.landmarks[3 * k + 2]};
}

}  // namespace lappet
