// The bodies of bones that move, each for itself, and the way that they go from one frame to the next.
#pragma once
#include <span>
#include <vector>

#include "lattice/surface_box.h"
#include "session/program.h"

namespace lappet {

// The bodies that the bones of a session are of: those that move alone, and what stays. One for bones that all stay.
std::vector<Surface> bone_bodies(const SessionSettings& settings);

class BoneWay {
 public:
  // Of an epoch: finds the boxes around bones that move; none where all stay.
  explicit BoneWay(const SessionSettings& settings);

  // Load steps for it: in each no corner of the box around a bone moves farther than tissue may lie in it. from, to:
  // motions of all bodies; none: they are at rest.
  int steps(std::span<const Eigen::Matrix4d> from, std::span<const Eigen::Matrix4d> to) const;
  // A fraction of the way between the motions of the bodies; none where all are at rest.
  std::vector<Eigen::Matrix4d> at(std::span<const Eigen::Matrix4d> from, std::span<const Eigen::Matrix4d> to,
                                  double fraction) const;

 private:
  double spacing_;
  std::vector<Box3> boxes_;
};

}  // namespace lappet
