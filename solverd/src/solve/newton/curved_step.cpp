#include "solve/newton/curved_step.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "solve/system/vectors.h"

namespace lappet {

namespace {

constexpr double kTolerance = 0.05;  // of the bend: third order is left out anyway
constexpr int kMaxIterations = 60;
constexpr double kGain = 1.5, kMaxGain = 16.0;  // times as far as the cut step: at least, and at first
constexpr double kArmijo = 1e-4;

}  // namespace

template <class Real>
CurvedStepOutcome follow_curve(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<Real> u,
                               const Multipliers& multipliers, const CutStep<Real>& cut, LinearVectors<Real>& work,
                               Evaluation& at, const std::function<bool()>& stop) {
  const EvaluationSummary at_cut = at;
  const std::size_t size = u.size();
  const auto share = static_cast<Real>(cut.alpha);
  const std::vector<Real> end(u.begin(), u.end());
  std::vector<Real> start(size), bend(size), path(size);
  const std::vector<double> gradient = at.gradient;
  const auto evaluate = [&] { at = system.evaluate(u, multipliers, std::move(at)); };
  for_each_index(size, [&](std::size_t i) { u[i] = start[i] = end[i] - share * cut.step[i]; });
  evaluate();
  const EvaluationSummary at_start = at;

  system.linearize(at, PsdProjection::kExact);
  system.multiply(cut.step, work.q);
  for_each_index(size, [&](std::size_t i) {
    const double beyond = gradient[i] - at.gradient[i] - cut.alpha * static_cast<double>(work.q[i]);
    work.r[i] = static_cast<Real>(-beyond / (cut.alpha * cut.alpha));
  });
  const LinearOutcome linear =
      conjugate_gradients<Real>(system, preconditioner, work, std::span<Real>(bend), kTolerance, kMaxIterations, stop);
  CurvedStepOutcome outcome{.pcg_iterations = linear.iterations};
  for (double beta = std::min(1.0, kMaxGain * cut.alpha); beta > kGain * cut.alpha && !outcome.taken; beta *= 0.5) {
    for_each_index(size, [&](std::size_t i) {
      path[i] = static_cast<Real>(beta) * cut.step[i] + static_cast<Real>(beta * beta) * bend[i];
    });
    if (system.largest_step(start, path, 1.0) < 1.0) continue;
    for_each_index(size, [&](std::size_t i) { u[i] = start[i] + path[i]; });
    evaluate();
    outcome.taken = at.energy < at_cut.energy && at.energy <= at_start.energy + kArmijo * beta * cut.slope &&
                    (cut.inverts || at.inverted <= at_start.inverted);
    if (outcome.taken) spdlog::debug("  along a curve: {:.3g} instead of {:.3g} of a step", beta, cut.alpha);
  }
  if (!outcome.taken) {
    copy<Real>(end, u);
    evaluate();
  }
  return outcome;
}

template CurvedStepOutcome follow_curve(System<float>&, TwoLevel<float>&, std::span<float>, const Multipliers&,
                                        const CutStep<float>&, LinearVectors<float>&, Evaluation&,
                                        const std::function<bool()>&);
template CurvedStepOutcome follow_curve(System<double>&, TwoLevel<double>&, std::span<double>, const Multipliers&,
                                        const CutStep<double>&, LinearVectors<double>&, Evaluation&,
                                        const std::function<bool()>&);

}  // namespace lappet
