#include "force/constraints/loaded_faces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lattice/embedding.h"

namespace lappet {

namespace {

using Polygon = std::vector<Vec3>;  // in spacings from the lattice's origin

constexpr double kOnPlane = 1e-9;  // spacings
// What of a convex polygon lies on either side of a plane across an axis.
std::array<Polygon, 2> split(const Polygon& polygon, int axis, double at) {
  std::array<Polygon, 2> sides;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    const double before = a[axis] - at, after = b[axis] - at;
    if (before <= kOnPlane) sides[0].push_back(a);
    if (before >= -kOnPlane) sides[1].push_back(a);
    if ((before < -kOnPlane && after > kOnPlane) || (before > kOnPlane && after < -kOnPlane)) {
      Vec3 crossing = a + before / (before - after) * (b - a);
      crossing[axis] = at;
      for (Polygon& side : sides) side.push_back(crossing);
    }
  }
  return sides;
}

// Cuts a triangle along the planes of the lattice.
std::vector<Polygon> by_cells(const std::array<Vec3, 3>& corners) {
  std::vector<Polygon> pieces{Polygon(corners.begin(), corners.end())};
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Polygon> cut;
    for (Polygon& piece : pieces) {
      const auto along = [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; };
      const auto [low, high] = std::ranges::minmax_element(piece, along);
      const double last = std::ceil((*high)[axis] - kOnPlane);
      for (double plane = std::floor((*low)[axis] + kOnPlane) + 1.0; plane < last; ++plane) {
        std::array<Polygon, 2> sides = split(piece, axis, plane);
        cut.push_back(std::move(sides[0]));
        piece = std::move(sides[1]);
      }
      cut.push_back(std::move(piece));
    }
    pieces = std::move(cut);
  }
  return pieces;
}

Vec3 area_of(const Polygon& polygon) {
  Vec3 area = Vec3::Zero();
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k)
    area += 0.5 * (polygon[k] - polygon[0]).cross(polygon[k + 1] - polygon[0]);
  return area;
}

// Of the area, not of the corners.
Vec3 centroid(const Polygon& polygon) {
  Vec3 moment = Vec3::Zero();
  double area = 0.0;
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
    const double own = (polygon[k] - polygon[0]).cross(polygon[k + 1] - polygon[0]).norm();
    moment += own / 3.0 * (polygon[0] + polygon[k] + polygon[k + 1]);
    area += own;
  }
  return moment / area;
}

// Integrates polynomials of degree 4 over a triangle (Dunavant 1985, Int J Num Meth Eng 21:1129): of three points, the
// weight of each and its coordinate that differs.
struct Orbit {
  double weight, other;
};
constexpr std::array<Orbit, 2> kRule{{{0.223381589678011, 0.108103018168070}, {0.109951743655322, 0.816847572980459}}};

// Calls add(point, share of the area) for the points of the rule.
template <class Add>
void integrate(const Vec3& a, const Vec3& b, const Vec3& c, const Add& add) {
  for (const auto& [weight, other] : kRule) {
    const double same = 0.5 * (1.0 - other);
    add(other * a + same * (b + c), weight);
    add(other * b + same * (c + a), weight);
    add(other * c + same * (a + b), weight);
  }
}

}  // namespace

std::array<double, 8> LoadedFaces::Sample::weights() const {
  std::array<double, 8> result{};
  for (int c = 0; c < 8; ++c)
    result[static_cast<std::size_t>(c)] =
        (c & 4 ? place[0] : 1 - place[0]) * (c & 2 ? place[1] : 1 - place[1]) * (c & 1 ? place[2] : 1 - place[2]);
  return result;
}

std::array<double, 8> LoadedFaces::Sample::slopes(const Vec3& direction, double spacing) const {
  std::array<double, 8> result{};
  for (int c = 0; c < 8; ++c) {
    const Vec3 sign(c & 4 ? 1 : -1, c & 2 ? 1 : -1, c & 1 ? 1 : -1);
    const Vec3 own(c & 4 ? place[0] : 1 - place[0], c & 2 ? place[1] : 1 - place[1], c & 1 ? place[2] : 1 - place[2]);
    const Vec3 gradient(sign[0] * own[1] * own[2], own[0] * sign[1] * own[2], own[0] * own[1] * sign[2]);
    result[static_cast<std::size_t>(c)] = gradient.dot(direction) / spacing;
  }
  return result;
}

LoadedFaces::LoadedFaces(const Lattice& lattice, const Surface& surface, std::span<const std::uint8_t> chosen,
                         const Interrupt& interrupt) {
  const double h = lattice.settings.spacing;
  Embedder embedder(lattice, surface);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    if (!chosen[t]) continue;
    const Index triangle = to_index(t);
    std::array<Vec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = (surface.points[surface.triangles[t][k]] - lattice.settings.origin) / h;
    const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    const Vec3 first = (corners[1] - corners[0]).normalized();
    for (const Polygon& polygon : by_cells(corners)) {
      interrupt.check();
      if (polygon.size() < 3 || !(area_of(polygon).norm() > kOnPlane)) continue;
      const Vec3 middle = lattice.settings.origin + h * centroid(polygon);
      const Index cell = embedder.embed(middle, {&triangle, 1}).cell;
      const GridPoint& corner = lattice.cell_position(static_cast<std::size_t>(cell));
      const Vec3 low(corner[0], corner[1], corner[2]);
      for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
        const Vec3 &a = polygon[0], &b = polygon[k], &c = polygon[k + 1];
        const double area = 0.5 * h * h * (b - a).cross(c - a).norm();
        integrate(a, b, c, [&](const Vec3& point, double share) {
          samples_.push_back({cell, to_index(directions_.size()), share * area, point - low});
        });
      }
    }
    directions_.push_back({first, normal.cross(first)});
  }
  find_cells();
}

LoadedFaces::LoadedFaces(const LoadedFaces& whole, std::span<const Index> place) : directions_(whole.directions_) {
  for (Sample sample : whole.samples_)
    if ((sample.cell = place[static_cast<std::size_t>(sample.cell)]) >= 0) samples_.push_back(sample);
  find_cells();
}

double LoadedFaces::area() const {
  double sum = 0.0;
  for (const Sample& sample : samples_) sum += sample.area;
  return sum;
}

Vec3 LoadedFaces::area_now(const Sample& sample, const FaceMotion& motion) const {
  const Directions& rest = directions(sample);
  return sample.area * (rest.first + motion.first).cross(rest.second + motion.second);
}

double swept_volume(const LoadedFaces::Directions& before, const FaceMotion& way) {
  const Vec3 &e1 = before.first, &e2 = before.second, &g1 = way.first, &g2 = way.second;
  return way.middle.dot(e1.cross(e2) + 0.5 * (e1.cross(g2) + g1.cross(e2)) + g1.cross(g2) / 3.0);
}

void add_symmetric_change(const LoadedFaces::Sample& sample, const LoadedFaces::Directions& rest,
                          const LoadedFaces::Directions& now, double spacing, NodePairs& pairs) {
  const auto n = sample.weights(), s = sample.slopes(rest.first, spacing), t = sample.slopes(rest.second, spacing);
  Vec3* pair = pairs.data();
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t b = a + 1; b < 8; ++b)
      *pair++ +=
          0.5 * sample.area * ((n[a] * t[b] - t[a] * n[b]) * now.first - (n[a] * s[b] - s[a] * n[b]) * now.second);
}

void LoadedFaces::find_cells() {
  std::ranges::stable_sort(samples_, {}, &Sample::cell);
  for (std::size_t k = 0; k < samples_.size(); ++k)
    if (k == 0 || samples_[k].cell != samples_[k - 1].cell) cell_begins_.push_back(k);
  cell_begins_.push_back(samples_.size());
}

}  // namespace lappet
