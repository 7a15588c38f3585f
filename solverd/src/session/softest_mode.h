// The softest displacement of an equilibrium, which tells a saddle of the energy from a minimum.
#pragma once
#include <limits>
#include <vector>

#include "session/epoch_system.h"
#include "solve/newton/lowest_mode.h"

namespace lappet {

template <class Real>
class SoftestMode {
 public:
  explicit SoftestMode(EpochSystem<Real>& epoch) : epoch_(epoch) {}

  // Looks for it at an equilibrium. Where the coarse level cannot be had nothing is known.
  void find(const LowestModeSearch& search, std::span<const Real> u, const Evaluation& at);
  // The share of its stiffness that it keeps; NaN where nothing is known.
  double stiffness() const { return stiffness_; }
  bool is_of_saddle() const { return stiffness_ < kSaddle; }
  // Where the energy falls to neither side of it, as far as that can be told.
  void take_as_neutral() { stiffness_ = std::max(stiffness_, 0.0); }
  // Empty where nothing is known.
  std::span<const Real> shape() const { return shape_; }
  // The rest point of the surface that moves most in it.
  Vec3 place() const;

 private:
  // Less, chosen above the rounding of single precision, is a saddle's.
  static constexpr double kSaddle = -1e-3;

  EpochSystem<Real>& epoch_;
  double stiffness_ = std::numeric_limits<double>::quiet_NaN();
  std::vector<Real> shape_;
};

}  // namespace lappet
