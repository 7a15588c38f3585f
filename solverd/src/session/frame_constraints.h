// Turns frames into the constraints of a system: what hooks and sutures hold, and frames on the way from a state to
// another.
#pragma once
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "lattice/anchor_stencil.h"
#include "session/bone_bodies.h"
#include "session/tissue_state.h"
#include "solve/system/system.h"

namespace lappet {

inline ConstraintId id_of(const HookState& hook) { return {ConstraintId::Kind::kHook, hook.index}; }
inline ConstraintId id_of(const SutureState& suture) { return {ConstraintId::Kind::kSuture, suture.index}; }

// The faces that loads act on, by their number in the messages.
using LoadedFacesByIndex = std::map<std::int32_t, std::shared_ptr<const LoadedFaces>>;

// Of one epoch. Keeps references to everything.
template <class Real>
class FrameConstraints {
 public:
  // walls: per triangle, whether it is a wall of a wound; empty: none is.
  FrameConstraints(const SessionSettings& settings, const Lattice& lattice, const Surface& surface,
                   const std::vector<std::uint8_t>& walls, const LoadedFacesByIndex& loaded, System<Real>& system);

  // Sets the system's constraints, places new sutures, and begins with the multipliers that a frame carries on from the
  // one before: those of sutures and held faces.
  void apply(const FrameInput& frame, TissueState<Real>& state);
  // Remembers how far apart the ends of new sutures are, or how long they are where they have more anchors.
  void place_sutures(const FrameInput& frame, TissueState<Real>& state) const;
  // Frames on the way from where the constraints are in a state to a frame, which is the last.
  std::vector<FrameInput> path(const FrameInput& frame, int steps, const TissueState<Real>& state) const;
  // Whether the way to a frame has places between: hooks, sutures, retractors, loads or muscles that move on.
  bool divides(const FrameInput& frame, const TissueState<Real>& state) const;
  // Of the muscles, per material.
  std::vector<double> activation_of(const FrameInput& frame) const {
    return frame.activation.empty() ? std::vector<double>(settings_.materials.size(), 0.0) : frame.activation;
  }

  Vec3 where(const Anchor& anchor, std::span<const Real> u) const { return position<Real>(lattice_, embed(anchor), u); }
  // How much of what two anchors of a suture that follow each other hold is the same, 0 to 1, pair by pair.
  std::vector<double> shared(const SutureState& suture) const;
  const BoneWay& bone_way() const { return bone_way_; }
  // Corners of the box around the surface at rest.
  const Vec3& lowest() const { return lowest_; }
  const Vec3& highest() const { return highest_; }

 private:
  FrameInput partway(const FrameInput& frame, double s, const TissueState<Real>& state) const;
  std::vector<FaceLoad> loads_of(const FrameInput& frame) const;
  std::vector<PointConstraint> point_constraints(const FrameInput& frame, const TissueState<Real>& state) const;
  const AnchorStencil& embed(const Anchor& anchor) const;
  PointConstraint suture_constraint(const SutureState& suture, const double* gap) const;
  // What a suture holds, end to end.
  std::vector<const AnchorStencil*> stencils_of(const SutureState& suture) const;
  // Of the two ends where tissue presses on tissue: each goes out to the middle between the walls that the suture
  // brings together, so that the ends meet where these touch. Null where it brings none together. Found once an epoch,
  // on the surface at rest.
  using Ends = std::pair<AnchorStencil, AnchorStencil>;
  const Ends* ends_between_walls(const SutureState& suture) const;
  std::optional<Ends> find_ends_between_walls(const SutureState& suture) const;
  Vec3 separation(const SutureState& suture, std::span<const Real> u) const;
  const AnchorStencils& stencil_maker() const;
  double max_penalty(std::span<const Index> held) const;

  const SessionSettings& settings_;
  const Lattice& lattice_;
  const Surface& surface_;
  const std::vector<std::uint8_t>& walls_;
  const LoadedFacesByIndex& loaded_;
  System<Real>& system_;
  BoneWay bone_way_;
  Vec3 lowest_, highest_;
  mutable std::optional<AnchorStencils> stencil_maker_;
  mutable std::map<std::array<double, 4>, AnchorStencil> stencils_;         // by rest point and triangle
  mutable std::map<std::int32_t, std::optional<Ends>> ends_between_walls_;  // by suture
};

extern template class FrameConstraints<float>;
extern template class FrameConstraints<double>;

}  // namespace lappet
