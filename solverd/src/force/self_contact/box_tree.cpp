#include "force/self_contact/box_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace lappet {

namespace {

// No larger, or no smaller, than it was.
template <int kSign>
MovingBox::Corner rounded(const Vec3& corner) {
  const Eigen::Array3f nearest = corner.cast<float>();
  MovingBox::Corner result = MovingBox::Corner::Zero();
  result.head<3>() = nearest + float(kSign) * std::numeric_limits<float>::epsilon() * nearest.abs();
  return result;
}

}  // namespace

BoxTree::BoxTree(std::span<const Vec3> places, std::vector<std::array<Index, 3>> triangles)
    : triangles_(std::move(triangles)),
      order_(triangles_.size()),
      boxes_(triangles_.size()),
      marked_(triangles_.size(), 1) {
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<Vec3> centers;
  for (const auto& [a, b, c] : triangles_) centers.push_back((places[a] + places[b] + places[c]) / 3.0);
  if (!triangles_.empty()) build(0, to_index(triangles_.size()), centers);
  refit(places, {});
}

// Halves the triangles across the longest side of the box around their centers. Returns the node.
Index BoxTree::build(Index first, Index last, std::span<const Vec3> centers) {
  const Index at = to_index(nodes_.size());
  nodes_.push_back({{}, first, last, -1});
  if (last - first <= kPartSize && (parts_.empty() || nodes_[parts_.back()].last <= first)) parts_.push_back(at);
  if (last - first <= kLeafSize) return at;
  Vec3 low = centers[order_[first]], high = low;
  for (Index k = first; k < last; ++k) {
    low = low.cwiseMin(centers[order_[k]]);
    high = high.cwiseMax(centers[order_[k]]);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const Index middle = first + (last - first) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last, [&](Index a, Index b) {
    return centers[a][axis] != centers[b][axis] ? centers[a][axis] < centers[b][axis] : a < b;
  });
  build(first, middle, centers);
  const Index next = build(middle, last, centers);
  nodes_[at].next = next;
  return at;
}

void BoxTree::refit(std::span<const Vec3> places, std::span<const Vec3> ways, std::span<const std::uint8_t> marked) {
  for_each_index(order_.size(), [&](std::size_t k) {
    const auto& [a, b, c] = triangles_[order_[k]];
    MovingBox& box = boxes_[k];
    marked_[k] = marked.empty() || marked[a] || marked[b] || marked[c];
    box.low = rounded<-1>(places[a].cwiseMin(places[b]).cwiseMin(places[c]));
    box.high = rounded<1>(places[a].cwiseMax(places[b]).cwiseMax(places[c]));
    box.least_way = box.most_way = MovingBox::Corner::Zero();
    if (ways.empty()) return;
    box.least_way = rounded<-1>(ways[a].cwiseMin(ways[b]).cwiseMin(ways[c]));
    box.most_way = rounded<1>(ways[a].cwiseMax(ways[b]).cwiseMax(ways[c]));
  });
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    if (node.next < 0) {
      node.box = boxes_[node.first];
      node.marked = marked_[node.first];
      for (Index k = node.first + 1; k < node.last; ++k) {
        node.box.grow(boxes_[k]);
        node.marked |= marked_[k] != 0;
      }
    } else {
      node.box = nodes_[n + 1].box;
      node.box.grow(nodes_[node.next].box);
      node.marked = nodes_[n + 1].marked || nodes_[node.next].marked;
    }
  }
}

std::size_t BoxTree::bytes() const {
  return triangles_.size() * (sizeof(triangles_[0]) + sizeof(Index) + sizeof(MovingBox) + 1) +
         nodes_.size() * sizeof(Node) + parts_.size() * sizeof(Index);
}

}  // namespace lappet
