#include "lattice/memory_estimate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "lattice/refused.h"
#include "lattice/voxel_box.h"

namespace lappet {
namespace {

std::string gibibytes(double bytes) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g GiB", bytes / (1024.0 * 1024.0 * 1024.0));
  return text.data();
}

std::string millimeters(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g mm", value);
  return text.data();
}

// Rounded up to two significant digits.
double round_up(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::ceil(value / unit - 1e-9) * unit;
}

bool fits(const SurfaceMeasure& measure, double spacing, int ratio, double budget) {
  return estimate_bytes(measure, spacing, ratio) <= budget &&
         (measure.high - measure.low).maxCoeff() / spacing * ratio + 2.0 * ratio < double(kMaxVoxelsPerAxis);
}

}  // namespace

SurfaceMeasure measure(const Surface& surface) {
  SurfaceMeasure result;
  if (surface.points.empty()) return result;
  result.low = result.high = surface.points.front();
  for (const Vec3& p : surface.points) {
    result.low = result.low.cwiseMin(p);
    result.high = result.high.cwiseMax(p);
  }
  const Vec3 middle = 0.5 * (result.low + result.high);
  for (const auto& t : surface.triangles) {
    const Vec3 a = surface.points[t[0]] - middle;
    const Vec3 b = surface.points[t[1]] - middle;
    const Vec3 c = surface.points[t[2]] - middle;
    result.projected_area += 0.5 * (b - a).cross(c - a).cwiseAbs();
    result.volume += a.dot(b.cross(c)) / 6.0;
  }
  return result;
}

double estimate_bytes(const SurfaceMeasure& measure, double spacing, int fine_ratio) {
  const double r = fine_ratio, voxel = spacing / r;
  const Vec3 cells = (measure.high - measure.low) / spacing + Vec3::Ones();
  const double box = cells.prod();
  const double crossings = measure.projected_area.sum() / (voxel * voxel);
  const double lines = box / cells.minCoeff() * r * r;
  // A plane meets (sum of its projected areas) / h^2 cells; a crossing may touch a neighbor, too.
  const double touched = std::min(box, 1.3 * measure.projected_area.sum() / (spacing * spacing));
  const double occupied = std::min(box, std::abs(measure.volume) / std::pow(spacing, 3) + touched);
  const double per_crossing = 16.0 + 6.0 + 4.0 + 8.0;           // crossing, inner voxel, order on its line, its reach
  const double per_touched = 4.0 * r * r * r / 8.0 + 72.0;      // four bit masks
  const double per_occupied = 2.0 * 32.0 + 16.0 + 48.0 + 96.0;  // corner equivalence, cell, and its share of nodes
  return 4.0 * box + 8.0 * lines + per_crossing * crossings + per_touched * touched + per_occupied * occupied;
}

void check_memory(const SurfaceMeasure& measure, const LatticeSettings& settings) {
  const auto budget = double(settings.memory_budget);
  const double h = settings.spacing;
  if (fits(measure, h, settings.fine_ratio, budget)) return;
  const double bytes = estimate_bytes(measure, h, settings.fine_ratio);
  const Vec3 size = measure.high - measure.low;
  std::string sentence = "A lattice of spacing " + millimeters(h) + " with " + std::to_string(settings.fine_ratio) +
                         " voxels per cell edge needs about " + gibibytes(bytes) + " for this tissue of " +
                         millimeters(size.x()) + " x " + millimeters(size.y()) + " x " + millimeters(size.z());
  sentence += bytes > budget ? ", more than the memory budget of " + gibibytes(budget)
                             : ", and more than " + std::to_string(kMaxVoxelsPerAxis) + " voxels along one side";
  double coarser = h;
  while (!fits(measure, coarser, settings.fine_ratio, budget) && coarser < 1e6 * h) coarser *= 1.02;
  sentence += ": use a spacing of at least " + millimeters(round_up(coarser));
  int lower_ratio = settings.fine_ratio - 1;
  while (lower_ratio >= 2 && !fits(measure, h, lower_ratio, budget)) --lower_ratio;
  if (lower_ratio >= 2) sentence += ", or a fine ratio of at most " + std::to_string(lower_ratio);
  throw RefusedError(ErrorCode::kMemoryBudget, sentence + ".");
}

}  // namespace lappet
