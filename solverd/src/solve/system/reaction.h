// The force of what holds the tissue from outside or loads it, as a whole: in equilibrium these, the hooks and the
// weight are in balance. Tissue that is fixed all through is not computed: it passes no force from one part to another.
#pragma once
#include <compare>
#include <cstdint>

#include "lattice/surface.h"

namespace lappet {

// What holds, or loads. kWeakBed: of fragments that no face holds (solve/system/system.h). kLoad: tractions and
// pressure.
struct Holder {
  enum class Kind : std::uint8_t { kFixed, kRetractor, kBed, kBone, kWeakBed, kRoller, kLoad };
  Kind kind = Kind::kFixed;
  std::int32_t index = 0;  // of the part of the fixed faces, the retractor, the roller, the loaded faces; else 0
  auto operator<=>(const Holder&) const = default;
};

struct Reaction {
  Holder holder;
  Vec3 force = Vec3::Zero();  // on the tissue, mN
};

}  // namespace lappet
