#include "force/self_contact/contact_friction.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace lappet {

namespace {

constexpr double kLeast = 1e-3;  // of the largest force, that what pressed at earlier looks still counts with

}  // namespace

void ContactFriction::begin(std::span<const Vec3> places) {
  from_.assign(places.begin(), places.end());
  pressed_.clear();
  before_.clear();
}

void ContactFriction::look(std::span<const TouchingPair> pairs) {
  before_ = std::exchange(pressed_, {});
  for (const TouchingPair& pair : pairs)
    if (pair.slope < 0.0)  // what is taken off at an edge that faces share has no friction of its own
      pressed_.push_back({pair.vertices, pair.weights, pair.normal, -pair.slope});
}

void ContactFriction::mix_with_looks_before(double share) {
  double most = 0.0;
  for (Pressed& pressed : pressed_) most = std::max(most, pressed.force *= share);
  for (Pressed& pressed : before_) most = std::max(most, pressed.force *= 1.0 - share);
  pressed_.insert(pressed_.end(), before_.begin(), before_.end());
  std::erase_if(pressed_, [&](const Pressed& pressed) { return pressed.force < kLeast * most; });
}

std::vector<SlidingPair> ContactFriction::sliding(std::span<const Vec3> places) const {
  std::vector<SlidingPair> result;
  result.reserve(pressed_.size());
  for (const Pressed& pressed : pressed_) {
    Vec3 slid = Vec3::Zero();
    for (std::size_t k = 0; k < 4 && pressed.vertices[k] >= 0; ++k)
      slid += pressed.weights[k] * (places[pressed.vertices[k]] - from_[pressed.vertices[k]]);
    slid -= pressed.normal.dot(slid) * pressed.normal;
    const double far = slid.norm(), share = far / slide_, most = coefficient_ * pressed.force;
    const Vec3 along = far > 0.0 ? Vec3(slid / far) : pressed.normal.unitOrthogonal();
    const Vec3 across = pressed.normal.cross(along);
    // The slope over the distance, and the second derivative along it (Li et al. 2020, eq. 12).
    const bool holds = share < 1.0;
    const double secant = holds ? (2.0 - share) / slide_ : 1.0 / far,
                 curvature = holds ? 2.0 * (1.0 - share) / slide_ : 0.0;
    const double energy = holds ? slide_ * share * share * (1.0 - share / 3.0) : far - slide_ / 3.0;
    result.push_back({pressed.vertices,
                      pressed.weights,
                      most * energy,
                      most * secant * slid,
                      {std::sqrt(most * curvature) * along, std::sqrt(most * secant) * across}});
  }
  return result;
}

std::array<TangentRow, 2> rows_of(const SlidingPair& pair) {
  std::array<TangentRow, 2> rows;
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 0; k < 4; ++k) rows[i][k] = pair.weights[k] * pair.roots[i];
  return rows;
}

}  // namespace lappet
