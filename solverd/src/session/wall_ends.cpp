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
// An edge goes no further ahead for a millimeter of each of its walls: at sharper ones than 39 degrees less is touched
// than is asked for.
constexpr double kFastest = 3.0;     // mm per mm
constexpr double kSamePoint = 1e-6;  // mm
// An anchor lies in the middle of a tip where one of its walls is so many times as far as the other at most. Two walls
// whose normals are opposite beyond this cosine are those of a thin part, or of a cut that ends.
constexpr double kInMiddle = 1.25, kThin = -0.95;

using Planes = Eigen::Matrix<double, 2, 3>;  // unit normals

// The shortest vector that rises so far above each of two planes.
Vec3 with_heights(const Planes& normals, const Eigen::Vector2d& heights) {
  return normals.transpose() * (normals * normals.transpose()).ldlt().solve(heights);
}

WallEnd end_at(const Facing& face) { return {face.depth * face.normal, face.normal}; }

// The edge where two walls with these normals meet, `out` from the anchor.
WallEnd edge_at(const Vec3& out, const Planes& normals) {
  const Vec3 ahead = with_heights(normals, {1.0, 1.0});
  return {out, std::min(1.0, kFastest / ahead.norm()) * ahead};
}

// The edge behind which the anchor lies: the point of the walls that is nearest to it, where two of them meet there and
// it lies behind both.
std::optional<WallEnd> edge_before(const Surface& surface, std::span<const std::uint8_t> walls, const Vec3& anchor,
                                   double radius) {
  struct Near {
    Vec3 point, normal;
    double distance;
    bool behind;
  };
  std::vector<Near> near;
  double least = radius;
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
    if (std::ranges::none_of(normals, [&](const Vec3& known) { return known.dot(other.normal) > kOneFace; }))
      normals.push_back(other.normal);
  }
  if (normals.size() != 2 || normals[0].dot(normals[1]) < kThin) return std::nullopt;
  return edge_at(near.front().point - anchor, (Planes() << normals[0].transpose(), normals[1].transpose()).finished());
}

// The edge of a tip under which an anchor lies: where the two nearest walls above it meet, which are about as far.
std::optional<WallEnd> edge_above(std::span<const Facing> faces, double radius) {
  if (faces.size() < 2 || faces[1].depth > kInMiddle * faces[0].depth) return std::nullopt;
  if (faces[0].normal.dot(faces[1].normal) < kThin) return std::nullopt;
  const Planes normals = (Planes() << faces[0].normal.transpose(), faces[1].normal.transpose()).finished();
  const Vec3 out = with_heights(normals, {faces[0].depth, faces[1].depth});
  return out.norm() <= radius ? std::optional(edge_at(out, normals)) : std::nullopt;
}

// above: all faces above the anchor.
std::optional<WallEnd> end_on_walls(const Surface& surface, std::span<const std::uint8_t> walls, const Vec3& anchor,
                                    std::vector<Facing> above, double radius) {
  if (const auto edge = edge_before(surface, walls, anchor, radius)) return edge;
  std::erase_if(above, [&](const Facing& face) { return walls[face.triangle] == 0; });
  if (above.empty()) return std::nullopt;
  std::ranges::stable_sort(above, {}, &Facing::depth);
  if (const auto edge = edge_above(above, radius)) return edge;
  return end_at(above.front());
}

}  // namespace

std::optional<std::pair<WallEnd, WallEnd>> find_wall_ends(const AnchorStencils& stencils, const Surface& surface,
                                                          std::span<const std::uint8_t> walls, const Vec3& first,
                                                          const Vec3& second) {
  const std::vector<Facing> above_first = stencils.faces_above(first), above_second = stencils.faces_above(second);
  if (!walls.empty()) {
    const auto own = end_on_walls(surface, walls, first, above_first, stencils.radius());
    const auto other = end_on_walls(surface, walls, second, above_second, stencils.radius());
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
