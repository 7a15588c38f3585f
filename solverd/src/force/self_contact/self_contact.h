// Contact of the tissue's surface with itself: a barrier between vertices and faces and between edges
// (contact_pairs.h, barrier.h), friction if there is any (contact_friction.h), and the largest step that takes nothing
// through anything (continuous_collision.h). A state whose surface does not go through itself stays so; where a search
// begins with one that does, the pairs at those places are left out and counted.
#pragma once
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "force/constraints/sparse_rows.h"
#include "force/self_contact/contact_friction.h"
#include "force/self_contact/contact_tangent.h"

namespace lappet {

// What the surface does to itself in a state of displacements.
struct SelfContactState {
  std::vector<TouchingPair> pairs;
  std::vector<SlidingPair> sliding;
  double energy = 0.0;  // mN mm

  bool touches() const { return !pairs.empty(); }
};

class SelfContact {
 public:
  // modulus: Young's, of the tissue, kPa; friction: Coulomb's coefficient. Keeps a reference to the lattice, not to the
  // surface.
  SelfContact(const Lattice& lattice, const Surface& surface, double modulus, double friction = 0.0,
              const Interrupt& interrupt = {});
  // The same where only a subdomain of the lattice moves, of a contact without friction: see ContactSurface.
  template <class Real>
  SelfContact(const SelfContact& whole, const Lattice& subdomain, std::span<const Index> place_of_cell,
              std::span<const Real> u)
      : surface_(whole.surface_, subdomain, place_of_cell, u),
        candidates_(whole.candidates_, surface_),
        stiffness_(whole.stiffness_),
        friction_(0.0, 1.0) {}
  SelfContact(const SelfContact&) = delete;
  SelfContact& operator=(const SelfContact&) = delete;

  // How often edges go through faces at u.
  template <class Real>
  std::size_t count_piercings(std::span<const Real> u);
  // Leaves out the pairs at these places from now on, and those that lie on each other, but no others. Returns how many
  // such places there are. Friction counts slides from here on.
  template <class Real>
  std::size_t begin(std::span<const Real> u);

  // Takes the surface apart where it goes through itself by little (untangling.h, contour_shortening.h), by nodes of
  // which `moves` tells.
  // Returns at how many places: all, or all but a few. 0, and u as it was, where it goes through nothing or cannot be
  // taken apart.
  template <class Real>
  std::size_t untangle(std::span<Real> u, const std::function<bool(Index)>& moves);

  // Whether the surface neither goes through itself nor presses on itself at u.
  template <class Real>
  bool is_apart(std::span<const Real> u);

  // Adds the gradient of the energy (3 per node). The same for any number of threads.
  template <class Real>
  void evaluate(std::span<const Real> u, std::span<double> gradient, SelfContactState& state);
  // What presses at a state rubs with that force from now on; false where there is no friction.
  bool look_for_friction(const SelfContactState& state);
  // What presses rubs with a share of its force, and with the rest what did at the looks before.
  void mix_friction(double share) { friction_.mix_with_looks_before(share); }
  // The definite part of the tangent at a state: first one row for each pair, then the others (contact_tangent.h).
  SparseRows rows(const SelfContactState& state) const;
  // By what the exact tangent is less.
  SparseRows negative_rows(std::span<const TouchingPair> pairs) const;
  // Adds the gradient of their energy (3 per node).
  void add_gradient(std::span<const TouchingPair> pairs, std::span<double> gradient) const;
  // Where a row's pair touches, at its first side, and where the vertex of that and of the other side is embedded that
  // weighs most.
  struct Place {
    Vec3 normal = Vec3::Zero();
    Vec3 at = Vec3::Zero();  // rest, mm
    Index cell = -1, other_cell = -1;
  };
  std::vector<Place> places(std::span<const TouchingPair> pairs) const;

  // The share of a step, `most` at most, on which no distance falls below a share of what it is.
  template <class Real>
  double largest_step(std::span<const Real> u, std::span<const Real> step, double most);

  // Whether a subdomain knows what it touches: not where that rubs.
  bool acts_in_subdomains() const { return !friction_.acts(); }
  double stiffness() const { return stiffness_; }
  // Of two walls that sutures hold together, mm: they touch, and do not press on each other yet.
  double distance_of_walls() const { return surface_.reach(); }
  const ContactSurface& surface() const { return surface_; }
  const ContactCandidates& candidates() const { return candidates_; }
  std::size_t bytes() const { return surface_.bytes() + candidates_.bytes() + friction_.bytes(); }

 private:
  // One that moves nodes at piercings; false where it finds none to move.
  using Round = std::function<bool(std::span<const Piercing>, std::span<double>)>;

  template <class Real>
  std::size_t take_apart(std::span<Real> u, int most_in_vain, std::size_t enough, const Round& round);
  void add_row(const std::array<Index, 4>& vertices, const TangentRow& row, SparseRows& to) const;
  void add_force(Index vertex, const Vec3& force, std::span<double> gradient) const;
  // Writes where a step begins and goes, and finds the candidates for it.
  template <class Real>
  void cover(std::span<const Real> u, std::span<const Real> step, double most);

  ContactSurface surface_;
  ContactCandidates candidates_;
  double stiffness_;
  ContactFriction friction_;
  std::vector<Vec3> places_, ways_;  // to write in
  std::vector<Vec3> in_vain_at_;     // where nothing was taken apart, as a frame begins where the one before ended
};

}  // namespace lappet
