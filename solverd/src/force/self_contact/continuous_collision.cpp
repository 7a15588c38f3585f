#include "force/self_contact/continuous_collision.h"

#include <algorithm>
#include <cmath>

#include "force/self_contact/distances.h"
#include "force/self_contact/separation.h"

namespace lappet {

namespace {

constexpr int kMaxSteps = 100;      // where more are needed the way ends
constexpr double kRounding = 1e-9;  // of what is to be kept, so that rounding takes nothing off it

// between: the vector between the closest points of four points.
template <int kFirst, class Between>
double advance(const std::array<Vec3, 4>& at, const std::array<Vec3, 4>& way, double most, double enough,
               const Between& between) {
  std::array<Vec3, 4> now = at;
  double kept = 0.0, clear = 0.0;
  for (int k = 0; k < kMaxSteps; ++k) {
    const Vec3 apart = between(now);
    const double distance = apart.norm();
    if (k == 0) kept = (1.0 + kRounding) * std::min(kDistanceKept * distance, enough);
    if (!(distance > kWayEnds * kept)) return clear;
    const double step = share_apart_along<kFirst>(now, way, apart / distance, kept, most - clear);
    clear += step;
    if (!(clear < most)) return most;
    for (int i = 0; i < 4; ++i) now[i] = at[i] + clear * way[i];
  }
  return clear;
}

}  // namespace

double point_triangle_way(const std::array<Vec3, 4>& at, const std::array<Vec3, 4>& way, double most, double enough) {
  return advance<1>(at, way, most, enough, [](const std::array<Vec3, 4>& x) -> Vec3 {
    const auto [p, q, r] = closest_on_triangle(x[0], x[1], x[2], x[3]).weights;
    return p * (x[0] - x[1]) + q * (x[0] - x[2]) + r * (x[0] - x[3]);
  });
}

double segments_way(const std::array<Vec3, 4>& at, const std::array<Vec3, 4>& way, double most, double enough) {
  return advance<2>(at, way, most, enough, [](const std::array<Vec3, 4>& x) -> Vec3 {
    const ClosestOnSegments closest = closest_on_segments(x[0], x[1], x[2], x[3]);
    return x[0] - x[2] + closest.first * (x[1] - x[0]) - closest.second * (x[3] - x[2]);
  });
}

}  // namespace lappet
