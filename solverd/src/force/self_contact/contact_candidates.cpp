#include "force/self_contact/contact_candidates.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "force/self_contact/distances.h"
#include "force/self_contact/separation.h"

namespace lappet {

namespace {

constexpr double kLiesOn = 1e-6;  // mm: nearer, the barrier is beyond what positions in single precision can balance

constexpr float kUnit = 1.0F - 1e-6F;  // no unit vector in single precision times this is longer than one

// The least and the largest coordinate of some of four vectors along an axis.
template <int kBegin, int kEnd>
std::pair<double, double> range_along(const std::array<Vec3, 4>& vectors, int axis) {
  double least = vectors[kBegin][axis], most = least;
  for (int i = kBegin + 1; i < kEnd; ++i) {
    least = std::min(least, vectors[i][axis]);
    most = std::max(most, vectors[i][axis]);
  }
  return {least, most};
}

// Whether two primitives stay farther apart than a distance along an axis, where they are and where they go.
template <int kFirst>
bool stays_beyond(const std::array<Vec3, 4>& from, const std::array<Vec3, 4>& way, double distance) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = range_along<0, kFirst>(from, axis);
    const auto [other_low, other_high] = range_along<kFirst, 4>(from, axis);
    const double above = low - other_high, below = other_low - high;
    if (!(std::max(above, below) > distance)) continue;
    const auto [least, most] = range_along<0, kFirst>(way, axis);
    const auto [other_least, other_most] = range_along<kFirst, 4>(way, axis);
    if ((above > below ? above + least - other_most : below + other_least - most) > distance) return true;
  }
  return false;
}

// Sorts what is sorted already up to `begin`.
template <class Pair, class Key>
void sort_from(std::vector<Pair>& pairs, std::ptrdiff_t begin, const Key& key) {
  std::ranges::sort(pairs.begin() + begin, pairs.end(), {}, key);
  std::ranges::inplace_merge(pairs, pairs.begin() + begin, {}, key);
}

}  // namespace

ContactCandidates::ContactCandidates(const ContactCandidates& whole, ContactSurface& subdomain)
    : surface_(subdomain),
      slack_(whole.slack_),
      faces_left_out_(whole.faces_left_out_),
      edges_left_out_(whole.edges_left_out_),
      from_(whole.from_),
      ways_(whole.ways_) {
  const auto moves = [&](const std::array<Index, 4>& vertices) {
    return std::ranges::any_of(vertices, [&](Index v) { return subdomain.embedded(v).cell >= 0; });
  };
  std::ranges::copy_if(whole.vertex_faces_, std::back_inserter(vertex_faces_),
                       [&](const VertexFacePair& pair) { return moves(subdomain.corners_of(pair.vertex, pair.face)); });
  std::ranges::copy_if(whole.edges_, std::back_inserter(edges_),
                       [&](const EdgePair& pair) { return moves(subdomain.ends_of(pair.first, pair.second)); });
}

const std::vector<Piercing>& ContactCandidates::piercings(const std::vector<Vec3>& places) {
  if (places == looked_at_) return piercings_;
  surface_.refit(places, {});
  const BoxTree& tree = surface_.tree();
  std::vector<std::vector<Piercing>> found(tree.chunks());
  const auto look = [&](Index edge, Index face, std::vector<Piercing>& to) {
    const auto& [a, b] = surface_.edges()[edge];
    const auto& [p, q, r] = surface_.triangles()[face];
    if (a == p || a == q || a == r || b == p || b == q || b == r) return;
    if (segment_meets_triangle(places[a], places[b], {places[p], places[q], places[r]})) to.push_back({edge, face});
  };
  tree.for_each_pair(0.0, [&](std::size_t chunk, Index t, Index other) {
    for (int k = 0; k < 3; ++k) {
      if (surface_.owns_edge(t, k)) look(surface_.edges_of(t)[k], other, found[chunk]);
      if (surface_.owns_edge(other, k)) look(surface_.edges_of(other)[k], t, found[chunk]);
    }
  });
  looked_at_ = places;
  piercings_.clear();
  for (const auto& of_chunk : found) piercings_.insert(piercings_.end(), of_chunk.begin(), of_chunk.end());
  std::ranges::sort(piercings_);
  return piercings_;
}

std::size_t ContactCandidates::leave_out(std::span<const Piercing> piercings, const std::vector<Vec3>& places) {
  if (left_out() > 0 || !piercings.empty()) from_.clear();
  faces_left_out_.clear();
  edges_left_out_.clear();
  for (const Piercing& piercing : piercings)
    for (const Index t : surface_.triangles_at(piercing.edge)) {
      if (t < 0) continue;
      for (const Index v : surface_.triangles()[t]) faces_left_out_.insert(key(v, piercing.face));
      for (const Index v : surface_.triangles()[piercing.face]) faces_left_out_.insert(key(v, t));
      for (const Index e : surface_.edges_of(t))
        for (const Index f : surface_.edges_of(piercing.face))
          edges_left_out_.insert(key(std::min(e, f), std::max(e, f)));
    }
  cover(places);
  std::size_t found = 0;
  for (const auto& [vertex, face, reach, direction] : vertex_faces_) {
    const std::array<Vec3, 4> corners = at(places, surface_.corners_of(vertex, face));
    if (apart_along<1>(corners, direction.cast<double>()) > kLiesOn) continue;
    if (closest_on_triangle(corners[0], corners[1], corners[2], corners[3]).squared_distance > kLiesOn * kLiesOn)
      continue;
    faces_left_out_.insert(key(vertex, face));
    ++found;
  }
  for (const EdgePair& pair : edges_) {
    const std::array<Vec3, 4> ends = at(places, surface_.ends_of(pair.first, pair.second));
    if (apart_along<2>(ends, pair.direction.cast<double>()) > kLiesOn) continue;
    if (closest_on_segments(ends[0], ends[1], ends[2], ends[3]).squared_distance > kLiesOn * kLiesOn) continue;
    edges_left_out_.insert(key(pair.first, pair.second));
    ++found;
  }
  if (found > 0) from_.clear();
  return found;
}

void ContactCandidates::cover(const std::vector<Vec3>& places) { cover(places, {}); }

void ContactCandidates::cover(const std::vector<Vec3>& places, const std::vector<Vec3>& ways) {
  if (holds_at(places, {}) && (ways.empty() || holds_at(places, ways))) return;
  take_over(places, ways);
  search();
}

// They hold along the whole way, so also about where it came to.
void ContactCandidates::take_over(const std::vector<Vec3>& places, const std::vector<Vec3>& ways) {
  const bool all = from_.empty();
  const double share = all ? 0.0 : share_of_way(places, {});
  from_.resize(places.size());
  ways_.resize(places.size());
  marked_.assign(places.size(), 1);
  for_each_index(places.size(), [&](std::size_t v) {
    const Vec3 way = ways.empty() ? Vec3(Vec3::Zero()) : ways[v];
    const Vec3 held = from_[v] + share * ways_[v], off = places[v] - held;
    marked_[v] = all || !(std::max(off.squaredNorm(), (off + way).squaredNorm()) <= slack_ * slack_);
    from_[v] = marked_[v] ? places[v] : held;
    ways_[v] = marked_[v] ? way : Vec3(Vec3::Zero());
  });
}

// Of the way that they hold for, nearest to a state or to where its ways lead.
double ContactCandidates::share_of_way(std::span<const Vec3> places, std::span<const Vec3> ways) const {
  double along = 0.0, length2 = 0.0;
  for (std::size_t v = 0; v < from_.size(); ++v) {
    Vec3 off = places[v] - from_[v];
    if (!ways.empty()) off += ways[v];
    along += off.dot(ways_[v]);
    length2 += ways_[v].squaredNorm();
  }
  return length2 > 0.0 ? std::clamp(along / length2, 0.0, 1.0) : 0.0;
}

// At the end of the ways, if any. The way from a place where they hold to another one is covered as well: the share of
// the way and what is off it are linear along it.
bool ContactCandidates::holds_at(std::span<const Vec3> places, std::span<const Vec3> ways) const {
  if (from_.empty()) return false;
  const double share = share_of_way(places, ways);
  for (std::size_t v = 0; v < from_.size(); ++v) {
    Vec3 off = places[v] - from_[v] - share * ways_[v];
    if (!ways.empty()) off += ways[v];
    if (!(off.squaredNorm() <= slack_ * slack_)) return false;
  }
  return true;
}

void ContactCandidates::search() {
  ++searches_;
  surface_.refit(from_, ways_, marked_);
  const BoxTree& tree = surface_.tree();
  std::vector<Found> found(tree.chunks());
  tree.for_each_pair(surface_.reach() + 2.0 * slack_, [&](std::size_t chunk, Index t, Index other) {
    add_vertices(t, other, found[chunk]);
    add_vertices(other, t, found[chunk]);
    add_edges(t, other, found[chunk]);
  });
  std::erase_if(vertex_faces_,
                [this](const VertexFacePair& pair) { return is_marked(surface_.corners_of(pair.vertex, pair.face)); });
  std::erase_if(edges_, [this](const EdgePair& pair) { return is_marked(surface_.ends_of(pair.first, pair.second)); });
  const auto known_faces = static_cast<std::ptrdiff_t>(vertex_faces_.size());
  const auto known_edges = static_cast<std::ptrdiff_t>(edges_.size());
  for (const Found& of_chunk : found) {
    vertex_faces_.insert(vertex_faces_.end(), of_chunk.vertex_faces.begin(), of_chunk.vertex_faces.end());
    edges_.insert(edges_.end(), of_chunk.edges.begin(), of_chunk.edges.end());
  }
  sort_from(vertex_faces_, known_faces, [](const VertexFacePair& pair) { return key(pair.vertex, pair.face); });
  sort_from(edges_, known_edges, [](const EdgePair& pair) { return key(pair.first, pair.second); });
}

// The vertices that a triangle owns, with a face.
void ContactCandidates::add_vertices(Index of, Index face, Found& to) const {
  for (int k = 0; k < 3; ++k) {
    if (!surface_.owns_vertex(of, k)) continue;
    const Index v = surface_.triangles()[of][k];
    const auto& [p, q, r] = surface_.triangles()[face];
    if (v == p || v == q || v == r) continue;
    const auto corners = surface_.corners_of(v, face);
    if (!is_marked(corners)) continue;
    const std::array<Vec3, 4> from = at(from_, corners), way = at(ways_, corners);
    if (stays_beyond<1>(from, way, surface_.reach() + 2.0 * slack_)) continue;
    const auto [of_a, of_b, of_c] = closest_on_triangle(from[0], from[1], from[2], from[3]).weights;
    const Vec3 between = from[0] - of_a * from[1] - of_b * from[2] - of_c * from[3];
    const double apart = between.norm();
    const Vec3 direction = apart > 0.0 ? Vec3(between / apart) : Vec3(Vec3::Zero());
    const auto comes_within = [&](double distance) {
      return apart <= distance || share_apart_along<1>(from, way, direction, distance, 1.0) < 1.0;
    };
    if (!comes_within(surface_.reach() + 2.0 * slack_)) continue;
    const double reach = surface_.reach_to(v, face);
    if (!(reach > 0.0) || !comes_within(reach + 2.0 * slack_)) continue;
    if (faces_left_out_.empty() || !faces_left_out_.contains(key(v, face)))
      to.vertex_faces.push_back({v, face, reach, kUnit * direction.cast<float>()});
  }
}

// The edges that two triangles own.
void ContactCandidates::add_edges(Index triangle, Index other, Found& to) const {
  for (int i = 0; i < 3; ++i) {
    if (!surface_.owns_edge(triangle, i)) continue;
    for (int k = 0; k < 3; ++k) {
      if (!surface_.owns_edge(other, k)) continue;
      const Index e = surface_.edges_of(triangle)[i], f = surface_.edges_of(other)[k];
      const auto ends = surface_.ends_of(e, f);
      if (!is_marked(ends)) continue;
      if (ends[0] == ends[2] || ends[0] == ends[3] || ends[1] == ends[2] || ends[1] == ends[3]) continue;
      const std::array<Vec3, 4> from = at(from_, ends), way = at(ways_, ends);
      if (stays_beyond<2>(from, way, kEdgeShare * surface_.reach() + 2.0 * slack_)) continue;
      const auto [first, second, squared] = closest_on_segments(from[0], from[1], from[2], from[3]);
      const Vec3 between = from[0] - from[2] + first * (from[1] - from[0]) - second * (from[3] - from[2]);
      const double apart = between.norm();
      const Vec3 direction = apart > 0.0 ? Vec3(between / apart) : Vec3(Vec3::Zero());
      const auto comes_within = [&](double distance) {
        return apart <= distance || share_apart_along<2>(from, way, direction, distance, 1.0) < 1.0;
      };
      if (!comes_within(kEdgeShare * surface_.reach() + 2.0 * slack_)) continue;
      const double reach = surface_.reach_of(e, f);
      if (reach > 0.0 && comes_within(reach + 2.0 * slack_) &&
          (edges_left_out_.empty() || !edges_left_out_.contains(key(std::min(e, f), std::max(e, f)))))
        to.edges.push_back({std::min(e, f), std::max(e, f), reach, (e < f ? kUnit : -kUnit) * direction.cast<float>()});
    }
  }
}

std::size_t ContactCandidates::bytes() const {
  return (from_.size() + ways_.size() + looked_at_.size()) * sizeof(Vec3) +
         vertex_faces_.size() * sizeof(VertexFacePair) + marked_.size() + edges_.size() * sizeof(EdgePair);
}

}  // namespace lappet
