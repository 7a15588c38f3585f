// Coulomb's friction where the surface presses on itself, smoothed and lagged as in Li et al. (2020, "Incremental
// Potential Contact", sec. 5.4): with the normal force N, the normal and the closest points of the last look, a pair
// that has slid by s across its normal since `begin` has the energy mu N f(|s|), whose slope grows from 0 to
// mu N over a small slide and stays. So what holds has crept by up to that slide. The searches of a frame look again
// until forces balance with what presses then.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "force/self_contact/contact_pairs.h"
#include "force/self_contact/contact_tangent.h"

namespace lappet {

// A pair that slides or is held from sliding.
struct SlidingPair {
  std::array<Index, 4> vertices;
  std::array<double, 4> weights;
  double energy;              // mN mm
  Vec3 slope;                 // of the energy to the slide, mN
  std::array<Vec3, 2> roots;  // of its second derivative: the sum of r r^T, sqrt(mN/mm)
};

class ContactFriction {
 public:
  // coefficient: mu; slide: from which on friction is whole, mm.
  ContactFriction(double coefficient, double slide) : coefficient_(coefficient), slide_(slide) {}

  bool acts() const { return coefficient_ > 0.0; }
  // Slides are counted from here on, where nothing is known to press.
  void begin(std::span<const Vec3> places);
  // These press.
  void look(std::span<const TouchingPair> pairs);
  // Of what presses a share, the rest of what did at the looks before: two looks may each lead to the other.
  void mix_with_looks_before(double share);
  std::vector<SlidingPair> sliding(std::span<const Vec3> places) const;
  std::size_t bytes() const {
    return from_.size() * sizeof(Vec3) + (pressed_.size() + before_.size()) * sizeof(Pressed);
  }

 private:
  struct Pressed {
    std::array<Index, 4> vertices;
    std::array<double, 4> weights;
    Vec3 normal;
    double force;  // mN
  };

  double coefficient_, slide_;
  std::vector<Vec3> from_;
  std::vector<Pressed> pressed_, before_;
};

// The rows of the tangent of a pair (contact_tangent.h).
std::array<TangentRow, 2> rows_of(const SlidingPair& pair);

}  // namespace lappet
