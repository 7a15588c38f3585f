// How far two primitives of four points in all lie apart along a direction: no more than their distance, whatever the
// direction, and the whole of it where that joins their closest points. It tells without looking for those that a pair
// is not near, and how far straight ways may go before it may be.
#pragma once
#include <algorithm>
#include <array>
#include <limits>

#include "lattice/surface.h"

namespace lappet {

// The first kFirst points span the one primitive, the rest the other. direction: from the other, no longer than a unit.
template <int kFirst>
double apart_along(const std::array<Vec3, 4>& at, const Vec3& direction) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (int i = 0; i < kFirst; ++i) least = std::min(least, direction.dot(at[i]));
  for (int k = kFirst; k < 4; ++k) most = std::max(most, direction.dot(at[k]));
  return least - most;
}

// The share of their ways, `most` at most, on which they stay so far apart along the direction.
template <int kFirst>
double share_apart_along(const std::array<Vec3, 4>& at, const std::array<Vec3, 4>& way, const Vec3& direction,
                         double distance, double most) {
  std::array<double, 4> from, speed;
  for (int i = 0; i < 4; ++i) {
    from[i] = direction.dot(at[i]);
    speed[i] = direction.dot(way[i]);
  }
  for (int i = 0; i < kFirst; ++i)
    for (int k = kFirst; k < 4; ++k) {
      const double left = from[i] - from[k] - distance, closing = speed[k] - speed[i];
      if (most * closing > left) most = closing > 0.0 ? std::max(left / closing, 0.0) : 0.0;
    }
  return most;
}

}  // namespace lappet
