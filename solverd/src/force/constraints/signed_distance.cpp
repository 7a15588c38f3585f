#include "force/constraints/signed_distance.h"

#include <spdlog/fmt/fmt.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <unsupported/Eigen/BVH>

#include "lattice/crossings.h"
#include "lattice/quantize.h"
#include "lattice/refused.h"

namespace lappet {
namespace {

constexpr std::int32_t kBlock = 8;          // nodes along the edge of a block
constexpr std::int32_t kSide = kBlock + 2;  // with those of its neighbors that an interpolation needs
constexpr std::size_t kNodes = std::size_t{kSide} * kSide * kSide;
constexpr Index kFar = -1, kDeep = -2;
// Nodes around the box of the surface: enough for the reach and for what an interpolation needs.
constexpr std::int32_t kMargin = 4;

using Box = Eigen::AlignedBox<double, 3>;

struct Corners {
  std::array<Vec3, 3> at;
  friend Box bounding_box(const Corners& triangle) {
    Box box(triangle.at[0]);
    box.extend(triangle.at[1]).extend(triangle.at[2]);
    return box;
  }
};

double squared_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * along).squaredNorm();
}

double squared_to_triangle(const Vec3& p, const Corners& triangle) {
  const auto& [a, b, c] = triangle.at;
  const Vec3 normal = (b - a).cross(c - a);
  const double area2 = normal.squaredNorm();
  if (area2 > 0.0 && (b - a).cross(p - a).dot(normal) >= 0.0 && (c - b).cross(p - b).dot(normal) >= 0.0 &&
      (a - c).cross(p - c).dot(normal) >= 0.0) {
    const double height = (p - a).dot(normal);
    return height * height / area2;
  }
  return std::min({squared_to_segment(p, a, b), squared_to_segment(p, b, c), squared_to_segment(p, c, a)});
}

// For Eigen's searches: the nearest triangle, and all within a ball.
struct Nearest {
  using Scalar = double;
  Vec3 point;
  double minimumOnVolume(const Box& box) const { return box.squaredExteriorDistance(point); }
  double minimumOnObject(const Corners& triangle) const { return squared_to_triangle(point, triangle); }
};
struct Within {
  Vec3 point;
  double squared;
  std::vector<Corners>& found;
  bool intersectVolume(const Box& box) const { return box.squaredExteriorDistance(point) <= squared; }
  bool intersectObject(const Corners& triangle) {
    if (squared_to_triangle(point, triangle) <= squared) found.push_back(triangle);
    return false;  // go on
  }
};

class Distance {
 public:
  explicit Distance(const std::vector<Corners>& triangles) : tree_(triangles.begin(), triangles.end()) {}
  double at(const Vec3& point) const {
    Nearest nearest{point};
    return std::sqrt(Eigen::BVMinimize(tree_, nearest));
  }
  std::vector<Corners> within(double radius, const Vec3& point) const {
    std::vector<Corners> found;
    Within ball{point, radius * radius, found};
    Eigen::BVIntersect(tree_, ball);
    return found;
  }

 private:
  Eigen::KdBVH<double, 3, Corners> tree_;
};

// Distances of neighboring points to the triangles near them, which the tree gives in an order that keeps neighbors
// together: runs of them, and single ones, are left out by the ball around each. What one point is near to is tried
// first for the next.
class NearbyDistance {
 public:
  explicit NearbyDistance(std::vector<Corners> triangles) : triangles_(std::move(triangles)) {
    for (std::size_t first = 0; first < triangles_.size(); first += kRun) {
      const std::size_t last = std::min(first + kRun, triangles_.size());
      Box box;
      for (std::size_t t = first; t < last; ++t) box.extend(bounding_box(triangles_[t]));
      runs_.push_back({box.center(), 0.5 * box.diagonal().norm()});
    }
    for (const Corners& triangle : triangles_) balls_.push_back(ball_around(triangle));
  }
  // The distance, or `max_distance` where that is less.
  double at(const Vec3& point, double max_distance) {
    if (triangles_.empty()) return max_distance;
    double best = std::min(max_distance, std::sqrt(squared_to_triangle(point, triangles_[last_])));
    const std::size_t tried = last_;
    for (std::size_t run = 0; run < runs_.size(); ++run) {
      if (runs_[run].is_beyond(best, point)) continue;
      for (std::size_t t = kRun * run; t < std::min(kRun * (run + 1), triangles_.size()); ++t) {
        if (t == tried || balls_[t].is_beyond(best, point)) continue;
        const double distance = std::sqrt(squared_to_triangle(point, triangles_[t]));
        if (distance < best) {
          best = distance;
          last_ = t;
        }
      }
    }
    return best;
  }

 private:
  static constexpr std::size_t kRun = 8;
  struct Ball {
    Vec3 middle;
    double radius;
    bool is_beyond(double distance, const Vec3& point) const {
      const double reach = distance + radius;
      return (middle - point).squaredNorm() >= reach * reach;
    }
  };
  // About the middle of the longest edge: the least one, unless all angles are acute.
  static Ball ball_around(const Corners& triangle) {
    const auto& corner = triangle.at;
    std::size_t longest = 0;
    const auto edge = [&](std::size_t k) { return (corner[(k + 1) % 3] - corner[k]).squaredNorm(); };
    for (std::size_t k = 1; k < 3; ++k)
      if (edge(k) > edge(longest)) longest = k;
    const Vec3 middle = 0.5 * (corner[longest] + corner[(longest + 1) % 3]);
    return {middle, std::sqrt(std::max(0.25 * edge(longest), (corner[(longest + 2) % 3] - middle).squaredNorm()))};
  }
  std::vector<Corners> triangles_;
  std::vector<Ball> runs_, balls_;
  std::size_t last_ = 0;
};

// The triangles without those that come as often in one orientation as in the other.
std::vector<Corners> outer_triangles(const Surface& surface, const std::vector<StepPoint>& points) {
  std::map<std::array<StepPoint, 3>, int> turns;  // corners in order -> even less odd orders of them
  const auto place = [&](const std::array<std::int32_t, 3>& t) {
    std::array<StepPoint, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = points[t[k]];
    int sign = 1;
    for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {0, 1}}) {
      auto &low = corners[a], &high = corners[b];
      if (high < low) {
        std::swap(low, high);
        sign = -sign;
      }
    }
    return std::pair{corners, sign};
  };
  for (const auto& t : surface.triangles) {
    const auto [corners, sign] = place(t);
    turns[corners] += sign;
  }
  std::vector<Corners> result;
  for (const auto& t : surface.triangles)
    if (turns[place(t).first] != 0)
      result.push_back({{surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]}});
  return result;
}

// Which nodes lie inside: the crossings of the surface with the lines of nodes along z.
class Inside {
 public:
  Inside(const Surface& surface, const Quantized& quantized, const Interrupt& interrupt) : box_(quantized.box) {
    auto first = count_crossings(quantized.points, surface.triangles, box_, interrupt);
    const Crossings crossings = find_crossings(quantized.points, surface.triangles, box_, std::move(first), interrupt);
    start_.assign(std::int64_t{box_.voxels(0)} * box_.voxels(1) + 1, 0);
    for (const Crossing& c : crossings.all)
      if (c.axis == 2) ++start_[line(c.lower[0], c.lower[1]) + 1];
    for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
    crossing_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (const Crossing& c : crossings.all)
      if (c.axis == 2) crossing_[next[line(c.lower[0], c.lower[1])]++] = {c.lower[2], c.winding};
  }
  // Node z of a line is node z of the box; those outside it are outside the bodies.
  bool at(std::int32_t x, std::int32_t y, std::int32_t z) const {
    if (x < 0 || y < 0 || x >= box_.voxels(0) || y >= box_.voxels(1)) return false;
    int winding = 0;
    for (std::size_t i = start_[line(x, y)]; i < start_[line(x, y) + 1]; ++i)
      if (crossing_[i].below < z) winding += crossing_[i].winding;
    return winding != 0;
  }

 private:
  struct Step {
    std::int32_t below;
    std::int8_t winding;
  };
  std::size_t line(std::int32_t x, std::int32_t y) const { return std::int64_t{x} * box_.voxels(1) + y; }
  VoxelBox box_;
  std::vector<std::size_t> start_;
  std::vector<Step> crossing_;
};

using Node = std::array<std::int32_t, 3>;

// What the values are made of: the bodies, and where the nodes lie.
struct Source {
  Vec3 first_node;
  double spacing;
  Node blocks;  // how many along each axis
  double depth, reach;
  Inside inside;
  Distance distance;

  // About the middle of a block, with all nodes that its interpolations need.
  double radius() const { return 0.5 * std::sqrt(3.0) * (kSide + 1) * spacing; }
  Node corner(std::size_t place) const {
    const Index p = to_index(place);
    return {p / (blocks[1] * blocks[2]) * kBlock, p / blocks[2] % blocks[1] * kBlock, p % blocks[2] * kBlock};
  }
  Node middle(const Node& corner) const {
    constexpr std::int32_t kHalf = kBlock / 2;
    return {corner[0] + kHalf, corner[1] + kHalf, corner[2] + kHalf};
  }
  Vec3 position(const Node& n) const { return first_node + spacing * Vec3(n[0], n[1], n[2]); }
  bool is_inside(const Node& n) const { return inside.at(n[0] - kMargin, n[1] - kMargin, n[2] - kMargin); }

  // kFar or kDeep where the value of a block is cut off throughout, else 0.
  Index kind_of(std::size_t place) const {
    const Node center = middle(corner(place));
    const double away = distance.at(position(center));
    const bool deep = away > radius() && is_inside(center);
    return away > radius() + (deep ? depth : reach) ? (deep ? kDeep : kFar) : 0;
  }
  void fill(std::size_t place, float* out) const {
    const Node c = corner(place);
    NearbyDistance nearby(distance.within(radius() + std::max(depth, reach), position(middle(c))));
    for (std::int32_t x = c[0] - 1; x < c[0] + kSide - 1; ++x)
      for (std::int32_t y = c[1] - 1; y < c[1] + kSide - 1; ++y)
        for (std::int32_t z = c[2] - 1; z < c[2] + kSide - 1; ++z)
          *out++ = float(is_inside({x, y, z}) ? -nearby.at(position({x, y, z}), depth)
                                              : nearby.at(position({x, y, z}), reach));
  }
};

}  // namespace

SignedDistance::SignedDistance(const Surface& surface, double spacing, double depth, std::size_t memory_budget,
                               const Interrupt& interrupt)
    : spacing_(spacing), depth_(depth), reach_(2.0 * spacing) {
  LatticeSettings grid;
  grid.spacing = spacing;
  grid.fine_ratio = 1;
  grid.origin = surface.points.front();
  for (const Vec3& p : surface.points) grid.origin = grid.origin.cwiseMin(p);
  const Quantized quantized = quantize(surface, grid);
  const VoxelBox& box = quantized.box;
  const auto check_budget = [&](double bytes) {
    if (bytes > double(memory_budget))
      throw RefusedError(
          ErrorCode::kMemoryBudget,
          fmt::format("the distance field of the bones needs {:.3g} GiB at a spacing of {:g} mm, more than "
                      "is left of the memory budget ({:.3g} GiB); use a larger spacing, leave out bone "
                      "that the tissue cannot reach, or raise the budget",
                      bytes / 0x1p30, spacing, double(memory_budget) / 0x1p30));
  };
  for (std::size_t a = 0; a < 3; ++a)
    if (box.voxels(a) >= kMaxVoxelsPerAxis)
      throw RefusedError(
          ErrorCode::kMemoryBudget,
          fmt::format("the distance field of the bones needs {} nodes along one side at a spacing of {:g} "
                      "mm, {} at most; use a larger spacing or leave out bone that the tissue cannot reach",
                      box.voxels(a), spacing, kMaxVoxelsPerAxis));
  double places = 1.0;
  for (std::size_t a = 0; a < 3; ++a) {
    blocks_[a] = (box.voxels(a) + 2 * kMargin + kBlock - 1) / kBlock;
    places *= blocks_[a];
    first_node_[a] = grid.origin[a] + spacing * (box.low[a] + 0.5 - kMargin);
  }
  const double columns = 1.0 * box.voxels(0) * box.voxels(1);
  check_budget(4.0 * places + 8.0 * columns);

  const Source source{first_node_,
                      spacing,
                      blocks_,
                      depth_,
                      reach_,
                      Inside(surface, quantized, interrupt),
                      Distance(outer_triangles(surface, quantized.points))};
  block_.assign(std::size_t(places), kFar);
  tbb::parallel_for(std::size_t{0}, block_.size(), [&](std::size_t place) {
    interrupt.check();
    block_[place] = source.kind_of(place);
  });
  std::vector<std::size_t> used;
  for (std::size_t place = 0; place < block_.size(); ++place)
    if (block_[place] == 0) {
      block_[place] = to_index(used.size());
      used.push_back(place);
    }
  check_budget(4.0 * kNodes * double(used.size()));
  values_.resize(kNodes * used.size());
  tbb::parallel_for(std::size_t{0}, used.size(), [&](std::size_t block) {
    interrupt.check();
    source.fill(used[block], &values_[kNodes * block]);
  });
}

SignedDistance::Sample SignedDistance::at(const Vec3& point) const {
  const Vec3 grid = (point - first_node_) / spacing_;
  std::array<std::int32_t, 3> middle, place;
  double weight[3][3], slope[3][3];
  for (std::size_t a = 0; a < 3; ++a) {
    const double g = grid[a], rounded = std::floor(g + 0.5);
    if (!(rounded >= 0.0 && rounded < blocks_[a] * kBlock)) return {reach_, Vec3::Zero()};
    middle[a] = std::int32_t(rounded);
    place[a] = middle[a] / kBlock;
    const double t = g - rounded;
    weight[a][0] = 0.5 * (0.5 - t) * (0.5 - t);
    weight[a][1] = 0.75 - t * t;
    weight[a][2] = 0.5 * (0.5 + t) * (0.5 + t);
    slope[a][0] = t - 0.5;
    slope[a][1] = -2.0 * t;
    slope[a][2] = t + 0.5;
  }
  const Index block = block_[(std::int64_t{place[0]} * blocks_[1] + place[1]) * blocks_[2] + place[2]];
  if (block == kFar) return {reach_, Vec3::Zero()};
  if (block == kDeep) return {-depth_, Vec3::Zero()};
  // Node `middle - 1` of the block, whose first node is one before its corner.
  const float* base =
      &values_[kNodes * block + ((middle[0] % kBlock) * kSide + middle[1] % kBlock) * kSide + middle[2] % kBlock];
  Sample sample{0.0, Vec3::Zero()};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const float* row = base + (i * kSide + j) * kSide;
      double value = 0.0, along = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        value += weight[2][k] * double(row[k]);
        along += slope[2][k] * double(row[k]);
      }
      sample.value += weight[0][i] * weight[1][j] * value;
      sample.gradient += Vec3(slope[0][i] * weight[1][j] * value, weight[0][i] * slope[1][j] * value,
                              weight[0][i] * weight[1][j] * along);
    }
  sample.gradient /= spacing_;
  return sample;
}

}  // namespace lappet
