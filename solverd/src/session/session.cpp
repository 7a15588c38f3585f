#include "session/session.h"

#include <spdlog/spdlog.h>
#include <tbb/task_arena.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "lattice/refused.h"
#include "math/features.h"
#include "session/bones.h"
#include "session/check_targets.h"
#include "session/checks.h"
#include "session/frame_constraints.h"
#include "session/is_valid_start.h"
#include "session/last_frame.h"
#include "session/process_memory.h"
#include "session/retry_schedule.h"
#include "session/surface_fields.h"
#include "solve/newton/equilibrium.h"
#include "solve/newton/newton_correction.h"

namespace lappet {

class Session::Implementation {
 public:
  virtual ~Implementation() = default;
  virtual EpochReport set_epoch(const EpochInput& epoch) = 0;
  virtual void set_state(const SolverState& state) = 0;
  virtual FrameOutput solve(const FrameInput& frame, const ProgressCallback& progress,
                            const std::atomic<bool>& cancel) = 0;
};

namespace {

constexpr int kChebyshevDegree = 4;
// All load steps of a frame together may take this many times max_newton iterations, and as many from rest: a frame
// without an equilibrium ends.
constexpr int kNewtonBudget = 4;
// Two equilibria whose energies differ by less are the same.
constexpr double kSameEnergy = 1e-6;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

template <class Real>
class TypedSession : public Session::Implementation {
 public:
  explicit TypedSession(const SessionSettings& settings)
      : settings_(settings),
        arena_(settings.threads > 0 ? settings.threads : tbb::task_arena::automatic),
        state_{{},
               std::vector<double>(3 * static_cast<std::size_t>(settings.sutures),
                                   std::numeric_limits<double>::quiet_NaN()),
               std::vector<double>(3 * static_cast<std::size_t>(settings.sutures), 0.0),
               {},
               std::vector<double>(settings.materials.size(), 0.0)} {
    if (!settings.bones.triangles.empty()) arena_.execute([&] { bones_ = distance_to_bones(settings); });
  }

  EpochReport set_epoch(const EpochInput& epoch) override {
    EpochReport report;
    arena_.execute([&] { report = install(epoch); });
    return report;
  }

  void set_state(const SolverState& state) override {
    if (!epoch_) throw RefusedError(ErrorCode::kOutOfOrder, "a state came before any epoch; send the epoch first");
    check_state(state, state_.u.size(), state_.suture_gaps.size(), settings_.materials.size(),
                std::is_same_v<Real, double>);
    state_.u.assign(state.nodes.begin(), state.nodes.end());
    state_.suture_gaps = state.suture_gaps;
    state_.suture_multipliers = state.suture_multipliers;
    state_.held_multipliers = state.grip_multipliers;
    state_.activation = state.activation;
    last_frame_.clear();
  }

  FrameOutput solve(const FrameInput& frame, const ProgressCallback& progress,
                    const std::atomic<bool>& cancel) override {
    if (!epoch_) throw RefusedError(ErrorCode::kOutOfOrder, "a frame came before any epoch; send the epoch first");
    check_frame(frame, settings_, epoch_->surface);
    FrameOutput output;
    arena_.execute([&] { output = find(frame, progress, cancel); });
    return output;
  }

 private:
  EpochReport install(const EpochInput& epoch) {
    const auto start = std::chrono::steady_clock::now();
    check_epoch(epoch, settings_);
    // After an epoch that is refused the session has none: the solver of the one before makes room.
    epoch_.reset();
    last_frame_.clear();
    constraints_.reset();
    preconditioner_.reset();
    system_.reset();
    LatticeSettings lattice_settings;
    lattice_settings.spacing = settings_.spacing;
    lattice_settings.fine_ratio = settings_.fine_ratio;
    lattice_settings.origin = settings_.origin;
    lattice_settings.memory_budget = settings_.memory_budget;
    auto lattice = std::make_unique<Lattice>(build_lattice(epoch.surface, lattice_settings));

    std::vector<Real> u(3 * lattice->node_rest.size(), Real(0));
    std::vector<double> held;
    if (lattice_) {
      std::vector<Vec3> positions(lattice_->node_rest.size());
      for (std::size_t n = 0; n < positions.size(); ++n)
        positions[n] = lattice_->node_rest[n] +
                       Vec3(double(state_.u[3 * n]), double(state_.u[3 * n + 1]), double(state_.u[3 * n + 2]));
      const auto carried = transfer_positions(*lattice_, positions, *lattice);
      for (std::size_t n = 0; n < carried.size(); ++n)
        for (int i = 0; i < 3; ++i)
          u[3 * n + static_cast<std::size_t>(i)] = static_cast<Real>(carried[n][i] - lattice->node_rest[n][i]);
      if (!state_.held_multipliers.empty()) {
        for (std::size_t n = 0; n < positions.size(); ++n)
          positions[n] = {state_.held_multipliers[3 * n], state_.held_multipliers[3 * n + 1],
                          state_.held_multipliers[3 * n + 2]};
        for (const Vec3& y : transfer_positions(*lattice_, positions, *lattice))
          held.insert(held.end(), {y[0], y[1], y[2]});
      }
    }
    CellMaterials materials = assign_materials(*lattice, settings_.materials, epoch.skin, epoch.regions);
    Attachments attachments = attach(*lattice, epoch.surface, epoch.fixed, epoch.bed, epoch.grip);
    std::unique_ptr<Contact> contact = bones_ ? contact_with_bones(bones_, *lattice, epoch, settings_) : nullptr;
    EpochReport report;
    for (const std::int32_t group : attachments.node_group) report.fixed_nodes += group == kFixedGroup;
    lattice_ = std::move(lattice);
    epoch_.emplace();  // the surface alone: what else it says has gone into what was made of it
    epoch_->index = epoch.index;
    epoch_->surface = epoch.surface;
    system_ =
        std::make_unique<System<Real>>(*lattice_, std::move(materials), settings_.quadrature, std::move(attachments),
                                       settings_.retractors, settings_.bed_stiffness, settings_.gravity);
    system_->set_contact(std::move(contact));
    preconditioner_ = std::make_unique<TwoLevel<Real>>(*system_, kChebyshevDegree);
    if (settings_.preconditioner == "chebyshev") preconditioner_->smoother_only();
    constraints_ = std::make_unique<FrameConstraints<Real>>(settings_, *lattice_, epoch_->surface, *system_, state_);
    state_.u = std::move(u);
    state_.held_multipliers = std::move(held);
    landmarks_.clear();
    for (std::size_t k = 0; k < epoch.landmarks.size(); ++k)
      landmarks_.push_back(
          embed_on_triangle(*lattice_, epoch_->surface, epoch.landmarks[k], epoch.landmark_triangles[k]));

    report.fine_voxels = lattice_->fine_voxels;
    report.cells = static_cast<std::int32_t>(lattice_->cell_nodes.size());
    report.grid_cells = lattice_->grid_cells;
    report.mesh_cells = lattice_->mesh_cells;
    report.nodes = static_cast<std::int32_t>(lattice_->node_rest.size());
    report.fragments = lattice_->fragments;
    if (epoch.nodes)
      for (const Vec3& rest : lattice_->node_rest)
        report.nodes_at_rest.insert(report.nodes_at_rest.end(), rest.begin(), rest.end());
    report.blocks = static_cast<std::int32_t>(system_->elastic().layout().blocks);
    report.bytes = static_cast<double>(lattice_->bytes() + system_->bytes() + preconditioner_->bytes() +
                                       state_.u.size() * sizeof(Real) + (bones_ ? bones_->bytes() : 0));
    release_freed_memory();
    report.seconds = seconds_since(start);
    return report;
  }

  void return_to_rest() {
    std::fill(state_.u.begin(), state_.u.end(), Real(0));
    std::fill(state_.suture_multipliers.begin(), state_.suture_multipliers.end(), 0.0);
    state_.held_multipliers.clear();
  }

  FrameOutput find(const FrameInput& frame, const ProgressCallback& progress, const std::atomic<bool>& cancel) {
    const auto start = std::chrono::steady_clock::now();
    const auto out_of_time = [&] {
      return settings_.time_budget > 0.0 && seconds_since(start) > settings_.time_budget;
    };
    EquilibriumOptions options;
    options.tolerance = settings_.tolerance;
    options.gap_tolerance = settings_.gap_tolerance * settings_.spacing;
    options.max_newton = settings_.max_newton;
    options.inverts =
        std::ranges::all_of(settings_.materials, [](const auto& m) { return MaterialModels::inverts(m.model); });

    FrameOutput output;
    output.time = frame.time;
    const TissueState<Real> before = state_;
    const Work done = system_->work();
    SolveObserver observer;
    observer.stop = [&] { return cancel.load(std::memory_order_relaxed) || out_of_time(); };
    observer.progress = [&](int newton, double residual, double gap) {
      if (progress) progress({frame.time, output.newton_iterations + newton, residual, gap});
    };
    EquilibriumOutcome outcome;
    // Goes to the frame in load steps; returns the one that failed, or their number.
    const auto attempt = [&](int steps, int budget) {
      preconditioner_->restart();
      std::vector<FrameInput> path;
      for (int step = 1; step < steps; ++step)
        path.push_back(constraints_->partway(frame, static_cast<double>(step) / steps));
      path.push_back(frame);
      output.load_steps = steps;
      options.neighborhood_first = settings_.region == "auto" && !preconditioner_->is_smoother_only() && steps == 1;
      for (int step = 0; step < steps; ++step) {
        constraints_->apply(path[static_cast<std::size_t>(step)]);
        options.max_newton = std::min(settings_.max_newton, budget - output.newton_iterations);
        outcome = find_equilibrium<Real>(*system_, *preconditioner_, state_.u, options, observer);
        output.newton_iterations += outcome.newton_iterations;
        output.pcg_iterations += outcome.pcg_iterations;
        output.active_cells = std::max(output.active_cells, outcome.active_cells);
        output.seconds_update += outcome.seconds_update;
        output.seconds_linear += outcome.seconds_linear;
        output.seconds_setup += outcome.seconds_setup;
        if (!outcome.converged) return step;
        constraints_->keep_multipliers(path[static_cast<std::size_t>(step)]);
      }
      return steps;
    };
    const bool valid = is_valid_start<Real>(*lattice_, state_.u);
    const bool moved = std::any_of(state_.u.begin(), state_.u.end(), [](Real x) { return x != Real(0); });
    options.moves_first = !moved && settings_.gravity != Vec3::Zero();
    if (!valid)
      spdlog::info("frame {:g} starts from rest: too many cells of its start are inverted or flat", frame.time);
    RetrySchedule schedule(valid && moved);
    int budget = kNewtonBudget * settings_.max_newton;
    // An equilibrium with inverted cells, until one from rest confirms it.
    std::optional<std::pair<EquilibriumOutcome, TissueState<Real>>> doubtful;
    const auto start_over = [&] {
      spdlog::info("frame {:g} starts over from rest: {}", frame.time,
                   doubtful ? fmt::format("{} cells are inverted", doubtful->first.inverted) : outcome.reason);
      schedule.start_over();
      budget = output.newton_iterations + kNewtonBudget * settings_.max_newton / 2;
    };
    const std::string unreachable = check_targets_reachable(
        frame, settings_.materials[0].youngs_modulus, constraints_->lowest(), constraints_->highest(),
        [&](const Anchor& anchor) { return constraints_->where(anchor); });
    if (!unreachable.empty()) {
      constraints_->apply(frame);
      outcome.reason = unreachable;
    }
    while (unreachable.empty() && schedule.next()) {
      const Attempt next = *schedule.next();
      state_ = before;
      if (next.from_rest && moved) {
        if (valid) constraints_->place_sutures(frame);
        return_to_rest();
      }
      const int reached = attempt(next.load_steps, budget);
      if (outcome.converged && outcome.inverted > 0 && !next.from_rest) {
        doubtful.emplace(outcome, state_);
        start_over();
      } else if (outcome.converged || observer.stop()) {
        break;
      } else if (output.newton_iterations < budget) {
        schedule.failed(reached, outcome.residual);
        if (schedule.next() && schedule.next()->from_rest && !next.from_rest) start_over();
      } else if (next.from_rest) {
        break;
      } else {
        start_over();
      }
    }
    if (doubtful && outcome.converged &&
        doubtful->first.energy <= outcome.energy + kSameEnergy * std::abs(outcome.energy)) {
      outcome = doubtful->first;
      state_ = doubtful->second;
      constraints_->apply(frame);
      system_->evaluate(state_.u);
    } else if (doubtful && !outcome.converged) {
      outcome.reason = fmt::format(
          "{} cells are inverted in the equilibrium found from the frame before, and none is found from rest "
          "to confirm it ({}); make smaller steps between frames or a smaller spacing",
          doubtful->first.inverted, outcome.reason);
    }
    if (!outcome.converged && observer.stop()) {
      state_ = before;
      if (cancel.load()) throw RefusedError(ErrorCode::kCancelled, fmt::format("frame {:g} was cancelled", frame.time));
      throw RefusedError(
          ErrorCode::kTimeBudget,
          fmt::format("frame {:g} ran out of its time budget of {:g} s at relative residual {:.2e}; raise the "
                      "budget or the spacing",
                      frame.time, settings_.time_budget, outcome.residual));
    }
    output.converged = outcome.converged;
    output.reason = outcome.reason;
    output.residual = outcome.residual;
    output.force_scale = outcome.force_scale;
    output.largest_gap = outcome.gap;
    output.minimum_j = outcome.minimum_j;
    output.inverted_cells = outcome.inverted;
    output.energy = outcome.energy;
    if (const Contact* contact = system_->contact()) {
      output.largest_penetration = contact->largest_penetration();
      output.contacts = contact->count();
    }
    const FrameFields* same = outcome.converged && output.newton_iterations == 0 ? last_frame_.of(frame) : nullptr;
    if (same) {
      static_cast<FrameFields&>(output) = *same;
    } else {
      if (!outcome.converged) system_->evaluate(state_.u);  // strain is that of the last evaluation
      write_fields(frame, output);
      if (kHasErrorEstimate && settings_.correction && outcome.converged) write_correction(output);
      last_frame_.keep(frame, output);
    }
    if (!outcome.converged) {
      state_ = before;
      last_frame_.clear();
    }
    output.state.is_double = std::is_same_v<Real, double>;
    output.state.nodes.assign(state_.u.begin(), state_.u.end());
    output.state.suture_gaps = state_.suture_gaps;
    output.state.suture_multipliers = state_.suture_multipliers;
    output.state.grip_multipliers = state_.held_multipliers;
    output.state.activation = state_.activation;
    output.seconds_total = seconds_since(start);
    output.work = system_->work() - done;
    output.peak_bytes = peak_bytes();
    return output;
  }

  void write_fields(const FrameInput& frame, FrameOutput& output) const {
    const auto append = [](auto& array, const Vec3& v) {
      for (int i = 0; i < 3; ++i)
        array.push_back(static_cast<typename std::decay_t<decltype(array)>::value_type>(v[i]));
    };
    for (const auto& point : lattice_->surface_points)
      append(output.points, position<Real>(*lattice_, point, state_.u));
    if constexpr (kHasLandmarks)
      for (const auto& point : landmarks_) append(output.landmarks, position<Real>(*lattice_, point, state_.u));
    if (kHasStrain && settings_.strain) write_surface_fields<Real>(system_->elastic(), state_.u, output);
    for (std::size_t k = 0; k < frame.hooks.size(); ++k) {
      const PointConstraint& constraint = system_->point_constraints()[k];
      append(output.hook_forces, -constraint.force(constraint.value<Real>(state_.u)));
      append(output.hook_points, constraints_->where(frame.hooks[k].anchor));
    }
    for (std::size_t k = 0; k < frame.sutures.size(); ++k) {
      const PointConstraint& constraint = system_->point_constraints()[frame.hooks.size() + k];
      const Vec3 c = constraint.value<Real>(state_.u);
      output.suture_gaps.push_back(c.norm());
      output.suture_forces.push_back(constraint.force(c).norm());
      append(output.suture_points, constraints_->where(frame.sutures[k].a));
      append(output.suture_points, constraints_->where(frame.sutures[k].b));
    }
  }

  void write_correction(FrameOutput& output) {
    std::vector<Real> step(state_.u.size());
    newton_correction<Real>(*system_, *preconditioner_, state_.u, step);
    const auto append = [&](auto& array, const EmbeddedPoint& point) {
      const Vec3 v = displacement<Real>(*lattice_, point, step);
      for (int i = 0; i < 3; ++i)
        array.push_back(static_cast<typename std::decay_t<decltype(array)>::value_type>(v[i]));
    };
    for (const auto& point : lattice_->surface_points) append(output.correction, point);
    for (const auto& point : landmarks_) append(output.landmark_correction, point);
  }

  SessionSettings settings_;
  tbb::task_arena arena_;
  std::shared_ptr<const SignedDistance> bones_;  // null: none
  std::optional<EpochInput> epoch_;
  std::unique_ptr<Lattice> lattice_;
  std::unique_ptr<System<Real>> system_;
  std::unique_ptr<TwoLevel<Real>> preconditioner_;
  TissueState<Real> state_;
  std::unique_ptr<FrameConstraints<Real>> constraints_;
  LastFrame last_frame_;
  std::vector<EmbeddedPoint> landmarks_;
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

EpochReport Session::set_epoch(const EpochInput& epoch) { return implementation_->set_epoch(epoch); }
void Session::set_state(const SolverState& state) { implementation_->set_state(state); }
FrameOutput Session::solve(const FrameInput& frame, const ProgressCallback& progress, const std::atomic<bool>& cancel) {
  return implementation_->solve(frame, progress, cancel);
}

}  // namespace lappet
