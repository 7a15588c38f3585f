#include "solve/newton/predict_motion.h"

#include <cmath>
#include <utility>

#include "math/parallel.h"
#include "solve/system/vectors.h"

namespace lappet {

namespace {

// Share of its energy that a motion must have left beside those before it: less is rounding.
constexpr double kOwnShare = 1e-4;

// A motion and its product with the tangent.
template <class Real>
struct Direction {
  std::vector<Real> way, force;
};

template <class Real>
Direction<Real> direction(const System<Real>& system, std::span<const float> motion) {
  Direction<Real> made{std::vector<Real>(motion.size()), std::vector<Real>(motion.size())};
  for_each_index(system.nodes(), [&](std::size_t n) {
    for (std::size_t i = 3 * n; i < 3 * n + 3; ++i) made.way[i] = system.is_free(n) ? Real(motion[i]) : Real(0);
  });
  system.multiply(made.way, made.force);
  return made;
}

}  // namespace

template <class Real>
void predict_motion(System<Real>& system, const Evaluation& now, std::span<const std::vector<float>> motions,
                    std::span<Real> motion) {
  system.linearize(now, PsdProjection::kExact);
  set_zero<Real>(motion);
  std::vector<Direction<Real>> basis;  // conjugate, of energy one half each
  for (const std::vector<float>& last : motions) {
    Direction<Real> next = direction<Real>(system, last);
    const double whole = dot<Real>(next.way, next.force);
    for (const Direction<Real>& known : basis) {
      const Real shared = Real(-dot<Real>(known.force, next.way));
      add<Real>(shared, known.way, next.way);
      add<Real>(shared, known.force, next.force);
    }
    const double own = dot<Real>(next.way, next.force);
    if (!(own > kOwnShare * std::abs(whole))) continue;  // also where the energy does not curve upwards
    const double slope =
        reduce<1>(next.way.size(), [g = now.gradient.data(), s = next.way.data()](std::size_t i, double* out) {
          out[0] = g[i] * static_cast<double>(s[i]);
        })[0];
    add<Real>(Real(-slope / own), next.way, motion);
    const Real scale = Real(1.0 / std::sqrt(own));
    for_each_index(next.way.size(), [&](std::size_t i) {
      next.way[i] *= scale;
      next.force[i] *= scale;
    });
    basis.push_back(std::move(next));
  }
}

template void predict_motion(System<float>&, const Evaluation&, std::span<const std::vector<float>>, std::span<float>);
template void predict_motion(System<double>&, const Evaluation&, std::span<const std::vector<float>>,
                             std::span<double>);

}  // namespace lappet
