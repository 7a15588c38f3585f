// Disjoint sets of the indices 0..count-1 (union-find). The root of a set is its smallest element, so that no result
// depends on the order in which sets were united.
#pragma once
#include <algorithm>
#include <numeric>
#include <vector>

#include "math/index.h"

namespace lappet {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

  Index find(Index a) {
    while (parent_[a] != a) a = parent_[a] = parent_[parent_[a]];
    return a;
  }
  void unite(Index a, Index b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<Index> parent_;
};

}  // namespace lappet
