// The signed distance of rigid bodies, negative inside, as a smooth function that is quick to evaluate: exact distances
// to the triangles at the nodes of a regular grid near the surface, interpolated by quadratic B-splines.
//
// The interpolant is once continuously differentiable and its gradient is its own exact derivative, so a force made of
// it belongs to an energy. Planes are reproduced exactly; where the surface has the curvature 2 H the value is off by
// s^2 H / 4 at most (s: node spacing), and an edge is rounded by about s / 5.
//
// The sign is the winding number along lines through the nodes, decided in exact integers (lattice/crossings.h): it
// does not depend on how the faces are oriented, and bodies may touch or overlap. Faces where two bodies touch, the
// triangles of the one being those of the other turned around, are inside and count as no surface.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "lattice/interrupt.h"
#include "lattice/surface.h"

namespace lappet {

class SignedDistance {
 public:
  struct Sample {
    double value;   // mm
    Vec3 gradient;  // d value / d x; zero where the value is cut off
  };

  // spacing: of the nodes, mm. depth: values are cut off at -depth, mm. Throws RefusedError(kMemoryBudget) where the
  // grid would need more bytes than allowed, and (kInvalidInput) for a surface that no integers of this spacing hold.
  SignedDistance(const Surface& surface, double spacing, double depth, std::size_t memory_budget,
                 const Interrupt& interrupt = {});

  Sample at(const Vec3& point) const;
  double depth() const { return depth_; }
  double reach() const { return reach_; }  // values are cut off at +reach
  double spacing() const { return spacing_; }
  std::size_t bytes() const { return values_.size() * sizeof(float) + block_.size() * sizeof(std::int32_t); }

 private:
  double spacing_, depth_, reach_;
  Vec3 first_node_ = Vec3::Zero();
  std::array<std::int32_t, 3> blocks_{};
  std::vector<Index> block_;   // per place: its number; negative where the value is cut off throughout
  std::vector<float> values_;  // of the nodes of each block and those around them
};

}  // namespace lappet
