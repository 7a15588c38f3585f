// Takes a surface that goes through itself apart by shortening the contours along which it does: each round moves nodes
// of the lattice so that edges go back against the faces that they go through. It knows no inside, so it finds a way
// where walls meet at right angles or a flap is thin, and none where two flat sides lie in each other over their whole
// length, as then the contour does not get shorter at first.
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "force/self_contact/intersection_contours.h"

namespace lappet {

class ContourShortening {
 public:
  // u: of the start, 3 per node. moves: of a node of the lattice. Keeps references to the surface and moves.
  ContourShortening(const ContactSurface& surface, const std::function<bool(Index)>& moves, std::span<const double> u)
      : surface_(surface), moves_(moves), start_(u.begin(), u.end()) {}

  // One round: changes u so that the contours get shorter. places: of the vertices at u; piercings: there. False: there
  // is nothing that moves, or a node would be farther from the start than what is no matter of triangles.
  bool push(std::span<const Vec3> places, std::span<const Piercing> piercings, std::span<double> u);

 private:
  // By what a node is to move: the mean of what is wanted of it, weighted by its share in that.
  struct Wanted {
    Vec3 sum = Vec3::Zero();
    double weight = 0.0;
  };

  void want(const ContourPoint& point);
  bool move(std::span<double> u) const;

  const ContactSurface& surface_;
  const std::function<bool(Index)>& moves_;
  std::vector<double> start_;
  std::vector<Wanted> wanted_;
};

}  // namespace lappet
