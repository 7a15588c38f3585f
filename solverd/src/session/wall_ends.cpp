#include "session/wall_ends.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "force/self_contact/distances.h"

namespace lappet {
namespace {

using Facing = AnchorStencils::Facing;

// Faces face each other from this cosine between their normals on.
constexpr double kFacing = -0.3;
// Walls make an edge up to this cosine between their normals; beyond, one wall that bends.
constexpr double kOneWall = 0.9;
// An end lies no further from its anchor, and goes no further ahead for a millimeter of each wall: at sharper edges
// than 39 degrees less is touched than is asked for.
constexpr double kFarthest = 1.0, kFastest = 3.0;  // mm; mm per mm
constexpr double kSamePoint = 1e-6;                // mm

WallEnd end_at(const Facing& face) { return {face.depth * face.normal, face.normal}; }

// The shortest vector with these heights above planes with these normals, one or two.
Vec3 with_heights(const std::vector<Vec3>& normals, const std::vector<double>& heights) {
  Eigen::MatrixXd planes(normals.size(), 3);
  Eigen::VectorXd above(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    planes.row(static_cast<Eigen::Index>(i)) = normals[i];
    above[static_cast<Eigen::Index>(i)] = heights[i];
  }
  return planes.completeOrthogonalDecomposition().solve(above);
}

Vec3 ahead_of(const std::vector<Vec3>& normals) {
  const Vec3 ahead = with_heights(normals, std::vector<double>(normals.size(), 1.0));
  return std::min(1.0, kFastest / ahead.norm()) * ahead;
}

// The edge behind which the anchor lies: the point of the walls that is nearest to it, where two of them meet there and
// it lies behind both.
std::optional<WallEnd> edge_before(const Surface& surface, std::span<const std::uint8_t> walls, const Vec3& anchor) {
  struct Near {
    Vec3 point, normal;
    double distance;
    bool behind;
  };
  std::vector<Near> near;
  double least = kFarthest;
  for (std::size_t t = 0; t < walls.size(); ++t) {
    if (walls[t] == 0) continue;
    const auto& corners = surface.triangles[t];
    const Vec3 &a = surface.points[corners[0]], &b = surface.points[corners[1]], &c = surface.points[corners[2]];
    const Vec3 normal = (b - a).cross(c - a);
    if (!(normal.squaredNorm() > 0.0)) continue;
    const ClosestOnTriangle closest = closest_on_triangle(anchor, a, b, c);
    const double distance = std::sqrt(closest.squared_distance);
    if (distance > least + kSamePoint) continue;
    least = std::min(least, distance);
    near.push_back({closest.weights[0] * a + closest.weights[1] * b + closest.weights[2] * c, normal.normalized(),
                    distance, (anchor - a).dot(normal) <= 0.0});
  }
  std::erase_if(near, [&](const Near& other) { return other.distance > least + kSamePoint; });
  std::vector<Vec3> normals;
  for (const Near& other : near) {
    if (!other.behind || (other.point - near.front().point).norm() > kSamePoint) return std::nullopt;
    if (std::ranges::none_of(normals, [&](const Vec3& known) { return known.dot(other.normal) > kOneWall; }))
      normals.push_back(other.normal);
  }
  if (normals.size() != 2) return std::nullopt;
  return WallEnd{near.front().point - anchor, ahead_of(normals)};
}

// The edge of a tip under which an anchor lies: where the two nearest walls above it meet.
std::optional<WallEnd> edge_above(std::vector<Facing> faces) {
  if (faces.size() < 2) return std::nullopt;
  std::ranges::stable_sort(faces, {}, &Facing::depth);
  const std::vector<Vec3> normals{faces[0].normal, faces[1].normal};
  const WallEnd end{with_heights(normals, {faces[0].depth, faces[1].depth}), ahead_of(normals)};
  return end.out.norm() <= kFarthest ? std::optional(end) : std::nullopt;
}

}  // namespace

std::optional<std::pair<WallEnd, WallEnd>> find_wall_ends(const AnchorStencils& stencils, const Surface& surface,
                                                          std::span<const std::uint8_t> walls, const Vec3& first,
                                                          const Vec3& second) {
  const std::vector<Facing> above_first = stencils.faces_above(first), above_second = stencils.faces_above(second);
  std::optional<std::pair<Facing, Facing>> nearest;
  const auto find = [&](const auto& are_pair) {
    for (const Facing& a : above_first)
      for (const Facing& b : above_second)
        if (are_pair(a, b) && (!nearest || a.depth + b.depth < nearest->first.depth + nearest->second.depth))
          nearest = {a, b};
  };
  if (!walls.empty()) {
    const auto walls_of = [&](std::vector<Facing> faces) {
      std::erase_if(faces, [&](const Facing& face) { return walls[face.triangle] == 0; });
      return faces;
    };
    const auto into_corner = [&](const Vec3& anchor,
                                 const std::vector<Facing>& others) -> std::optional<std::pair<WallEnd, WallEnd>> {
      const std::optional<WallEnd> corner = edge_before(surface, walls, anchor);
      if (!corner || others.empty()) return std::nullopt;
      const std::optional<WallEnd> tip = edge_above(others);
      return std::pair(*corner, tip ? *tip : end_at(*std::ranges::min_element(others, {}, &Facing::depth)));
    };
    const std::vector<Facing> walls_first = walls_of(above_first), walls_second = walls_of(above_second);
    if (const auto ends = into_corner(first, walls_second)) return ends;
    if (const auto ends = into_corner(second, walls_first)) return std::pair(ends->second, ends->first);
    find([&](const Facing& a, const Facing& b) { return walls[a.triangle] != 0 && walls[b.triangle] != 0; });
  }
  if (!nearest) find([](const Facing& a, const Facing& b) { return a.normal.dot(b.normal) < kFacing; });
  if (!nearest) return std::nullopt;
  return std::pair(end_at(nearest->first), end_at(nearest->second));
}

}  // namespace lappet
