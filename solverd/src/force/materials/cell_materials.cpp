#include "force/materials/cell_materials.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/BVH>

#include "force/materials/prestretch.h"

namespace lappet {

namespace {

using Box = Eigen::AlignedBox3d;
using Tree = Eigen::KdBVH<double, 3, std::int32_t>;

struct Triangle {
  Vec3 a, b, c;
};

Triangle triangle_of(const Surface& surface, std::size_t t) {
  const auto& [a, b, c] = surface.triangles[t];
  return {surface.points[a], surface.points[b], surface.points[c]};
}

// The weights of a triangle's corners at its point closest to p.
Vec3 closest_weights(const Vec3& p, const Triangle& t) {
  const Vec3 normal = (t.b - t.a).cross(t.c - t.a);
  const double area = normal.squaredNorm();
  if (area > 0.0) {
    const Vec3 weights((t.c - t.b).cross(p - t.b).dot(normal), (t.a - t.c).cross(p - t.c).dot(normal),
                       (t.b - t.a).cross(p - t.a).dot(normal));
    if (weights.minCoeff() >= 0.0) return weights / weights.sum();
  }
  const Vec3* corners[3] = {&t.a, &t.b, &t.c};
  Vec3 best = Vec3::UnitX();
  double closest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vec3 &from = *corners[k], edge = *corners[(k + 1) % 3] - from;
    const double length = edge.squaredNorm();
    const double s = length > 0.0 ? std::clamp((p - from).dot(edge) / length, 0.0, 1.0) : 0.0;
    const double found = (p - from - s * edge).squaredNorm();
    if (!(found < closest)) continue;
    closest = found;
    best.setZero();
    best[k] = 1.0 - s;
    best[(k + 1) % 3] = s;
  }
  return best;
}

double squared_distance(const Vec3& p, const Triangle& t) {
  const Vec3 w = closest_weights(p, t);
  return (p - w[0] * t.a - w[1] * t.b - w[2] * t.c).squaredNorm();
}

// The normals of a surface's points: those of the triangles around, by their area.
std::vector<Vec3> point_normals(const Surface& surface) {
  std::vector<Vec3> normals(surface.points.size(), Vec3::Zero());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle corners = triangle_of(surface, t);
    const Vec3 normal = (corners.b - corners.a).cross(corners.c - corners.a);
    for (const Index p : surface.triangles[t]) normals[p] += normal;
  }
  for (Vec3& normal : normals) normal.normalize();
  return normals;
}

bool has_direction(const MaterialParameters& m) { return m.has_fibers() || m.has_muscle() || m.has_prestretch(); }

// Whether the normal z, which holds where none is kept, serves every cell as well.
bool flat(const CellMaterials& materials) {
  const auto is_z = [](const Eigen::Vector3f& n) { return std::abs(n[2]) > 1.0F - 1e-6F; };
  const auto lies_flat = [](const MaterialParameters& m) {
    return !has_direction(m) || (direction_in_plane(m, Vec3::UnitZ()) - m.fiber_direction.normalized()).norm() < 1e-6;
  };
  return std::ranges::all_of(materials.normal_of_cell, is_z) && std::ranges::all_of(materials.table, lies_flat);
}

// For Eigen::BVMinimize: the closest triangle, of equally close ones that with the smallest index.
struct Closest {
  using Scalar = double;
  const Surface& skin;
  Vec3 point;
  double squared = std::numeric_limits<double>::infinity();
  Index triangle = -1;

  double minimumOnVolume(const Box& box) const {
    // Rounded down, so that a box that only touches the smallest distance is still opened.
    return box.squaredExteriorDistance(point) * (1.0 - 1e-12);
  }
  double minimumOnObject(Index t) {
    const double found = squared_distance(point, triangle_of(skin, static_cast<std::size_t>(t)));
    if (found < squared || (found == squared && t < triangle)) {
      squared = found;
      triangle = t;
    }
    return found;
  }
};

}  // namespace

CellMaterials assign_materials(const Lattice& lattice, std::vector<MaterialParameters> table, const Surface& skin,
                               std::span<const MaterialRegion> regions) {
  CellMaterials result{std::move(table), {}};
  const bool directional = std::ranges::any_of(result.table, has_direction);
  if ((regions.empty() && !directional) || skin.triangles.empty()) return result;
  std::vector<Index> triangles(skin.triangles.size());
  std::vector<Box> boxes(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    triangles[t] = to_index(t);
    const Triangle corners = triangle_of(skin, t);
    boxes[t] = Box(corners.a).extend(corners.b).extend(corners.c);
  }
  const Tree tree(triangles.begin(), triangles.end(), boxes.begin(), boxes.end());

  if (!regions.empty()) result.of_cell.assign(lattice.cell_nodes.size(), 0);
  std::vector<Vec3> normals;
  if (directional) {
    result.normal_of_cell.resize(lattice.cell_nodes.size());
    normals = point_normals(skin);
  }
  const double h = lattice.settings.spacing;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, lattice.cell_nodes.size(), 256), [&](const auto& range) {
    for (std::size_t c = range.begin(); c != range.end(); ++c) {
      const auto& [x, y, z] = lattice.cell_position(c);
      Closest closest{skin, lattice.settings.origin + h * Vec3(x + 0.5, y + 0.5, z + 0.5)};
      Eigen::BVMinimize(tree, closest);
      if (directional) {
        const std::size_t t = closest.triangle;
        const Vec3 weights = closest_weights(closest.point, triangle_of(skin, t));
        Vec3 normal = Vec3::Zero();
        for (int k = 0; k < 3; ++k) normal += weights[k] * normals[skin.triangles[t][k]];
        result.normal_of_cell[c] = normal.normalized().cast<float>();
      }
      const double depth = std::sqrt(closest.squared);
      for (const auto& region : regions)
        if (region.faces[closest.triangle] != 0 && depth >= region.from_depth && depth < region.to_depth)
          result.of_cell[c] = static_cast<std::uint8_t>(region.material);
    }
  });
  if (flat(result)) result.normal_of_cell.clear();
  return result;
}

}  // namespace lappet
