#include "session/frame_constraints.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "session/wall_ends.h"

namespace lappet {

namespace {

// The penalty of a suture that closes exactly, in E h; its multiplier closes the gap whatever it is.
constexpr double kSuturePenalty = 50.0;
// A hook or a thread stiffer than this multiple of E h, of the stiffest material, is held by a multiplier too.
constexpr double kMaxPenalty = 1000.0;
// The ends of a suture that meet leave walls so much of the distance apart from which on they press on each other, and
// its slack is that distance: what closes a wound leaves its walls room to touch without a push. Chosen.
constexpr double kMeetingShare = 0.5;
// Spacings by which the ends of a suture may be held apart by walls that touch and do not fit: chosen.
constexpr double kHeldApart = 0.25;

// How far a thread was drawn if it were as long as its ends are apart now.
double closure_of(const SutureState& suture, double placed, double now) {
  const double way = placed - suture.length;
  return way != 0.0 ? (placed - now) / way : 1.0;
}

// A fraction of the way between the loads of two frames; what one of them lacks is zero there.
std::vector<LoadState> between(const std::vector<LoadState>& from, const std::vector<LoadState>& to, double s) {
  std::map<std::int32_t, LoadState> loads;
  const auto add = [&](const std::vector<LoadState>& some, double share) {
    for (const LoadState& load : some) {
      LoadState& sum = loads.try_emplace(load.index, LoadState{load.index, Vec3::Zero(), 0.0}).first->second;
      sum.traction += share * load.traction;
      sum.pressure += share * load.pressure;
    }
  };
  add(from, 1.0 - s);
  add(to, s);
  std::vector<LoadState> result;
  for (const auto& [index, load] : loads) result.push_back(load);
  return result;
}

}  // namespace

template <class Real>
FrameConstraints<Real>::FrameConstraints(const SessionSettings& settings, const Lattice& lattice,
                                         const Surface& surface, const std::vector<std::uint8_t>& walls,
                                         const LoadedFacesByIndex& loaded, System<Real>& system)
    : settings_(settings),
      lattice_(lattice),
      surface_(surface),
      walls_(walls),
      loaded_(loaded),
      system_(system),
      bone_way_(settings),
      lowest_(surface.points.front()),
      highest_(lowest_) {
  for (const Vec3& point : surface.points) {
    lowest_ = lowest_.cwiseMin(point);
    highest_ = highest_.cwiseMax(point);
  }
}

template <class Real>
std::vector<FrameInput> FrameConstraints<Real>::path(const FrameInput& frame, int steps,
                                                     const TissueState<Real>& state) const {
  std::vector<FrameInput> result;
  for (int step = 1; step < steps; ++step) result.push_back(partway(frame, static_cast<double>(step) / steps, state));
  result.push_back(frame);
  return result;
}

template <class Real>
bool FrameConstraints<Real>::divides(const FrameInput& frame, const TissueState<Real>& state) const {
  return digest(partway(frame, 0.5, state)) != digest(partway(frame, 1.0, state));
}

// The frame at a fraction of the way.
template <class Real>
FrameInput FrameConstraints<Real>::partway(const FrameInput& frame, double s, const TissueState<Real>& state) const {
  FrameInput result = frame;
  for (auto& hook : result.hooks) hook.target = (1 - s) * where(hook.anchor, state.u) + s * hook.target;
  for (auto& suture : result.sutures) {
    const double* gap = &state.suture_gaps[3 * static_cast<std::size_t>(suture.index)];
    if (std::isnan(gap[0])) {
      suture.closure *= s;
      continue;
    }
    const Vec3 placed(gap[0], gap[1], gap[2]), apart = separation(suture, state.u);
    const double now = suture.is_thread ? closure_of(suture, placed.norm(), apart.norm())
                                        : 1.0 - apart.dot(placed) / std::max(placed.squaredNorm(), 1e-300);
    suture.closure = (1 - s) * std::clamp(now, 0.0, 1.0) + s * suture.closure;
  }
  for (auto& retractor : result.retractors)
    retractor.motion = system_.motion_towards(retractor.motion, s, retractor.index, state.u);
  result.loads = between(state.loads, frame.loads, s);
  result.activation = activation_of(frame);
  for (std::size_t m = 0; m < state.activation.size(); ++m)
    result.activation[m] = (1 - s) * state.activation[m] + s * result.activation[m];
  result.bone_motions = bone_way_.at(state.bone_motions, frame.bone_motions, s);
  return result;
}

// What is held at an anchor; found once an epoch.
template <class Real>
const AnchorStencil& FrameConstraints<Real>::embed(const Anchor& anchor) const {
  const std::array<double, 4> key{anchor.point[0], anchor.point[1], anchor.point[2], double(anchor.triangle)};
  auto found = stencils_.find(key);
  if (found == stencils_.end())
    found = stencils_.emplace(key, stencil_maker().around(anchor.point, anchor.triangle)).first;
  return found->second;
}

template <class Real>
const AnchorStencils& FrameConstraints<Real>::stencil_maker() const {
  const double radius = std::min(kStencilRadius, kStencilShare * (highest_ - lowest_).minCoeff());
  if (!stencil_maker_) stencil_maker_.emplace(lattice_, surface_, radius);
  return *stencil_maker_;
}

template <class Real>
void FrameConstraints<Real>::place_sutures(const FrameInput& frame, TissueState<Real>& state) const {
  for (const auto& suture : frame.sutures) {
    double* gap = &state.suture_gaps[3 * static_cast<std::size_t>(suture.index)];
    if (!std::isnan(gap[0])) continue;
    const Vec3 now = separation(suture, state.u);
    for (int i = 0; i < 3; ++i) gap[i] = now[i];
  }
}

template <class Real>
void FrameConstraints<Real>::apply(const FrameInput& frame, TissueState<Real>& state) {
  std::vector<std::int32_t> active;
  std::vector<Eigen::Matrix4d> motions;
  for (const auto& retractor : frame.retractors) {
    active.push_back(retractor.index);
    motions.push_back(retractor.motion);
  }
  system_.set_retractors(active, motions);
  system_.set_activation(activation_of(frame));
  system_.place_bones(frame.bone_motions);
  place_sutures(frame, state);
  system_.set_point_constraints(point_constraints(frame, state));
  system_.set_loads(loads_of(frame), state.u);
  system_.fit(state.multipliers);
  state.multipliers.of_contact_proxy.clear();
  std::erase_if(state.multipliers.of_constraint,
                [](const auto& entry) { return entry.first.kind == ConstraintId::Kind::kHook; });
}

// An epoch may have lost the faces that the load of the frame before it was on.
template <class Real>
std::vector<FaceLoad> FrameConstraints<Real>::loads_of(const FrameInput& frame) const {
  std::vector<FaceLoad> loads;
  for (const LoadState& load : frame.loads)
    if (const auto faces = loaded_.find(load.index); faces != loaded_.end())
      loads.push_back({load.index, faces->second, load.traction, load.pressure});
  return loads;
}

template <class Real>
std::vector<PointConstraint> FrameConstraints<Real>::point_constraints(const FrameInput& frame,
                                                                       const TissueState<Real>& state) const {
  std::vector<PointConstraint> constraints;
  for (const auto& hook : frame.hooks) {
    const AnchorStencil& held_by = embed(hook.anchor);
    constraints.push_back(make_hook(lattice_, held_by, hook.target, hook.stiffness, max_penalty(held_by.nodes)));
    constraints.back().id = id_of(hook);
  }
  for (const auto& suture : frame.sutures) {
    constraints.push_back(suture_constraint(suture, &state.suture_gaps[3 * static_cast<std::size_t>(suture.index)]));
    constraints.back().id = id_of(suture);
  }
  return constraints;
}

// gap: how far apart its ends were when it was placed.
template <class Real>
PointConstraint FrameConstraints<Real>::suture_constraint(const SutureState& suture, const double* gap) const {
  const Vec3 placed(gap[0], gap[1], gap[2]);
  const std::vector<const AnchorStencil*> stencils = stencils_of(suture);
  if (!suture.is_thread) {
    const double penalty = kSuturePenalty * settings_.materials[0].youngs_modulus * settings_.spacing;
    PointConstraint closing =
        make_suture(lattice_, *stencils[0], *stencils[1], (1.0 - suture.closure) * placed, penalty);
    if (ends_between_walls(suture)) {
      closing.slack = system_.self_contact_or_suspended()->distance_of_walls();
      closing.walls_keep = std::max(closing.slack, kHeldApart * settings_.spacing);
      closing.drawn = suture.closure == 1.0;
    }
    return closing;
  }
  Thread thread;
  thread.length = (1.0 - suture.closure) * placed.norm() + suture.closure * suture.length;
  if (suture.tension > 0.0) thread.most = suture.tension;
  double max_stiffness = 0.0;
  for (const AnchorStencil* stencil : stencils) max_stiffness = std::max(max_stiffness, max_penalty(stencil->nodes));
  return make_thread(lattice_, stencils, thread, suture.stiffness, max_stiffness);
}

template <class Real>
std::vector<const AnchorStencil*> FrameConstraints<Real>::stencils_of(const SutureState& suture) const {
  if (const Ends* ends = ends_between_walls(suture)) return {&ends->first, &ends->second};
  std::vector<const AnchorStencil*> stencils{&embed(suture.a)};
  for (const Anchor& anchor : suture.inner) stencils.push_back(&embed(anchor));
  stencils.push_back(&embed(suture.b));
  return stencils;
}

template <class Real>
const typename FrameConstraints<Real>::Ends* FrameConstraints<Real>::ends_between_walls(
    const SutureState& suture) const {
  if (!system_.self_contact_or_suspended() || !suture.inner.empty()) return nullptr;
  auto known = ends_between_walls_.find(suture.index);
  if (known == ends_between_walls_.end())
    known = ends_between_walls_.emplace(suture.index, find_ends_between_walls(suture)).first;
  return known->second ? &*known->second : nullptr;
}

template <class Real>
std::optional<typename FrameConstraints<Real>::Ends> FrameConstraints<Real>::find_ends_between_walls(
    const SutureState& suture) const {
  const auto ends = find_wall_ends(stencil_maker(), surface_, walls_, suture.a.point, suture.b.point);
  if (!ends) return std::nullopt;
  // Walls that are close at rest, as at the end of a cut, press on each other from half of that on only.
  const double at_rest = (suture.a.point + ends->first.out - suture.b.point - ends->second.out).norm();
  const double apart = std::min(system_.self_contact_or_suspended()->distance_of_walls(), kShareOfRest * at_rest);
  const auto stencil = [&](const Anchor& anchor, const WallEnd& end) {
    return stencil_maker().around(anchor.point, anchor.triangle, end.beyond(kMeetingShare * apart));
  };
  return Ends(stencil(suture.a, ends->first), stencil(suture.b, ends->second));
}

// As SolverState keeps it.
template <class Real>
Vec3 FrameConstraints<Real>::separation(const SutureState& suture, std::span<const Real> u) const {
  const std::vector<const AnchorStencil*> stencils = stencils_of(suture);
  if (suture.inner.empty())
    return position<Real>(lattice_, *stencils[0], u) - position<Real>(lattice_, *stencils[1], u);
  double length = 0.0;
  for (std::size_t k = 0; k + 1 < stencils.size(); ++k)
    length += (position<Real>(lattice_, *stencils[k], u) - position<Real>(lattice_, *stencils[k + 1], u)).norm();
  return {length, 0.0, 0.0};
}

template <class Real>
std::vector<double> FrameConstraints<Real>::shared(const SutureState& suture) const {
  std::vector<double> found;
  const std::vector<const AnchorStencil*> stencils = stencils_of(suture);
  for (std::size_t k = 0; k + 1 < stencils.size(); ++k) found.push_back(shared_hold(*stencils[k], *stencils[k + 1]));
  return found;
}

// No multiplier moves what is held in space: there the spring is plain.
template <class Real>
double FrameConstraints<Real>::max_penalty(std::span<const Index> held) const {
  double stiffest = 0.0;
  for (const auto& material : settings_.materials) stiffest = std::max(stiffest, material.youngs_modulus);
  const bool moves =
      std::ranges::any_of(held, [&](std::int32_t n) { return system_.is_free(static_cast<std::size_t>(n)); });
  return moves ? kMaxPenalty * stiffest * settings_.spacing : std::numeric_limits<double>::infinity();
}

template class FrameConstraints<float>;
template class FrameConstraints<double>;

}  // namespace lappet
