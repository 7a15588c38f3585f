// Turns frames into the constraints of a system: what hooks and sutures hold, in what state their multipliers are, and
// frames on the way from the present state to another.
#pragma once
#include <array>
#include <map>
#include <vector>

#include "lattice/anchor_stencil.h"
#include "session/program.h"
#include "solve/system/system.h"

namespace lappet {

// What a solve changes, and all that the next one starts from.
template <class Real>
struct TissueState {
  std::vector<Real> u;              // displacements, 3 per node, mm
  std::vector<double> suture_gaps;  // the others: as in SolverState
  std::vector<double> suture_multipliers, held_multipliers, activation;
};

// Of one epoch. Keeps references to everything.
template <class Real>
class FrameConstraints {
 public:
  FrameConstraints(const SessionSettings& settings, const Lattice& lattice, const Surface& surface,
                   System<Real>& system, TissueState<Real>& state);

  // Sets the system's constraints at the present state.
  void apply(const FrameInput& frame);
  // Remembers how far apart the ends of new sutures are.
  void place_sutures(const FrameInput& frame);
  // Takes the system's multipliers into the state, once a frame was solved.
  void keep_multipliers(const FrameInput& frame);
  // The frame at a fraction of the way from where the constraints are now.
  FrameInput partway(const FrameInput& frame, double s) const;

  Vec3 where(const Anchor& anchor) const { return position<Real>(lattice_, embed(anchor), state_.u); }
  // Corners of the box around the surface at rest.
  const Vec3& lowest() const { return lowest_; }
  const Vec3& highest() const { return highest_; }

 private:
  const AnchorStencil& embed(const Anchor& anchor) const;
  double max_hook_penalty(const AnchorStencil& anchor) const;
  std::vector<double> activation_of(const FrameInput& frame) const {
    return frame.activation.empty() ? std::vector<double>(settings_.materials.size(), 0.0) : frame.activation;
  }

  const SessionSettings& settings_;
  const Lattice& lattice_;
  const Surface& surface_;
  System<Real>& system_;
  TissueState<Real>& state_;
  Vec3 lowest_, highest_;
  mutable std::map<std::array<double, 4>, AnchorStencil> stencils_;  // by rest point and triangle
};

extern template class FrameConstraints<float>;
extern template class FrameConstraints<double>;

}  // namespace lappet
