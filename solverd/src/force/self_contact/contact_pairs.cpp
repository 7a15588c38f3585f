#include "force/self_contact/contact_pairs.h"

#include <algorithm>
#include <cmath>

#include "force/self_contact/barrier.h"
#include "force/self_contact/distances.h"
#include "force/self_contact/separation.h"

namespace lappet {

namespace {

using Kind = TriangleFeature::Kind;

// Of the barrier of edges, in those of vertices and faces: a ridge bears at one pair what a face does at many.
constexpr double kEdgeStiffness = 1.0;
constexpr double kBeyond = 1.0 + 1e-9;
constexpr std::size_t kPairsPerChunk = 256;

// Whether the direction in which a candidate was found tells that it is out of its reach, by more than rounding.
template <int kFirst, class Pair>
bool is_out_of_reach(const std::array<Vec3, 4>& at, const Pair& pair) {
  return apart_along<kFirst>(at, pair.direction.template cast<double>()) > kBeyond * pair.reach;
}

// A barrier of weight `area`, of the vector between the closest points.
void press(TouchingPair& pair, const Vec3& between, double area, const BarrierValue& value) {
  pair.distance = between.norm();
  pair.normal = between / pair.distance;
  pair.energy = area * value.energy;
  pair.slope = area * value.slope;
  pair.stiffness = area * value.curvature;
}

// A parameter of the closest points: towards vertex `to` of the pair from vertex `from`.
void add_parameter(TouchingPair& pair, std::size_t from, std::size_t to, double sign, const Vec3& edge) {
  auto& turn = pair.turns[pair.parameters];
  turn[to] = sign;
  turn[from] = -sign;
  pair.edges[pair.parameters++] = sign * edge;
}

// The part of the surface near a vertex: the faces that count and are within its reach.
class NearVertex {
 public:
  NearVertex(const ContactSurface& surface, std::span<const Vec3> places, double stiffness)
      : surface_(surface), places_(places), stiffness_(stiffness) {}

  void add(std::span<const VertexFacePair> faces, std::vector<TouchingPair>& to) {
    features_.clear();
    vertex_ = faces.front().vertex;
    near_.clear();
    for (const VertexFacePair& pair : faces) {
      const std::array<Vec3, 4> corners = at(places_, surface_.corners_of(vertex_, pair.face));
      if (is_out_of_reach<1>(corners, pair)) continue;
      const ClosestOnTriangle closest = closest_on_triangle(corners[0], corners[1], corners[2], corners[3]);
      if (!(closest.squared_distance < pair.reach * pair.reach)) continue;
      near_.push_back(&pair);
      count(pair, closest);
    }
    if (near_.empty()) return;
    for (const VertexFacePair* pair : near_) take_off_edges(*pair);
    for (const VertexFacePair* pair : near_) add_corners(pair->face);
    for (const Feature& feature : features_)
      if (feature.times != 0) press_on(feature, to);
  }

 private:
  // Vertices of the feature that is closest, -1: none; from where on it counts, and how often.
  struct Feature {
    std::array<Index, 3> vertices;
    std::array<double, 3> weights;
    double reach;
    int times;
  };

  // From where on a face that is near counts; 0: it is not.
  double reach_of(Index face) const {
    const auto found = std::ranges::find(near_, face, [](const VertexFacePair* pair) { return pair->face; });
    return found != near_.end() ? (*found)->reach : 0.0;
  }

  // The closest point of a face, by the corners that it lies between.
  void count(const VertexFacePair& pair, const ClosestOnTriangle& closest) {
    const auto& corners = surface_.triangles()[pair.face];
    const int k = closest.feature.which;
    switch (closest.feature.kind) {
      case Kind::kFace:
        features_.push_back({corners, closest.weights, pair.reach, 1});
        break;
      case Kind::kEdge:
        count_edge(corners[k], corners[(k + 1) % 3], closest.weights[(k + 1) % 3], pair.reach, 1);
        break;
      case Kind::kCorner:
        count({corners[k], -1, -1}, {1.0, 0.0, 0.0}, pair.reach, 1);
        break;
    }
  }
  void count_edge(Index a, Index b, double at, double reach, int times) {
    if (a > b) {
      std::swap(a, b);
      at = 1.0 - at;
    }
    count({a, b, -1}, {1.0 - at, at, 0.0}, reach, times);
  }
  void count(const std::array<Index, 3>& vertices, const std::array<double, 3>& weights, double reach, int times) {
    const auto found = std::ranges::find_if(
        features_, [&](const Feature& feature) { return feature.vertices == vertices && feature.reach == reach; });
    if (found != features_.end())
      found->times += times;
    else
      features_.push_back({vertices, weights, reach, times});
  }

  // Edges that two of the faces share, each at the first of them.
  void take_off_edges(const VertexFacePair& pair) {
    const Index face = pair.face;
    for (int k = 0; k < 3; ++k) {
      const auto& [first, second] = surface_.triangles_at(surface_.edges_of(face)[k]);
      if (face != std::min(first, second)) continue;
      const double reach = std::min(pair.reach, reach_of(std::max(first, second)));
      const auto& corners = surface_.triangles()[face];
      const Index a = std::min(corners[k], corners[(k + 1) % 3]), b = std::max(corners[k], corners[(k + 1) % 3]);
      const ClosestOnSegment closest = closest_on_segment(places_[vertex_], places_[a], places_[b]);
      if (!(closest.squared_distance < reach * reach)) continue;
      if (closest.at == 0.0)
        count({a, -1, -1}, {1.0, 0.0, 0.0}, reach, -1);
      else if (closest.at == 1.0)
        count({b, -1, -1}, {1.0, 0.0, 0.0}, reach, -1);
      else
        count_edge(a, b, closest.at, reach, -1);
    }
  }

  // Corners whose faces are all among them, each at the first of them.
  void add_corners(Index face) {
    for (const Index corner : surface_.triangles()[face]) {
      const auto around = surface_.triangles_around(corner);
      if (face != *std::ranges::min_element(around)) continue;
      double reach = surface_.reach();
      for (const Index t : around) reach = std::min(reach, reach_of(t));
      if ((places_[corner] - places_[vertex_]).squaredNorm() < reach * reach)
        count({corner, -1, -1}, {1.0, 0.0, 0.0}, reach, 1);
    }
  }

  void press_on(const Feature& feature, std::vector<TouchingPair>& to) const {
    TouchingPair pair;
    Vec3 between = places_[vertex_];
    pair.vertices[0] = vertex_;
    pair.weights[0] = 1.0;
    for (std::size_t k = 0; k < 3 && feature.vertices[k] >= 0; ++k) {
      pair.vertices[k + 1] = feature.vertices[k];
      pair.weights[k + 1] = -feature.weights[k];
      between -= feature.weights[k] * places_[feature.vertices[k]];
      if (k > 0) add_parameter(pair, 1, k + 1, -1.0, places_[feature.vertices[k]] - places_[feature.vertices[0]]);
    }
    press(pair, between, 0.5 * feature.times * surface_.area(vertex_),
          barrier(between.norm(), feature.reach, stiffness_));
    to.push_back(pair);
  }

  const ContactSurface& surface_;
  std::span<const Vec3> places_;
  double stiffness_;
  Index vertex_ = -1;
  std::vector<const VertexFacePair*> near_;
  std::vector<Feature> features_;
};

// Two edges; each stands for a third of its triangles, and either side for half of the pressure.
void add_edges(const ContactSurface& surface, const EdgePair& edges, std::span<const Vec3> places, double stiffness,
               std::vector<TouchingPair>& to) {
  TouchingPair pair;
  pair.vertices = surface.ends_of(edges.first, edges.second);
  const std::array<Vec3, 4> ends = at(places, pair.vertices);
  if (is_out_of_reach<2>(ends, edges)) return;
  const auto& [a, b, c, d] = ends;
  const ClosestOnSegments closest = closest_on_segments(a, b, c, d);
  if (!(closest.squared_distance < edges.reach * edges.reach)) return;
  pair.weights = {1.0 - closest.first, closest.first, closest.second - 1.0, -closest.second};
  const Vec3 between = pair.weights[0] * a + pair.weights[1] * b + pair.weights[2] * c + pair.weights[3] * d;
  const auto squared_at_rest = [&](Index edge) {
    return (surface.rest(surface.edges()[edge][1]) - surface.rest(surface.edges()[edge][0])).squaredNorm();
  };
  // Where the closest point of an edge is an end, that does not move along.
  if (closest.first > 0.0 && closest.first < 1.0) add_parameter(pair, 0, 1, 1.0, b - a);
  if (closest.second > 0.0 && closest.second < 1.0) add_parameter(pair, 2, 3, -1.0, d - c);
  const ParallelMollifier mollifier(b - a, d - c, squared_at_rest(edges.first) * squared_at_rest(edges.second));
  const double area = 0.25 * (surface.area_of_edge(edges.first) + surface.area_of_edge(edges.second));
  const BarrierValue value = barrier(between.norm(), edges.reach, kEdgeStiffness * stiffness);
  press(pair, between, area * mollifier.value, value);
  const Vec3 first = area * value.energy * mollifier.first, second = area * value.energy * mollifier.second;
  pair.turning = {-first, first, -second, second};
  to.push_back(pair);
}

}  // namespace

std::vector<TouchingPair> touching_pairs(const ContactSurface& surface, const ContactCandidates& candidates,
                                         std::span<const Vec3> places, double stiffness) {
  const auto& faces = candidates.vertex_faces();
  const auto& edges = candidates.edges();
  const std::size_t of_faces = (faces.size() + kPairsPerChunk - 1) / kPairsPerChunk;
  const std::size_t of_edges = (edges.size() + kPairsPerChunk - 1) / kPairsPerChunk;
  std::vector<std::vector<TouchingPair>> found(of_faces + of_edges);
  for_each_chunk(
      faces.size(),
      [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        NearVertex close(surface, places, stiffness);
        // The faces of a vertex belong to the chunk in which they begin.
        while (begin < end && begin > 0 && faces[begin].vertex == faces[begin - 1].vertex) ++begin;
        while (begin < end) {
          std::size_t next = begin + 1;
          while (next < faces.size() && faces[next].vertex == faces[begin].vertex) ++next;
          close.add(std::span(faces).subspan(begin, next - begin), found[chunk]);
          begin = next;
        }
      },
      kPairsPerChunk);
  for_each_chunk(
      edges.size(),
      [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k)
          add_edges(surface, edges[k], places, stiffness, found[of_faces + chunk]);
      },
      kPairsPerChunk);
  std::vector<TouchingPair> result;
  for (const auto& of_chunk : found) result.insert(result.end(), of_chunk.begin(), of_chunk.end());
  return result;
}

}  // namespace lappet
