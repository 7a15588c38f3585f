#include "session/frame_constraints.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lappet {

namespace {

// A suture's penalty stays between these multiples of E h; its multiplier closes the gap whatever it is.
constexpr double kMinSuturePenalty = 50.0, kMaxSuturePenalty = 500.0;
// A hook stiffer than this multiple of E h, of the stiffest material, is held by a multiplier too.
constexpr double kMaxHookPenalty = 1000.0;

}  // namespace

template <class Real>
FrameConstraints<Real>::FrameConstraints(const SessionSettings& settings, const Lattice& lattice,
                                         const Surface& surface, System<Real>& system)
    : settings_(settings),
      lattice_(lattice),
      surface_(surface),
      system_(system),
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
    const Vec3 placed(gap[0], gap[1], gap[2]);
    const double now =
        (where(suture.a, state.u) - where(suture.b, state.u)).dot(placed) / std::max(placed.squaredNorm(), 1e-300);
    suture.closure = (1 - s) * std::clamp(1.0 - now, 0.0, 1.0) + s * suture.closure;
  }
  for (auto& retractor : result.retractors)
    retractor.motion = system_.motion_towards(retractor.motion, s, retractor.index, state.u);
  result.activation = activation_of(frame);
  for (std::size_t m = 0; m < state.activation.size(); ++m)
    result.activation[m] = (1 - s) * state.activation[m] + s * result.activation[m];
  return result;
}

// What is held at an anchor; found once an epoch.
template <class Real>
const AnchorStencil& FrameConstraints<Real>::embed(const Anchor& anchor) const {
  const std::array<double, 4> key{anchor.point[0], anchor.point[1], anchor.point[2], double(anchor.triangle)};
  auto found = stencils_.find(key);
  if (found == stencils_.end()) {
    const double radius = std::min(kStencilRadius, kStencilShare * (highest_ - lowest_).minCoeff());
    if (!stencil_maker_) stencil_maker_.emplace(lattice_, surface_, radius);
    found = stencils_.emplace(key, stencil_maker_->around(anchor.point, anchor.triangle)).first;
  }
  return found->second;
}

template <class Real>
void FrameConstraints<Real>::place_sutures(const FrameInput& frame, TissueState<Real>& state) const {
  for (const auto& suture : frame.sutures) {
    double* gap = &state.suture_gaps[3 * static_cast<std::size_t>(suture.index)];
    if (!std::isnan(gap[0])) continue;
    const Vec3 now = where(suture.a, state.u) - where(suture.b, state.u);
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
  place_sutures(frame, state);
  system_.set_point_constraints(point_constraints(frame, state));
  system_.fit(state.multipliers);
  state.multipliers.of_contact_proxy.clear();
  std::erase_if(state.multipliers.of_constraint,
                [](const auto& entry) { return entry.first.kind == ConstraintId::Kind::kHook; });
}

template <class Real>
std::vector<PointConstraint> FrameConstraints<Real>::point_constraints(const FrameInput& frame,
                                                                       const TissueState<Real>& state) const {
  std::vector<PointConstraint> constraints;
  for (const auto& hook : frame.hooks) {
    const AnchorStencil& held_by = embed(hook.anchor);
    constraints.push_back(make_hook(lattice_, held_by, hook.target, hook.stiffness, max_hook_penalty(held_by)));
    constraints.back().id = id_of(hook);
  }
  const double unit = settings_.materials[0].youngs_modulus * settings_.spacing;
  for (const auto& suture : frame.sutures) {
    const AnchorStencil &a = embed(suture.a), &b = embed(suture.b);
    const double* gap = &state.suture_gaps[3 * static_cast<std::size_t>(suture.index)];
    constraints.push_back(
        make_suture(lattice_, a, b, (1.0 - suture.closure) * Vec3(gap[0], gap[1], gap[2]),
                    std::clamp(suture.stiffness, kMinSuturePenalty * unit, kMaxSuturePenalty * unit)));
    constraints.back().id = id_of(suture);
  }
  return constraints;
}

// No multiplier moves what is held in space: there the spring is plain.
template <class Real>
double FrameConstraints<Real>::max_hook_penalty(const AnchorStencil& anchor) const {
  double stiffest = 0.0;
  for (const auto& material : settings_.materials) stiffest = std::max(stiffest, material.youngs_modulus);
  const bool moves =
      std::ranges::any_of(anchor.nodes, [&](std::int32_t n) { return system_.is_free(static_cast<std::size_t>(n)); });
  return moves ? kMaxHookPenalty * stiffest * settings_.spacing : std::numeric_limits<double>::infinity();
}

template class FrameConstraints<float>;
template class FrameConstraints<double>;

}  // namespace lappet
