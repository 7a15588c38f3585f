// Where the tissue goes while something is dragged. Its equilibria lie close to each other, and the ways from one to
// the next span few directions: three of the target, and how these turn as it goes on. Of all combinations of the last
// ways the one is taken that makes the quadratic model of the energy lowest, whichever way the target has gone.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "solve/system/system.h"

namespace lappet {

inline constexpr std::size_t kMaxMotions = 4;  // chosen: a fifth one spares no iteration

// motions: 3 per node, mm, the last first; motion: written, zero where nodes are prescribed. The system takes the exact
// tangent at `now`.
template <class Real>
void predict_motion(System<Real>& system, const Evaluation& now, std::span<const std::vector<float>> motions,
                    std::span<Real> motion);

}  // namespace lappet
