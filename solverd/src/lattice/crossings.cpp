#include "lattice/crossings.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace lappet {
namespace {

// Of a triangle that many lines pass through.
constexpr std::int64_t kLinesBetweenChecks = 16;

__extension__ using Wide = __int128;

std::int64_t floor_divide(std::int64_t a, std::int64_t b) {  // b > 0
  const std::int64_t q = a / b;
  return q - (a % b < 0 ? 1 : 0);
}

std::int64_t ceil_divide(std::int64_t a, std::int64_t b) { return -floor_divide(-a, b); }

std::int64_t center(std::int64_t voxel) { return voxel * kSteps + kSteps / 2; }

// Calls row(v, first_u, last_u) for the lines along `axis` that pass through the triangle; u and v are the two axes
// after `axis` in cyclic order. `normal` is twice the area vector.
template <class Row>
void scan_rows(std::array<StepPoint, 3> corner, const std::array<std::int64_t, 3>& normal, std::size_t axis,
               const VoxelBox& box, const Row& row) {
  if (normal[axis] == 0) return;  // edge-on: a moved line never meets it
  const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (normal[axis] < 0) std::swap(corner[1], corner[2]);
  const auto [low, high] = std::minmax({corner[0][v], corner[1][v], corner[2][v]});
  const std::int64_t first_v = std::max<std::int64_t>(0, ceil_divide(low - kSteps / 2, kSteps));
  const std::int64_t last_v = std::min<std::int64_t>(box.voxels(v) - 1, floor_divide(high - kSteps / 2, kSteps));

  // Edge a -> b: E(U, V) = du (V - a_v) - dv (U - a_u) must be positive at the moved center. E = 0 is decided by
  // du e_v - dv e_u, of which the axis with the smaller number has the larger e.
  struct Edge {
    std::int64_t du, dv, a_u, a_v, minimum;
  };
  std::array<Edge, 3> edges;
  for (std::size_t k = 0; k < 3; ++k) {
    const StepPoint &a = corner[k], &b = corner[(k + 1) % 3];
    const std::int64_t du = b[u] - a[u], dv = b[v] - a[v];
    const std::int64_t tie = u < v ? (dv != 0 ? -dv : du) : (du != 0 ? du : -dv);
    edges[k] = {du, dv, a[u], a[v], tie > 0 ? 0 : 1};
  }
  for (std::int64_t line = first_v; line <= last_v; ++line) {
    std::int64_t first_u = 0, last_u = box.voxels(u) - 1;
    for (const Edge& e : edges) {
      // E - minimum = rest - dv kSteps u' for the center u'.
      const std::int64_t rest = e.du * (center(line) - e.a_v) - e.dv * (kSteps / 2 - e.a_u) - e.minimum;
      if (e.dv > 0)
        last_u = std::min(last_u, floor_divide(rest, e.dv * kSteps));
      else if (e.dv < 0)
        first_u = std::max(first_u, ceil_divide(-rest, -e.dv * kSteps));
      else if (rest < 0)
        last_u = -1;
    }
    if (first_u <= last_u) row(line, first_u, last_u);
  }
}

std::array<StepPoint, 3> corners_of(std::span<const StepPoint> points, const std::array<Index, 3>& triangle) {
  return {points[triangle[0]], points[triangle[1]], points[triangle[2]]};
}

// The crossing of one line with the plane of a triangle: floor of its height above the first center, in steps, lowered
// by one where the moved center lies above a crossing that meets it exactly.
std::int64_t height_above_first_center(const StepPoint& on_plane, const std::array<std::int64_t, 3>& normal,
                                       std::size_t axis, std::int64_t u_steps, std::int64_t v_steps) {
  const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  Wide numerator = -(Wide{normal[u]} * (u_steps - on_plane[u]) + Wide{normal[v]} * (v_steps - on_plane[v]));
  std::int64_t denominator = normal[axis];
  if (denominator < 0) {
    numerator = -numerator;
    denominator = -denominator;
  }
  std::int64_t quotient;
  bool exact;
  if (numerator >= std::numeric_limits<std::int64_t>::min() && numerator <= std::numeric_limits<std::int64_t>::max()) {
    const std::int64_t n = numerator;
    quotient = floor_divide(n, denominator);
    exact = n % denominator == 0;
  } else {
    const Wide q = numerator / denominator, rest = numerator % denominator;
    quotient = std::int64_t(q) - (rest < 0 ? 1 : 0);
    exact = rest == 0;
  }
  std::int64_t height = quotient + on_plane[axis] - kSteps / 2;
  if (exact && (height & (kSteps - 1)) == 0) {
    const std::int64_t leading = normal[0] != 0 ? normal[0] : normal[1] != 0 ? normal[1] : normal[2];
    if ((leading > 0) == (normal[axis] > 0)) --height;
  }
  return height;
}

}  // namespace

std::array<std::int64_t, 3> area_vector(const StepPoint& a, const StepPoint& b, const StepPoint& c) {
  std::array<std::int64_t, 3> normal{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    normal[axis] = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
  }
  return normal;
}

std::vector<std::int64_t> count_crossings(std::span<const StepPoint> points,
                                          std::span<const std::array<Index, 3>> triangles, const VoxelBox& box,
                                          const Interrupt& interrupt) {
  std::vector<std::int64_t> first(triangles.size() + 1, 0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles.size(), 256), [&](const auto& range) {
    interrupt.check();
    for (std::size_t t = range.begin(); t != range.end(); ++t) {
      const auto corner = corners_of(points, triangles[t]);
      const auto normal = area_vector(corner[0], corner[1], corner[2]);
      std::int64_t count = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        scan_rows(corner, normal, axis, box,
                  [&](std::int64_t, std::int64_t first_u, std::int64_t last_u) { count += last_u - first_u + 1; });
      first[t + 1] = count;
    }
  });
  for (std::size_t t = 0; t < triangles.size(); ++t) first[t + 1] += first[t];
  return first;
}

Crossings find_crossings(std::span<const StepPoint> points, std::span<const std::array<Index, 3>> triangles,
                         const VoxelBox& box, std::vector<std::int64_t> first, const Interrupt& interrupt) {
  Crossings result;
  result.first = std::move(first);
  result.all.resize(result.first.back());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles.size(), 64), [&](const auto& range) {
    for (std::size_t t = range.begin(); t != range.end(); ++t) {
      const auto corner = corners_of(points, triangles[t]);
      const auto normal = area_vector(corner[0], corner[1], corner[2]);
      Crossing* out = result.all.data() + result.first[t];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        scan_rows(corner, normal, axis, box, [&](std::int64_t line, std::int64_t first_u, std::int64_t last_u) {
          if (line % kLinesBetweenChecks == 0) interrupt.check();
          for (std::int64_t i = first_u; i <= last_u; ++i) {
            const std::int64_t height = height_above_first_center(corner[0], normal, axis, center(i), center(line));
            Voxel lower;
            lower[u] = std::int32_t(i);
            lower[v] = std::int32_t(line);
            lower[axis] = std::int32_t(height >> kStepBits);
            *out++ = {lower, std::uint16_t(height & (kSteps - 1)), std::int8_t(normal[axis] > 0 ? -1 : 1),
                      std::uint8_t(axis)};
          }
        });
      }
    }
  });
  return result;
}

}  // namespace lappet
