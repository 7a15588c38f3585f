#include "session/frame_fields.h"

#include "math/features.h"
#include "session/surface_fields.h"

namespace lappet {

namespace {

template <class Number>
void append(std::vector<Number>& array, const Vec3& v) {
  for (int i = 0; i < 3; ++i) array.push_back(static_cast<Number>(v[i]));
}

template <class Real>
void write_constraints(const EpochSystem<Real>& epoch, const FrameInput& frame, const TissueState<Real>& state,
                       FrameFields& fields) {
  for (const HookState& hook : frame.hooks) {
    const PointConstraint& constraint = epoch.system.point_constraint(id_of(hook));
    const std::vector<Vec3> c = constraint.values<Real>(state.u);
    fields.hook_indices.push_back(hook.index);
    append(fields.hook_forces, -constraint.forces(c, state.multipliers.of(constraint)).front());
    append(fields.hook_points, epoch.constraints.where(hook.anchor, state.u));
  }
  for (const SutureState& suture : frame.sutures) {
    const PointConstraint& constraint = epoch.system.point_constraint(id_of(suture));
    const std::vector<Vec3> c = constraint.values<Real>(state.u);
    fields.suture_indices.push_back(suture.index);
    const Vec3 multiplier = state.multipliers.of(constraint);
    fields.suture_gaps.push_back(constraint.thread && !constraint.exact ? 0.0 : constraint.gap(c, multiplier));
    const Vec3 force = constraint.forces(c, multiplier).front();
    fields.suture_forces.push_back(constraint.slides() ? constraint.tension(c, multiplier) : force.norm());
    append(fields.suture_force_vectors, -force);
    for (const double shared : epoch.constraints.shared(suture)) fields.suture_shared.push_back(shared);
    append(fields.suture_points, epoch.constraints.where(suture.a, state.u));
    append(fields.suture_points, epoch.constraints.where(suture.b, state.u));
    for (const Anchor& anchor : suture.inner)
      append(fields.inner_bite_points, epoch.constraints.where(anchor, state.u));
  }
}

template <class Real>
void write_reactions(const EpochSystem<Real>& epoch, const FoundFrame<Real>& found, FrameFields& fields) {
  const TissueState<Real>& state = found.state;
  for (const auto& [holder, force] : epoch.system.reactions(state.u, state.multipliers, found.outcome.at)) {
    fields.holders.insert(fields.holders.end(), {static_cast<std::int32_t>(holder.kind), holder.index});
    append(fields.reactions, force);
  }
}

// A frame that did not converge has none, nor one that is the same as the last, whose fields are taken instead.
template <class Real>
void write_correction(const EpochSystem<Real>& epoch, const FoundFrame<Real>& found, FrameFields& fields) {
  const std::span<const float> step = found.outcome.step;
  for (const auto& point : epoch.lattice.surface_points)
    append(fields.correction, displacement<float>(epoch.lattice, point, step));
  for (const auto& point : epoch.landmarks)
    append(fields.landmark_correction, displacement<float>(epoch.lattice, point, step));
}

}  // namespace

template <class Real>
FrameFields frame_fields(const SessionSettings& settings, EpochSystem<Real>& epoch, const FrameInput& frame,
                         const FoundFrame<Real>& found) {
  FrameFields fields;
  for (const auto& point : epoch.lattice.surface_points)
    append(fields.points, position<Real>(epoch.lattice, point, found.state.u));
  if constexpr (kHasLandmarks)
    for (const auto& point : epoch.landmarks)
      append(fields.landmarks, position<Real>(epoch.lattice, point, found.state.u));
  if (kHasStrain && settings.strain)
    write_surface_fields<Real>(epoch.system.elastic_at(found.outcome.at), found.state.u, fields);
  write_constraints(epoch, frame, found.state, fields);
  write_reactions(epoch, found, fields);
  for (const Vec3& force : epoch.system.section_forces(epoch.sections, found.state.u))
    append(fields.section_forces, force);
  const FrameStability& stability = found.state.stability;
  if (found.outcome.converged) fields.lowest_stiffness = stability.lowest_stiffness;
  if (found.outcome.converged && stability.softest_point) append(fields.softest_point, *stability.softest_point);
  if (!found.outcome.step.empty() && found.outcome.converged) write_correction(epoch, found, fields);
  return fields;
}

template FrameFields frame_fields(const SessionSettings&, EpochSystem<float>&, const FrameInput&,
                                  const FoundFrame<float>&);
template FrameFields frame_fields(const SessionSettings&, EpochSystem<double>&, const FrameInput&,
                                  const FoundFrame<double>&);

}  // namespace lappet
