#include "force/self_contact/distances.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace lappet {

namespace {

using Kind = TriangleFeature::Kind;

// Squared sine of the angle between segments that count as parallel: their closest points are those of an end then.
constexpr double kParallel = 1e-20;

ClosestOnTriangle at_edge(const ClosestOnSegment& on, int edge) {
  ClosestOnTriangle result;
  const int next = (edge + 1) % 3;
  result.weights[edge] = 1.0 - on.at;
  result.weights[next] = on.at;
  result.squared_distance = on.squared_distance;
  if (on.at == 0.0)
    result.feature = {Kind::kCorner, edge};
  else if (on.at == 1.0)
    result.feature = {Kind::kCorner, next};
  else
    result.feature = {Kind::kEdge, edge};
  return result;
}

}  // namespace

ClosestOnTriangle closest_on_triangle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const double area2 = normal.squaredNorm();
  if (area2 > 0.0) {
    const double of_a = (b - point).cross(c - point).dot(normal) / area2;
    const double of_b = (c - point).cross(a - point).dot(normal) / area2;
    const double of_c = (a - point).cross(b - point).dot(normal) / area2;
    if (of_a > 0.0 && of_b > 0.0 && of_c > 0.0) {
      const double height = (point - a).dot(normal);
      return {{Kind::kFace, 0}, {of_a, of_b, of_c}, height * height / area2};
    }
  }
  ClosestOnTriangle best = at_edge(closest_on_segment(point, a, b), 0);
  for (const auto& other : {at_edge(closest_on_segment(point, b, c), 1), at_edge(closest_on_segment(point, c, a), 2)})
    if (other.squared_distance < best.squared_distance) best = other;
  return best;
}

ClosestOnSegments closest_on_segments(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 first = b - a, second = d - c, between = a - c;
  const double aa = first.squaredNorm(), bb = second.squaredNorm(), ab = first.dot(second);
  const double normal2 = first.cross(second).squaredNorm();
  if (normal2 > kParallel * aa * bb) {
    const double fa = first.dot(between), fb = second.dot(between);
    const double s = (ab * fb - bb * fa) / normal2, t = (aa * fb - ab * fa) / normal2;
    if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) return {s, t, (between + s * first - t * second).squaredNorm()};
  }
  const ClosestOnSegment of_a = closest_on_segment(a, c, d), of_b = closest_on_segment(b, c, d);
  const ClosestOnSegment of_c = closest_on_segment(c, a, b), of_d = closest_on_segment(d, a, b);
  ClosestOnSegments best{0.0, of_a.at, of_a.squared_distance};
  for (const ClosestOnSegments& other :
       {ClosestOnSegments{1.0, of_b.at, of_b.squared_distance}, ClosestOnSegments{of_c.at, 0.0, of_c.squared_distance},
        ClosestOnSegments{of_d.at, 1.0, of_d.squared_distance}})
    if (other.squared_distance < best.squared_distance) best = other;
  return best;
}

// Where the segment goes through the plane is looked for in the plane: of points that lie in it but for rounding, as on
// a flat face, the signs of volumes say nothing.
bool segment_meets_triangle(const Vec3& a, const Vec3& b, const std::array<Vec3, 3>& triangle) {
  const auto& [p, q, r] = triangle;
  const Vec3 normal = (q - p).cross(r - p);
  const double above = (a - p).dot(normal), below = (b - p).dot(normal);
  if ((above > 0.0) == (below > 0.0) || above == below) return false;
  const Vec3 x = a + above / (above - below) * (b - a);
  return (q - x).cross(r - x).dot(normal) >= 0.0 && (r - x).cross(p - x).dot(normal) >= 0.0 &&
         (p - x).cross(q - x).dot(normal) >= 0.0;
}

}  // namespace lappet
