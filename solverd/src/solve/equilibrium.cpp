#include "solve/equilibrium.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <limits>

#include "solve/conjugate_gradients.h"

namespace lappet {

namespace {

constexpr double kArmijo = 1e-4;
constexpr double kLeastStep = 1e-5;
constexpr double kStepCap = 8.0;  // spacings a node may move in one iteration
constexpr int kMostLinearIterations = 120;
constexpr int kMostMultiplierUpdates = 60;
// While gaps are open the residual need not be below the tolerance before the multipliers move on: this many tolerances
// at most, in proportion to the gap. Where a gap does not shrink by kGapProgress the residual hides it: solve more
// exactly.
constexpr double kLooseTolerance = 10.0, kGapProgress = 0.7, kStricter = 0.3, kStrictest = 0.02, kStall = 0.5;
// Where the exact tangent is indefinite eigenvalues are clamped while predicted and actual decrease agree to this, and
// replaced by their magnitudes where they do not.
constexpr double kModelAgreement = 0.01;
// Iterations to wait after an indefinite tangent before the exact one is tried again.
constexpr int kIndefinitePause = 3;
// A definite tangent is too stiff where tissue buckles: the step is doubled while the energy falls this much more than
// predicted.
constexpr double kSoftening = 1.4;
constexpr int kMostDoublings = 5;

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace

template <class Real>
EquilibriumOutcome find_equilibrium(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<Real> u,
                                    const EquilibriumOptions& options, const EquilibriumWatch& watcher) {
  const std::size_t size = u.size();
  const double h = system.lattice().settings.spacing;
  std::vector<Real> increment(size), step(size), rhs(size), trial(size), product(size);
  EquilibriumOutcome outcome;
  Definiteness fallback = Definiteness::kClamp;
  int exact_pause = 0;
  int multiplier_updates = 0;
  double strictness = 1.0, previous_gap = std::numeric_limits<double>::infinity(), previous_residual = previous_gap;
  Stopwatch watch;

  Evaluation now = system.evaluate(u);
  const auto record = [&] {
    outcome.residual = now.residual / now.force_scale;
    outcome.force_scale = now.force_scale;
    outcome.energy = now.energy;
    outcome.minimum_j = now.minimum_j;
    outcome.inverted = now.inverted;
    outcome.gap = system.largest_gap(u);
  };
  const auto fail = [&](std::string reason) {
    outcome.reason = std::move(reason);
    return outcome;
  };

  // Doubles the step from u (which has taken it once) while the energy falls and no cell turns over.
  const auto go_further = [&](Evaluation reached, double& alpha) {
    double more = 1.0;
    for (int k = 0; k < kMostDoublings; ++k, more *= 2.0) {
      for (std::size_t i = 0; i < size; ++i) trial[i] = u[i] + static_cast<Real>(more) * step[i];
      const Evaluation further = system.evaluate(trial);
      if (!(further.energy < reached.energy) || further.inverted > reached.inverted) break;
      copy<Real>(trial, u);
      alpha += more;
      reached = further;
    }
    return system.evaluate(u);
  };

  while (true) {
    const bool moves = system.prescribed_increment(u, increment);
    record();
    watcher.progress(outcome.newton_iterations, outcome.residual, outcome.gap);
    if (!std::isfinite(outcome.residual)) return fail("the residual is not a finite number");
    if (!moves) {
      while (true) {  // multipliers
        const bool open = outcome.gap > options.gap_tolerance;
        const double looseness = std::clamp(outcome.gap / options.gap_tolerance, 1.0, kLooseTolerance);
        // What rounding leaves of the residual cannot be asked to fall further.
        const bool stalled = outcome.residual <= options.tolerance && outcome.residual > kStall * previous_residual;
        if (outcome.residual > options.tolerance * (open ? strictness * looseness : 1.0) && !(open && stalled)) {
          previous_residual = outcome.residual;
          break;
        }
        if (!open) {
          if (!options.inverts && now.inverted > 0)
            return fail(
                fmt::format("{} cells are inverted at rest (smallest J {:.3g}); make smaller steps between frames "
                            "or a smaller spacing",
                            now.inverted, now.minimum_j));
          outcome.converged = true;
          return outcome;
        }
        ++multiplier_updates;
        if (multiplier_updates > kMostMultiplierUpdates && system.contact() &&
            system.contact()->excess() > options.gap_tolerance)
          return fail(
              fmt::format("tissue is pressed {:.3g} mm deep into bone; what holds or pulls it there contradicts "
                          "the bone: move it, or move the bone away",
                          system.contact()->largest_penetration()));
        if (multiplier_updates > kMostMultiplierUpdates)
          return fail(
              fmt::format("a suture or a held face keeps a gap of {:.3g} mm (tolerance {:.3g} mm); its demands "
                          "contradict others or need more force than the tissue bears",
                          outcome.gap, options.gap_tolerance));
        if (outcome.gap > kGapProgress * previous_gap) strictness = std::max(kStricter * strictness, kStrictest);
        previous_gap = outcome.gap;
        previous_residual = std::numeric_limits<double>::infinity();
        system.update_multipliers(u);
        now = system.evaluate(u);
        record();
      }
    }
    if (outcome.newton_iterations >= options.max_newton)
      return fail(
          fmt::format("no equilibrium after {} Newton iterations: relative residual {:.2e} (tolerance {:.1e}), gap "
                      "{:.3g} mm",
                      outcome.newton_iterations, outcome.residual, options.tolerance, outcome.gap));
    if (watcher.stop()) return fail("stopped");

    outcome.seconds_update += watch.lap();
    const auto gradient = system.gradient();
    const double target =
        moves ? 1e-3 : std::clamp(0.3 * strictness * options.tolerance / std::max(outcome.residual, 1e-300), 1e-2, 0.1);
    // The exact tangent converges quadratically also beyond a buckling load; a definite one is the way out where it has
    // directions of negative curvature.
    Definiteness definiteness = exact_pause == 0 ? Definiteness::kExact : fallback;
    LinearOutcome linear;
    while (true) {
      system.linearize(definiteness);
      try {
        preconditioner.update(u);
      } catch (const NotDefiniteError&) {
        if (definiteness != Definiteness::kExact)
          return fail("the stiffness of a hook or a suture is so large that the equations cannot be solved; lower it");
        definiteness = fallback;
        exact_pause = kIndefinitePause + 1;
        continue;
      }
      outcome.seconds_setup += watch.lap();
      if (moves)
        system.multiply(increment, rhs);
      else
        std::fill(rhs.begin(), rhs.end(), Real(0));
      for (std::size_t i = 0; i < size; ++i) rhs[i] = static_cast<Real>(-gradient[i]) - rhs[i];
      linear =
          conjugate_gradients<Real>(system, preconditioner, rhs, step, target, kMostLinearIterations, watcher.stop);
      outcome.pcg_iterations += linear.iterations;
      outcome.seconds_linear += watch.lap();
      if (!linear.indefinite || definiteness != Definiteness::kExact) break;
      definiteness = fallback;
      exact_pause = kIndefinitePause + 1;
    }
    exact_pause = std::max(0, exact_pause - 1);
    ++outcome.newton_iterations;
    if (linear.reduction < 1.0 && linear.iterations > 0)
      preconditioner.observe(linear.iterations / std::max(-std::log10(linear.reduction), 0.5));
    if (watcher.stop()) return fail("stopped");

    double slope = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < size; ++i) {
      slope += gradient[i] * static_cast<double>(step[i]);
      largest = std::max(largest, std::abs(static_cast<double>(step[i])));
    }
    system.multiply(step, product);
    const double curvature = dot<Real>(step, product);
    if (moves) {
      for (std::size_t i = 0; i < size; ++i) {
        step[i] += increment[i];
        largest = std::max(largest, std::abs(static_cast<double>(step[i])));
      }
    } else if (!(slope < 0.0)) {
      return fail("the linear solve gave no descent direction");
    }

    // Prescribed motion does work: there the step is only kept from turning cells inside out.
    double alpha = moves ? 1.0 : std::min(1.0, kStepCap * h / std::max(largest, 1e-300));
    alpha = system.largest_step(u, step, alpha);
    const Evaluation before = now;
    while (true) {
      for (std::size_t i = 0; i < size; ++i) trial[i] = u[i] + static_cast<Real>(alpha) * step[i];
      if (moves && alpha == 1.0)  // land exactly
        for (std::size_t n = 0; n < system.nodes(); ++n)
          if (!system.is_free(n))
            for (std::size_t i = 3 * n; i < 3 * n + 3; ++i) trial[i] = u[i] + increment[i];
      now = system.evaluate(trial);
      const bool inverts_more = !options.inverts && now.inverted > before.inverted;
      const double slack = 1e-12 * std::abs(before.energy);
      const bool descends =
          moves ? std::isfinite(now.energy) : now.energy <= before.energy + kArmijo * alpha * slope + slack;
      if (descends && (!inverts_more || alpha < 1e-3)) break;
      if (alpha < kLeastStep) {
        now = system.evaluate(u);
        if (definiteness == Definiteness::kAbsolute)
          return fail(fmt::format("no step lowers the energy at relative residual {:.2e}", outcome.residual));
        fallback = Definiteness::kAbsolute;
        exact_pause = kIndefinitePause;
        alpha = 0.0;
        break;
      }
      double shrink = 0.5;
      // What meets bone along the way bends the energy late: a parabola from the start would make the step too short.
      if (!moves && std::isfinite(now.energy) && !inverts_more && !system.contact()) {
        const double bend = now.energy - before.energy - alpha * slope;
        if (bend > 0.0) shrink = std::clamp(-0.5 * slope * alpha / bend, 0.1, 0.5);
      }
      alpha *= shrink;
    }
    if (alpha > 0.0) {
      copy<Real>(trial, u);
      double ratio = 1.0;
      if (!moves) {
        const auto predicted = [&](double a) { return std::max(-a * slope - 0.5 * a * a * curvature, 1e-300); };
        ratio = (before.energy - now.energy) / predicted(alpha);
        if (definiteness != Definiteness::kExact)
          fallback = std::abs(ratio - 1.0) > kModelAgreement ? Definiteness::kAbsolute : Definiteness::kClamp;
        if (alpha == 1.0 && ratio > kSoftening) now = go_further(now, alpha);
      }
      spdlog::debug(
          "newton {}: residual {:.2e} gap {:.2e} J {:.2f} | pcg {} to {:.1e} {} | alpha {:.3g} largest {:.2e} ratio "
          "{:.3g}",
          outcome.newton_iterations, outcome.residual, outcome.gap, before.minimum_j, linear.iterations,
          linear.reduction, definiteness == Definiteness::kExact ? "exact" : "definite", alpha, largest, ratio);
    }
  }
}

template EquilibriumOutcome find_equilibrium<float>(System<float>&, TwoLevel<float>&, std::span<float>,
                                                    const EquilibriumOptions&, const EquilibriumWatch&);
template EquilibriumOutcome find_equilibrium<double>(System<double>&, TwoLevel<double>&, std::span<double>,
                                                     const EquilibriumOptions&, const EquilibriumWatch&);

}  // namespace lappet
