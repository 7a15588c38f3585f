// Takes a surface that goes through itself apart again, where it does so by little: a new epoch's triangles lie
// otherwise on tissue that touches than those before, and a state that was solved without contact begins so. Each round
// finds the vertices that lie behind the surface in front of them, by the normals there, and the edges that cross a
// ridge, and moves the nodes of the lattice the least that takes them before it (Kaczmarz's method, row by row).
// Forces are not looked at: the search for the equilibrium begins where this ends.
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "force/constraints/sparse_rows.h"
#include "force/self_contact/contact_candidates.h"

namespace lappet {

class Untangling {
 public:
  // moves: of a node of the lattice. Keeps references.
  Untangling(ContactSurface& surface, const std::function<bool(Index)>& moves);

  // One round: changes u (3 per node) so that the surface goes less through itself. places: of the vertices at u;
  // piercings: there. False: nothing was found to push.
  bool push(std::span<const Vec3> places, std::span<const Piercing> piercings, std::span<double> u);

 private:
  // The point of the surface that faces a vertex: a face, the weights of its corners and the normal there.
  struct Facing {
    Index face = -1;
    std::array<double, 3> weights{};
    Vec3 normal = Vec3::Zero();
    double distance = 0.0;
    bool behind = false;  // the vertex lies behind it
  };

  void find_normals(std::span<const Vec3> places);
  void mark_near(std::span<const Vec3> places, std::span<const Piercing> piercings);
  void find_facing(std::span<const Vec3> places);
  std::optional<Facing> facing(Index vertex, Index face, std::span<const Vec3> places) const;
  bool lies_behind_at_rest(Index vertex, Index face) const;
  Vec3 normal_of_edge(Index edge) const;
  void add_vertices(std::span<const Vec3> places);
  void add_edges(std::span<const Vec3> places, std::span<const Piercing> piercings);
  // That the sum of the weights times what their vertices move by, along a direction, is `lacks` at least.
  void add(const std::array<Index, 4>& vertices, const std::array<double, 4>& weights, const Vec3& along, double lacks);
  void sweep(std::span<double> u) const;

  ContactSurface& surface_;
  const std::function<bool(Index)>& moves_;
  double deepest_, target_;  // mm
  // Now and at rest, as long as twice the area of a face.
  std::vector<Vec3> face_normals_, face_normals_at_rest_;
  // At vertices, of the faces there by their angles: they tell what lies behind (Baerentzen and Aanaes 2005).
  std::vector<Vec3> normals_;
  std::vector<std::uint8_t> marked_;  // vertices
  std::vector<Facing> facing_;        // of each vertex the nearest
  SparseRows rows_;
  std::vector<double> lacks_;  // of each row, mm
};

}  // namespace lappet
