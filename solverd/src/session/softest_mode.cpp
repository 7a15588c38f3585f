#include "session/softest_mode.h"

#include <utility>

namespace lappet {

template <class Real>
void SoftestMode<Real>::find(const LowestModeSearch& search, std::span<const Real> u, const Evaluation& at) {
  try {
    auto found = find_lowest_mode<Real>(epoch_.system, epoch_.preconditioner, u, at, search);
    stiffness_ = found.stiffness;
    shape_ = std::move(found.shape);
  } catch (const NotDefiniteError&) {
    stiffness_ = std::numeric_limits<double>::quiet_NaN();
    shape_.clear();
  }
}

template <class Real>
Vec3 SoftestMode<Real>::place() const {
  const auto& points = epoch_.lattice.surface_points;
  std::size_t softest = 0;
  double most = 0.0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double length = displacement<Real>(epoch_.lattice, points[k], shape()).squaredNorm();
    if (length > most) {
      most = length;
      softest = k;
    }
  }
  return epoch_.surface.points[softest];
}

template class SoftestMode<float>;
template class SoftestMode<double>;

}  // namespace lappet
