#include "force/self_contact/contact_tangent.h"

#include <Eigen/Geometry>
#include <cmath>

namespace lappet {

std::vector<TangentRow> tangent_rows(const TouchingPair& pair) {
  std::vector<TangentRow> rows;
  if (!(pair.stiffness > 0.0)) return rows;
  const auto along_normal = [&](const std::array<double, 4>& weights, double scale) {
    TangentRow& row = rows.emplace_back();
    for (int k = 0; k < 4; ++k) row[k] = scale * weights[k] * pair.normal;
  };
  along_normal(pair.weights, std::sqrt(pair.stiffness));
  // G = L L^T by hand: of the edges that the closest points go along, two at most.
  const double scale = std::sqrt(std::max(-pair.slope * pair.distance, 0.0));
  if (pair.parameters == 0 || !(scale > 0.0)) return rows;
  const double first = pair.edges[0].norm();
  if (!(first > 0.0)) return rows;
  along_normal(pair.turns[0], scale / first);
  if (pair.parameters == 1) return rows;
  const double overlap = pair.edges[0].dot(pair.edges[1]) / (first * first);
  const double second = (pair.edges[1] - overlap * pair.edges[0]).norm();
  if (!(second > 1e-6 * pair.edges[1].norm())) return rows;
  std::array<double, 4> rest;
  for (int k = 0; k < 4; ++k) rest[k] = pair.turns[1][k] - overlap * pair.turns[0][k];
  along_normal(rest, scale / second);
  return rows;
}

}  // namespace lappet
