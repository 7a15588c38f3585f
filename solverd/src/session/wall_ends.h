// Where the ends of a suture meet when tissue presses on tissue: where the walls touch that it brings together.
//
// An anchor lies behind a wall of the wound, and its end is the point of the wall above it. At the corner of a wound it
// lies behind the edge where two walls meet, no wall is above it, and its end is the edge; in the middle of a flap's
// tip it is the edge of the tip. A point of one wall beside it would have the tip beyond the corner, where there is
// tissue.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "lattice/anchor_stencil.h"

namespace lappet {

struct WallEnd {
  Vec3 out;    // from the anchor to the wall or the edge, at rest, mm
  Vec3 ahead;  // by how much more where each wall is to be a millimeter further

  // From the anchor to where its walls' distance from those of the tissue that they touch is `apart`, half of it each.
  Vec3 beyond(double apart) const { return out + 0.5 * apart * ahead; }
};

// On the surface at rest. walls: per triangle, whether it is a wall of a wound; empty: none is. Of the walls around
// each anchor the nearest; where one has none, as in a mesh whose lips were never cut, of all faces those two that face
// each other, the nearest first. Nothing where the suture brings no two together.
std::optional<std::pair<WallEnd, WallEnd>> find_wall_ends(const AnchorStencils& stencils, const Surface& surface,
                                                          std::span<const std::uint8_t> walls, const Vec3& first,
                                                          const Vec3& second);

}  // namespace lappet
