#include "session/session.h"

#include <spdlog/spdlog.h>
#include <tbb/task_arena.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "lattice/refused.h"
#include "math/features.h"
#include "session/attempts.h"
#include "session/bones.h"
#include "session/checks.h"
#include "session/fit_to_start.h"
#include "session/process_memory.h"
#include "session/reach.h"
#include "session/surface_fields.h"
#include "solve/equilibrium.h"
#include "solve/newton_correction.h"

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
// A suture's penalty stays between these multiples of E h; its multiplier closes the gap whatever it is.
constexpr double kLeastSuturePenalty = 50.0, kMostSuturePenalty = 500.0;
// A hook stiffer than this multiple of E h, of the stiffest material, is held by a multiplier too.
constexpr double kMostHookPenalty = 1000.0;
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
        suture_gaps_(3 * static_cast<std::size_t>(settings.sutures), std::numeric_limits<double>::quiet_NaN()),
        suture_multipliers_(3 * static_cast<std::size_t>(settings.sutures), 0.0),
        activation_(settings.materials.size(), 0.0) {
    if (!settings.bones.triangles.empty()) arena_.execute([&] { bones_ = distance_to_bones(settings); });
  }

  EpochReport set_epoch(const EpochInput& epoch) override {
    EpochReport report;
    arena_.execute([&] { report = install(epoch); });
    return report;
  }

  void set_state(const SolverState& state) override {
    if (!epoch_) throw RefusedError(ErrorCode::kOutOfOrder, "a state came before any epoch; send the epoch first");
    check_state(state, u_.size(), suture_gaps_.size(), settings_.materials.size(), std::is_same_v<Real, double>);
    u_.assign(state.nodes.begin(), state.nodes.end());
    suture_gaps_ = state.suture_gaps;
    suture_multipliers_ = state.suture_multipliers;
    held_multipliers_ = state.grip_multipliers;
    activation_ = state.activation;
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
  // What a solve changes; put back when it fails.
  struct Snapshot {
    std::vector<Real> u;
    std::vector<double> suture_gaps, suture_multipliers, held_multipliers, activation;
  };
  Snapshot snapshot() const { return {u_, suture_gaps_, suture_multipliers_, held_multipliers_, activation_}; }
  void restore(const Snapshot& s) {
    u_ = s.u;
    suture_gaps_ = s.suture_gaps;
    suture_multipliers_ = s.suture_multipliers;
    held_multipliers_ = s.held_multipliers;
    activation_ = s.activation;
  }

  EpochReport install(const EpochInput& epoch) {
    const auto start = std::chrono::steady_clock::now();
    check_epoch(epoch, settings_);
    // After an epoch that is refused the session has none: the solver of the one before makes room.
    epoch_.reset();
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
        positions[n] = lattice_->node_rest[n] + Vec3(double(u_[3 * n]), double(u_[3 * n + 1]), double(u_[3 * n + 2]));
      const auto carried = transfer_positions(*lattice_, positions, *lattice);
      for (std::size_t n = 0; n < carried.size(); ++n)
        for (int i = 0; i < 3; ++i)
          u[3 * n + static_cast<std::size_t>(i)] = static_cast<Real>(carried[n][i] - lattice->node_rest[n][i]);
      if (!held_multipliers_.empty()) {
        for (std::size_t n = 0; n < positions.size(); ++n)
          positions[n] = {held_multipliers_[3 * n], held_multipliers_[3 * n + 1], held_multipliers_[3 * n + 2]};
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
    lowest_ = highest_ = epoch.surface.points.front();
    for (const Vec3& point : epoch.surface.points) {
      lowest_ = lowest_.cwiseMin(point);
      highest_ = highest_.cwiseMax(point);
    }
    u_ = std::move(u);
    held_multipliers_ = std::move(held);
    landmarks_.clear();
    bites_.clear();
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
                                       u_.size() * sizeof(Real) + (bones_ ? bones_->bytes() : 0));
    release_freed_memory();
    report.seconds = seconds_since(start);
    return report;
  }

  void return_to_rest() {
    std::fill(u_.begin(), u_.end(), Real(0));
    std::fill(suture_multipliers_.begin(), suture_multipliers_.end(), 0.0);
    held_multipliers_.clear();
  }

  // The frame at a fraction of the way from where the constraints are now.
  FrameInput partway(const FrameInput& frame, double s) const {
    FrameInput result = frame;
    for (auto& hook : result.hooks) hook.target = (1 - s) * where(hook.anchor) + s * hook.target;
    for (auto& suture : result.sutures) {
      const double* gap = &suture_gaps_[3 * static_cast<std::size_t>(suture.index)];
      if (std::isnan(gap[0])) {
        suture.closure *= s;
        continue;
      }
      const Vec3 placed(gap[0], gap[1], gap[2]);
      const double now = (where(suture.a) - where(suture.b)).dot(placed) / std::max(placed.squaredNorm(), 1e-300);
      suture.closure = (1 - s) * std::clamp(1.0 - now, 0.0, 1.0) + s * suture.closure;
    }
    for (auto& retractor : result.retractors)
      retractor.motion = system_->motion_towards(retractor.motion, s, retractor.index, u_);
    result.activation = activation_of(frame);
    for (std::size_t m = 0; m < activation_.size(); ++m)
      result.activation[m] = (1 - s) * activation_[m] + s * result.activation[m];
    return result;
  }

  std::vector<double> activation_of(const FrameInput& frame) const {
    return frame.activation.empty() ? std::vector<double>(settings_.materials.size(), 0.0) : frame.activation;
  }

  // What is held at an anchor; found once an epoch.
  const Bite& embed(const Anchor& anchor) const {
    const std::array<double, 4> key{anchor.point[0], anchor.point[1], anchor.point[2], double(anchor.triangle)};
    auto found = bites_.find(key);
    if (found == bites_.end()) {
      const auto point = embed_on_triangle(*lattice_, epoch_->surface, anchor.point, anchor.triangle);
      const double reach = std::min(kBite, kBiteShare * (highest_ - lowest_).minCoeff());
      found = bites_.emplace(key, bite(*lattice_, point, reach)).first;
    }
    return found->second;
  }
  Vec3 where(const Anchor& anchor) const { return position<Real>(*lattice_, embed(anchor), u_); }

  // Remembers how far apart the ends of new sutures are.
  void place_sutures(const FrameInput& frame) {
    for (const auto& suture : frame.sutures) {
      double* gap = &suture_gaps_[3 * static_cast<std::size_t>(suture.index)];
      if (!std::isnan(gap[0])) continue;
      const Vec3 now = where(suture.a) - where(suture.b);
      for (int i = 0; i < 3; ++i) gap[i] = now[i];
    }
  }

  // Turns a frame into the system's constraints at the present state.
  void constrain(const FrameInput& frame) {
    std::vector<std::int32_t> active;
    std::vector<Eigen::Matrix4d> motions;
    for (const auto& retractor : frame.retractors) {
      active.push_back(retractor.index);
      motions.push_back(retractor.motion);
    }
    system_->set_retractors(active, motions);
    system_->set_activation(activation_of(frame));
    if (Contact* contact = system_->contact()) contact->reset_multipliers();
    auto& held = system_->held_multipliers();
    if (!held.empty()) {
      if (held_multipliers_.size() == held.size())
        held = held_multipliers_;
      else
        std::fill(held.begin(), held.end(), 0.0);
    }
    place_sutures(frame);
    std::vector<Tie> ties;
    for (const auto& hook : frame.hooks) {
      const Bite& held_by = embed(hook.anchor);
      ties.push_back(make_hook(*lattice_, held_by, hook.target, hook.stiffness, most_hook_penalty(held_by)));
    }
    const double unit = settings_.materials[0].youngs_modulus * settings_.spacing;
    for (const auto& suture : frame.sutures) {
      const Bite &a = embed(suture.a), &b = embed(suture.b);
      const double* gap = &suture_gaps_[3 * static_cast<std::size_t>(suture.index)];
      const double* multiplier = &suture_multipliers_[3 * static_cast<std::size_t>(suture.index)];
      ties.push_back(make_suture(*lattice_, a, b, (1.0 - suture.closure) * Vec3(gap[0], gap[1], gap[2]),
                                 std::clamp(suture.stiffness, kLeastSuturePenalty * unit, kMostSuturePenalty * unit),
                                 Vec3(multiplier[0], multiplier[1], multiplier[2])));
    }
    system_->set_ties(std::move(ties));
  }

  // No multiplier moves what is held in space: there the spring is plain.
  double most_hook_penalty(const Bite& anchor) const {
    double stiffest = 0.0;
    for (const auto& material : settings_.materials) stiffest = std::max(stiffest, material.youngs_modulus);
    const bool moves = std::ranges::any_of(
        anchor.nodes, [&](std::int32_t n) { return system_->is_free(static_cast<std::size_t>(n)); });
    return moves ? kMostHookPenalty * stiffest * settings_.spacing : std::numeric_limits<double>::infinity();
  }

  void keep_multipliers(const FrameInput& frame) {
    for (std::size_t k = 0; k < frame.sutures.size(); ++k)
      for (int i = 0; i < 3; ++i)
        suture_multipliers_[3 * static_cast<std::size_t>(frame.sutures[k].index) + static_cast<std::size_t>(i)] =
            system_->ties()[frame.hooks.size() + k].multiplier[i];
    held_multipliers_ = system_->held_multipliers();
    activation_ = activation_of(frame);
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
    options.inverts = std::ranges::all_of(
        settings_.materials, [](const auto& m) { return m.model == "corotated" || m.model == "stableNeoHookean"; });

    FrameOutput output;
    output.time = frame.time;
    const Snapshot before = snapshot();
    const Work done = system_->work();
    EquilibriumWatch watcher;
    watcher.stop = [&] { return cancel.load(std::memory_order_relaxed) || out_of_time(); };
    watcher.progress = [&](int newton, double residual, double gap) {
      if (progress) progress({frame.time, output.newton_iterations + newton, residual, gap});
    };
    EquilibriumOutcome outcome;
    // Goes to the frame in load steps; returns the one that failed, or their number.
    const auto attempt = [&](int steps, int budget) {
      preconditioner_->restart();
      std::vector<FrameInput> path;
      for (int step = 1; step < steps; ++step) path.push_back(partway(frame, static_cast<double>(step) / steps));
      path.push_back(frame);
      output.load_steps = steps;
      options.region_first = settings_.region == "auto" && !preconditioner_->is_smoother_only() && steps == 1;
      for (int step = 0; step < steps; ++step) {
        constrain(path[static_cast<std::size_t>(step)]);
        options.max_newton = std::min(settings_.max_newton, budget - output.newton_iterations);
        outcome = find_equilibrium<Real>(*system_, *preconditioner_, u_, options, watcher);
        output.newton_iterations += outcome.newton_iterations;
        output.pcg_iterations += outcome.pcg_iterations;
        output.active_cells = std::max(output.active_cells, outcome.active_cells);
        output.seconds_update += outcome.seconds_update;
        output.seconds_linear += outcome.seconds_linear;
        output.seconds_setup += outcome.seconds_setup;
        if (!outcome.converged) return step;
        keep_multipliers(path[static_cast<std::size_t>(step)]);
      }
      return steps;
    };
    const bool fit = fit_to_start<Real>(*lattice_, u_);
    const bool moved = std::any_of(u_.begin(), u_.end(), [](Real x) { return x != Real(0); });
    if (!fit) spdlog::info("frame {:g} starts from rest: too many cells of its start are inverted or flat", frame.time);
    Attempts attempts(fit && moved);
    int budget = kNewtonBudget * settings_.max_newton;
    // An equilibrium with inverted cells, until one from rest confirms it.
    std::optional<std::pair<EquilibriumOutcome, Snapshot>> doubtful;
    const auto start_over = [&] {
      spdlog::info("frame {:g} starts over from rest: {}", frame.time,
                   doubtful ? fmt::format("{} cells are inverted", doubtful->first.inverted) : outcome.reason);
      attempts.start_over();
      budget = output.newton_iterations + kNewtonBudget * settings_.max_newton / 2;
    };
    const std::string beyond = beyond_reach(frame, settings_.materials[0].youngs_modulus, lowest_, highest_,
                                            [&](const Anchor& anchor) { return where(anchor); });
    if (!beyond.empty()) {
      constrain(frame);
      outcome.reason = beyond;
    }
    while (beyond.empty() && attempts.next()) {
      const Attempt next = *attempts.next();
      restore(before);
      if (next.from_rest && moved) {
        if (fit) place_sutures(frame);
        return_to_rest();
      }
      const int reached = attempt(next.load_steps, budget);
      if (outcome.converged && outcome.inverted > 0 && !next.from_rest) {
        doubtful.emplace(outcome, snapshot());
        start_over();
      } else if (outcome.converged || watcher.stop()) {
        break;
      } else if (output.newton_iterations < budget) {
        attempts.failed(reached, outcome.residual);
        if (attempts.next() && attempts.next()->from_rest && !next.from_rest) start_over();
      } else if (next.from_rest) {
        break;
      } else {
        start_over();
      }
    }
    if (doubtful && outcome.converged &&
        doubtful->first.energy <= outcome.energy + kSameEnergy * std::abs(outcome.energy)) {
      outcome = doubtful->first;
      restore(doubtful->second);
      constrain(frame);
      system_->evaluate(u_);
    } else if (doubtful && !outcome.converged) {
      outcome.reason = fmt::format(
          "{} cells are inverted in the equilibrium found from the frame before, and none is found from rest "
          "to confirm it ({}); make smaller steps between frames or a smaller spacing",
          doubtful->first.inverted, outcome.reason);
    }
    if (!outcome.converged && watcher.stop()) {
      restore(before);
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
    write_fields(frame, output);
    if (kHasErrorEstimate && settings_.correction && outcome.converged) write_correction(output);
    if (!outcome.converged) restore(before);
    output.state.is_double = std::is_same_v<Real, double>;
    output.state.nodes.assign(u_.begin(), u_.end());
    output.state.suture_gaps = suture_gaps_;
    output.state.suture_multipliers = suture_multipliers_;
    output.state.grip_multipliers = held_multipliers_;
    output.state.activation = activation_;
    output.seconds_total = seconds_since(start);
    output.work = system_->work() - done;
    output.peak_bytes = peak_bytes();
    return output;
  }

  void write_fields(const FrameInput& frame, FrameOutput& output) const {
    const auto push = [](auto& array, const Vec3& v) {
      for (int i = 0; i < 3; ++i)
        array.push_back(static_cast<typename std::decay_t<decltype(array)>::value_type>(v[i]));
    };
    for (const auto& point : lattice_->surface_points) push(output.points, position<Real>(*lattice_, point, u_));
    if constexpr (kHasLandmarks)
      for (const auto& point : landmarks_) push(output.landmarks, position<Real>(*lattice_, point, u_));
    if (kHasStrain && settings_.strain) write_surface_fields<Real>(system_->elastic(), u_, output);
    for (std::size_t k = 0; k < frame.hooks.size(); ++k) {
      const Tie& tie = system_->ties()[k];
      push(output.hook_forces, -tie.force(tie.value<Real>(u_)));
      push(output.hook_points, where(frame.hooks[k].anchor));
    }
    for (std::size_t k = 0; k < frame.sutures.size(); ++k) {
      const Tie& tie = system_->ties()[frame.hooks.size() + k];
      const Vec3 c = tie.value<Real>(u_);
      output.suture_gaps.push_back(c.norm());
      output.suture_forces.push_back(tie.force(c).norm());
      push(output.suture_points, where(frame.sutures[k].a));
      push(output.suture_points, where(frame.sutures[k].b));
    }
  }

  void write_correction(FrameOutput& output) {
    std::vector<Real> step(u_.size());
    newton_correction<Real>(*system_, *preconditioner_, u_, step);
    const auto push = [&](auto& array, const EmbeddedPoint& point) {
      const Vec3 v = displacement<Real>(*lattice_, point, step);
      for (int i = 0; i < 3; ++i)
        array.push_back(static_cast<typename std::decay_t<decltype(array)>::value_type>(v[i]));
    };
    for (const auto& point : lattice_->surface_points) push(output.correction, point);
    for (const auto& point : landmarks_) push(output.landmark_correction, point);
  }

  SessionSettings settings_;
  tbb::task_arena arena_;
  std::shared_ptr<const SignedDistance> bones_;  // null: none
  std::optional<EpochInput> epoch_;
  std::unique_ptr<Lattice> lattice_;
  std::unique_ptr<System<Real>> system_;
  std::unique_ptr<TwoLevel<Real>> preconditioner_;
  std::vector<Real> u_;
  std::vector<EmbeddedPoint> landmarks_;
  mutable std::map<std::array<double, 4>, Bite> bites_;                                   // by rest point and triangle
  Vec3 lowest_ = Vec3::Zero(), highest_ = Vec3::Zero();                                   // of the surface at rest
  std::vector<double> suture_gaps_, suture_multipliers_, held_multipliers_, activation_;  // the last one per material
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
