#include "lattice/anchor_stencil.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>

namespace lappet {

namespace {

// Eigenvalues of A, lengths in stencil radii, over its trace; below, the nodes do not span space.
constexpr double kMinSpan = 1e-4;

// Calls body(cell) for the cells that share a whole face with one. Cells lie in grid order.
template <class Body>
void for_each_neighbor(const Lattice& lattice, Index cell, const Body& body) {
  const auto& nodes = lattice.cell_nodes[cell];
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const int direction : {-1, 1}) {
      GridPoint place = lattice.cell_position(cell);
      place[axis] += direction;
      const auto [begin, end] = std::ranges::equal_range(
          lattice.cell_nodes, place, {}, [&](const auto& corners) { return lattice.node_rest.grid_point(corners[0]); });
      for (auto found = begin; found != end; ++found) {
        const std::size_t other = found - lattice.cell_nodes.begin();
        const std::size_t bit = std::size_t{4} >> axis;
        bool whole = true;
        for (std::size_t c = 0; c < 8 && whole; ++c)
          if (((c & bit) != 0) == (direction > 0)) whole = nodes[c] == lattice.cell_nodes[other][c ^ bit];
        if (whole) body(to_index(other));
      }
    }
}

}  // namespace

AnchorStencil point_stencil(const Lattice& lattice, const EmbeddedPoint& anchor) {
  AnchorStencil result;
  for (std::size_t k = 0; k < 8; ++k) {
    if (std::abs(anchor.weights[k]) < 1e-9) continue;
    const Index node = lattice.cell_nodes[anchor.cell][k];
    const auto found = std::find(result.nodes.begin(), result.nodes.end(), node);
    if (found == result.nodes.end()) {
      result.nodes.push_back(node);
      result.weights.push_back(anchor.weights[k]);
    } else {
      result.weights[found - result.nodes.begin()] += anchor.weights[k];
    }
  }
  return result;
}

AnchorStencil anchor_stencil(const Lattice& lattice, const EmbeddedPoint& anchor, double reach) {
  const double h = lattice.settings.spacing;
  const AnchorStencil point = point_stencil(lattice, anchor);
  if (h >= reach) return point;
  Vec3 center = Vec3::Zero();
  for (std::size_t k = 0; k < point.nodes.size(); ++k) center += point.weights[k] * lattice.node_rest[point.nodes[k]];

  std::vector<Index> cells{anchor.cell};
  std::map<Index, double> carried;  // cells at each node; ordered: the result is deterministic
  std::vector<Index> seen{anchor.cell};
  while (!cells.empty()) {
    const Index cell = cells.back();
    cells.pop_back();
    for (const Index node : lattice.cell_nodes[cell]) carried[node] += double(lattice.cell_fill[cell]);
    for_each_neighbor(lattice, cell, [&](Index next) {
      const auto place = std::lower_bound(seen.begin(), seen.end(), next);
      if (place != seen.end() && *place == next) return;
      const auto& p = lattice.cell_position(next);
      const Vec3 middle = lattice.settings.origin + h * Vec3(p[0] + 0.5, p[1] + 0.5, p[2] + 0.5);
      if ((middle - center).norm() > reach) return;
      seen.insert(place, next);
      cells.push_back(next);
    });
  }

  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  const auto arm = [&](Index node) -> Eigen::Vector4d {
    const Vec3 x = (lattice.node_rest[node] - center) / reach;
    return {1.0, x[0], x[1], x[2]};
  };
  for (auto& [node, weight] : carried) {
    const Eigen::Vector4d p = arm(node);
    weight *= std::max(0.0, 1.0 - p.tail<3>().squaredNorm());
    moments += weight * p * p.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> spectrum(moments);
  if (!(spectrum.eigenvalues()[0] > kMinSpan * moments.trace())) return point;
  const Eigen::Vector4d gain = moments.llt().solve(Eigen::Vector4d::UnitX());
  AnchorStencil result;
  for (const auto& [node, weight] : carried) {
    if (weight == 0.0) continue;
    result.nodes.push_back(node);
    result.weights.push_back(weight * arm(node).dot(gain));
  }
  return result;
}

}  // namespace lappet
