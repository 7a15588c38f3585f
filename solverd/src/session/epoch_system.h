// All that an epoch is solved with. It is made beside the epoch before it and takes its place whole, or not at all.
#pragma once
#include <memory>
#include <vector>

#include "lattice/surface_box.h"
#include "session/frame_constraints.h"
#include "solve/multigrid/two_level.h"

namespace lappet {

class Ground;
class SignedDistance;

template <class Real>
struct EpochSystem {
  // bones, ground: null without any. Refuses what bones and budgets do not allow.
  EpochSystem(const EpochInput& epoch, const SessionSettings& settings, const std::optional<BoneDistance>& bones,
              std::shared_ptr<const Ground> ground, const Interrupt& interrupt);
  EpochSystem(const EpochSystem&) = delete;
  EpochSystem& operator=(const EpochSystem&) = delete;

  // Its numbers; `bytes` counts what is held here.
  EpochReport report(bool with_nodes) const;

  Surface surface;
  std::vector<std::uint8_t> walls;  // of wounds, per triangle; empty: none
  Box3 box;                         // around it
  Lattice lattice;
  LoadedFacesByIndex loaded;
  std::vector<Section> sections;
  System<Real> system;
  TwoLevel<Real> preconditioner;
  FrameConstraints<Real> constraints;
  std::vector<EmbeddedPoint> landmarks;
  std::vector<std::vector<float>> motions;  // of the last frames of a drag, the last first (predict_motion.h)
};

extern template struct EpochSystem<float>;
extern template struct EpochSystem<double>;

}  // namespace lappet
