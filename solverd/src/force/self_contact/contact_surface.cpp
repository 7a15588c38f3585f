#include "force/self_contact/contact_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "force/self_contact/distances.h"

namespace lappet {

namespace {

// Of what two primitives of one piece are apart at rest, the share from which on a barrier acts, of vertices and faces
// and of edges. What lies in one cell, or in two that share a face, stays apart with the lattice as long as no cell is
// inside out; the barrier is for creases, where one nearly is. With the share of other pairs it hindered compression of
// wherever triangles are small.
constexpr double kShareInPiece = 0.1, kEdgeShareInPiece = 0.05;

// Whether two cells share a face, from either side of it: as copies of one cell do not.
bool share_face(const Lattice& lattice, Index cell, Index other) {
  const auto& nodes = lattice.cell_nodes[cell];
  const auto& of_other = lattice.cell_nodes[other];
  const auto shared =
      std::ranges::count_if(nodes, [&](Index node) { return std::ranges::find(of_other, node) != of_other.end(); });
  const Vec3 apart = lattice.node_rest[nodes[0]] - lattice.node_rest[of_other[0]];
  return shared == 4 && apart.norm() > 0.5 * lattice.settings.spacing;
}

// Whether all of four vertices lie in one cell or in two that share a face.
bool are_in_one_piece(const Lattice& lattice, const std::array<Index, 4>& vertices) {
  std::array<Index, 2> cells{lattice.surface_points[vertices[0]].cell, -1};
  for (const Index vertex : vertices) {
    const Index cell = lattice.surface_points[vertex].cell;
    if (cell == cells[0] || cell == cells[1]) continue;
    if (cells[1] >= 0) return false;
    cells[1] = cell;
  }
  return cells[1] < 0 || share_face(lattice, cells[0], cells[1]);
}

}  // namespace

ContactSurface::ContactSurface(const Lattice& lattice, const Surface& surface, double reach, const Interrupt& interrupt)
    : lattice_(&lattice),
      whole_(&lattice),
      points_(lattice.surface_points),
      reach_(reach),
      rest_(surface.points),
      triangles_(surface.triangles),
      tree_(surface.points, surface.triangles) {
  interrupt.check();
  find_edges();
  interrupt.check();
  find_areas();
}

template <class Real>
ContactSurface::ContactSurface(const ContactSurface& whole, const Lattice& subdomain,
                               std::span<const Index> place_of_cell, std::span<const Real> u)
    : ContactSurface(whole) {
  lattice_ = &subdomain;
  whole.positions(u, still_);
  own_points_.assign(whole.points_.begin(), whole.points_.end());
  for (EmbeddedPoint& point : own_points_)
    if (point.cell >= 0) point.cell = place_of_cell[point.cell];
  points_ = own_points_;
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
  const double face = lattice_->settings.spacing * lattice_->settings.spacing;
  for (double& area : area_of_vertex_) area = std::max(area, kMinArea * face);
  for (double& area : area_of_edge_) area = std::max(area, kMinEdgeArea * face);
}

double ContactSurface::reach_to(Index vertex, Index triangle) const {
  const auto& [a, b, c] = triangles_[triangle];
  if (a == vertex || b == vertex || c == vertex) return 0.0;
  const double apart = std::sqrt(closest_on_triangle(rest_[vertex], rest_[a], rest_[b], rest_[c]).squared_distance);
  if (!(apart > kTouchesAtRest)) return 0.0;
  const double share = are_in_one_piece(*whole_, corners_of(vertex, triangle)) ? kShareInPiece : kShareOfRest;
  return std::min(reach_, share * apart);
}

double ContactSurface::reach_of(Index edge, Index other) const {
  const auto ends = ends_of(edge, other);
  if (ends[0] == ends[2] || ends[0] == ends[3] || ends[1] == ends[2] || ends[1] == ends[3]) return 0.0;
  const auto [a, b, c, d] = at(rest_, ends);
  const double apart = std::sqrt(closest_on_segments(a, b, c, d).squared_distance);
  if (!(apart > kTouchesAtRest)) return 0.0;
  const double share = are_in_one_piece(*whole_, ends) ? kEdgeShareInPiece : kEdgeShareOfRest;
  return std::min(kEdgeShare * reach_, share * apart);
}

template <class Real>
void ContactSurface::positions(std::span<const Real> u, std::vector<Vec3>& result) const {
  displacements(u, result);
  for_each_index(rest_.size(), [&](std::size_t v) {
    if (points_[v].cell < 0)
      result[v] = still_[v];
    else
      result[v] += rest_[v];
  });
}

template <class Real>
void ContactSurface::displacements(std::span<const Real> u, std::vector<Vec3>& result) const {
  result.resize(rest_.size());
  for_each_index(rest_.size(), [&](std::size_t v) {
    const EmbeddedPoint& point = points_[v];
    result[v].setZero();
    if (point.cell < 0) return;
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < 8; ++k) sum += point.weights[k] * NodeField(u)[lattice_->cell_nodes[point.cell][k]];
    result[v] = sum;
  });
}

std::size_t ContactSurface::bytes() const {
  return rest_.size() * (sizeof(Vec3) + sizeof(double)) + triangles_.size() * (6 * sizeof(Index) + 1) +
         edges_.size() * (4 * sizeof(Index) + sizeof(double)) + around_.bytes() + tree_.bytes();
}

template ContactSurface::ContactSurface(const ContactSurface&, const Lattice&, std::span<const Index>,
                                        std::span<const float>);
template ContactSurface::ContactSurface(const ContactSurface&, const Lattice&, std::span<const Index>,
                                        std::span<const double>);
template void ContactSurface::positions(std::span<const float>, std::vector<Vec3>&) const;
template void ContactSurface::positions(std::span<const double>, std::vector<Vec3>&) const;
template void ContactSurface::displacements(std::span<const float>, std::vector<Vec3>&) const;
template void ContactSurface::displacements(std::span<const double>, std::vector<Vec3>&) const;

}  // namespace lappet
