// The one index type: nodes, cells, slots, triangles and what else is numbered take 32 bits, signed, so that -1 can
// stand for none. Containers take an Index as it is; `to_index` is the way back from a place in one.
#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>

namespace lappet {

using Index = std::int32_t;

// Of a place or a count: a lattice has fewer than 2^31 of anything that is numbered.
template <std::integral Place>
constexpr Index to_index(Place place) {
  return static_cast<Index>(place);
}

// Where the numbers of an item begin in an array that holds `stride` of them for each.
constexpr std::size_t offset_of(std::size_t stride, Index item) { return stride * static_cast<std::size_t>(item); }

}  // namespace lappet
