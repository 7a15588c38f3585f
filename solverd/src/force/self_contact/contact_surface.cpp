#include "force/self_contact/contact_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "force/self_contact/distances.h"

namespace lappet {
ContactSurface::ContactSurface(const Lattice& lattice, const Surface& surface, double reach, const Interrupt& interrupt)
    : lattice_(lattice),
      reach_(reach),
      rest_(surface.points),
      triangles_(surface.triangles),
      tree_(surface.points, surface.triangles) {
  interrupt.check();
  find_edges();
  interrupt.check();
  find_areas();
}

std::array<Vec3, 3> ContactSurface::rest_of(Index triangle) const {
  const auto& [a, b, c] = triangles_[triangle];
  return {rest_[a], rest_[b], rest_[c]};
}

void ContactSurface::find_edges() {
  std::vector<Index> corners;
  std::vector<std::uint8_t> owned_already(rest_.size(), 0);
  std::map<Edge, Index> known;
  owned_.assign(triangles_.size(), 0);
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    auto& own = edges_of_triangle_.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const Index a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
      corners.push_back(a);
      if (!std::exchange(owned_already[a], 1)) owned_[t] |= std::uint8_t(1 << k);
      const auto [found, fresh] = known.try_emplace({std::min(a, b), std::max(a, b)}, to_index(edges_.size()));
      if (fresh) {
        edges_.push_back({std::min(a, b), std::max(a, b)});
        triangles_of_edge_.push_back({to_index(t), -1});
        owned_[t] |= std::uint8_t(1 << (3 + k));
      } else {
        triangles_of_edge_[found->second][1] = to_index(t);
      }
      own[k] = found->second;
    }
  }
  around_ = group_by(corners, rest_.size());
  for (Index& corner : around_.items) corner /= 3;
}

void ContactSurface::find_areas() {
  area_of_vertex_.assign(rest_.size(), 0.0);
  area_of_edge_.assign(edges_.size(), 0.0);
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto [a, b, c] = rest_of(to_index(t));
    const double third = (b - a).cross(c - a).norm() / 6.0;
    for (int k = 0; k < 3; ++k) {
      area_of_vertex_[triangles_[t][k]] += third;
      area_of_edge_[edges_of_triangle_[t][k]] += third;
    }
  }
  const double face = lattice_.settings.spacing * lattice_.settings.spacing;
  for (double& area : area_of_vertex_) area = std::max(area, kMinArea * face);
  for (double& area : area_of_edge_) area = std::max(area, kMinEdgeArea * face);
}

// Cells that have the same nodes wherever they have the same corners.
bool ContactSurface::is_uncut(Index cell, Index other) const {
  if (cell == other) return true;
  const GridPoint& at = lattice_.cell_position(cell);
  const GridPoint& of_other = lattice_.cell_position(other);
  std::array<Index, 3> off;
  for (std::size_t i = 0; i < 3; ++i) {
    off[i] = of_other[i] - at[i];
    if (std::abs(off[i]) > 1) return false;
  }
  for (Index c = 0; c < 8; ++c) {
    const std::array<Index, 3> corner{(c >> 2 & 1) - off[0], (c >> 1 & 1) - off[1], (c & 1) - off[2]};
    if (std::ranges::any_of(corner, [](Index i) { return i < 0 || i > 1; })) continue;
    if (lattice_.cell_nodes[cell][c] != lattice_.cell_nodes[other][4 * corner[0] + 2 * corner[1] + corner[2]])
      return false;
  }
  return true;
}

// Whether triangles that are near a point at rest lead from one to another of some.
bool ContactSurface::leads_along(std::span<const Index> from, std::span<const Index> to, const Vec3& near,
                                 double within) const {
  std::vector<Index> seen(from.begin(), from.end());
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (seen[k] < 0) continue;
    if (std::ranges::find(to, seen[k]) != to.end()) return true;
    for (const Index edge : edges_of_triangle_[seen[k]])
      for (const Index next : triangles_of_edge_[edge]) {
        if (next < 0 || std::ranges::find(seen, next) != seen.end()) continue;
        const auto [a, b, c] = rest_of(next);
        if (closest_on_triangle(near, a, b, c).squared_distance <= within * within) seen.push_back(next);
      }
  }
  return false;
}

bool ContactSurface::in_one_piece(std::span<const Index> first, std::span<const Index> second) const {
  for (const Index v : first)
    for (const Index w : second)
      if (!is_uncut(embedded(v).cell, embedded(w).cell)) return false;
  return true;
}

double ContactSurface::reach_to(Index vertex, Index triangle) const {
  const auto& [a, b, c] = triangles_[triangle];
  if (a == vertex || b == vertex || c == vertex) return 0.0;
  const double apart = std::sqrt(closest_on_triangle(rest_[vertex], rest_[a], rest_[b], rest_[c]).squared_distance);
  if (!(apart > kTouchesAtRest)) return 0.0;
  if (apart < kSliver * lattice_.settings.spacing && in_one_piece(std::array{vertex}, triangles_[triangle]) &&
      leads_along(around_[vertex], std::array{triangle}, rest_[vertex], kAround * apart))
    return 0.0;
  return std::min(reach_, kShareOfRest * apart);
}

double ContactSurface::reach_of(Index edge, Index other) const {
  const auto ends = ends_of(edge, other);
  if (ends[0] == ends[2] || ends[0] == ends[3] || ends[1] == ends[2] || ends[1] == ends[3]) return 0.0;
  const auto [a, b, c, d] = at(rest_, ends);
  const double apart = std::sqrt(closest_on_segments(a, b, c, d).squared_distance);
  if (!(apart > kTouchesAtRest)) return 0.0;
  if (apart < kSliver * lattice_.settings.spacing && in_one_piece(edges_[edge], edges_[other])) {
    const ClosestOnSegments closest = closest_on_segments(a, b, c, d);
    if (leads_along(triangles_of_edge_[edge], triangles_of_edge_[other], a + closest.first * (b - a), kAround * apart))
      return 0.0;
  }
  return std::min(kEdgeShare * reach_, kEdgeShareOfRest * apart);
}

template <class Real>
void ContactSurface::positions(std::span<const Real> u, std::vector<Vec3>& result) const {
  displacements(u, result);
  for_each_index(rest_.size(), [&](std::size_t v) { result[v] += rest_[v]; });
}

template <class Real>
void ContactSurface::displacements(std::span<const Real> u, std::vector<Vec3>& result) const {
  result.resize(rest_.size());
  for_each_index(rest_.size(), [&](std::size_t v) {
    const EmbeddedPoint& point = lattice_.surface_points[v];
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < 8; ++k) sum += point.weights[k] * NodeField(u)[lattice_.cell_nodes[point.cell][k]];
    result[v] = sum;
  });
}

std::size_t ContactSurface::bytes() const {
  return rest_.size() * (sizeof(Vec3) + sizeof(double)) + triangles_.size() * (6 * sizeof(Index) + 1) +
         edges_.size() * (4 * sizeof(Index) + sizeof(double)) + around_.bytes() + tree_.bytes();
}

template void ContactSurface::positions(std::span<const float>, std::vector<Vec3>&) const;
template void ContactSurface::positions(std::span<const double>, std::vector<Vec3>&) const;
template void ContactSurface::displacements(std::span<const float>, std::vector<Vec3>&) const;
template void ContactSurface::displacements(std::span<const double>, std::vector<Vec3>&) const;

}  // namespace lappet
