// A hierarchy of boxes around triangles: built once by their places at rest, refitted to wherever they are. It finds
// the pairs of triangles that come near each other on straight ways, at the same time: what goes away from another, or
// along with it, is passed over.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/surface.h"
#include "math/parallel.h"

namespace lappet {

// Where triangles are, and the ways that they go.
struct MovingBox {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();            // of the places
  Vec3 least_way = Vec3::Zero(), most_way = Vec3::Zero();  // of the ways

  void grow(const MovingBox& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
    least_way = least_way.cwiseMin(other.least_way);
    most_way = most_way.cwiseMax(other.most_way);
  }
  // Whether something in the one may come nearer than `distance` to something in the other: along no axis are they
  // farther apart than that both where they are and where they go.
  bool may_meet(const MovingBox& other, double distance) const {
    for (int i = 0; i < 3; ++i) {
      const double above = low[i] - other.high[i], below = other.low[i] - high[i];
      if (above > distance && above + least_way[i] - other.most_way[i] > distance) return false;
      if (below > distance && below + other.least_way[i] - most_way[i] > distance) return false;
    }
    return true;
  }
};

class BoxTree {
 public:
  BoxTree() = default;
  // places: of the vertices.
  BoxTree(std::span<const Vec3> places, std::vector<std::array<Index, 3>> triangles);

  // ways: of the vertices; empty: they stay. marked: vertices, of which pairs are looked for; empty: all of them.
  void refit(std::span<const Vec3> places, std::span<const Vec3> ways, std::span<const std::uint8_t> marked = {});

  // Calls body(chunk, triangle, other) for every pair of different triangles, one of them with a marked vertex, that
  // may come nearer than `distance`, each once; chunks run at the same time. What belongs to a chunk, and its order, is
  // always the same.
  template <class Body>
  void for_each_pair(double distance, const Body& body) const {
    for_each_chunk(
        leaves_.size(),
        [&](std::size_t chunk, std::size_t begin, std::size_t end) {
          for (std::size_t leaf = begin; leaf < end; ++leaf)
            visit_pairs(to_index(leaf), distance, [&](Index triangle, Index other) { body(chunk, triangle, other); });
        },
        kLeavesPerChunk);
  }
  std::size_t chunks() const { return (leaves_.size() + kLeavesPerChunk - 1) / kLeavesPerChunk; }
  std::size_t bytes() const;

 private:
  static constexpr Index kLeafSize = 4;
  static constexpr std::size_t kLeavesPerChunk = 64;

  // The triangles order_[first] to order_[last - 1]. A node is followed by the half that comes first; `next` is the
  // other one, -1 in a leaf.
  struct Node {
    MovingBox box;
    Index first = 0, last = 0, next = -1;
    bool marked = true;  // one of them is
  };

  Index build(Index first, Index last, std::span<const Vec3> centers);
  // Calls body(leaf) for the leaves that may come near another one and whose triangles come there or later.
  template <class Body>
  void visit(const Node& own, double distance, const Body& body) const {
    std::array<Index, 64> stack;
    std::size_t height = 0;
    stack[height++] = 0;
    while (height > 0) {
      const Index at = stack[--height];
      const Node& node = nodes_[at];
      if (node.last <= own.first || !(own.marked || node.marked) || !node.box.may_meet(own.box, distance)) continue;
      if (node.next < 0) {
        body(node);
      } else {
        stack[height++] = node.next;
        stack[height++] = at + 1;
      }
    }
  }
  template <class Body>
  void visit_pairs(Index leaf, double distance, const Body& body) const {
    const Node& own = nodes_[leaves_[leaf]];
    visit(own, distance, [&](const Node& other) {
      for (Index i = own.first; i < own.last; ++i)
        for (Index k = std::max(other.first, i + 1); k < other.last; ++k)
          if ((marked_[i] || marked_[k]) && boxes_[i].may_meet(boxes_[k], distance)) body(order_[i], order_[k]);
    });
  }

  std::vector<std::array<Index, 3>> triangles_;
  std::vector<Index> order_;      // the triangles, neighbors near each other
  std::vector<MovingBox> boxes_;  // of each, in that order
  std::vector<std::uint8_t> marked_;
  std::vector<Node> nodes_;
  std::vector<Index> leaves_;  // their nodes
};

}  // namespace lappet
