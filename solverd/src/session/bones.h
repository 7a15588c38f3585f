// The bones of a session: their distance field, and the tissue of an epoch against it.
#pragma once
#include <memory>
#include <optional>

#include "force/constraints/contact.h"
#include "session/program.h"

namespace lappet {

// None without bones.
std::optional<BoneDistance> distance_to_bones(const SessionSettings& settings, const Interrupt& interrupt);

// Throws RefusedError where tissue lies deeper in bone at rest than half the spacing; what is less deep is pushed out.
std::unique_ptr<Contact> contact_with_bones(const BoneDistance& bones, const Lattice& lattice, const EpochInput& epoch,
                                            const SessionSettings& settings, const Interrupt& interrupt);

// The bodies that the bones of a session are of: those that move alone, and what stays. One for bones that all stay.
std::vector<Surface> bone_bodies(const SessionSettings& settings);

// Load steps for bones that move: in each of them no corner of the box around a bone moves farther than tissue may
// lie in it. from: motions of all bodies, as those in `to`; none: they are at rest.
int steps_of_bones(const SessionSettings& settings, std::span<const Eigen::Matrix4d> from,
                   std::span<const Eigen::Matrix4d> to);

// A fraction of the way between the motions of the bodies.
std::vector<Eigen::Matrix4d> bones_partway(const SessionSettings& settings, std::span<const Eigen::Matrix4d> from,
                                           std::span<const Eigen::Matrix4d> to, double fraction);

}  // namespace lappet
