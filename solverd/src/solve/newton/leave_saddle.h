// The way off a saddle of the energy: along a mode of negative stiffness, to either side.
#pragma once
#include <optional>
#include <span>

#include "solve/system/system.h"

namespace lappet {

// Of an energy: a fall by less is none.
inline constexpr double kEnergyRounding = 1e-9;

// The displacement along `mode` (3 per node, its largest component 1) with the lowest energy found on either side of u:
// the amplitude in mm, signed; none where no step lowers the energy without turning cells over. Steps grow from a
// fraction of the spacing while the energy falls. Multipliers stay as they are. at: the evaluation at u; the system's
// last evaluation is another one afterwards.
template <class Real>
std::optional<double> way_off_saddle(System<Real>& system, std::span<const Real> u, std::span<const Real> mode,
                                     const Multipliers& multipliers, const EvaluationSummary& at, bool inverts);

}  // namespace lappet
