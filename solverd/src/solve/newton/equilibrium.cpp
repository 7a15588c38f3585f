#include "solve/newton/equilibrium.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "solve/multigrid/conjugate_gradients.h"
#include "solve/newton/augmented_lagrangian.h"
#include "solve/newton/change_neighborhood.h"
#include "solve/newton/curved_step.h"
#include "solve/newton/displacement_to_come.h"
#include "solve/newton/line_search.h"
#include "solve/newton/local_relaxation.h"
#include "solve/newton/predict_motion.h"
#include "solve/newton/tangent_choice.h"

namespace lappet {

namespace {

constexpr int kMaxLinearIterations = 120;
// The linear solve that carries prescribed motion is exact: nearly incompressible tissue otherwise starts from a volume
// that is wrong everywhere. In a search that begins with a jump a few per cent do for the rest, as Newton's own model
// is no better; one that starts near its end takes the fewest iterations at one.
constexpr double kCarryTolerance = 1e-4, kFarTolerance = 5e-2, kNearTolerance = 1e-2, kMaxTolerance = 0.1;
constexpr double kForcing = 0.3;
constexpr double kJump = 1.0;  // spacings that a prescribed node moves at once
// A residual below that no step lowers may be rounding in float: that of stiff cells which are carried far.
constexpr double kRoundedResidual = 0.1;

// An estimate of the displacement still to come is good where the series has this share of its sum left, and not
// needed any better where all of it is this share of the limit.
constexpr double kGoodEstimate = 0.25, kClearly = 0.3;
// Share of the limit at which a search ends. One that begins within the whole limit has nothing to do: a solve that is
// resumed estimates with another preconditioner, and must come to the same end.
constexpr double kAtEnd = 0.8;
// Where the linear estimate is in doubt the search ends at this share: where the exact tangent has directions of
// negative curvature, as at a saddle, and a definite one stands in, which is too stiff for what is soft; where the
// last step was not a whole one with the exact tangent, so that nothing shows yet whether Newton-Raphson converges;
// where the energy did not fall as predicted in it; and where the step to come is no smaller a part of it than
// Newton-Raphson makes it near an equilibrium. The last three are the signs of a place that tissue passes slowly before
// it moves on.
constexpr double kUnsure = 0.1, kBent = 0.1, kContraction = 0.3;
// A search that is within its tolerances of forces and gaps ends where in so many steps neither the displacement still
// to come has fallen to this share nor the energy by what its rounding leaves of it: along a curved valley, as of
// fibers that are much stiffer than what is around them, a definite tangent makes many steps of about one size. Where
// it grows by as much the tissue leaves a ridge, slowly at first.
constexpr double kNearer = 0.7;
constexpr int kMaxArrivals = 6;
// Share of a step: one of which less was taken may have left a valley that bends.
constexpr double kCutShort = 0.5;
constexpr int kStraightPause = 2;  // such steps that stay straight after one that was not to be bent
constexpr int kManyUpdates = 10;   // of the multipliers: a gap that they can close is closed after a few
// The neighborhood of a change ends at a stricter tolerance; of the limit of the whole it has this share left at most.
constexpr double kShareOfNeighborhood = 0.5;
// Share of the retractors' way; so many steps in a row that something keeps shorter end a search.
constexpr double kBlockedStep = 0.01;
constexpr int kMaxBlocked = 8;
constexpr int kFreeLooks = 2;       // of friction: what does not settle then goes to and fro
constexpr double kNoForce = 1e-20;  // residual over force scale that cannot be told from none
constexpr double kClose = 10.0;     // tolerances of the residual from which a Newton step tells of the next one

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

template <class Real>
class EquilibriumSearch {
 public:
  EquilibriumSearch(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<Real> u, Multipliers& multipliers,
                    const EquilibriumOptions& options, const SolveObserver& observer, Evaluation reused)
      : system_(system),
        preconditioner_(preconditioner),
        u_(u),
        multipliers_(multipliers),
        options_(options),
        observer_(observer),
        augmented_lagrangian_(options.tolerance, options.gap_tolerance),
        step_(u.size()),
        linear_vectors_(u.size()),
        line_(system, multipliers, options.inverts, linear_vectors_.p),
        now_(std::move(reused)) {}

  EquilibriumOutcome run() {
    search();
    outcome_.at = std::move(now_);
    return std::move(outcome_);
  }

 private:
  void search() {
    evaluate();
    (void)rubs_otherwise();
    if (now_.self_contact.touches() && options_.accuracy != Accuracy::kRelaxation)
      system_.leave_closed(u_, multipliers_);
    go_on_moving();
    while (true) {
      const bool carries = system_.prescribed_increment(u_, increment());
      record();
      observer_.progress(outcome_.newton_iterations, outcome_.residual, outcome_.gap);
      if (!std::isfinite(outcome_.residual))
        return fail(FailureCode::kNotFinite, "the residual is not a finite number");
      bool arriving = false;
      if (!carries) {
        const auto action = settle();
        if (action == AugmentedLagrangian::Action::kGiveUp) return;
        arriving = action == AugmentedLagrangian::Action::kConverged;
      }
      if (arriving && has_arrived()) return;
      if (options_.neighborhood_first && !arriving && !neighborhood_tried_ && neighborhood_goes_ahead()) continue;
      if (outcome_.newton_iterations - newton_in_neighborhood_ >= options_.max_newton) return fail_late();
      if (observer_.stop()) return fail(FailureCode::kStopped, "stopped");
      if (arriving && !goes_on())
        return fail(FailureCode::kNoDescent,
                    fmt::format("the displacement still to come stays at {:.2g} mm{}", outcome_.to_come, rounding()));
      const bool solved = arriving ? outcome_.failure.code == FailureCode::kNone : solve_tangent(carries, false);
      if (observer_.stop()) return fail(FailureCode::kStopped, "stopped");
      if (!solved) return;
      ++outcome_.newton_iterations;
      outcome_.active_cells = static_cast<std::int64_t>(system_.lattice().cells());
      if (!take_step(carries)) return;
      if (options_.accuracy != Accuracy::kRelaxation && !carries && !jumped_ &&
          (used_ != PsdProjection::kExact || cut_))
        relax();
    }
  }

  // What holds or pulls the tissue mostly goes on as it did in the frame before, and so does the tissue: from there the
  // search is shorter. Prescribed nodes are carried by steps of their own.
  void go_on_moving() {
    if (options_.motion.empty() && options_.motions.empty()) return;
    if (now_.relative_residual <= options_.tolerance || system_.prescribed_increment(u_, increment())) return;
    if (options_.motions.empty())
      for_each_index(system_.nodes(), [&](std::size_t n) {
        for (std::size_t i = 3 * n; i < 3 * n + 3; ++i)
          step_[i] = system_.is_free(n) ? static_cast<Real>(options_.motion[i]) : Real(0);
      });
    else
      predict_motion<Real>(system_, now_, options_.motions, step_);
    StepTaken taken = line_.go_on(u_, step_, std::move(now_));
    now_ = std::move(taken.reached);
    went_on_ = taken.alpha > 0.0;
    if (went_on_) outcome_.active_cells = static_cast<std::int64_t>(system_.lattice().cells());
    spdlog::debug("  goes on by {:.3g} of the last motion: residual {:.2e}", taken.alpha, now_.relative_residual);
  }

  void evaluate() { now_ = system_.evaluate(u_, multipliers_, std::move(now_)); }
  void record() {
    outcome_.residual =
        options_.accuracy == Accuracy::kRelaxation ? now_.residual / now_.force_scale : now_.relative_residual;
    outcome_.force_scale = now_.force_scale;
    outcome_.energy = now_.energy;
    outcome_.minimum_j = now_.minimum_j;
    outcome_.inverted = now_.inverted;
    outcome_.gap = system_.largest_gap(u_, multipliers_, now_);
  }
  // Sutures between walls have their slack also in a search for a frame in which nothing may meet.
  double gap_of(typename System<Real>::Gaps which) const {
    return system_.self_contact_or_suspended() ? system_.largest_gap(u_, multipliers_, now_, which) : outcome_.gap;
  }
  // Friction goes by what pressed at the last look. True where forces no longer balance with what presses now.
  bool rubs_otherwise() {
    if (!system_.self_contact() || looked_at_ == outcome_.newton_iterations) return false;
    looked_at_ = outcome_.newton_iterations;
    if (!system_.self_contact()->look_for_friction(now_.self_contact)) return false;
    evaluate();
    record();
    if (outcome_.residual <= options_.tolerance) return false;
    if (++looks_ > kFreeLooks) {
      system_.self_contact()->mix_friction(1.0 / (looks_ - kFreeLooks + 1));
      evaluate();
      record();
      if (outcome_.residual > options_.tolerance) return true;
      // Forces balance with the mean, and do not with what presses: that is no equilibrium, and the mean begins anew.
      looks_ = 0;
      (void)system_.self_contact()->look_for_friction(now_.self_contact);
      evaluate();
      record();
    }
    return true;
  }
  void fail(FailureCode code, std::string message) { outcome_.failure = {code, std::move(message)}; }

  void fail_open() {
    fail(
        FailureCode::kGap,
        fmt::format("a suture, a held face or a stiff hook keeps a gap of {:.3g} mm (tolerance {:.3g} mm); its demands "
                    "contradict others or need more force than the tissue bears{}",
                    outcome_.gap, options_.gap_tolerance,
                    now_.self_contact.touches() ? ", or tissue that presses on tissue is in the way" : ""));
  }
  // A gap that many multipliers have not closed is why there is no equilibrium, also where each of them takes so many
  // iterations that these run out first.
  bool stays_open() const {
    return gap_of(System<Real>::Gaps::kOpen) > options_.gap_tolerance &&
           augmented_lagrangian_.updates() >= kManyUpdates &&
           !(system_.contact() && now_.contact.excess > options_.gap_tolerance);
  }
  void fail_late() {
    if (stays_open()) return fail_open();
    fail(FailureCode::kIterations,
         fmt::format("no equilibrium after {} Newton iterations: relative residual {:.2e} (tolerance {:.1e}), gap "
                     "{:.3g} mm",
                     outcome_.newton_iterations, outcome_.residual, options_.tolerance, outcome_.gap));
  }

  // Moves the multipliers on while the residual allows. kConverged: forces and gaps are within their tolerances.
  AugmentedLagrangian::Action settle() {
    while (true) {
      const auto action = augmented_lagrangian_.next(outcome_.residual, gap_of(System<Real>::Gaps::kOpen),
                                                     gap_of(System<Real>::Gaps::kButWalls));
      switch (action) {
        case AugmentedLagrangian::Action::kConverged:
          if (rubs_otherwise()) continue;
          return action;
        case AugmentedLagrangian::Action::kIterate:
          return action;
        case AugmentedLagrangian::Action::kGiveUp:
          if (system_.contact() && now_.contact.excess > options_.gap_tolerance)
            fail(FailureCode::kInBone,
                 fmt::format("tissue is pressed {:.3g} mm deep into bone; what holds or pulls it there contradicts the "
                             "bone: move it, or move the bone away",
                             now_.contact.largest_penetration));
          else
            fail_open();
          return action;
        case AugmentedLagrangian::Action::kUpdate:
          system_.update(multipliers_, u_, now_);
          if (const double factor = augmented_lagrangian_.stiffening(); factor > 1.0) {
            system_.stiffen_widest(factor, u_, multipliers_);
            spdlog::debug("  the penalty of what is open grows {:.3g} times", factor);
          }
          evaluate();
          record();
      }
    }
  }

  // False once many steps within the tolerances of forces and gaps neither brought it nearer nor away from a ridge.
  bool goes_on() {
    if (outcome_.to_come < kNearer * to_come_at_arrival_ || kNearer * outcome_.to_come > to_come_at_arrival_) {
      to_come_at_arrival_ = outcome_.to_come;
      arrivals_ = 0;
    }
    if (now_.energy < energy_at_arrival_ - line_.rounding(now_.energy)) {
      energy_at_arrival_ = now_.energy;
      arrivals_ = 0;
    }
    return ++arrivals_ <= kMaxArrivals;
  }
  static const char* rounding() {
    return std::is_same_v<Real, float> ? "; it may be the rounding of single precision: try precision 'double'" : "";
  }

  // Forces and gaps are within their tolerances: whether the displacement still to come is too, which ends the search.
  // It is no larger than the last Newton step, if that was a whole one whose size is well known; else the next one is
  // found and not taken.
  bool has_arrived() {
    const bool known = options_.known && outcome_.newton_iterations == 0 && options_.known->energy == now_.energy &&
                       options_.known->residual == outcome_.residual;
    if (known) {
      outcome_.to_come = options_.known->to_come;
    } else if (options_.accuracy == Accuracy::kFrame && !(now_.residual > kNoForce * now_.force_scale)) {
      if (options_.keeps_step) outcome_.step.assign(u_.size(), 0.0f);
    } else if (options_.accuracy == Accuracy::kFrame) {
      bool is_near = last_step_ <= kAtEnd && good_ && !bent_;
      outcome_.to_come = last_step_ * unit_;
      if (!is_near || options_.keeps_step) {
        if (!solve_tangent(false, true) || observer_.stop()) return false;
        is_near = is_near || clearly_near_ || to_come_ <= nearness();
        outcome_.to_come = to_come_ * unit_;
        spdlog::debug("  to come {:.3g} mm ({:.3g} of the limit), {} pcg to {:.1e}; the last step was {:.3g}",
                      outcome_.to_come, to_come_, linear_.iterations, linear_.reduction, last_step_);
      }
      if (!is_near) return false;
      if (options_.keeps_step) outcome_.step.assign(step_.begin(), step_.end());
    }
    if (!options_.inverts && now_.inverted > 0)
      fail(FailureCode::kInverted,
           fmt::format("{} cells are inverted at rest (smallest J {:.3g}); make smaller steps between frames "
                       "or a smaller spacing",
                       now_.inverted, now_.minimum_j));
    else
      outcome_.converged = true;
    return true;
  }

  // Share of the limit that the solution of the last linear solve may be where the search ends.
  double nearness() const {
    if (used_ != PsdProjection::kExact || bent_ || !whole_) return kUnsure;
    return std::min(outcome_.newton_iterations > 0 || went_on_ ? kAtEnd : 1.0,
                    std::max(kContraction * last_step_, kUnsure));
  }

  std::span<Real> increment() { return linear_vectors_.z; }

  // K step = -gradient - K increment on free nodes; false if the equations cannot be solved. arriving: until the size
  // of the step is known.
  bool solve_tangent(bool carries, bool arriving) {
    outcome_.seconds_update += watch_.lap();
    const double forcing =
        kForcing * augmented_lagrangian_.strictness() * options_.tolerance / std::max(outcome_.residual, 1e-300);
    const double least = jumped_ ? kFarTolerance : kNearTolerance;
    const double target = carries ? kCarryTolerance : std::clamp(forcing, least, kMaxTolerance);
    // What comes of a step from afar says nothing of the next one.
    const bool tracks = options_.accuracy == Accuracy::kFrame && !carries &&
                        (arriving || outcome_.residual <= kClose * options_.tolerance);
    std::optional<DisplacementLimits<Real>> limits;
    if (tracks) limits.emplace(system_, u_, displacement_tolerance());
    SeriesEstimate pieces;
    const auto enough = [&](double reduction, double alpha, std::span<const Real> p, std::span<const Real> x) {
      if (tracks) pieces.add(std::abs(alpha) * limits->share(p));
      if (!arriving) return reduction <= target && (!tracks || size_is_known(reduction, *limits, x, pieces));
      if (reduction > kMaxTolerance) return false;  // what is floppy is found late
      const double sum = limits->share(x), left = pieces.left();
      clearly_near_ = clearly_near_ || sum + left <= std::min(kClearly, nearness());
      return (clearly_near_ && !options_.keeps_step) || left <= kGoodEstimate * sum || reduction <= kCarryTolerance;
    };
    // A definite tangent knows nothing of soft modes: only the exact one tells how far it is.
    used_ = arriving && !exact_failed_ ? PsdProjection::kExact : tangent_.next();
    while (true) {
      pieces = {};
      clearly_near_ = false;
      system_.linearize(now_, used_);
      try {
        preconditioner_.update(u_);
      } catch (const NotDefiniteError&) {
        if (used_ != PsdProjection::kExact) {
          fail(FailureCode::kTooStiff,
               "the stiffness of a hook or a suture is so large that the equations cannot be solved; lower it");
          return false;
        }
        used_ = tangent_.replace_exact();
        continue;
      }
      outcome_.seconds_setup += watch_.lap();
      set_right_hand_side(carries);
      linear_ = conjugate_gradients_until<Real>(system_, preconditioner_, linear_vectors_, step_, enough,
                                                kMaxLinearIterations, observer_.stop);
      outcome_.pcg_iterations += linear_.iterations;
      outcome_.seconds_linear += watch_.lap();
      if (!linear_.indefinite || used_ != PsdProjection::kExact) break;
      used_ = tangent_.replace_exact();
    }
    tangent_.iteration_done();
    to_come_ = std::numeric_limits<double>::infinity();
    if (tracks) {
      const double sum = limits->share(step_);
      to_come_ = sum + pieces.left();
      good_ = pieces.left() <= kGoodEstimate * sum;
      unit_ = DisplacementLimits<Real>::largest_length(step_) / std::max(sum, 1e-300);
    }
    if (linear_.reduction < 1.0 && linear_.iterations > 0)
      preconditioner_.observe(linear_.iterations / std::max(-std::log10(linear_.reduction), 0.5));
    return true;
  }

  // Whether the size of a step is known or need not be, as it will not be the last.
  bool size_is_known(double reduction, const DisplacementLimits<Real>& limits, std::span<const Real> x,
                     const SeriesEstimate& pieces) const {
    if (!options_.last_step_tells || reduction <= kCarryTolerance) return true;
    const double sum = limits.share(x);
    return sum > kAtEnd || pieces.left() <= kGoodEstimate * sum;
  }

  void set_right_hand_side(bool carries) {
    auto& rhs = linear_vectors_.r;
    if (carries) {
      system_.prescribed_increment(u_, increment());
      system_.multiply(increment(), rhs);
    } else {
      set_zero<Real>(rhs);
    }
    for_each_index(rhs.size(), [&, gradient = now_.gradient.data()](std::size_t i) {
      rhs[i] = static_cast<Real>(-gradient[i]) - rhs[i];
    });
  }

  bool take_step(bool carries) {
    const double minimum_j = now_.minimum_j;
    StepTaken taken;
    if (carries) {
      system_.prescribed_increment(u_, increment());
      const double jump = largest<Real>(increment());
      add<Real>(Real(1), increment(), step_);
      taken = line_.carry(u_, step_, increment(), std::move(now_));
      now_ = std::move(taken.reached);
      if (!(taken.alpha > 0.0)) {
        fail(FailureCode::kInverted,
             "the retractors' motion turns cells inside out however small the step; move them less between frames");
        return false;
      }
      blocked_ = taken.hindered && taken.alpha < kBlockedStep ? blocked_ + 1 : 0;
      if (blocked_ > kMaxBlocked) {
        fail(FailureCode::kBlocked,
             "tissue is in the way of what the retractors carry; lead them around it, or move it away first");
        return false;
      }
      if (jump > kJump * system_.lattice().settings.spacing) {
        tangent_.jumped();
        jumped_ = true;
      }
    } else {
      const double slope = LineSearch<Real>::slope_of(now_, step_);
      if (!(slope < 0.0)) {
        fail(FailureCode::kNoDescent, "the linear solve gave no descent direction");
        return false;
      }
      auto& product = linear_vectors_.q;
      system_.multiply(step_, product);
      taken = line_.descend(u_, step_, std::move(now_), slope, dot<Real>(step_, product),
                            outcome_.residual <= options_.tolerance);
      now_ = std::move(taken.reached);
      exact_failed_ = !(taken.alpha > 0.0);
      if (exact_failed_) {
        if (tangent_.try_another(used_)) return true;
        fail(FailureCode::kNoDescent,
             fmt::format("no step lowers the energy at relative residual {:.2e}{}", outcome_.residual,
                         outcome_.residual < kRoundedResidual ? rounding() : ""));
        return false;
      }
      tangent_.agreed(taken.alpha, taken.ratio, used_);
      if (taken.alpha < kCutShort && used_ == PsdProjection::kExact && !taken.hindered) bend_step(taken.alpha, slope);
    }
    whole_ = !carries && taken.alpha == 1.0 && used_ == PsdProjection::kExact;
    last_step_ = whole_ ? to_come_ : std::numeric_limits<double>::infinity();
    cut_ = !carries && taken.alpha < 1.0;
    bent_ = !carries && std::abs(taken.ratio - 1.0) > kBent;
    if (options_.accuracy == Accuracy::kRelaxation)
      return true;  // the many small searches of a relaxation are not logged
    spdlog::debug("newton {}: residual {:.2e} gap {:.2e} J {:.2f} | pcg {} to {:.1e} {} | alpha {:.3g} ratio {:.3g}",
                  outcome_.newton_iterations, outcome_.residual, outcome_.gap, minimum_j, linear_.iterations,
                  linear_.reduction, used_ == PsdProjection::kExact ? "exact" : "definite", taken.alpha, taken.ratio);
    return true;
  }

  // A step that was cut short may have left a valley that bends: it is followed. Not soon again where that was in vain.
  void bend_step(double alpha, double slope) {
    if (outcome_.residual <= options_.tolerance || --straight_ > 0) return;
    const CurvedStepOutcome curved =
        follow_curve<Real>(system_, preconditioner_, u_, multipliers_, {step_, alpha, slope, options_.inverts},
                           linear_vectors_, now_, observer_.stop);
    outcome_.pcg_iterations += curved.pcg_iterations;
    if (!curved.taken) straight_ = kStraightPause;
  }

  // The state before a part of the tissue went to its own equilibrium, unaware of tissue that it may meet.
  class BeforeShortcut {
   public:
    explicit BeforeShortcut(EquilibriumSearch& search) : search_(search) {
      if (!search.system_.self_contact()) return;
      u_.assign(search.u_.begin(), search.u_.end());
      multipliers_ = search.multipliers_;
      energy_ = search.now_.energy;
    }
    // Goes back to it where tissue met tissue on the way, or where it touches now and the energy of the whole, with
    // what presses on it, is no lower.
    bool is_undone() const {
      if (u_.empty()) return false;
      const bool lower = !search_.now_.self_contact.touches() || search_.now_.energy < energy_;
      if (lower && search_.system_.is_clear_way(u_, search_.u_)) return false;
      copy<Real>(u_, search_.u_);
      search_.multipliers_ = multipliers_;
      search_.evaluate();
      return true;
    }

   private:
    EquilibriumSearch& search_;
    double energy_ = 0.0;
    std::vector<Real> u_;
    Multipliers multipliers_;
  };

  // What the changes reach goes to its equilibrium, before anything else is done; false where all is for the whole.
  bool neighborhood_goes_ahead() {
    neighborhood_tried_ = true;
    const BeforeShortcut before(*this);
    const NeighborhoodOutcome neighborhood = solve_change_neighborhood<Real>(
        system_, preconditioner_.modes().coarse_lattice(), u_, multipliers_, now_, options_, observer_);
    outcome_.newton_iterations += newton_in_neighborhood_ = neighborhood.newton_iterations;
    outcome_.pcg_iterations += neighborhood.pcg_iterations;
    outcome_.seconds_update += neighborhood.seconds_update;
    outcome_.seconds_linear += neighborhood.seconds_linear;
    outcome_.seconds_setup += neighborhood.seconds_setup;
    watch_.lap();
    if (!neighborhood.converged) return false;
    evaluate();
    if (before.is_undone()) return false;
    outcome_.active_cells = neighborhood.active_cells;
    last_step_ = with_rim(neighborhood);
    good_ = true;
    spdlog::debug("  {} cells went ahead: newton {} residual {:.2e}", neighborhood.active_cells,
                  neighborhood.newton_iterations, now_.relative_residual);
    return true;
  }

  // What is still to come after the neighborhood, of which little is: its own, and what its rim gives way by.
  double with_rim(const NeighborhoodOutcome& neighborhood) {
    const DisplacementLimits<Real> limits(system_, u_, displacement_tolerance());
    for_each_index(system_.nodes(), [&](std::size_t n) {
      for (std::size_t i = 3 * n; i < 3 * n + 3; ++i)
        step_[i] = neighborhood.moved[n] ? Real(0) : static_cast<Real>(neighborhood.rim_compliance * now_.gradient[i]);
    });
    const double share = kShareOfNeighborhood + limits.share(step_);
    unit_ = (neighborhood.to_come + DisplacementLimits<Real>::largest_length(step_)) / share;
    return share;
  }

  // What a definite tangent is too stiff for, or what bends too much for a whole step, is often a matter of a few
  // nodes: they go ahead.
  void relax() {
    if (now_.relative_residual <= options_.tolerance) return;
    std::optional<BeforeShortcut> state;
    if (system_.self_contact() && !system_.self_contact()->acts_in_subdomains()) state.emplace(*this);
    const LocalRelaxation relaxed =
        relax_locally<Real>(system_, u_, multipliers_, now_, options_.tolerance, options_.inverts, observer_.stop);
    if (relaxed.nodes == 0) return;
    const double before = now_.relative_residual;
    evaluate();
    if (state && state->is_undone()) return;
    spdlog::debug("  {} nodes relaxed in {} clusters and {} iterations: residual {:.2e} to {:.2e}", relaxed.nodes,
                  relaxed.clusters, relaxed.newton_iterations, before, now_.relative_residual);
  }

  DisplacementTolerance displacement_tolerance() const {
    const double at_most = kSpacingsPerTolerance * options_.tolerance * system_.lattice().settings.spacing;
    return {at_most, kSharePerTolerance * options_.tolerance, options_.gap_tolerance};
  }

  System<Real>& system_;
  TwoLevel<Real>& preconditioner_;
  std::span<Real> u_;
  Multipliers& multipliers_;
  const EquilibriumOptions& options_;
  const SolveObserver& observer_;
  AugmentedLagrangian augmented_lagrangian_;
  TangentChoice tangent_;
  std::vector<Real> step_;
  // Between linear solves r is the right-hand side, z the way that prescribed nodes have to go, p the line search's.
  LinearVectors<Real> linear_vectors_;
  LineSearch<Real> line_;
  Evaluation now_;
  bool jumped_ = false, neighborhood_tried_ = false;
  bool went_on_ = false;  // the search began where the last motion leads
  double to_come_at_arrival_ = std::numeric_limits<double>::infinity();
  double energy_at_arrival_ = std::numeric_limits<double>::infinity();  // from which a fall is counted
  int arrivals_ = 0;
  bool whole_ = true;               // the last step was a whole one with the exact tangent, or none was made
  bool bent_ = false;               // the energy did not fall as predicted in the last step
  bool cut_ = false;                // the line search made the last step shorter
  bool exact_failed_ = false;       // no step along its direction lowered the energy
  int looks_ = 0;                   // of friction, after which forces did not balance
  int looked_at_ = -1;              // the iteration at which friction looked
  int straight_ = 0;                // steps that were cut and stay straight
  int blocked_ = 0;                 // steps in a row in which hardly anything was carried
  int newton_in_neighborhood_ = 0;  // these leave those of the whole as many as ever
  PsdProjection used_ = PsdProjection::kExact;
  LinearOutcome linear_;
  double to_come_ = 0.0;  // of the last linear solve, as a share of the limits
  bool good_ = false;     // and whether the iterations told it well
  bool clearly_near_ = false;
  double unit_ = 0.0;                                           // mm of such a share
  double last_step_ = std::numeric_limits<double>::infinity();  // if it was a whole one with the exact tangent
  EquilibriumOutcome outcome_;
  Stopwatch watch_;
};

}  // namespace

template <class Real>
EquilibriumOutcome find_equilibrium(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<Real> u,
                                    Multipliers& multipliers, const EquilibriumOptions& options,
                                    const SolveObserver& observer, Evaluation reused) {
  return EquilibriumSearch<Real>(system, preconditioner, u, multipliers, options, observer, std::move(reused)).run();
}

template EquilibriumOutcome find_equilibrium<float>(System<float>&, TwoLevel<float>&, std::span<float>, Multipliers&,
                                                    const EquilibriumOptions&, const SolveObserver&, Evaluation);
template EquilibriumOutcome find_equilibrium<double>(System<double>&, TwoLevel<double>&, std::span<double>,
                                                     Multipliers&, const EquilibriumOptions&, const SolveObserver&,
                                                     Evaluation);

}  // namespace lappet
