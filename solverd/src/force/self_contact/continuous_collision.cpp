#include "force/self_contact/continuous_collision.h"

#include <algorithm>
#include <cmath>

#include "force/self_contact/distances.h"

namespace lappet {

namespace {

constexpr int kMaxSteps = 2000;  // where more are needed the way ends

// distance: of four points; speed: by which it changes at most along the whole way.
template <class Distance>
double add_up(std::array<Vec3, 4>& at, const std::array<Vec3, 4>& way, double speed, double most,
              const Distance& distance) {
  const double start = distance(at);
  if (start > speed * most || !(speed > 0.0)) return most;
  const double kept = kDistanceKept * start;
  double clear = 0.0, step = (1.0 - kDistanceKept) * start / speed;
  for (int k = 0; k < kMaxSteps && step > 0.0; ++k) {
    for (int i = 0; i < 4; ++i) at[i] += step * way[i];
    const double now = distance(at);
    if (now < kept && k > 0) return clear;
    clear += step;
    if (clear >= most) return most;
    step = (now - 0.5 * kept) / speed;
  }
  return clear;
}

// Takes the mean off the ways: only what they differ by counts.
void take_mean_off(std::array<Vec3, 4>& way) {
  const Vec3 mean = 0.25 * (way[0] + way[1] + way[2] + way[3]);
  for (Vec3& each : way) each -= mean;
}

}  // namespace

double point_triangle_way(std::array<Vec3, 4> at, std::array<Vec3, 4> way, double most) {
  take_mean_off(way);
  const double speed = way[0].norm() + std::max({way[1].norm(), way[2].norm(), way[3].norm()});
  return add_up(at, way, speed, most, [](const std::array<Vec3, 4>& x) {
    return std::sqrt(closest_on_triangle(x[0], x[1], x[2], x[3]).squared_distance);
  });
}

double segments_way(std::array<Vec3, 4> at, std::array<Vec3, 4> way, double most) {
  take_mean_off(way);
  const double speed = std::max(way[0].norm(), way[1].norm()) + std::max(way[2].norm(), way[3].norm());
  return add_up(at, way, speed, most, [](const std::array<Vec3, 4>& x) {
    return std::sqrt(closest_on_segments(x[0], x[1], x[2], x[3]).squared_distance);
  });
}

}  // namespace lappet
