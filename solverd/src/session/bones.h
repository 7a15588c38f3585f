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

}  // namespace lappet
