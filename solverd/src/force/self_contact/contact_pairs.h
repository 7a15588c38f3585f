// What presses at a state: the candidates whose barrier acts, with its energy, its gradient and a tangent.
//
// A vertex stands for a third of its triangles at rest, and the surface that it comes near to is one surface: where the
// nearest points of several faces are on an edge or a corner that they share, that counts once. So summed over faces,
// less over edges that two of them share, plus over corners whose faces all count (Li et al. 2023, sec. 4), the
// pressure of two flat surfaces at a distance d is -b'(d), whatever their triangles; half of it comes from the vertices
// of either side. Faces and edges that do not count for a vertex, its own above all, leave a border, whose edges are
// not taken off.
//
// Vertices and faces do not see a ridge that meets another. Edges stand in, from a smaller distance on.
#pragma once
#include <array>
#include <vector>

#include "force/self_contact/contact_candidates.h"

namespace lappet {

// Up to four vertices of the surface, and how the distance between the closest points of their primitives changes with
// each: by weight times normal.
struct TouchingPair {
  std::array<Index, 4> vertices{-1, -1, -1, -1};
  std::array<double, 4> weights{};
  Vec3 normal = Vec3::Zero();  // unit
  double distance = 0.0;       // mm
  double energy = 0.0;         // mN mm
  double slope = 0.0;          // of the energy to the distance, mN
  double stiffness = 0.0;      // its second derivative to the distance, mN/mm, not negative
  // How the weights change with the parameters of the closest points, and the edges that these are along, mm.
  int parameters = 0;
  std::array<std::array<double, 4>, 2> turns{};
  std::array<Vec3, 2> edges{Vec3::Zero(), Vec3::Zero()};
  std::array<Vec3, 4> turning{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  // see gradient

  // Of the energy to vertex k, mN. turning: what comes of edges that are nearly parallel and turn.
  Vec3 gradient(std::size_t k) const { return slope * weights[k] * normal + turning[k]; }
};

// places: of the vertices, for which the candidates hold. stiffness: of the barrier, kPa. The same, in the same order,
// for any number of threads.
std::vector<TouchingPair> touching_pairs(const ContactSurface& surface, const ContactCandidates& candidates,
                                         std::span<const Vec3> places, double stiffness);

}  // namespace lappet
