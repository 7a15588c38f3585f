// Where the nodes of a lattice lie at rest: grid points, from which the places follow, at half the memory of the
// places.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "lattice/surface.h"

namespace lappet {

using GridPoint = std::array<std::int32_t, 3>;

class RestPositions {
 public:
  RestPositions() = default;
  // `origin` is where the grid point (0, 0, 0) lies, mm.
  RestPositions(const Vec3& origin, double spacing) : origin_(origin), spacing_(spacing) {}

  std::size_t size() const { return points_.size(); }
  void resize(std::size_t nodes) { points_.resize(nodes); }
  void push_back(const GridPoint& point) { points_.push_back(point); }
  GridPoint& grid_point(std::size_t node) { return points_[node]; }
  const GridPoint& grid_point(std::size_t node) const { return points_[node]; }

  // mm
  Vec3 operator[](std::size_t node) const {
    const GridPoint& p = points_[node];
    return origin_ + spacing_ * Vec3(p[0], p[1], p[2]);
  }
  std::vector<Vec3> all() const { return {begin(), end()}; }

  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = Vec3;
    using difference_type = std::ptrdiff_t;
    using pointer = const Vec3*;
    using reference = Vec3;
    Iterator(const RestPositions& positions, std::size_t node) : positions_(&positions), node_(node) {}
    Vec3 operator*() const { return (*positions_)[node_]; }
    Iterator& operator++() {
      ++node_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return node_ == other.node_; }

   private:
    const RestPositions* positions_;
    std::size_t node_;
  };
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size()}; }

 private:
  Vec3 origin_ = Vec3::Zero();
  double spacing_ = 1.0;
  std::vector<GridPoint> points_;
};

}  // namespace lappet
