#include "force/self_contact/untangling.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "force/self_contact/distances.h"

namespace lappet {

namespace {

// How deep a surface may lie behind another one, in spacings: what lies deeper is a fault of the start and no matter of
// triangles.
constexpr double kDeepest = 0.5;
// Where surfaces are taken to, in reaches; nearer than the second, they are taken there.
constexpr double kTarget = 0.5, kTooNear = 0.1;
// Within so many of the deepest distances around a piercing vertices are looked at.
constexpr double kAround = 4.0;
// The cosine, negative, from which on a vertex lies behind a face at rest.
constexpr double kBehindAtRest = 0.3;
constexpr int kSweeps = 20;
// A row whose two sides hang on nearly the same nodes, by which squared factor at most, is not to be had by moving
// them.
constexpr double kSameNodes = 0.02;

Vec3 twice_area(const Vec3& a, const Vec3& b, const Vec3& c) { return (b - a).cross(c - a); }

}  // namespace

Untangling::Untangling(ContactSurface& surface, const std::function<bool(Index)>& moves)
    : surface_(surface),
      moves_(moves),
      deepest_(kDeepest * surface.lattice().settings.spacing),
      target_(kTarget * surface.reach()) {
  for (std::size_t t = 0; t < surface.triangles().size(); ++t) {
    const auto [a, b, c] = surface.rest_of(to_index(t));
    face_normals_at_rest_.push_back(twice_area(a, b, c));
  }
}

bool Untangling::push(std::span<const Vec3> places, std::span<const Piercing> piercings, std::span<double> u) {
  rows_ = {};
  lacks_.clear();
  find_normals(places);
  mark_near(places, piercings);
  find_facing(places);
  add_vertices(places);
  add_edges(places, piercings);
  sweep(u);
  return rows_.count() > 0;
}

void Untangling::find_normals(std::span<const Vec3> places) {
  const auto& triangles = surface_.triangles();
  face_normals_.resize(triangles.size());
  normals_.assign(places.size(), Vec3::Zero());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& corners = triangles[t];
    face_normals_[t] = twice_area(places[corners[0]], places[corners[1]], places[corners[2]]);
    const Vec3 unit = face_normals_[t].normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 first = places[corners[(k + 1) % 3]] - places[corners[k]];
      const Vec3 second = places[corners[(k + 2) % 3]] - places[corners[k]];
      normals_[corners[k]] += std::atan2(first.cross(second).norm(), first.dot(second)) * unit;
    }
  }
}

void Untangling::mark_near(std::span<const Vec3> places, std::span<const Piercing> piercings) {
  marked_.assign(places.size(), 0);
  const double around = kAround * deepest_;
  struct Bounds {
    Vec3 low, high;
  };
  std::vector<Bounds> bounds;
  for (const Piercing& piercing : piercings) {
    const auto& [a, b] = surface_.edges()[piercing.edge];
    bounds.push_back({places[a].cwiseMin(places[b]).array() - around, places[a].cwiseMax(places[b]).array() + around});
  }
  for_each_index(places.size(), [&](std::size_t v) {
    marked_[v] = std::ranges::any_of(bounds, [&](const Bounds& box) {
      return (places[v].array() >= box.low.array()).all() && (places[v].array() <= box.high.array()).all();
    });
  });
  for (const Piercing& piercing : piercings)
    for (const Index v : surface_.triangles()[piercing.face]) marked_[v] = 1;
}

Vec3 Untangling::normal_of_edge(Index edge) const {
  Vec3 sum = Vec3::Zero();
  for (const Index t : surface_.triangles_at(edge))
    if (t >= 0) sum += face_normals_[t].normalized();
  return sum.normalized();
}

// What lies behind a face at rest, as the other side of a thin flap does, or its own other wall at an edge, is no
// tissue that came there.
bool Untangling::lies_behind_at_rest(Index vertex, Index face) const {
  const auto [a, b, c] = surface_.rest_of(face);
  const Vec3 rest = surface_.rest(vertex);
  const auto& w = closest_on_triangle(rest, a, b, c).weights;
  const Vec3 between = rest - w[0] * a - w[1] * b - w[2] * c;
  if (between.norm() > 2.0 * deepest_) return false;
  return between.dot(face_normals_at_rest_[face].normalized()) < -kBehindAtRest * between.norm();
}

std::optional<Untangling::Facing> Untangling::facing(Index vertex, Index face, std::span<const Vec3> places) const {
  const auto& corners = surface_.triangles()[face];
  if (std::ranges::find(corners, vertex) != corners.end()) return {};
  const ClosestOnTriangle closest =
      closest_on_triangle(places[vertex], places[corners[0]], places[corners[1]], places[corners[2]]);
  if (!(closest.squared_distance < deepest_ * deepest_)) return {};
  Facing found{face, closest.weights, {}, std::sqrt(closest.squared_distance), false};
  const auto which = static_cast<std::size_t>(closest.feature.which);
  switch (closest.feature.kind) {
    case TriangleFeature::Kind::kFace:
      found.normal = face_normals_[face].normalized();
      break;
    case TriangleFeature::Kind::kEdge:
      found.normal = normal_of_edge(surface_.edges_of(face)[which]);
      break;
    case TriangleFeature::Kind::kCorner:
      found.normal = normals_[corners[which]].normalized();
      break;
  }
  if (!(found.normal.dot(normals_[vertex]) < 0.0) || lies_behind_at_rest(vertex, face)) return {};
  Vec3 between = places[vertex];
  for (std::size_t k = 0; k < 3; ++k) between -= closest.weights[k] * places[corners[k]];
  found.behind = between.dot(found.normal) < 0.0;
  return found;
}

void Untangling::find_facing(std::span<const Vec3> places) {
  surface_.refit(places, {}, marked_);
  const BoxTree& tree = surface_.tree();
  std::vector<std::vector<std::pair<Index, Facing>>> found(tree.chunks());
  const auto look = [&](Index of, Index face, std::vector<std::pair<Index, Facing>>& to) {
    for (int k = 0; k < 3; ++k) {
      const Index v = surface_.triangles()[of][k];
      if (!surface_.owns_vertex(of, k) || !marked_[v]) continue;
      if (const auto found = facing(v, face, places)) to.emplace_back(v, *found);
    }
  };
  tree.for_each_pair(deepest_, [&](std::size_t chunk, Index t, Index other) {
    look(t, other, found[chunk]);
    look(other, t, found[chunk]);
  });
  facing_.assign(places.size(), {});
  for (const auto& of_chunk : found)
    for (const auto& [v, facing] : of_chunk)
      if (facing_[v].face < 0 || facing.distance < facing_[v].distance) facing_[v] = facing;
}

void Untangling::add_vertices(std::span<const Vec3> places) {
  for (std::size_t v = 0; v < facing_.size(); ++v) {
    const Facing& facing = facing_[v];
    if (facing.face < 0) continue;
    const double apart = facing.behind ? -facing.distance : facing.distance;
    if (apart > kTooNear * surface_.reach()) continue;
    const auto& [p, q, r] = surface_.triangles()[facing.face];
    const auto& w = facing.weights;
    const double along = facing.normal.dot(places[v] - w[0] * places[p] - w[1] * places[q] - w[2] * places[r]);
    add({to_index(v), p, q, r}, {1.0, -w[0], -w[1], -w[2]}, facing.normal, target_ - along);
  }
}

// An edge that goes in through a face and out through the next one, with no vertex behind the surface, crosses the
// ridge between them.
void Untangling::add_edges(std::span<const Vec3> places, std::span<const Piercing> piercings) {
  const auto is_behind = [&](Index v) { return facing_[v].face >= 0 && facing_[v].behind; };
  for (const Piercing& piercing : piercings) {
    const auto& [a, b] = surface_.edges()[piercing.edge];
    if (is_behind(a) || is_behind(b) || std::ranges::any_of(surface_.triangles()[piercing.face], is_behind)) continue;
    const Vec3 normal = normal_of_edge(piercing.edge);
    double least = deepest_;
    std::array<Index, 4> nearest{};
    std::array<double, 4> weights{};
    Vec3 direction = Vec3::Zero();
    for (const Index ridge : surface_.edges_of(piercing.face)) {
      const auto ends = surface_.ends_of(piercing.edge, ridge);
      const std::array<Vec3, 4> at_ends = at(places, ends);
      const Vec3 across = (at_ends[1] - at_ends[0]).cross(at_ends[3] - at_ends[2]);
      const ClosestOnSegments closest = closest_on_segments(at_ends[0], at_ends[1], at_ends[2], at_ends[3]);
      const double apart = std::sqrt(closest.squared_distance);
      if (!(apart < least) || !(across.norm() > 0.0)) continue;
      least = apart;
      nearest = ends;
      weights = {1.0 - closest.first, closest.first, closest.second - 1.0, -closest.second};
      direction = across.normalized();
      if (direction.dot(normal_of_edge(ridge) - normal) < 0.0) direction = -direction;
    }
    if (!(least < deepest_)) continue;
    Vec3 between = Vec3::Zero();
    for (std::size_t k = 0; k < 4; ++k) between += weights[k] * places[nearest[k]];
    const double lacks = target_ - direction.dot(between);
    if (lacks > 0.0) add(nearest, weights, direction, lacks);
  }
}

void Untangling::add(const std::array<Index, 4>& vertices, const std::array<double, 4>& weights, const Vec3& along,
                     double lacks) {
  const auto first = static_cast<std::ptrdiff_t>(rows_.nodes.size());
  for (std::size_t k = 0; k < 4; ++k) {
    const EmbeddedPoint& point = surface_.embedded(vertices[k]);
    for (std::size_t n = 0; n < 8; ++n) {
      const Index node = surface_.lattice().cell_nodes[point.cell][n];
      const double factor = weights[k] * point.weights[n];
      if (factor == 0.0 || !moves_(node)) continue;
      const auto known = std::find(rows_.nodes.begin() + first, rows_.nodes.end(), node);
      if (known != rows_.nodes.end()) {
        rows_.factors[known - rows_.nodes.begin()] += factor * along;
      } else {
        rows_.nodes.push_back(node);
        rows_.factors.push_back(factor * along);
      }
    }
  }
  rows_.start.push_back(static_cast<std::uint32_t>(rows_.nodes.size()));
  lacks_.push_back(lacks);
}

void Untangling::sweep(std::span<double> u) const {
  std::vector<double> gone(u.size(), 0.0);
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (std::size_t r = 0; r < rows_.count(); ++r) {
      double lacks = lacks_[r], squared = 0.0;
      for (std::uint32_t k = rows_.start[r]; k < rows_.start[r + 1]; ++k) {
        lacks -= rows_.factors[k].dot(Vec3::Map(&gone[offset_of(3, rows_.nodes[k])]));
        squared += rows_.factors[k].squaredNorm();
      }
      if (!(lacks > 0.0) || !(squared > kSameNodes)) continue;
      for (std::uint32_t k = rows_.start[r]; k < rows_.start[r + 1]; ++k)
        Vec3::Map(&gone[offset_of(3, rows_.nodes[k])]) += lacks / squared * rows_.factors[k];
    }
  for (std::size_t i = 0; i < u.size(); ++i) u[i] += gone[i];
}

}  // namespace lappet
