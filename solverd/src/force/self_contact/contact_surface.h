// The surface of an epoch as what touches itself: its triangles, edges and vertices, embedded in the lattice, with the
// areas that they stand for and the distances that they have at rest.
//
// The barrier of a pair begins where the surfaces come as near as `reach`, but never farther than a share of what the
// two are apart at rest: it is zero there, however thin a cut is. A wall of a cut therefore keeps less apart from the
// wall that it was cut from than from any other tissue. Primitives that all but touch at rest never count as a pair.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "force/self_contact/box_tree.h"
#include "lattice/lattice.h"
#include "lattice/node_field.h"
#include "math/groups.h"

namespace lappet {

// Of the distance at rest, the share from which on a barrier acts.
inline constexpr double kShareOfRest = 0.5;
// Closer at rest, mm, is touching: positions in single precision tell no more apart.
inline constexpr double kTouchesAtRest = 1e-3;
// Two edges keep apart from these shares of the reach or of their distance at rest on: faces carry the pressure, edges
// stand in only where one ridge meets another.
inline constexpr double kEdgeShare = 0.5, kEdgeShareOfRest = 0.2;

// Of a field over the vertices, that of some.
inline std::array<Vec3, 4> at(std::span<const Vec3> field, const std::array<Index, 4>& vertices) {
  return {field[vertices[0]], field[vertices[1]], field[vertices[2]], field[vertices[3]]};
}

// The least areas that a vertex and an edge stand for, in squares of the spacing: a sliver, and the tip of a flap,
// bears what the cell that carries it presses with, and a single pair of edges what a whole ridge does. With less of it
// the barrier would bear such a load only at a tiny distance, along which no step can slide.
inline constexpr double kMinArea = 1.0, kMinEdgeArea = 1.0;

class ContactSurface {
 public:
  using Edge = std::array<Index, 2>;

  // reach: mm. Keeps a reference to the lattice, which must have the embedded points of the surface.
  ContactSurface(const Lattice& lattice, const Surface& surface, double reach, const Interrupt& interrupt);
  // The same surface where only a subdomain of its lattice moves. place_of_cell: per cell of the whole, its index in
  // the subdomain, or -1; u: of the whole. Keeps references to the subdomain and to the lattice of the whole.
  template <class Real>
  ContactSurface(const ContactSurface& whole, const Lattice& subdomain, std::span<const Index> place_of_cell,
                 std::span<const Real> u);

  std::size_t vertices() const { return rest_.size(); }
  double reach() const { return reach_; }
  const std::vector<std::array<Index, 3>>& triangles() const { return triangles_; }
  const std::vector<Edge>& edges() const { return edges_; }
  // Its cell is -1 where the vertex does not move.
  const EmbeddedPoint& embedded(Index vertex) const { return points_[vertex]; }
  const Lattice& lattice() const { return *lattice_; }
  const Vec3& rest(Index vertex) const { return rest_[vertex]; }
  std::array<Vec3, 3> rest_of(Index triangle) const;
  // Edge k of a triangle joins its corners k and k + 1.
  const std::array<Index, 3>& edges_of(Index triangle) const { return edges_of_triangle_[triangle]; }
  // Of a vertex and a face, and of two edges: their vertices.
  std::array<Index, 4> corners_of(Index vertex, Index face) const {
    const auto& [p, q, r] = triangles_[face];
    return {vertex, p, q, r};
  }
  std::array<Index, 4> ends_of(Index edge, Index other) const {
    return {edges_[edge][0], edges_[edge][1], edges_[other][0], edges_[other][1]};
  }
  // The two triangles at an edge; -1 where there is no second.
  const std::array<Index, 2>& triangles_at(Index edge) const { return triangles_of_edge_[edge]; }
  // The triangles at a vertex.
  std::span<const Index> triangles_around(Index vertex) const { return around_[vertex]; }
  // Each vertex and each edge belongs to one of its triangles: bit k for corner k, bit 3 + k for edge k.
  bool owns_vertex(Index triangle, int k) const { return owned_[triangle] >> k & 1; }
  bool owns_edge(Index triangle, int k) const { return owned_[triangle] >> (3 + k) & 1; }

  double area(Index vertex) const { return area_of_vertex_[vertex]; }    // a third of its triangles, mm^2, or the least
  double area_of_edge(Index edge) const { return area_of_edge_[edge]; }  // likewise
  // From where on the barrier of a vertex and a face acts; 0: they do not count.
  double reach_to(Index vertex, Index triangle) const;
  // Of two edges; 0: they do not count.
  double reach_of(Index edge, Index other) const;

  // The tree over its triangles, at rest until it is refitted.
  const BoxTree& tree() const { return tree_; }
  void refit(std::span<const Vec3> places, std::span<const Vec3> ways, std::span<const std::uint8_t> marked = {}) {
    tree_.refit(places, ways, marked);
  }
  // Where the vertices are, and what a field of displacements moves them by.
  template <class Real>
  void positions(std::span<const Real> u, std::vector<Vec3>& result) const;
  template <class Real>
  void displacements(std::span<const Real> u, std::vector<Vec3>& result) const;
  std::size_t bytes() const;

 private:
  void find_edges();
  void find_areas();

  const Lattice* lattice_;
  const Lattice* whole_;                   // the same, unless that is a subdomain
  std::vector<EmbeddedPoint> own_points_;  // of a subdomain
  std::vector<Vec3> still_;                // where its vertices are that do not move; empty: all may
  std::span<const EmbeddedPoint> points_;
  double reach_;
  std::vector<Vec3> rest_;
  std::vector<std::array<Index, 3>> triangles_, edges_of_triangle_;
  std::vector<Edge> edges_;
  std::vector<std::array<Index, 2>> triangles_of_edge_;
  Groups around_;
  std::vector<std::uint8_t> owned_;
  std::vector<double> area_of_vertex_, area_of_edge_;
  BoxTree tree_;
};

}  // namespace lappet
