#include "force/materials/skin_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace lappet {

namespace {

using Box = Eigen::AlignedBox3d;

struct Triangle {
  Vec3 a, b, c;
};

Triangle triangle_of(const Surface& surface, Index t) {
  const auto& [a, b, c] = surface.triangles[t];
  return {surface.points[a], surface.points[b], surface.points[c]};
}

// The weights of a triangle's corners at its point closest to p. A triangle without area is an edge.
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

// For Eigen::BVMinimize.
struct Search {
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
    const double found = squared_distance(point, triangle_of(skin, t));
    if (found < squared || (found == squared && t < triangle)) {
      squared = found;
      triangle = t;
    }
    return found;
  }
};

}  // namespace

SkinTree::SkinTree(const Surface& skin) : skin_(skin) {
  std::vector<Index> triangles(skin.triangles.size());
  std::vector<Box> boxes(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    triangles[t] = to_index(t);
    const Triangle corners = triangle_of(skin, triangles[t]);
    boxes[t] = Box(corners.a).extend(corners.b).extend(corners.c);
  }
  tree_.init(triangles.begin(), triangles.end(), boxes.begin(), boxes.end());
}

SkinTree::Closest SkinTree::closest(const Vec3& point) const {
  Search search{skin_, point};
  Eigen::BVMinimize(tree_, search);
  return {search.triangle, std::sqrt(search.squared), closest_weights(point, triangle_of(skin_, search.triangle))};
}

Vec3 SkinTree::interpolate(const Closest& at, const std::vector<Vec3>& of_points) const {
  const auto& corners = skin_.triangles[at.triangle];
  return at.weights[0] * of_points[corners[0]] + at.weights[1] * of_points[corners[1]] +
         at.weights[2] * of_points[corners[2]];
}

}  // namespace lappet
