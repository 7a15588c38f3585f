// Items sorted by a key, each group's items one after the other: cells around a node, nodes of a coarse cell.
#pragma once
#include <cstddef>
#include <numeric>
#include <ranges>
#include <span>
#include <vector>

#include "math/index.h"

namespace lappet {

struct Groups {
  std::vector<Index> start;  // where each group begins in `items`, and the end
  std::vector<Index> items;

  std::size_t count() const { return start.size() - 1; }
  // The items of a group, and their places in `items`.
  std::span<const Index> operator[](std::size_t group) const {
    return std::span(items).subspan(start[group], start[group + 1] - start[group]);
  }
  auto places(std::size_t group) const {
    return std::views::iota(std::size_t(start[group]), std::size_t(start[group + 1]));
  }
  std::size_t bytes() const { return sizeof(Index) * (start.size() + items.size()); }
};

// The items 0..keys.size()-1 by their keys, which lie in 0..groups-1; ascending in each group.
inline Groups group_by(std::span<const Index> keys, std::size_t groups) {
  Groups result;
  result.start.assign(groups + 1, 0);
  for (const Index key : keys) ++result.start[key + 1];
  std::partial_sum(result.start.begin(), result.start.end(), result.start.begin());
  result.items.resize(keys.size());
  std::vector<Index> next(result.start.begin(), result.start.end() - 1);
  for (std::size_t i = 0; i < keys.size(); ++i) result.items[next[keys[i]]++] = to_index(i);
  return result;
}

}  // namespace lappet
