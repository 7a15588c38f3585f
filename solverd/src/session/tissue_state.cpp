#include "session/tissue_state.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace lappet {

namespace {

// Three numbers per node of one lattice, as those of another.
template <class Real>
std::vector<Vec3> rows(const std::vector<Real>& values) {
  std::vector<Vec3> result(values.size() / 3);
  for (std::size_t n = 0; n < result.size(); ++n)
    result[n] = {double(values[3 * n]), double(values[3 * n + 1]), double(values[3 * n + 2])};
  return result;
}

// FNV-1a over the bytes of numbers, in the order in which they are given.
class Digest {
 public:
  void add(double number) {
    for (const auto bits = std::bit_cast<std::uint64_t>(number); const int shift : {0, 8, 16, 24, 32, 40, 48, 56})
      hash_ = (hash_ ^ ((bits >> shift) & 0xffU)) * 1099511628211U;
  }
  void add(const Vec3& v) {
    for (int i = 0; i < 3; ++i) add(v[i]);
  }
  void add(const Anchor& anchor) {
    add(anchor.point);
    add(static_cast<double>(anchor.triangle));
  }
  double value() const { return static_cast<double>((hash_ >> 12) + 1); }

 private:
  std::uint64_t hash_ = 14695981039346656037U;
};

}  // namespace

double digest(const FrameInput& frame) {
  Digest digest;
  for (const HookState& hook : frame.hooks) {
    digest.add(static_cast<double>(hook.index));
    digest.add(hook.anchor);
    digest.add(hook.target);
    digest.add(hook.stiffness);
  }
  for (const SutureState& suture : frame.sutures) {
    digest.add(static_cast<double>(suture.index) + 0.5);
    digest.add(suture.a);
    digest.add(suture.b);
    digest.add(suture.closure);
    digest.add(suture.stiffness);
    digest.add(suture.is_thread ? 1.0 : 0.0);
    digest.add(suture.length);
    digest.add(suture.tension);
    for (const Anchor& anchor : suture.inner) digest.add(anchor);
  }
  for (const RetractorState& retractor : frame.retractors) {
    digest.add(static_cast<double>(retractor.index) + 0.25);
    for (const double entry : retractor.motion.reshaped()) digest.add(entry);
  }
  for (const LoadState& load : frame.loads) {
    digest.add(static_cast<double>(load.index) + 0.75);
    digest.add(load.traction);
    digest.add(load.pressure);
  }
  for (const double activation : frame.activation) digest.add(activation);
  for (const Eigen::Matrix4d& motion : frame.bone_motions)
    for (const double entry : motion.reshaped()) digest.add(entry);
  return digest.value();
}

template <class Real>
TissueState<Real> initial_state(const SessionSettings& settings) {
  TissueState<Real> state;
  state.suture_gaps.assign(3 * static_cast<std::size_t>(settings.sutures), std::numeric_limits<double>::quiet_NaN());
  state.activation.assign(settings.materials.size(), 0.0);
  return state;
}

template <class Real>
TissueState<Real> carry_over(const TissueState<Real>& state, const Lattice* from, const Lattice& to,
                             const Interrupt& interrupt) {
  TissueState<Real> carried;
  carried.suture_gaps = state.suture_gaps;
  carried.multipliers.of_constraint = state.multipliers.of_constraint;
  carried.activation = state.activation;
  carried.loads = state.loads;
  carried.bone_motions = state.bone_motions;
  carried.u.assign(3 * to.node_rest.size(), Real(0));
  if (!from) return carried;
  std::vector<Vec3> positions = rows(state.u);
  for (std::size_t n = 0; n < positions.size(); ++n) positions[n] = from->node_rest[n] + positions[n];
  const auto moved = transfer_positions(*from, positions, to, interrupt);
  for (std::size_t n = 0; n < moved.size(); ++n)
    for (int i = 0; i < 3; ++i)
      carried.u[3 * n + static_cast<std::size_t>(i)] = static_cast<Real>(moved[n][i] - to.node_rest[n][i]);
  if (!state.multipliers.of_held_node.empty())
    for (const Vec3& y : transfer_positions(*from, rows(state.multipliers.of_held_node), to, interrupt))
      carried.multipliers.of_held_node.insert(carried.multipliers.of_held_node.end(), {y[0], y[1], y[2]});
  return carried;
}

template <class Real>
SolverState exported(const TissueState<Real>& state) {
  SolverState result;
  result.is_double = std::is_same_v<Real, double>;
  result.nodes.assign(state.u.begin(), state.u.end());
  result.suture_gaps = state.suture_gaps;
  result.suture_multipliers.assign(state.suture_gaps.size(), 0.0);
  for (const auto& [id, multiplier] : state.multipliers.of_constraint)
    if (id.kind == ConstraintId::Kind::kSuture)
      for (int i = 0; i < 3; ++i) result.suture_multipliers[static_cast<std::size_t>(3 * id.index + i)] = multiplier[i];
  result.grip_multipliers = state.multipliers.of_held_node;
  result.roller_multipliers = state.multipliers.of_roller_row;
  for (const LoadState& load : state.loads) {
    const Vec3& t = load.traction;
    result.loads.insert(result.loads.end(), {static_cast<double>(load.index), t[0], t[1], t[2], load.pressure});
  }
  result.activation = state.activation;
  for (const Eigen::Matrix4d& motion : state.bone_motions)
    for (const double entry : motion.reshaped<Eigen::RowMajor>()) result.bone_motions.push_back(entry);
  result.motion = state.motion;
  const FrameStability& stability = state.stability;
  if (stability.constraints != 0.0 && std::isfinite(stability.lowest_stiffness)) {
    result.stability = {stability.constraints, stability.lowest_stiffness};
    if (const auto& point = stability.softest_point)
      result.stability.insert(result.stability.end(), point->begin(), point->end());
  }
  return result;
}

template <class Real>
TissueState<Real> imported(const SolverState& state) {
  TissueState<Real> result;
  result.u.assign(state.nodes.begin(), state.nodes.end());
  result.suture_gaps = state.suture_gaps;
  const auto multipliers = rows(state.suture_multipliers);
  for (std::size_t k = 0; k < multipliers.size(); ++k)
    result.multipliers.of_constraint[{ConstraintId::Kind::kSuture, static_cast<std::int32_t>(k)}] = multipliers[k];
  result.multipliers.of_held_node = state.grip_multipliers;
  result.multipliers.of_roller_row = state.roller_multipliers;
  for (std::size_t k = 0; k + 4 < state.loads.size(); k += 5)
    result.loads.push_back(
        {static_cast<std::int32_t>(state.loads[k]), Vec3::Map(&state.loads[k + 1]), state.loads[k + 4]});
  result.activation = state.activation;
  for (std::size_t k = 0; k + 15 < state.bone_motions.size(); k += 16)
    result.bone_motions.emplace_back(
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(&state.bone_motions[k]));
  result.motion = state.motion;
  if (state.stability.size() >= 2) {
    result.stability.constraints = state.stability[0];
    result.stability.lowest_stiffness = state.stability[1];
    if (state.stability.size() >= 5) result.stability.softest_point = Vec3::Map(&state.stability[2]);
  }
  return result;
}

template TissueState<float> initial_state<float>(const SessionSettings&);
template TissueState<double> initial_state<double>(const SessionSettings&);
template TissueState<float> carry_over<float>(const TissueState<float>&, const Lattice*, const Lattice&,
                                              const Interrupt&);
template TissueState<double> carry_over<double>(const TissueState<double>&, const Lattice*, const Lattice&,
                                                const Interrupt&);
template SolverState exported<float>(const TissueState<float>&);
template SolverState exported<double>(const TissueState<double>&);
template TissueState<float> imported<float>(const SolverState&);
template TissueState<double> imported<double>(const SolverState&);

}  // namespace lappet
