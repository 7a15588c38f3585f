// How far to go along a Newton step: the energy must fall (Armijo), no node moves more than some spacings, and cells
// of a material that does not invert stay upright. Where tissue buckles a definite tangent is too stiff and the step is
// doubled while the energy falls.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "solve/system/system.h"
#include "solve/system/vectors.h"

namespace lappet {

struct StepTaken {
  double alpha = 0.0;  // 0: no step lowers the energy
  double ratio = 1.0;  // actual to predicted decrease
  Evaluation reached;
  bool hindered = false;  // with self-contact: something was in the way of a longer step
};

template <class Real>
class LineSearch {
 public:
  // multipliers: stay as they are during a search. trial: 3 per node, for the search to write in.
  LineSearch(System<Real>& system, const Multipliers& multipliers, bool inverts, std::span<Real> trial)
      : system_(system), multipliers_(multipliers), inverts_(inverts), trial_(trial) {
    double stiffest = 0.0;
    for (const auto& material : system.elastic().materials().table)
      stiffest = std::max(stiffest, material.youngs_modulus);
    energy_unit_ = stiffest * std::pow(system.lattice().settings.spacing, 3) *
                   std::sqrt(static_cast<double>(system.lattice().cells()));
  }

  // gradient . step
  static double slope_of(const Evaluation& at, std::span<const Real> step) {
    return reduce<1>(step.size(), [g = at.gradient.data(), s = step.data()](std::size_t i, double* out) {
      out[0] = g[i] * static_cast<double>(s[i]);
    })[0];
  }

  // Moves u along the step of a definite or exact tangent. slope: gradient . step, negative; curvature: step . K step.
  // start: the evaluation at u, whose memory goes into those of the trials. balanced: forces balance within their
  // tolerance, and what is sought is the place: also a step that lowers the energy may lead too far then, and the next
  // one back.
  StepTaken descend(std::span<Real> u, std::span<const Real> step, Evaluation start, double slope, double curvature,
                    bool balanced) {
    const EvaluationSummary before = start;
    StepTaken taken{.alpha = 0.0, .ratio = 1.0, .reached = std::move(start)};
    Evaluation& now = taken.reached;
    double alpha = std::min(1.0, kStepCap * system_.lattice().settings.spacing / std::max(largest<Real>(step), 1e-300));
    const double free_way = system_.largest_step(u, step, alpha);
    taken.hindered = system_.self_contact() != nullptr && free_way < alpha;
    alpha = free_way;
    const double slack = 1e-12 * std::abs(before.energy);  // what rounding leaves of an energy
    evaluate_at(u, step, alpha, now);
    while (true) {
      const bool upright = stays_upright(before, now, alpha);
      const bool lower = now.energy <= before.energy + kArmijo * alpha * slope + slack;
      // Where the energy of all of the tissue is rounded more coarsely than a step changes it, the slopes along the
      // step decide (Hager and Zhang 2005, the approximate Wolfe conditions).
      const bool rounded = upright && std::abs(now.energy - before.energy) <= rounding(before.energy);
      const double last = rounded && (balanced || !lower) ? slope_of(now, step) : 0.0;
      const bool overshot = last > -kFlatter * slope;
      if (upright && lower && !overshot) break;
      if (rounded && !lower && !overshot && last >= kFlatter * slope) {
        copy<Real>(trial_, u);
        taken.alpha = alpha;
        return taken;
      }
      if (alpha < kMinStep) {
        evaluate(u, now);
        return taken;
      }
      if (overshot) {
        alpha = go_between(u, step, {.end = alpha, .slope = slope, .slope_at_end = last}, now);
        continue;
      }
      double shrink = 0.5;
      const double bend = now.energy - before.energy - alpha * slope;
      // What meets bone or tissue along the way bends the energy late: a parabola from the start would make the step
      // too short.
      if (upright && std::isfinite(bend) && bend > 0.0 && !system_.contact() && !now.self_contact.touches())
        shrink = std::clamp(-0.5 * slope * alpha / bend, 0.1, 0.5);
      alpha *= shrink;
      evaluate_at(u, step, alpha, now);
    }
    copy<Real>(trial_, u);
    const double predicted = std::max(-alpha * slope - 0.5 * alpha * alpha * curvature, 1e-300);
    taken.ratio = (before.energy - now.energy) / predicted;
    if (alpha == 1.0 && taken.ratio > kSoftening) go_further(u, step, now, alpha);
    taken.alpha = alpha;
    return taken;
  }

  // Moves u along a motion to where the slopes at its start and end make the energy lowest, or the whole of it where
  // that is about the same; alpha: 0 where the energy does not fall so.
  StepTaken go_on(std::span<Real> u, std::span<const Real> motion, Evaluation start) {
    const EvaluationSummary before = start;
    StepTaken taken{.alpha = 0.0, .ratio = 1.0, .reached = std::move(start)};
    Evaluation& now = taken.reached;
    const double first = slope_of(now, motion);
    if (!(first < 0.0)) return taken;
    double alpha = 1.0;
    for (const bool whole : {true, false}) {
      if (system_.largest_step(u, motion, alpha) < alpha) break;
      evaluate_at(u, motion, alpha, now);
      const double lowest = first / (first - slope_of(now, motion));  // times alpha
      if (now.energy < before.energy && now.inverted <= before.inverted &&
          (!whole || std::abs(lowest - 1.0) < kAboutWhole)) {
        copy<Real>(trial_, u);
        taken.alpha = alpha;
        return taken;
      }
      if (!(lowest > kMinMotion && lowest < kMaxMotion)) break;
      alpha *= lowest;
    }
    evaluate(u, now);
    return taken;
  }

  // What rounding may have changed an energy of this size by.
  double rounding(double energy) const { return kRounding * (std::abs(energy) + energy_unit_); }

  // Moves u along a step that carries the prescribed nodes, by `increment` where it is taken whole. Their motion does
  // work: the step is only kept from turning cells over.
  StepTaken carry(std::span<Real> u, std::span<const Real> step, std::span<const Real> increment, Evaluation start) {
    const EvaluationSummary before = start;
    StepTaken taken{.alpha = system_.largest_step(u, step, 1.0), .ratio = 1.0, .reached = std::move(start)};
    taken.hindered = system_.self_contact() != nullptr && taken.alpha < 1.0;
    while (true) {
      for_each_index(u.size(), [&](std::size_t i) { trial_[i] = u[i] + static_cast<Real>(taken.alpha) * step[i]; });
      if (taken.alpha == 1.0)  // land exactly
        for_each_index(system_.nodes(), [&](std::size_t n) {
          if (!system_.is_free(n))
            for (std::size_t i = 3 * n; i < 3 * n + 3; ++i) trial_[i] = u[i] + increment[i];
        });
      evaluate(trial_, taken.reached);
      if (std::isfinite(taken.reached.energy) && stays_upright(before, taken.reached, taken.alpha)) break;
      if (taken.alpha < kMinStep) {
        taken.alpha = 0.0;
        evaluate(u, taken.reached);
        return taken;
      }
      taken.alpha *= 0.5;
    }
    copy<Real>(trial_, u);
    return taken;
  }

 private:
  static constexpr double kArmijo = 1e-4;
  static constexpr double kRounding = 4.0 * std::numeric_limits<Real>::epsilon();
  static constexpr double kMinStep = 1e-5;
  static constexpr double kFlatter = 0.8;      // of the slope that may be left at the end of a step, either way
  static constexpr double kStepCap = 8.0;      // spacings a node may move in one iteration
  static constexpr double kMinUpright = 1e-3;  // shorter steps may turn cells over: the energy decides
  static constexpr double kSoftening = 1.4;    // the energy falls this much more than predicted
  static constexpr int kMaxDoublings = 5, kMaxCuts = 8;
  // Of a motion that goes on: chosen.
  static constexpr double kAboutWhole = 0.25, kMinMotion = 0.05, kMaxMotion = 4.0;

  bool stays_upright(const EvaluationSummary& before, const EvaluationSummary& now, double alpha) const {
    return inverts_ || now.inverted <= before.inverted || alpha < kMinUpright;
  }
  // These write a new evaluation over one that is no longer needed.
  void evaluate(std::span<const Real> u, Evaluation& now) { now = system_.evaluate(u, multipliers_, std::move(now)); }
  void evaluate_at(std::span<const Real> u, std::span<const Real> step, double alpha, Evaluation& now) {
    for_each_index(u.size(), [&](std::size_t i) { trial_[i] = u[i] + static_cast<Real>(alpha) * step[i]; });
    evaluate(trial_, now);
  }
  // A part of a step, from u on: the energy falls at its start and rises at its end. mN mm for each step.
  struct Valley {
    double end, slope, slope_at_end;
  };

  // Evaluates at about the lowest place of a valley and returns where that is: what meets a wall late on the way makes
  // the first guess by the slopes at both ends far too short, so each second one halves what is left.
  double go_between(std::span<const Real> u, std::span<const Real> step, Valley valley, Evaluation& now) {
    double begin = 0.0, slope_at_begin = valley.slope, alpha = valley.end;
    for (int cut = 0; cut < kMaxCuts; ++cut) {
      const double share = cut % 2 == 0 ? slope_at_begin / (slope_at_begin - valley.slope_at_end) : 0.5;
      alpha = begin + share * (valley.end - begin);
      evaluate_at(u, step, alpha, now);
      const double here = slope_of(now, step);
      if (std::abs(here) <= -kFlatter * valley.slope) break;
      if (here > 0.0) {
        valley.end = alpha;
        valley.slope_at_end = here;
      } else {
        begin = alpha;
        slope_at_begin = here;
      }
    }
    return alpha;
  }
  // Doubles the step that u has taken while the energy falls, no cell turns over and none goes through bone.
  void go_further(std::span<Real> u, std::span<const Real> step, Evaluation& now, double& alpha) {
    EvaluationSummary reached = now;
    double more = 1.0;
    for (int k = 0; k < kMaxDoublings; ++k, more *= 2.0) {
      if (system_.largest_step(u, step, more) < more) break;
      evaluate_at(u, step, more, now);
      if (!(now.energy < reached.energy) || now.inverted > reached.inverted) break;
      copy<Real>(trial_, u);
      alpha += more;
      reached = now;
    }
    evaluate(u, now);
  }

  System<Real>& system_;
  const Multipliers& multipliers_;
  bool inverts_;
  std::span<Real> trial_;
  double energy_unit_ = 0.0;  // mN mm; a cell's energy is rounded as a strain of about one would be
};

}  // namespace lappet
