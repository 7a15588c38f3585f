#include "solve/newton/leave_saddle.h"

#include <vector>

#include "solve/system/vectors.h"

namespace lappet {

namespace {

constexpr double kFirstStep = 0.01, kMaxStep = 8.0;  // spacings

}  // namespace

template <class Real>
std::optional<double> way_off_saddle(System<Real>& system, std::span<const Real> u, std::span<const Real> mode,
                                     const Multipliers& multipliers, const EvaluationSummary& at, bool inverts) {
  std::vector<Real> trial(u.size()), step(u.size());
  Evaluation now;
  const double start = at.energy - kEnergyRounding * std::abs(at.energy);
  double lowest = start;
  std::optional<double> best;
  const double spacing = system.lattice().settings.spacing;
  for (const double sign : {1.0, -1.0}) {
    for_each_index(u.size(), [&](std::size_t i) { step[i] = static_cast<Real>(sign) * mode[i]; });
    double reached = start;
    for (double alpha = kFirstStep * spacing; alpha <= kMaxStep * spacing; alpha *= 2.0) {
      if (system.largest_step(u, step, alpha) < alpha) break;
      for_each_index(u.size(), [&](std::size_t i) { trial[i] = u[i] + static_cast<Real>(alpha) * step[i]; });
      now = system.evaluate(trial, multipliers, std::move(now));
      if (!inverts && now.inverted > at.inverted) break;
      if (now.energy >= reached) {
        if (reached < start) break;
        continue;
      }
      reached = now.energy;
      if (reached < lowest) {
        lowest = reached;
        best = sign * alpha;
      }
    }
  }
  return best;
}

template std::optional<double> way_off_saddle(System<float>&, std::span<const float>, std::span<const float>,
                                              const Multipliers&, const EvaluationSummary&, bool);
template std::optional<double> way_off_saddle(System<double>&, std::span<const double>, std::span<const double>,
                                              const Multipliers&, const EvaluationSummary&, bool);

}  // namespace lappet
