// The pairs of primitives that may come near each other, for a state and a straight way on from it. They are kept, with
// a slack, and found anew only for vertices that lie farther than that off the ways that they were found for.
#pragma once
#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

#include "force/self_contact/contact_surface.h"

namespace lappet {

struct VertexFacePair {
  Index vertex, face;
  double reach;               // mm
  Eigen::Vector3f direction;  // in which they were apart when they were found, no longer than a unit
};
struct EdgePair {
  Index first, second;        // first < second
  double reach;               // mm
  Eigen::Vector3f direction;  // likewise
};

// An edge of the surface that goes through a face of it.
struct Piercing {
  Index edge, face;
  auto operator<=>(const Piercing&) const = default;
};

class ContactCandidates {
 public:
  // slack: mm. Keeps a reference to the surface.
  ContactCandidates(ContactSurface& surface, double slack) : surface_(surface), slack_(slack) {}
  // Of those of the whole the ones that have a vertex that moves, of a surface of which only a subdomain does.
  ContactCandidates(const ContactCandidates& whole, ContactSurface& subdomain);
  ContactCandidates(const ContactCandidates&) = delete;
  ContactCandidates& operator=(const ContactCandidates&) = delete;

  // Where edges go through faces in a state, places of the vertices, in order. Refits the tree.
  const std::vector<Piercing>& piercings(const std::vector<Vec3>& places);
  // From now on leaves out the pairs of the faces at these edges with those that they go through, those that lie on
  // each other in a state, and no others. Returns the number of the latter.
  std::size_t leave_out(std::span<const Piercing> piercings, const std::vector<Vec3>& places);
  std::size_t left_out() const { return faces_left_out_.size() + edges_left_out_.size(); }

  // Finds them anew, unless those that are known hold all the way.
  void cover(const std::vector<Vec3>& places, const std::vector<Vec3>& ways);
  // The same for a state alone.
  void cover(const std::vector<Vec3>& places);

  // Those that may come within their reach; sorted by vertex, and by the first edge.
  const std::vector<VertexFacePair>& vertex_faces() const { return vertex_faces_; }
  const std::vector<EdgePair>& edges() const { return edges_; }
  std::int64_t searches() const { return searches_; }
  std::size_t bytes() const;

 private:
  // What is found in a chunk of the tree.
  struct Found {
    std::vector<VertexFacePair> vertex_faces;
    std::vector<EdgePair> edges;
  };
  static std::uint64_t key(Index a, Index b) { return std::uint64_t(std::uint32_t(a)) << 32 | std::uint32_t(b); }

  double share_of_way(std::span<const Vec3> places, std::span<const Vec3> ways) const;
  // Whether a state lies within the slack of the way that the candidates hold for.
  bool holds_at(std::span<const Vec3> places, std::span<const Vec3> ways) const;
  // Marks the vertices that do not stay within the slack of where the candidates hold, and takes their places and ways;
  // of all where none hold.
  void take_over(const std::vector<Vec3>& places, const std::vector<Vec3>& ways);
  // Finds the pairs of marked vertices.
  void search();
  bool is_marked(const std::array<Index, 4>& vertices) const {
    return marked_[vertices[0]] || marked_[vertices[1]] || marked_[vertices[2]] || marked_[vertices[3]];
  }
  void add_vertices(Index of, Index face, Found& to) const;
  void add_edges(Index triangle, Index other, Found& to) const;

  ContactSurface& surface_;
  double slack_;
  std::unordered_set<std::uint64_t> faces_left_out_, edges_left_out_;
  std::vector<Vec3> from_, ways_;  // the way that they hold for; empty: for none
  std::vector<std::uint8_t> marked_;
  std::vector<VertexFacePair> vertex_faces_;
  std::vector<EdgePair> edges_;
  std::int64_t searches_ = 0;
  // Where piercings were looked for last, and what was found: a frame begins where the one before ended.
  std::vector<Vec3> looked_at_;
  std::vector<Piercing> piercings_;
};

}  // namespace lappet
