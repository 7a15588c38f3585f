#include <algorithm>
#include <cmath>

#include "force/self_contact/barrier.h"
#include "force/self_contact/contact_pairs.h"
#include "force/self_contact/continuous_collision.h"
#include "force/self_contact/distances.h"

namespace lappet {

namespace {

// Where a pair is to end that a step would take through itself, as a share of its reach or of its distance now.
constexpr double kEnd = 0.5;
// Of its spring, in those of a barrier at half its reach: it gives way by little of what is left there.
constexpr double kSpring = 4.0;
constexpr int kMaxAdvances = 8;
constexpr std::size_t kPairsPerChunk = 128;

using Four = std::array<Vec3, 4>;

// Weights of the vector between the closest points of two primitives, and its squared length.
struct Between {
  std::array<double, 4> weights;
  double squared;
};
Between between_vertex_and_face(const Four& x) {
  const ClosestOnTriangle closest = closest_on_triangle(x[0], x[1], x[2], x[3]);
  return {{1.0, -closest.weights[0], -closest.weights[1], -closest.weights[2]}, closest.squared_distance};
}
Between between_edges(const Four& x) {
  const ClosestOnSegments closest = closest_on_segments(x[0], x[1], x[2], x[3]);
  return {{1.0 - closest.first, closest.first, closest.second - 1.0, -closest.second}, closest.squared_distance};
}

Vec3 sum(const std::array<double, 4>& weights, const Four& x) {
  return weights[0] * x[0] + weights[1] * x[1] + weights[2] * x[2] + weights[3] * x[3];
}

// The pair goes on until it is within its reach, where its direction is that in which it would meet.
template <class Way, class Distance>
void add_met(const std::array<Index, 4>& vertices, const Four& from, const Four& way, double reach, double spring,
             const Way& way_of, const Distance& between, std::vector<TouchingPair>& to) {
  double share = way_of(from, way, 1.0);
  if (!(share < 1.0)) return;
  Four x = from;
  Between now = between(x);
  const double start = std::sqrt(now.squared);
  for (int k = 0; k < kMaxAdvances && share < 1.0; ++k) {
    for (int i = 0; i < 4; ++i) x[i] = from[i] + share * way[i];
    now = between(x);
    if (now.squared < reach * reach) break;
    share += way_of(x, way, 1.0 - share);
  }
  if (!(now.squared > 0.0)) return;
  TouchingPair pair;
  pair.vertices = vertices;
  pair.weights = now.weights;
  pair.normal = sum(now.weights, x) / std::sqrt(now.squared);
  pair.distance = pair.normal.dot(sum(now.weights, from));
  pair.stiffness = spring;
  pair.slope = spring * (pair.distance - kEnd * std::min(reach, start));
  to.push_back(pair);
}

}  // namespace

std::vector<TouchingPair> met_pairs(const ContactSurface& surface, const ContactCandidates& candidates,
                                    std::span<const Vec3> places, std::span<const Vec3> ways, double stiffness) {
  const auto& faces = candidates.vertex_faces();
  const auto& edges = candidates.edges();
  const std::size_t of_faces = (faces.size() + kPairsPerChunk - 1) / kPairsPerChunk;
  std::vector<std::vector<TouchingPair>> found(of_faces + (edges.size() + kPairsPerChunk - 1) / kPairsPerChunk);
  const auto spring = [&](double area, double reach) {
    return kSpring * area * barrier(0.5 * reach, reach, stiffness).curvature;
  };
  for_each_chunk(
      faces.size(),
      [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const auto corners = surface.corners_of(faces[k].vertex, faces[k].face);
          const double reach = surface.reach_of(faces[k].vertex);
          add_met(corners, at(places, corners), at(ways, corners), reach,
                  spring(0.5 * surface.area(faces[k].vertex), reach), point_triangle_way, between_vertex_and_face,
                  found[chunk]);
        }
      },
      kPairsPerChunk);
  for_each_chunk(
      edges.size(),
      [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const auto ends = surface.ends_of(edges[k].first, edges[k].second);
          const double area = 0.25 * (surface.area_of_edge(edges[k].first) + surface.area_of_edge(edges[k].second));
          add_met(ends, at(places, ends), at(ways, ends), edges[k].reach, spring(area, edges[k].reach), segments_way,
                  between_edges, found[of_faces + chunk]);
        }
      },
      kPairsPerChunk);
  std::vector<TouchingPair> result;
  for (const auto& of_chunk : found) result.insert(result.end(), of_chunk.begin(), of_chunk.end());
  return result;
}

}  // namespace lappet
