#include "force/self_contact/intersection_contours.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "force/self_contact/distances.h"

namespace lappet {

namespace {

// The sine of the angle between an edge and a face that it goes through, at least: nearer to parallel they have no
// direction.
constexpr double kMinSine = 1e-3;
// From which length of a gradient on its direction counts in full.
constexpr double kClear = 0.1;

struct Gradient {
  Vec3 at = Vec3::Zero(), turn = Vec3::Zero();
  int contour = -1;
  double side = 1.0;  // -1: its edge is of the surface whose faces others of the contour go through
};

class Contours {
 public:
  Contours(const ContactSurface& surface, std::span<const Vec3> places, std::span<const Piercing> piercings)
      : surface_(surface), places_(places), piercings_(piercings), points_(piercings.size()) {}

  std::vector<ContourPoint> points(double near) {
    gradients_.resize(piercings_.size());
    for_each_index(piercings_.size(), [&](std::size_t i) { find_gradient(i); });
    for (std::size_t i = 0; i < piercings_.size(); ++i)
      for (const Index t : surface_.triangles_at(piercings_[i].edge))
        if (t >= 0) ends_[segment(t, i)].push_back(i);
    int contours = 0;
    for (std::size_t i = 0; i < gradients_.size(); ++i)
      if (gradients_[i].contour < 0) follow(i, contours++);
    for_each_index(points_.size(), [&](std::size_t i) { find_direction(i, near); });
    return std::move(points_);
  }

 private:
  Vec3 normal(Index face) const {
    const auto& [a, b, c] = surface_.triangles()[face];
    return (places_[b] - places_[a]).cross(places_[c] - places_[a]).normalized();
  }

  // What a triangle at its edge and the face that this goes through have in common ends at the point.
  std::pair<Index, Index> segment(Index triangle, std::size_t i) const {
    return std::minmax({triangle, piercings_[i].face});
  }

  void find_gradient(std::size_t i) {
    const auto& [edge, face] = piercings_[i];
    const auto& [a, b] = surface_.edges()[edge];
    const auto& [p, q, r] = surface_.triangles()[face];
    const Vec3 across = normal(face), way = places_[b] - places_[a], along = way.normalized();
    const double sine = std::copysign(std::max(std::abs(along.dot(across)), kMinSine), along.dot(across));
    ContourPoint& point = points_[i];
    point.edge = edge;
    point.face = face;
    point.share = std::clamp((places_[p] - places_[a]).dot(across) / (sine * way.norm()), 0.0, 1.0);
    Gradient& gradient = gradients_[i];
    gradient.at = places_[a] + point.share * way;
    point.weights = closest_on_triangle(gradient.at, places_[p], places_[q], places_[r]).weights;
    for (const Index t : surface_.triangles_at(edge)) {
      if (t < 0) continue;
      Vec3 contour = across.cross(normal(t));
      if (!(contour.norm() > kMinSine)) continue;
      contour.normalize();
      Vec3 inward = -3.0 * gradient.at;
      for (const Index v : surface_.triangles()[t]) inward += places_[v];
      inward -= inward.dot(along) * along;
      if (contour.dot(inward) < 0.0) contour = -contour;
      gradient.turn += contour - 2.0 * along.dot(contour) / sine * across;
    }
  }

  // All points of the contour of one, and whether the edges there are of the same surface as its own.
  void follow(std::size_t first, int contour) {
    std::vector<std::size_t> to_visit{first};
    gradients_[first].contour = contour;
    while (!to_visit.empty()) {
      const std::size_t i = to_visit.back();
      to_visit.pop_back();
      for (const Index t : surface_.triangles_at(piercings_[i].edge)) {
        if (t < 0) continue;
        for (const std::size_t k : ends_.at(segment(t, i))) {
          if (gradients_[k].contour >= 0) continue;
          gradients_[k].contour = contour;
          gradients_[k].side = piercings_[k].face == piercings_[i].face ? gradients_[i].side : -gradients_[i].side;
          to_visit.push_back(k);
        }
      }
    }
  }

  void find_direction(std::size_t i, double near) {
    const Gradient& of = gradients_[i];
    Vec3 turn = Vec3::Zero();
    for (const Gradient& other : gradients_)
      if (other.contour == of.contour && (other.at - of.at).squaredNorm() <= near * near)
        turn += other.side * of.side * other.turn;
    points_[i].direction = turn / std::hypot(turn.norm(), kClear);
  }

  const ContactSurface& surface_;
  std::span<const Vec3> places_;
  std::span<const Piercing> piercings_;
  std::vector<ContourPoint> points_;
  std::vector<Gradient> gradients_;
  std::map<std::pair<Index, Index>, std::vector<std::size_t>> ends_;  // of segments
};

}  // namespace

std::vector<ContourPoint> contour_points(const ContactSurface& surface, std::span<const Vec3> places,
                                         std::span<const Piercing> piercings, double near) {
  return Contours(surface, places, piercings).points(near);
}

}  // namespace lappet
