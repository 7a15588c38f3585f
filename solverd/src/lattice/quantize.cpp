#include "lattice/quantize.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "lattice/refused.h"

namespace lappet {
namespace {

constexpr int kMaxRatio = 32;  // r^3 labels fit 16 bits

}  // namespace

void check_input(const Surface& surface, const LatticeSettings& settings) {
  if (!(std::isfinite(settings.spacing) && settings.spacing > 0.0))
    refuse("The lattice spacing is " + shown(settings.spacing) + " mm; give a positive number.");
  if (settings.fine_ratio < 1 || settings.fine_ratio > kMaxRatio)
    refuse("The fine ratio is " + std::to_string(settings.fine_ratio) + "; give 1 to " + std::to_string(kMaxRatio) +
           " voxels per cell edge (4 to 10 are usual).");
  if (!(std::isfinite(settings.fill_floor) && settings.fill_floor > 0.0 && settings.fill_floor <= 1.0))
    refuse("The least fill of a cell is " + shown(settings.fill_floor) + "; give a fraction above 0 and at most 1.");
  if (!settings.origin.allFinite()) refuse("The lattice origin is not finite; give three numbers in mm.");
  if (surface.points.empty() || surface.triangles.empty()) refuse("The tissue surface is empty; give a closed mesh.");
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    if (!surface.points[i].allFinite())
      refuse("Point " + std::to_string(i) + " of the tissue surface is not finite (" + shown(surface.points[i].x()) +
             ", " + shown(surface.points[i].y()) + ", " + shown(surface.points[i].z()) + "); remove or repair it.");
  const std::int64_t count = surface.points.size();
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (const Index p : surface.triangles[t])
      if (p < 0 || p >= count)
        refuse("Triangle " + std::to_string(t) + " of the tissue surface names point " + std::to_string(p) +
               ", but there are " + std::to_string(count) + " points.");
}

Quantized quantize(const Surface& surface, const LatticeSettings& settings) {
  Quantized result;
  const std::int64_t cell = settings.fine_ratio * kSteps;
  result.points.resize(surface.points.size());
  StepPoint low, high;
  low.fill(std::numeric_limits<std::int64_t>::max());
  high.fill(std::numeric_limits<std::int64_t>::min());
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      const Eigen::Index axis = a;
      const double steps = (surface.points[i][axis] - settings.origin[axis]) / settings.spacing * double(cell);
      if (std::abs(steps) > 1e15)
        refuse("Point " + std::to_string(i) + " of the tissue surface lies " +
               shown(surface.points[i][axis] - settings.origin[axis]) +
               " mm from the lattice origin, too far for this spacing; move the origin to the tissue.");
      result.points[i][a] = std::llround(steps);
      low[a] = std::min(low[a], result.points[i][a]);
      high[a] = std::max(high[a], result.points[i][a]);
    }
  result.box.ratio = settings.fine_ratio;
  StepPoint shift;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t first = std::floor(double(low[a]) / double(cell));
    const std::int64_t last = std::ceil(double(high[a]) / double(cell));
    if (std::max(std::abs(first), std::abs(last)) > std::numeric_limits<std::int32_t>::max() / kMaxRatio)
      refuse("The tissue lies too far from the lattice origin for a spacing of " + shown(settings.spacing) +
             " mm; move the origin to the tissue.");
    result.box.low[a] = std::int32_t(first);
    result.box.cells[a] = std::int32_t(std::max<std::int64_t>(1, last - first));
    shift[a] = first * cell;
  }
  for (StepPoint& p : result.points)
    for (std::size_t a = 0; a < 3; ++a) p[a] -= shift[a];
  return result;
}

}  // namespace lappet
