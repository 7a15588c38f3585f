// Closest points of the primitives of a surface: of a point and a triangle, of two segments. The distance is
// differentiable wherever its closest points are unique, and its gradient with respect to a corner is that corner's
// weight times the direction (the envelope theorem), whatever feature they lie on.
#pragma once
#include <algorithm>
#include <array>

#include "lattice/surface.h"

namespace lappet {

// The part of a triangle that a point is closest to. Edge k joins the corners k and k + 1.
struct TriangleFeature {
  enum class Kind { kFace, kEdge, kCorner };
  Kind kind = Kind::kFace;
  int which = 0;  // edge or corner
};

struct ClosestOnTriangle {
  TriangleFeature feature;
  std::array<double, 3> weights{};  // of the corners, their sum is 1
  double squared_distance = 0.0;
};
ClosestOnTriangle closest_on_triangle(const Vec3& point, const Vec3& a, const Vec3& b, const Vec3& c);

struct ClosestOnSegment {
  double at = 0.0;  // 0 at a, 1 at b
  double squared_distance = 0.0;
};
inline ClosestOnSegment closest_on_segment(const Vec3& point, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length2 = along.squaredNorm();
  const double at = length2 > 0.0 ? std::clamp((point - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return {at, (point - a - at * along).squaredNorm()};
}

// Of parallel segments it is one of many.
struct ClosestOnSegments {
  double first = 0.0, second = 0.0;  // 0 at the start of each segment, 1 at its end
  double squared_distance = 0.0;
};
ClosestOnSegments closest_on_segments(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// Whether the segment from a to b meets the triangle.
bool segment_meets_triangle(const Vec3& a, const Vec3& b, const std::array<Vec3, 3>& triangle);

}  // namespace lappet
