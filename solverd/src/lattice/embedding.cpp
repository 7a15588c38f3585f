#include "lattice/embedding.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <string>
#include <tuple>

#include "lattice/refused.h"
#include "math/groups.h"

namespace lappet {
namespace {

// Lengths here are in voxels. Points this close to a cell count as inside it; weights this close to 0 or 1 are set to
// it.
constexpr double kRounding = 1e-7;
constexpr double kHalfDiagonal = 0.8660254037844387;  // from a voxel's center to its corners
constexpr int kMaxVoxelsWalked = 256;
constexpr std::size_t kManyVoxels = 48;  // of a triangle: from here on they are looked up in a tree

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const double area2 = normal.squaredNorm();
  if (area2 > 0.0 && (b - a).cross(p - a).dot(normal) >= 0.0 && (c - b).cross(p - b).dot(normal) >= 0.0 &&
      (a - c).cross(p - c).dot(normal) >= 0.0)
    return std::abs((p - a).dot(normal)) / std::sqrt(area2);
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

}  // namespace

Embedder::Embedder(const Lattice& lattice, const Surface& surface)
    : lattice_(lattice),
      surface_(surface),
      fine_(*lattice.fine),
      voxels_per_mm_(fine_.box().ratio / lattice.settings.spacing),
      none_dropped_(lattice.dropped_voxels == 0),
      seen_(surface.triangles.size(), 0) {
  if (static_cast<std::size_t>(fine_.triangle_count()) != surface.triangles.size())
    throw RefusedError(ErrorCode::kInternal, "The surface given to embed points has " +
                                                 std::to_string(surface.triangles.size()) +
                                                 " triangles, but the lattice was built from one with " +
                                                 std::to_string(fine_.triangle_count()) + ".");
}

Vec3 Embedder::surface_point(Index index) const {
  const auto& low = fine_.box().low;
  return (surface_.points[index] - lattice_.settings.origin) * voxels_per_mm_ -
         fine_.box().ratio * Vec3(low[0], low[1], low[2]);
}

std::array<Vec3, 3> Embedder::corners_of(Index triangle) const {
  const auto& corners = surface_.triangles[triangle];
  return {surface_point(corners[0]), surface_point(corners[1]), surface_point(corners[2])};
}

const VoxelTree& Embedder::tree_of(Index triangle) {
  const auto [found, fresh] = trees_.try_emplace(triangle);
  if (fresh) found->second = VoxelTree(fine_.inner_voxels(triangle));
  return found->second;
}

// The inside voxel on the inner side of the surface that is nearest to the point *along the surface*: a triangle
// reached over an edge counts as at least as far as that edge is from the point, so the far wall of a narrow cut is as
// far as the end of the cut.
Voxel Embedder::inner_voxel(const Vec3& point, std::span<const Index> triangles) {
  ++search_;
  front_.clear();
  const auto reach_later = [&](double reach, Index triangle) {
    front_.emplace_back(reach, triangle);
    std::push_heap(front_.begin(), front_.end(), std::greater<>());
  };
  double best = std::numeric_limits<double>::infinity();
  Voxel result{-1, -1, -1};
  for (const Index t : triangles) {
    const auto [a, b, c] = corners_of(t);
    reach_later(distance_to_triangle(point, a, b, c), t);
  }
  while (!front_.empty()) {
    const auto [reach, triangle] = front_.front();
    std::pop_heap(front_.begin(), front_.end(), std::greater<>());
    front_.pop_back();
    if (reach >= best) break;
    auto& seen = seen_[triangle];
    if (seen == search_) continue;
    seen = search_;
    const auto look = [&, min_distance = reach](const Voxel& voxel) {
      const double distance = std::max(min_distance, (VoxelTree::center(voxel) - point).norm());
      if ((distance < best || (distance == best && voxel < result)) &&
          (none_dropped_ || fine_.lattice_cell(voxel) >= 0)) {
        best = distance;
        result = voxel;
      }
      return best;
    };
    const auto voxels = fine_.inner_voxels(triangle);
    if (voxels.size() < kManyVoxels) {
      for (const Voxel voxel : voxels)
        if (voxel[0] >= 0 && !VoxelTree::beyond((VoxelTree::center(voxel) - point).squaredNorm(), best)) look(voxel);
    } else {
      tree_of(triangle).visit_nearest(voxels, point, best, look);
    }
    const auto& neighbors = fine_.neighbors(triangle);
    const auto corner = corners_of(triangle);
    for (std::size_t k = 0; k < 3; ++k) {
      const Index next = neighbors[k];
      if (next < 0 || seen_[next] == search_) continue;
      const double edge = distance_to_segment(point, corner[k], corner[(k + 1) % 3]);
      if (std::max(reach, edge) < best) reach_later(std::max(reach, edge), next);
    }
  }
  return result;
}

// For a fragment so small that it holds no voxel center: the nearest voxel of all carries it.
Voxel Embedder::nearest_of_all(const Vec3& point) const {
  double best = std::numeric_limits<double>::infinity();
  Voxel result{-1, -1, -1};
  for (Index t = 0; t < fine_.triangle_count(); ++t)
    for (const Voxel voxel : fine_.inner_voxels(t)) {
      const double distance = (VoxelTree::center(voxel) - point).squaredNorm();
      if ((distance < best || (distance == best && voxel < result)) && fine_.lattice_cell(voxel) >= 0) {
        best = distance;
        result = voxel;
      }
    }
  return result;
}

// From a voxel on the right side over connected voxels to the cell that holds the point, or comes nearest to it.
Index Embedder::walk_to_cell(const Vec3& point, const Voxel& start) {
  const std::int32_t r = fine_.box().ratio;
  // Distance of the point from the cell of a voxel, then from the voxel.
  using Rank = std::tuple<double, double, Voxel>;
  const auto rank = [&](const Voxel& voxel) {
    Vec3 out = Vec3::Zero();
    for (std::size_t a = 0; a < 3; ++a) {
      const Eigen::Index axis = a;
      const double low = voxel[a] / r * r;
      out[axis] = std::max({0.0, low - point[axis], point[axis] - low - r});
    }
    const double cell = out.norm();
    return Rank{cell < kRounding ? 0.0 : cell, (VoxelTree::center(voxel) - point).norm(), voxel};
  };
  Rank best = rank(start);
  if (!(std::get<0>(best) > 0.0)) return fine_.lattice_cell(start);
  const double reach = (VoxelTree::center(start) - point).norm() + 1.5;
  std::priority_queue<Rank, std::vector<Rank>, std::greater<>> front;
  std::vector<Voxel> seen{start};
  front.push(best);
  for (int steps = 0; !front.empty() && steps < kMaxVoxelsWalked && std::get<0>(best) > 0.0; ++steps) {
    const Rank here = front.top();
    front.pop();
    best = std::min(best, here);
    const Voxel& voxel = std::get<2>(here);
    for (int axis = 0; axis < 3; ++axis)
      for (const int direction : {-1, 1}) {
        Voxel next = voxel;
        next[axis] += direction;
        if ((VoxelTree::center(next) - point).norm() > reach ||
            std::find(seen.begin(), seen.end(), next) != seen.end() ||
            !fine_.connected_above(direction > 0 ? voxel : next, axis))
          continue;
        seen.push_back(next);
        front.push(rank(next));
        best = std::min(best, front.top());
      }
  }
  return fine_.lattice_cell(std::get<2>(best));
}

EmbeddedPoint Embedder::embed(const Vec3& point, std::span<const Index> triangles) {
  const std::int32_t r = fine_.box().ratio;
  const auto& low = fine_.box().low;
  const Vec3 grid = (point - lattice_.settings.origin) / lattice_.settings.spacing;
  const Vec3 at = r * (grid - Vec3(low[0], low[1], low[2]));
  Voxel voxel = inner_voxel(at, triangles);
  if (voxel[0] < 0) voxel = nearest_of_all(at);
  const Index cell = voxel[0] < 0 ? -1 : walk_to_cell(at, voxel);
  if (cell < 0)
    throw RefusedError(ErrorCode::kInvalidInput, "No cell of the lattice is near the point (" + shown(point.x()) +
                                                     ", " + shown(point.y()) + ", " + shown(point.z()) +
                                                     ") mm; points lie in the tissue or on its surface.");
  return {cell, trilinear_weights(lattice_, cell, point)};
}

// The distance of a point from the surface around a triangle: that triangle and those reached from it over edges that
// are no farther from the point than it.
double Embedder::distance_to_surface(const Vec3& point, Index triangle) {
  ++search_;
  std::vector<Index> front{triangle};
  seen_[triangle] = search_;
  double nearest = std::numeric_limits<double>::infinity(), reach = nearest;
  while (!front.empty()) {
    const Index here = front.back();
    front.pop_back();
    const auto corners = corners_of(here);
    nearest = std::min(nearest, distance_to_triangle(point, corners[0], corners[1], corners[2]));
    if (here == triangle) reach = nearest;
    const auto& neighbors = fine_.neighbors(here);
    for (std::size_t k = 0; k < 3; ++k) {
      const Index next = neighbors[k];
      if (next < 0 || seen_[next] == search_ || distance_to_segment(point, corners[k], corners[(k + 1) % 3]) > reach)
        continue;
      seen_[next] = search_;
      front.push_back(next);
    }
  }
  return nearest;
}

// Deep in the tissue the voxel that holds the point says which cell it belongs to: no surface parts it from its center.
EmbeddedPoint Embedder::embed_near(const Vec3& point, Index triangle) {
  const auto& low = fine_.box().low;
  const Vec3 at =
      (point - lattice_.settings.origin) * voxels_per_mm_ - fine_.box().ratio * Vec3(low[0], low[1], low[2]);
  if (distance_to_surface(at, triangle) > kHalfDiagonal) {
    if (const Index cell = fine_.lattice_cell(fine_.box().voxel_at(at)); cell >= 0)
      return {cell, trilinear_weights(lattice_, cell, point)};
  }
  return embed(point, {&triangle, 1});
}

std::array<double, 8> trilinear_weights(const Lattice& lattice, Index cell, const Vec3& point) {
  const auto& position = lattice.cell_position(cell);
  Vec3 local =
      (point - lattice.settings.origin) / lattice.settings.spacing - Vec3(position[0], position[1], position[2]);
  for (double& x : local)
    if (std::abs(x - std::round(x)) < kRounding) x = std::round(x);
  std::array<double, 8> weights;
  for (std::size_t c = 0; c < 8; ++c)
    weights[c] = ((c & 4) ? local.x() : 1.0 - local.x()) * ((c & 2) ? local.y() : 1.0 - local.y()) *
                 ((c & 1) ? local.z() : 1.0 - local.z());
  return weights;
}

std::vector<EmbeddedPoint> embed_surface(const Lattice& lattice, const Surface& surface, const Interrupt& interrupt) {
  std::vector<Index> corners;
  corners.reserve(3 * surface.triangles.size());
  for (const auto& t : surface.triangles) corners.insert(corners.end(), t.begin(), t.end());
  Groups triangles = group_by(corners, surface.points.size());
  for (Index& corner : triangles.items) corner /= 3;

  std::vector<EmbeddedPoint> result(surface.points.size());
  tbb::enumerable_thread_specific<Embedder> embedder([&] { return Embedder(lattice, surface); });
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, surface.points.size(), 64), [&](const auto& range) {
    interrupt.check();
    Embedder& local = embedder.local();
    for (std::size_t p = range.begin(); p != range.end(); ++p) result[p] = local.embed(surface.points[p], triangles[p]);
  });
  return result;
}

EmbeddedPoint embed_on_triangle(const Lattice& lattice, const Surface& surface, const Vec3& point, Index triangle) {
  if (triangle < 0 || static_cast<std::size_t>(triangle) >= surface.triangles.size())
    throw RefusedError(ErrorCode::kInvalidInput, "An anchor names triangle " + std::to_string(triangle) +
                                                     " of the tissue surface, which has " +
                                                     std::to_string(surface.triangles.size()) + ".");
  if (!point.allFinite())
    throw RefusedError(ErrorCode::kInvalidInput, "An anchor on triangle " + std::to_string(triangle) +
                                                     " is not finite; give three numbers in mm.");
  return Embedder(lattice, surface).embed_near(point, triangle);
}

}  // namespace lappet
