// Refusals: what a session does not accept, each as a sentence that names the value and the remedy. All throw
// RefusedError.
#pragma once
#include "lattice/surface_box.h"
#include "session/program.h"

namespace lappet {

void check_settings(const SessionSettings& settings);
void check_epoch(const EpochInput& epoch, const SessionSettings& settings);
// box: around the surface of the epoch.
void check_frame(const FrameInput& frame, const SessionSettings& settings, const Surface& surface, const Box3& box);
void check_state(const SolverState& state, std::size_t node_values, std::size_t suture_values, std::size_t materials,
                 bool is_double, std::int32_t bones = 0);

}  // namespace lappet
