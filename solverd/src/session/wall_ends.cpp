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
// An anchor lies in the middle of a tip where one of its walls is so many times as far as the other at most. Two walls
// that look away from each other beyond this cosine are those of a thin part.
constexpr double kInMiddle = 1.25, kThin = -0.95;

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

// The edge of a tip under which an anchor lies: where the two nearest walls above it meet, which are about as far.
std::optional<WallEnd> edge_above(const std::vector<Facing>& faces) {
  if (faces.size() < 2 || faces[1].depth > kInMiddle * faces[0].depth) return std::nullopt;
  const std::vector<Vec3> normals{faces[0].normal, faces[1].normal};
  if (normals[0].dot(normals[1]) < kThin) return std::nullopt;
  const WallEnd end{with_heights(normals, {faces[0].depth, faces[1].depth}), ahead_of(normals)};
  return end.out.norm() <= kFarthest ? std::optional(end) : std::nullopt;
}

// above: all faces above the anchor.
std::optional<WallEnd> end_on_walls(const Surface& surface, std::span<const std::uint8_t> walls, const Vec3& anchor,
                                    std::vector<Facing> above) {
  if (const auto edge = edge_before(surface, walls, anchor)) return edge;
  std::erase_if(above, [&](const Facing& face) { return walls[face.triangle] == 0; });
  if (above.empty()) return std::nullopt;
  std::ranges::stable_sort(above, {}, &Facing::depth);
  if (const auto edge = edge_above(above)) return edge;
  return end_at(above.front());
}

}  // namespace

std::optional<std::pair<WallEnd, WallEnd>> find_wall_ends(const AnchorStencils& stencils, const Surface& surface,
                                                          std::span<const std::uint8_t> walls, const Vec3& first,
                                                          const Vec3& second) {
  const std::vector<Facing> above_first = stencils.faces_above(first), above_second = stencils.faces_above(second);
  if (!walls.empty()) {
    const auto own = end_on_walls(surface, walls, first, above_first);
    const auto other = end_on_walls(surface, walls, second, above_second);
    if (own && other) return std::pair(*own, *other);
  }
  std::optional<std::pair<Facing, Facing>> nearest;
  for (const Facing& a : above_first)
    for (const Facing& b : above_second)
      if (a.normal.dot(b.normal) < kFacing &&
          (!nearest || a.depth + b.depth < nearest->first.depth + nearest->second.depth))
        nearest = {a, b};
  if (!nearest) return std::nullopt;
  return std::pair(end_at(nearest->first), end_at(nearest->second));
}

}  // namespace lappet
