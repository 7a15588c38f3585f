#include "force/self_contact/contact_tangent.h"

#include <Eigen/Geometry>
#include <cmath>

namespace lappet {

namespace {

// A direction that the closest points go along, of unit length, and how the weights change with the way along it.
struct Way {
  Vec3 direction;
  std::array<double, 4> turn;
};

// Orthogonal ones, by hand: two edges at most.
std::vector<Way> ways_of(const TouchingPair& pair) {
  std::vector<Way> ways;
  if (pair.parameters == 0) return ways;
  const double first = pair.edges[0].norm();
  if (!(first > 0.0)) return ways;
  Way& along = ways.emplace_back(pair.edges[0] / first, pair.turns[0]);
  for (double& turn : along.turn) turn /= first;
  if (pair.parameters == 1) return ways;
  const double overlap = pair.edges[0].dot(pair.edges[1]) / (first * first);
  const Vec3 rest = pair.edges[1] - overlap * pair.edges[0];
  const double second = rest.norm();
  if (!(second > 1e-6 * pair.edges[1].norm())) return ways;
  Way& across = ways.emplace_back(rest / second, pair.turns[1]);
  for (int k = 0; k < 4; ++k) across.turn[k] = (pair.turns[1][k] - overlap * pair.turns[0][k]) / second;
  return ways;
}

TangentRow row_of(const std::array<double, 4>& weights, const Vec3& vector) {
  TangentRow row;
  for (int k = 0; k < 4; ++k) row[k] = weights[k] * vector;
  return row;
}

// What a way adds to the Hessian beside the distance's own part: f (a b^T + b a^T) + f d b b^T, a the slide along it
// and b the tilt, which are orthogonal. Its positive eigenvalue and its negative one, each with the square root of its
// size on a unit eigenvector.
struct SlideAndTilt {
  TangentRow positive, negative;
};
SlideAndTilt slide_and_tilt(const TouchingPair& pair, const Way& way) {
  double slide = 0.0, tilt = 0.0;
  for (int k = 0; k < 4; ++k) {
    slide += pair.weights[k] * pair.weights[k];
    tilt += way.turn[k] * way.turn[k];
  }
  slide = std::sqrt(slide);
  tilt = std::sqrt(tilt);
  const double force = -pair.slope, coupling = force * slide * tilt, own = 0.5 * force * pair.distance * tilt * tilt;
  const double root = std::hypot(own, coupling);
  // The eigenvectors are (coupling, own +- root), in unit slides and tilts.
  const auto row = [&](double of_tilt, double eigenvalue) {
    const double scale = std::sqrt(std::abs(eigenvalue)) / std::hypot(coupling, of_tilt);
    TangentRow result;
    for (int k = 0; k < 4; ++k)
      result[k] =
          scale * (coupling * pair.weights[k] / slide * way.direction + of_tilt * way.turn[k] / tilt * pair.normal);
    return result;
  };
  return {row(own + root, own + root), row(own - root, own - root)};
}

// Across the normal and the ways the closest points stay where they are while the pair turns about them, and the
// distance bends by 1/d. What presses apart gives way so, which is left out; what is taken off at an edge that faces
// share (contact_pairs.h) is stiff: without these rows a vertex in a groove has a fraction of its stiffness along it.
std::vector<TangentRow> turning_rows(const TouchingPair& pair) {
  std::vector<Vec3> known{pair.normal};
  for (const Way& way : ways_of(pair)) known.push_back(way.direction);
  const double root = std::sqrt(std::abs(pair.slope) / pair.distance);
  std::vector<TangentRow> rows;
  while (known.size() < 3) {
    const Vec3 across = known.size() == 2 ? Vec3(known[0].cross(known[1]).normalized()) : known[0].unitOrthogonal();
    rows.push_back(row_of(pair.weights, root * across));
    known.push_back(across);
  }
  return rows;
}

}  // namespace

std::vector<TangentRow> definite_rows(const TouchingPair& pair) {
  std::vector<TangentRow> rows{row_of(pair.weights, std::sqrt(std::max(pair.stiffness, 0.0)) * pair.normal)};
  if (pair.slope == 0.0) return rows;
  for (const Way& way : ways_of(pair)) rows.push_back(slide_and_tilt(pair, way).positive);
  if (pair.slope > 0.0)
    for (const TangentRow& row : turning_rows(pair)) rows.push_back(row);
  return rows;
}

std::vector<TangentRow> negative_rows(const TouchingPair& pair) {
  std::vector<TangentRow> rows;
  if (pair.stiffness < 0.0) rows.push_back(row_of(pair.weights, std::sqrt(-pair.stiffness) * pair.normal));
  if (pair.slope == 0.0) return rows;
  for (const Way& way : ways_of(pair)) rows.push_back(slide_and_tilt(pair, way).negative);
  return rows;
}

}  // namespace lappet
