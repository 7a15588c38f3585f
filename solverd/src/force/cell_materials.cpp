#include "force/cell_materials.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/BVH>

namespace lappet {

namespace {

using Box = Eigen::AlignedBox3d;
using Tree = Eigen::KdBVH<double, 3, std::int32_t>;

struct Triangle {
  Vec3 a, b, c;
};

Triangle triangle_of(const Surface& surface, std::size_t t) {
  const auto& [a, b, c] = surface.triangles[t];
  return {surface.points[static_cast<std::size_t>(a)], surface.points[static_cast<std::size_t>(b)],
          surface.points[static_cast<std::size_t>(c)]};
}

double squared_distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 edge = b - a;
  const double length = edge.squaredNorm();
  const double s = length > 0.0 ? std::clamp((p - a).dot(edge) / length, 0.0, 1.0) : 0.0;
  return (p - a - s * edge).squaredNorm();
}

double squared_distance(const Vec3& p, const Triangle& t) {
  const Vec3 normal = (t.b - t.a).cross(t.c - t.a);
  const double area = normal.squaredNorm();
  const bool above = area > 0.0 && (t.b - t.a).cross(p - t.a).dot(normal) >= 0.0 &&
                     (t.c - t.b).cross(p - t.b).dot(normal) >= 0.0 && (t.a - t.c).cross(p - t.c).dot(normal) >= 0.0;
  if (above) {
    const double height = (p - t.a).dot(normal);
    return height * height / area;
  }
  return std::min({squared_distance_to_segment(p, t.a, t.b), squared_distance_to_segment(p, t.b, t.c),
                   squared_distance_to_segment(p, t.c, t.a)});
}

// What Eigen::BVMinimize asks: the closest triangle, of equally close ones that with the least index.
struct Closest {
  using Scalar = double;
  const Surface& skin;
  Vec3 point;
  double squared = std::numeric_limits<double>::infinity();
  std::int32_t triangle = -1;

  double minimumOnVolume(const Box& box) const {
    // Nudged down, so that a box that only touches the least distance is still opened.
    return box.squaredExteriorDistance(point) * (1.0 - 1e-12);
  }
  double minimumOnObject(std::int32_t t) {
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
  const bool directional = std::any_of(result.table.begin(), result.table.end(), [](const auto& m) {
    return m.has_fibres() || m.has_muscle() || m.has_prestretch();
  });
  if ((regions.empty() && !directional) || skin.triangles.empty()) return result;
  std::vector<std::int32_t> triangles(skin.triangles.size());
  std::vector<Box> boxes(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    triangles[t] = static_cast<std::int32_t>(t);
    const Triangle corners = triangle_of(skin, t);
    boxes[t] = Box(corners.a).extend(corners.b).extend(corners.c);
  }
  const Tree tree(triangles.begin(), triangles.end(), boxes.begin(), boxes.end());

  if (!regions.empty()) result.of_cell.assign(lattice.cell_position.size(), 0);
  if (directional) result.normal_of_cell.resize(lattice.cell_position.size());
  const double h = lattice.settings.spacing;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, lattice.cell_position.size(), 256), [&](const auto& range) {
    for (std::size_t c = range.begin(); c != range.end(); ++c) {
      const auto& [x, y, z] = lattice.cell_position[c];
      Closest closest{skin, lattice.settings.origin + h * Vec3(x + 0.5, y + 0.5, z + 0.5)};
      Eigen::BVMinimize(tree, closest);
      if (directional) {
        const Triangle above = triangle_of(skin, static_cast<std::size_t>(closest.triangle));
        result.normal_of_cell[c] = (above.b - above.a).cross(above.c - above.a).normalized().cast<float>();
      }
      const double depth = std::sqrt(closest.squared);
      for (const auto& region : regions)
        if (region.faces[static_cast<std::size_t>(closest.triangle)] != 0 && depth >= region.from_depth &&
            depth < region.to_depth)
          result.of_cell[c] = static_cast<std::uint8_t>(region.material);
    }
  });
  return result;
}

}  // namespace lappet
