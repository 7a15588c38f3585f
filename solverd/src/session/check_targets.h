// Whether a frame asks for what no tissue bears: known before anything is solved.
#pragma once
#include <functional>
#include <string>

#include "session/program.h"

namespace lappet {

// A sentence naming the hook or retractor, or nothing. lowest, highest: the corners of the tissue's bounding box at
// rest, mm; `place` gives where an anchor is now.
std::string check_targets_reachable(const FrameInput& frame, double youngs_modulus, const Vec3& lowest,
                                    const Vec3& highest, const std::function<Vec3(const Anchor&)>& place);

}  // namespace lappet
