// What a solve changes, and all that the next one starts from.
#pragma once
#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "session/program.h"
#include "solve/system/multipliers.h"

namespace lappet {

// How stable the equilibrium of a frame is: what a frame that asks for the same, and finds it there, repeats.
struct FrameStability {
  double constraints = 0.0;  // digest of what the frame asked for; 0: nothing is known
  double lowest_stiffness = std::numeric_limits<double>::quiet_NaN();  // as in FrameFields
  std::optional<Vec3> softest_point;

  bool is_of(double digest) const { return constraints != 0.0 && constraints == digest; }
};

// Of all that a frame asks for but its time: a whole number from 1 to 2^52.
double digest(const FrameInput& frame);

template <class Real>
struct TissueState {
  std::vector<Real> u;              // displacements, 3 per node, mm
  std::vector<double> suture_gaps;  // as in SolverState
  Multipliers multipliers;
  std::vector<double> activation;             // of the muscles, per material
  std::vector<LoadState> loads;               // of the last frame
  std::vector<Eigen::Matrix4d> bone_motions;  // likewise
  FrameStability stability;
  std::vector<float> motion;  // as in SolverState

  void return_to_rest() {
    std::ranges::fill(u, Real(0));
    multipliers = {};
    stability = {};
    motion.clear();
    bone_motions.clear();
  }
};

// Of a session without an epoch.
template <class Real>
TissueState<Real> initial_state(const SessionSettings& settings);

// The state of an epoch, carried by rest position from the lattice before it (null: there is none, it is at rest).
template <class Real>
TissueState<Real> carry_over(const TissueState<Real>& state, const Lattice* from, const Lattice& to,
                             const Interrupt& interrupt);

template <class Real>
SolverState exported(const TissueState<Real>& state);
template <class Real>
TissueState<Real> imported(const SolverState& state);

}  // namespace lappet
