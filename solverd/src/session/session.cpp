#include "session/session.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "lattice/refused.h"
#include "platform/platform.h"
#include "session/bones.h"
#include "session/checks.h"
#include "session/find_frame.h"
#include "session/frame_fields.h"
#include "session/ground_of_session.h"
#include "session/last_frame.h"

namespace lappet {

class Session::Implementation {
 public:
  virtual ~Implementation() = default;
  virtual EpochReport set_epoch(const EpochInput& epoch, const std::atomic<bool>& cancel) = 0;
  virtual void set_state(const SolverState& state) = 0;
  virtual FrameOutput solve(const FrameInput& frame, const ProgressCallback& progress,
                            const std::atomic<bool>& cancel) = 0;
};

namespace {

// An epoch may take so many times the time budget of a frame: it is paid for once.
constexpr double kFramesOfEpoch = 10.0;
// A clock counts no more nanoseconds than some 9e9 s; a budget beyond this is none that anybody waits for.
constexpr double kLongest = 1e9;  // s

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void write_outcome(const EquilibriumOutcome& outcome, FrameOutput& output) {
  output.converged = outcome.converged;
  output.failure = outcome.failure;
  output.residual = outcome.residual;
  output.force_scale = outcome.force_scale;
  output.displacement_to_come = outcome.to_come;
  output.largest_gap = outcome.gap;
  output.minimum_j = outcome.minimum_j;
  output.inverted_cells = outcome.inverted;
  output.energy = outcome.energy;
  output.largest_penetration = outcome.at.contact.largest_penetration;
  output.contacts = outcome.at.contact.count();
  output.self_contacts = static_cast<std::int32_t>(outcome.at.self_contact.pairs.size());
}

template <class Real>
class TypedSession : public Session::Implementation {
 public:
  explicit TypedSession(const SessionSettings& settings)
      : settings_(settings),
        arena_(settings.threads > 0 ? settings.threads : tbb::task_arena::automatic),
        state_(initial_state<Real>(settings)) {}

  EpochReport set_epoch(const EpochInput& epoch, const std::atomic<bool>& cancel) override {
    return arena_.execute(
        [&] { return replace_epoch(epoch, {cancel, std::min(kFramesOfEpoch * settings_.time_budget, kLongest)}); });
  }

  void set_state(const SolverState& state) override {
    if (!epoch_) throw RefusedError(ErrorCode::kOutOfOrder, "a state came before any epoch; send the epoch first");
    check_state(state, state_.u.size(), state_.suture_gaps.size(), settings_.materials.size(),
                std::is_same_v<Real, double>, settings_.moving_bones());
    state_ = imported<Real>(state);
    epoch_->motions.clear();
    epoch_->preconditioner.restart();
    last_frame_.clear();
  }

  FrameOutput solve(const FrameInput& frame, const ProgressCallback& progress,
                    const std::atomic<bool>& cancel) override {
    if (!epoch_) throw RefusedError(ErrorCode::kOutOfOrder, "a frame came before any epoch; send the epoch first");
    check_frame(frame, settings_, epoch_->surface, epoch_->box);
    for (const LoadState& load : frame.loads)
      if (!epoch_->loaded.contains(load.index))
        throw RefusedError(ErrorCode::kInvalidInput, "a load acts on faces that the epoch does not name");
    return arena_.execute([&] { return solve_frame(frame, progress, cancel); });
  }

 private:
  EpochReport replace_epoch(const EpochInput& input, const Interrupt& interrupt) {
    const auto start = std::chrono::steady_clock::now();
    check_epoch(input, settings_);
    if (!bones_) bones_ = distance_to_bones(settings_, interrupt);
    auto epoch = std::make_unique<EpochSystem<Real>>(input, settings_, bones_, ground_.of(input, settings_, interrupt),
                                                     interrupt);
    TissueState<Real> state = carry_over(state_, epoch_ ? &epoch_->lattice : nullptr, epoch->lattice, interrupt);
    EpochReport report = epoch->report(input.nodes);
    report.bytes += static_cast<double>(state.u.size() * sizeof(Real) + (bones_ ? bones_->bytes() : 0));
    epoch_ = std::move(epoch);  // nothing fails from here on
    state_ = std::move(state);
    last_frame_.clear();
    release_freed_memory();
    report.seconds = seconds_since(start);
    return report;
  }

  FrameOutput solve_frame(const FrameInput& frame, const ProgressCallback& progress, const std::atomic<bool>& cancel) {
    const auto start = std::chrono::steady_clock::now();
    const Work done = epoch_->system.work();
    FoundFrame<Real> found =
        find_frame(settings_, *epoch_, state_, frame, last_frame_.arrival_of(frame), progress, cancel);
    const bool converged = found.outcome.converged;
    FrameOutput output;
    output.time = frame.time;
    static_cast<SolveEffort&>(output) = found.effort;
    write_outcome(found.outcome, output);
    output.piercings_before = static_cast<std::int32_t>(found.piercings_before);
    output.untangled = static_cast<std::int32_t>(found.untangled);
    if (SelfContact* contact = epoch_->system.self_contact_or_suspended())
      output.piercings = static_cast<std::int32_t>(contact->count_piercings<Real>(found.state.u));
    const FrameFields* same = converged && found.effort.newton_iterations == 0 ? last_frame_.of(frame) : nullptr;
    static_cast<FrameFields&>(output) = same ? *same : frame_fields(settings_, *epoch_, frame, found);
    if (!converged)
      last_frame_.clear();
    else if (!same)
      last_frame_.keep(frame, output, {output.energy, output.residual, output.displacement_to_come});
    if (converged) state_ = std::move(found.state);
    output.state = exported(state_);
    output.seconds_total = seconds_since(start);
    output.work = epoch_->system.work() - done;
    output.peak_bytes = peak_bytes();
    return output;
  }

  SessionSettings settings_;
  tbb::task_arena arena_;
  std::optional<BoneDistance> bones_;  // none, or no epoch yet
  GroundOfSession ground_;
  std::unique_ptr<EpochSystem<Real>> epoch_;  // null before the first
  TissueState<Real> state_;                   // fits the epoch
  LastFrame last_frame_;
};

}  // namespace

Session::Session(const SessionSettings& settings) {
  check_settings(settings);
  if (settings.precision == "double")
    implementation_ = std::make_unique<TypedSession<double>>(settings);
  else
    implementation_ = std::make_unique<TypedSession<float>>(settings);
}

Session::~Session() = default;
Session::Session(Session&&) noexcept = default;

EpochReport Session::set_epoch(const EpochInput& epoch, const std::atomic<bool>& cancel) {
  return implementation_->set_epoch(epoch, cancel);
}
void Session::set_state(const SolverState& state) { implementation_->set_state(state); }
FrameOutput Session::solve(const FrameInput& frame, const ProgressCallback& progress, const std::atomic<bool>& cancel) {
  return implementation_->solve(frame, progress, cancel);
}

}  // namespace lappet
