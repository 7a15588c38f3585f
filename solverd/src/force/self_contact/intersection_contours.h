// Where a surface goes through itself, and how to shorten that: the contours along which it does, edge by edge. Their
// length falls fastest where the edge moves against the face by the gradient of Volino and Magnenat-Thalmann (2006,
// Resolving surface collisions through intersection contour minimization, sec. 3). That needs no inside: thin flaps
// and walls that face each other at right angles have none that is near enough.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "force/self_contact/contact_candidates.h"

namespace lappet {

// Where an edge goes through a face: the share of the way along the edge, the weights of the corners of the face, and
// the unit direction in which the edge should move against the face; zero where none is known.
struct ContourPoint {
  Index edge = -1, face = -1;
  double share = 0.0;
  std::array<double, 3> weights{};
  Vec3 direction = Vec3::Zero();
};

// Of all piercings, in their order. places: of the vertices. near: mm; directions are of what the contour is within it,
// as a single edge of a smooth surface has hardly one.
std::vector<ContourPoint> contour_points(const ContactSurface& surface, std::span<const Vec3> places,
                                         std::span<const Piercing> piercings, double near);

}  // namespace lappet
