#include "force/self_contact/contour_shortening.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lappet {

namespace {

// How far a node may go, in spacings: what lies deeper in other tissue is a fault of the start and no matter of
// triangles.
constexpr double kFarthest = 0.5;
// What an edge goes back against a face in a round, and what a node moves for it at most, in reaches.
constexpr double kStep = 0.25, kMaxOfNode = 0.5;
// Along how much of a contour one direction is looked for, in spacings: nodes move no finer.
constexpr double kNear = 1.0;

}  // namespace

bool ContourShortening::push(std::span<const Vec3> places, std::span<const Piercing> piercings, std::span<double> u) {
  wanted_.assign(u.size() / 3, {});
  const double near = kNear * surface_.lattice().settings.spacing;
  for (const ContourPoint& point : contour_points(surface_, places, piercings, near)) want(point);
  return move(u);
}

void ContourShortening::want(const ContourPoint& point) {
  const auto& [a, b] = surface_.edges()[point.edge];
  const auto& [p, q, r] = surface_.triangles()[point.face];
  const auto& w = point.weights;
  const std::array<Index, 5> vertices{a, b, p, q, r};
  const std::array<double, 5> weights{1.0 - point.share, point.share, -w[0], -w[1], -w[2]};
  struct Share {
    Index node;
    double factor;
  };
  std::vector<Share> shares;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    const EmbeddedPoint& embedded = surface_.embedded(vertices[k]);
    for (std::size_t n = 0; n < 8; ++n) {
      const Index node = surface_.lattice().cell_nodes[embedded.cell][n];
      if (!moves_(node)) continue;
      const double factor = weights[k] * embedded.weights[n];
      const auto known = std::ranges::find(shares, node, &Share::node);
      if (known != shares.end()) {
        known->factor += factor;
      } else {
        shares.push_back({node, factor});
      }
    }
  }
  double squared = 0.0;
  for (const Share& share : shares) squared += share.factor * share.factor;
  if (!(squared > 0.0)) return;
  const double by = surface_.reach() * std::min(kStep / squared, kMaxOfNode / std::sqrt(squared));
  for (const auto& [node, factor] : shares) {
    wanted_[node].sum += std::abs(factor) * by * factor * point.direction;
    wanted_[node].weight += std::abs(factor);
  }
}

bool ContourShortening::move(std::span<double> u) const {
  const double farthest = kFarthest * surface_.lattice().settings.spacing;
  bool any = false;
  for (std::size_t n = 0; n < wanted_.size(); ++n) {
    if (!(wanted_[n].weight > 0.0)) continue;
    auto now = Vec3::Map(&u[3 * n]);
    now += wanted_[n].sum / wanted_[n].weight;
    any = true;
    if (!((now - Vec3::Map(&start_[3 * n])).norm() <= farthest)) return false;
  }
  return any;
}

}  // namespace lappet
