// A hierarchy of boxes around triangles: built once by their places at rest, refitted to wherever they are. It finds
// the pairs of triangles that come near each other on straight ways, at the same time: what goes away from another, or
// along with it, is passed over.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/surface.h"
#include "math/parallel.h"

namespace lappet {

// Where triangles are, and the ways that they go: in single precision, rounded outwards. The fourth numbers are zero.
struct MovingBox {
  using Corner = Eigen::Array4f;
  Corner low = Corner::Zero(), high = Corner::Zero();            // of the places
  Corner least_way = Corner::Zero(), most_way = Corner::Zero();  // of the ways

  void grow(const MovingBox& other) {
    low = low.min(other.low);
    high = high.max(other.high);
    least_way = least_way.min(other.least_way);
    most_way = most_way.max(other.most_way);
  }
  // Whether something in the one may come nearer than `distance` to something in the other: along no axis are they
  // farther apart than that both where they are and where they go.
  bool may_meet(const MovingBox& other, float distance) const {
    const Corner above = low - other.high, below = other.low - high;
    const Corner least_above = above.min(above + least_way - other.most_way);
    const Corner least_below = below.min(below + other.least_way - most_way);
    return !(least_above.max(least_below).maxCoeff() > distance);
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
    const float apart = static_cast<float>(distance) + kRounding;
    for_each_chunk(
        parts_.size(),
        [&](std::size_t chunk, std::size_t, std::size_t) {
          visit(parts_[chunk], apart, [&](Index triangle, Index other) { body(chunk, triangle, other); });
        },
        1);
  }
  std::size_t chunks() const { return parts_.size(); }
  std::size_t bytes() const;

 private:
  static constexpr Index kLeafSize = 4, kPartSize = 256;
  static constexpr float kRounding = 1e-4F;  // mm: more than differences of places and ways lose within two meters

  // The triangles order_[first] to order_[last - 1]. A node is followed by the half that comes first; `next` is the
  // other one, -1 in a leaf.
  struct Node {
    MovingBox box;
    Index first = 0, last = 0, next = -1;
    bool marked = true;  // one of them is

    Index size() const { return last - first; }
    bool is_leaf() const { return next < 0; }
  };

  Index build(Index first, Index last, std::span<const Vec3> centers);
  // Calls body(triangle, other) for pairs of a triangle of a part with one that comes later: two nodes at once go down
  // the tree, from the part and from the root.
  template <class Body>
  void visit(Index part, float distance, const Body& body) const {
    std::array<std::array<Index, 2>, 256> stack;
    std::size_t height = 0;
    const auto push = [&](Index own, Index other) { stack[height++] = {own, other}; };
    push(part, 0);
    while (height > 0) {
      const auto [at, at_other] = stack[--height];
      const Node &own = nodes_[at], &other = nodes_[at_other];
      if (other.last <= own.first || !(own.marked || other.marked)) continue;
      if (at == at_other) {
        if (own.is_leaf()) {
          visit_triangles(own, other, distance, body);
        } else {
          push(own.next, own.next);
          push(at + 1, own.next);
          push(at + 1, at + 1);
        }
      } else if (other.first <= own.first) {  // and holds it
        push(at, other.next);
        push(at, at_other + 1);
      } else if (other.box.may_meet(own.box, distance)) {
        if (own.is_leaf() && other.is_leaf()) {
          visit_triangles(own, other, distance, body);
        } else if (own.size() >= other.size()) {
          push(own.next, at_other);
          push(at + 1, at_other);
        } else {
          push(at, other.next);
          push(at, at_other + 1);
        }
      }
    }
  }
  template <class Body>
  void visit_triangles(const Node& own, const Node& other, float distance, const Body& body) const {
    for (Index i = own.first; i < own.last; ++i) {
      if (!(marked_[i] || other.marked) || !boxes_[i].may_meet(other.box, distance)) continue;
      for (Index k = std::max(other.first, i + 1); k < other.last; ++k)
        if ((marked_[i] || marked_[k]) && boxes_[i].may_meet(boxes_[k], distance)) body(order_[i], order_[k]);
    }
  }

  std::vector<std::array<Index, 3>> triangles_;
  std::vector<Index> order_;      // the triangles, neighbors near each other
  std::vector<MovingBox> boxes_;  // of each, in that order
  std::vector<std::uint8_t> marked_;
  std::vector<Node> nodes_;
  std::vector<Index> parts_;  // nodes that hold all triangles between them
};

}  // namespace lappet
