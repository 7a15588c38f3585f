#include "session/find_frame.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "force/materials/material_models.h"
#include "lattice/refused.h"
#include "math/features.h"
#include "session/check_targets.h"
#include "session/is_valid_start.h"
#include "session/retry_schedule.h"
#include "session/softest_mode.h"
#include "solve/newton/leave_saddle.h"
#include "solve/newton/predict_motion.h"

namespace lappet {

namespace {

// Two equilibria whose energies differ by less are the same.
constexpr double kSameEnergy = 1e-6;
// Saddles that are left one after the other in a frame.
constexpr int kMaxSaddles = 6;
// Tolerances of the residual within which a search that has run out of iterations is close to an equilibrium.
constexpr double kNearly = 10.0;
// The way down from a saddle is long: so many times the Newton iterations of a load step.
constexpr int kRounds = 4;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// While it lives the tissue passes through itself.
template <class Real>
class SelfContactSuspended {
 public:
  explicit SelfContactSuspended(System<Real>& system) : system_(system) { system.suspend_self_contact(true); }
  ~SelfContactSuspended() { system_.suspend_self_contact(false); }
  SelfContactSuspended(const SelfContactSuspended&) = delete;
  SelfContactSuspended& operator=(const SelfContactSuspended&) = delete;

 private:
  System<Real>& system_;
};

template <class Real>
class FrameSearch {
 public:
  FrameSearch(const SessionSettings& settings, EpochSystem<Real>& epoch, const TissueState<Real>& before,
              const FrameInput& frame, const std::optional<Arrival>& known, const ProgressCallback& progress,
              const std::atomic<bool>& cancel)
      : settings_(settings),
        epoch_(epoch),
        before_(before),
        frame_(frame),
        cancel_(cancel),
        valid_(is_valid_start<Real>(epoch.lattice, before.u)),
        moved_(std::ranges::any_of(before.u, [](Real x) { return x != Real(0); })) {
    options_.tolerance = settings.tolerance;
    options_.gap_tolerance = settings.gap_tolerance * settings.spacing;
    options_.inverts =
        std::ranges::all_of(settings.materials, [](const auto& m) { return MaterialModels::inverts(m.model); });
    options_.known = known;
    options_.keeps_step = kHasErrorEstimate && settings.correction;
    observer_.stop = [this] { return cancel_.load(std::memory_order_relaxed) || out_of_time(); };
    observer_.progress = [this, &progress](int newton, double residual, double gap) {
      if (progress) progress({frame_.time, found_.effort.newton_iterations + newton, residual, gap});
    };
  }
  FrameSearch(const FrameSearch&) = delete;
  FrameSearch& operator=(const FrameSearch&) = delete;

  FoundFrame<Real> run() {
    const std::string unreachable = check_targets_reachable(
        frame_, settings_.materials[0].youngs_modulus, epoch_.constraints.lowest(), epoch_.constraints.highest(),
        [this](const Anchor& anchor) { return epoch_.constraints.where(anchor, before_.u); });
    if (unreachable.empty()) {
      if (!search_apart()) search();
    } else {
      found_.state = before_;
      epoch_.constraints.apply(frame_, found_.state);
      begin_self_contact(found_.state.u);
      found_.outcome.failure = {FailureCode::kUnreachable, unreachable};
    }
    if (found_.outcome.converged) note_motion();
    if (!found_.outcome.converged) {
      refuse_if_stopped();
      evaluate();
    }
    found_.effort.add(in_vain_);
    return std::move(found_);
  }

 private:
  void search() {
    walk(RetrySchedule(valid_ && moved_, settings_.max_newton, epoch_.system.self_contact() != nullptr,
                       epoch_.constraints.bone_way().steps(before_.bone_motions, frame_.bone_motions),
                       epoch_.constraints.bone_way().steps({}, frame_.bone_motions)));
    settle_doubt();
    if (found_.outcome.converged) part_at_rest();
    if (settings_.stability && found_.outcome.converged) leave_saddles();
  }

  // Where nothing touches before, the frame is found as if nothing did. It stands where nothing touches in it and
  // nothing meets anything on the straight way to it: most frames take no more than the look at that. False, and
  // nothing found, where the search has to keep surfaces apart.
  bool search_apart() {
    System<Real>& system = epoch_.system;
    SelfContact* contact = system.self_contact();
    if (!contact || !contact->is_apart<Real>(before_.u)) return false;
    {
      const SelfContactSuspended<Real> suspended(system);
      search();
    }
    if (found_.outcome.converged && system.is_clear_way(before_.u, found_.state.u) &&
        contact->is_apart<Real>(found_.state.u))
      return true;
    refuse_if_stopped();
    spdlog::info("frame {:g} meets itself: {} iterations as if it did not", frame_.time,
                 found_.effort.newton_iterations);
    in_vain_ = found_.effort;
    Evaluation reused = std::move(found_.outcome.at);
    found_ = {};
    found_.outcome.at = std::move(reused);
    doubtful_.reset();
    return false;
  }

  // What the next frame may go on with: no start over and no way off a saddle.
  void note_motion() {
    auto& motion = found_.state.motion;
    if (std::ranges::equal(found_.state.u, before_.u)) return;
    motion.clear();
    if (found_.effort.restart != Restart::kNone || found_.effort.saddles_left > 0) {
      epoch_.motions.clear();
      return;
    }
    motion.resize(before_.u.size());
    for_each_index(motion.size(),
                   [&](std::size_t i) { motion[i] = static_cast<float>(found_.state.u[i] - before_.u[i]); });
    if (!settings_.live) return;
    if (epoch_.motions.size() == kMaxMotions) epoch_.motions.pop_back();
    epoch_.motions.insert(epoch_.motions.begin(), motion);
  }

  // Tries what the schedule says until an attempt succeeds or none is left.
  void walk(RetrySchedule schedule) {
    if (!valid_) {
      found_.effort.restart = Restart::kInvalidStart;
      spdlog::info("frame {:g} starts from rest: too many cells of its start are inverted or flat", frame_.time);
    }
    while (const auto attempt = schedule.next()) {
      const int reached = try_once(*attempt, schedule);
      const EquilibriumOutcome& outcome = found_.outcome;
      if (stalls(*attempt, reached)) go_off_ridge();
      std::string why = outcome.failure.message;
      if (outcome.converged && outcome.inverted > 0 && !attempt->from_rest) {
        why = fmt::format("{} cells are inverted", outcome.inverted);
        set_aside();
        schedule.start_over(found_.effort.newton_iterations);
      } else if (outcome.converged || observer_.stop()) {
        return;
      } else {
        schedule.failed(reached, outcome.residual, found_.effort.newton_iterations, goes_on(*attempt, reached));
      }
      if (schedule.next() && schedule.next()->from_rest && !attempt->from_rest) {
        found_.effort.restart = doubtful_ ? Restart::kInverted : Restart::kNoEquilibrium;
        spdlog::info("frame {:g} starts over from rest: {}", frame_.time, why);
      }
    }
  }

  // Whether an attempt that ran out of iterations in its last load step goes on: close to an equilibrium, and where
  // there is no load to divide, as under prestretch and weight alone, so that another attempt would go the same way.
  bool goes_on(const Attempt& attempt, int load_step) const {
    const EquilibriumOutcome& outcome = found_.outcome;
    if (outcome.failure.code != FailureCode::kIterations || load_step + 1 != attempt.load_steps) return false;
    const bool nearly = outcome.residual <= kNearly * options_.tolerance && outcome.gap <= options_.gap_tolerance;
    return nearly || !epoch_.constraints.divides(frame_, before_);
  }

  // Whether an attempt came to its end within the tolerances of forces and gaps, and no nearer by further steps.
  bool stalls(const Attempt& attempt, int load_step) const {
    const EquilibriumOutcome& outcome = found_.outcome;
    return outcome.failure.code == FailureCode::kNoDescent && load_step + 1 == attempt.load_steps &&
           outcome.residual <= options_.tolerance && outcome.gap <= options_.gap_tolerance;
  }

  // A ridge of the energy that falls slowly along it has an equilibrium beside it, on its lower side.
  void go_off_ridge() {
    if (!epoch_.system.pressures_have_energy(found_.state.u)) return;
    find_mode(LowestModeSearch::thorough());
    spdlog::debug("  stalls where the softest displacement keeps {:.2g} of its stiffness", mode_.stiffness());
    if (mode_.is_of_saddle()) leave_saddle(kEnergyRounding);
  }

  // Where the surface goes through itself by little at the start of an attempt it is taken apart first.
  void untangle(std::span<Real> u) {
    SelfContact* contact = epoch_.system.self_contact();
    found_.untangled = contact ? contact->untangle<Real>(u, moves()) : 0;
    if (found_.untangled > 0)
      spdlog::info("frame {:g} starts with a surface that went through itself {} times and was taken apart",
                   frame_.time, found_.untangled);
  }

  // What could not be taken apart at the start may come apart where the frame rests, as the next one would begin. It
  // rests again then with all of it kept apart.
  void part_at_rest() {
    if (found_.piercings_before == found_.untangled) return;
    SelfContact& contact = *epoch_.system.self_contact();
    auto apart = found_.state.u;
    if (contact.untangle<Real>(apart, moves()) == 0 || contact.count_piercings<Real>(apart) > 0) return;
    contact.begin<Real>(apart);
    if (search_from(std::move(apart), [](const EquilibriumOutcome&) { return true; })) {
      spdlog::info("frame {:g} came apart where it rests", frame_.time);
      found_.untangled = found_.piercings_before;
    } else {
      contact.begin<Real>(began_);
      evaluate();
    }
  }

  std::function<bool(Index)> moves() const {
    return [this](Index node) { return epoch_.system.is_free(static_cast<std::size_t>(node)); };
  }

  // Where it still does, it cannot be kept apart.
  void begin_self_contact(std::span<const Real> u) {
    if (SelfContact* contact = epoch_.system.self_contact())
      if ((found_.piercings_before = contact->begin<Real>(u)) > 0) {
        spdlog::info("frame {:g} starts with a surface that goes through itself {} times", frame_.time,
                     found_.piercings_before);
        began_.assign(u.begin(), u.end());
      }
    found_.piercings_before += found_.untangled;
  }

  void set_aside() {
    Evaluation reused = std::move(found_.outcome.at);
    doubtful_.emplace(std::exchange(found_.outcome, {}), std::move(found_.state));
    found_.outcome.at = std::move(reused);
  }

  // Returns the load step that failed, or their number.
  int try_once(const Attempt& attempt, const RetrySchedule& schedule) {
    if (attempt.goes_on) {
      options_.neighborhood_first = false;
      clear_motion();
      return search_load_step(frame_, schedule) ? attempt.load_steps : attempt.load_steps - 1;
    }
    found_.state = before_;
    if (attempt.from_rest && moved_) {
      if (valid_) epoch_.constraints.place_sutures(frame_, found_.state);
      found_.state.return_to_rest();
    }
    untangle(found_.state.u);
    begin_self_contact(found_.state.u);
    if (!follows_freely() || attempt.from_rest || attempt.load_steps > 1) epoch_.preconditioner.restart();
    options_.last_step_tells = follows_freely();
    found_.effort.load_steps = attempt.load_steps;
    // While something is dragged the whole keeps its coarse operator, which a neighborhood cannot.
    options_.neighborhood_first = settings_.region == "auto" && !settings_.live &&
                                  !epoch_.preconditioner.is_smoother_only() && attempt.load_steps == 1 &&
                                  found_.untangled == 0;
    clear_motion();
    if (!attempt.from_rest && attempt.load_steps == 1 && (settings_.live || !before_.stability.is_of(digest(frame_)))) {
      options_.motion = before_.motion;
      if (follows_freely()) options_.motions = epoch_.motions;
    }
    const auto path = epoch_.constraints.path(frame_, attempt.load_steps, found_.state);
    for (int step = 0; step < attempt.load_steps; ++step)
      if (options_.accuracy = step + 1 < attempt.load_steps ? Accuracy::kLoadStep : Accuracy::kFrame;
          !take_load_step(path[static_cast<std::size_t>(step)], schedule))
        return step;
    return attempt.load_steps;
  }

  bool take_load_step(const FrameInput& to, const RetrySchedule& schedule) {
    epoch_.constraints.apply(to, found_.state);
    if (!search_load_step(to, schedule)) return false;
    if (options_.accuracy == Accuracy::kLoadStep && settings_.stability)
      descend_from_saddles(kSameEnergy);  // from a saddle the way to the next load step leads along a ridge
    return true;
  }

  bool search_load_step(const FrameInput& to, const RetrySchedule& schedule) {
    search_equilibrium(schedule.newton_left(found_.effort.newton_iterations));
    if (found_.outcome.converged) {
      found_.state.activation = epoch_.constraints.activation_of(to);
      found_.state.loads = to.loads;
      found_.state.bone_motions = to.bone_motions;
    }
    return found_.outcome.converged;
  }

  // Whether it follows a drag and nothing is in the way: tissue that presses on tissue or bone has more than one way to
  // go, which a quadratic model does not know, and what presses changes the coarse operator.
  bool follows_freely() const { return settings_.live && !epoch_.system.self_contact() && !epoch_.system.contact(); }

  void clear_motion() {
    options_.motion = {};
    options_.motions = {};
  }

  void search_equilibrium(int max_newton) {
    SolveEffort& effort = found_.effort;
    EquilibriumOutcome& outcome = found_.outcome;
    options_.max_newton = max_newton;
    outcome = find_equilibrium<Real>(epoch_.system, epoch_.preconditioner, found_.state.u, found_.state.multipliers,
                                     options_, observer_, std::move(outcome.at));
    effort.newton_iterations += outcome.newton_iterations;
    effort.pcg_iterations += outcome.pcg_iterations;
    effort.active_cells = std::max(effort.active_cells, outcome.active_cells);
    effort.seconds_update += outcome.seconds_update;
    effort.seconds_linear += outcome.seconds_linear;
    effort.seconds_setup += outcome.seconds_setup;
  }

  // An equilibrium with inverted cells stands where one from rest has no lower energy; without one it does not.
  void settle_doubt() {
    if (!doubtful_) return;
    auto& [doubtful, state] = *doubtful_;
    EquilibriumOutcome& outcome = found_.outcome;
    if (!outcome.converged) {
      outcome.failure = {
          FailureCode::kInverted,
          fmt::format(
              "{} cells are inverted in the equilibrium found from the frame before, and none is found from rest "
              "to confirm it ({}); make smaller steps between frames or a smaller spacing",
              doubtful.inverted, outcome.failure.message)};
    } else if (doubtful.energy <= outcome.energy + kSameEnergy * std::abs(outcome.energy)) {
      outcome = std::move(doubtful);
      found_.state = std::move(state);
      found_.untangled = 0;
      found_.effort.restart = Restart::kNone;
      epoch_.constraints.apply(frame_, found_.state);
      begin_self_contact(before_.u);
      evaluate();
      SelfContact* contact = epoch_.system.self_contact();
      if (contact && contact->look_for_friction(outcome.at.self_contact)) evaluate();
    }
  }

  // Tissue rests in a minimum of the energy. Moves on from a saddle until none is left or none can be left.
  void leave_saddles() {
    auto& stability = found_.state.stability;
    if (!epoch_.system.pressures_have_energy(found_.state.u)) {
      stability = {};
      return;
    }
    const double constraints = digest(frame_);
    if (stability.is_of(constraints) && std::ranges::equal(found_.state.u, before_.u)) return;
    descend_from_saddles(kEnergyRounding);
    stability = {.constraints = constraints, .lowest_stiffness = mode_.stiffness(), .softest_point = {}};
    if (!mode_.shape().empty()) stability.softest_point = mode_.place();
  }

  // least: share of the energy by which it falls, or the saddle stays.
  void descend_from_saddles(double least) {
    find_mode({});
    if (mode_.is_of_saddle()) find_mode(LowestModeSearch::thorough());
    for (int left = 0; mode_.is_of_saddle() && left < kMaxSaddles && leave_saddle(least); ++left)
      find_mode(LowestModeSearch::thorough());
  }

  void find_mode(const LowestModeSearch& search) {
    const auto start = std::chrono::steady_clock::now();
    mode_.find(search, found_.state.u, found_.outcome.at);
    found_.effort.seconds_stability += seconds_since(start);
  }

  // Goes on from the lower side of the saddle; false, and back at it, where that leads to no lower equilibrium: lower
  // by more than rounding, since what gives way may be a small part of the tissue and of its energy. Where the energy
  // falls to neither side the equilibrium is neutral, as far as the energy can tell.
  bool leave_saddle(double least) {
    const auto amplitude = way_off_saddle<Real>(epoch_.system, found_.state.u, mode_.shape(), found_.state.multipliers,
                                                found_.outcome.at, options_.inverts);
    if (amplitude) {
      const double energy = found_.outcome.energy;
      auto beside = found_.state.u;
      add<Real>(static_cast<Real>(*amplitude), mode_.shape(), beside);
      const auto is_lower = [&](const EquilibriumOutcome& at_saddle) {
        return found_.outcome.inverted <= at_saddle.inverted &&
               found_.outcome.energy < energy - least * std::abs(energy);
      };
      if (search_from(std::move(beside), is_lower)) {
        ++found_.effort.saddles_left;
        spdlog::info("frame {:g} leaves a saddle: energy {:.6g} to {:.6g} mN mm", frame_.time, energy,
                     found_.outcome.energy);
        return true;
      }
    } else {
      mode_.take_as_neutral();
    }
    evaluate();
    return false;
  }

  // Goes on from other displacements than those of an equilibrium, to another one. Where none is found, or
  // stands(outcome of the one before) is false, the one before is found again; it is for the caller to evaluate it.
  template <class Stands>
  bool search_from(std::vector<Real> u, const Stands& stands) {
    TissueState<Real> state = found_.state;
    Evaluation reused = std::move(found_.outcome.at);
    EquilibriumOutcome outcome = std::exchange(found_.outcome, {});
    found_.outcome.at = std::move(reused);
    found_.state.u = std::move(u);
    options_.neighborhood_first = false;
    options_.known.reset();
    clear_motion();
    for (int round = 0; round < kRounds; ++round) {
      search_equilibrium(settings_.max_newton);
      if (found_.outcome.converged || found_.outcome.failure.code != FailureCode::kIterations) break;
    }
    if (found_.outcome.converged && stands(outcome)) return true;
    refuse_if_stopped();
    outcome.at = std::move(found_.outcome.at);
    found_.outcome = std::move(outcome);
    found_.state = std::move(state);
    return false;
  }

  void refuse_if_stopped() const {
    if (!observer_.stop()) return;
    if (cancel_.load()) throw RefusedError(ErrorCode::kCancelled, fmt::format("frame {:g} was cancelled", frame_.time));
    throw RefusedError(
        ErrorCode::kTimeBudget,
        fmt::format("frame {:g} ran out of its time budget of {:g} s at relative residual {:.2e}; raise the "
                    "budget or the spacing",
                    frame_.time, settings_.time_budget, found_.outcome.residual));
  }

  void evaluate() {
    Evaluation& at = found_.outcome.at;
    at = epoch_.system.evaluate(found_.state.u, found_.state.multipliers, std::move(at));
  }
  bool out_of_time() const { return settings_.time_budget > 0.0 && seconds_since(start_) > settings_.time_budget; }

  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  const SessionSettings& settings_;
  EpochSystem<Real>& epoch_;
  const TissueState<Real>& before_;
  const FrameInput& frame_;
  const std::atomic<bool>& cancel_;
  bool valid_, moved_;  // the state before: may be started from, differs from rest
  EquilibriumOptions options_;
  SolveObserver observer_;
  FoundFrame<Real> found_;
  SolveEffort in_vain_;  // before tissue was found to meet tissue
  SoftestMode<Real> mode_{epoch_};
  std::vector<Real> began_;  // where the surface last began to be kept apart but for what goes through itself
  // An equilibrium with inverted cells, until one from rest confirms it.
  std::optional<std::pair<EquilibriumOutcome, TissueState<Real>>> doubtful_;
};

}  // namespace

template <class Real>
FoundFrame<Real> find_frame(const SessionSettings& settings, EpochSystem<Real>& epoch, const TissueState<Real>& before,
                            const FrameInput& frame, const std::optional<Arrival>& known,
                            const ProgressCallback& progress, const std::atomic<bool>& cancel) {
  return FrameSearch<Real>(settings, epoch, before, frame, known, progress, cancel).run();
}

template FoundFrame<float> find_frame(const SessionSettings&, EpochSystem<float>&, const TissueState<float>&,
                                      const FrameInput&, const std::optional<Arrival>&, const ProgressCallback&,
                                      const std::atomic<bool>&);
template FoundFrame<double> find_frame(const SessionSettings&, EpochSystem<double>&, const TissueState<double>&,
                                       const FrameInput&, const std::optional<Arrival>&, const ProgressCallback&,
                                       const std::atomic<bool>&);

}  // namespace lappet
