#include "force/materials/strands.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "force/materials/cell_fill.h"

namespace lappet {

namespace {

constexpr std::size_t kCellsPerChunk = 4096;
// Where a strand tapers to a point the fibers would turn ever steeper towards it.
constexpr double kMinRadius = 1e-3;  // mm

Eigen::AlignedBox3d box_around(const Strand& strand) {
  Eigen::AlignedBox3d box;
  for (std::size_t k = 0; k < strand.points.size(); ++k) {
    box.extend(strand.points[k] - Vec3::Constant(strand.radii[k]));
    box.extend(strand.points[k] + Vec3::Constant(strand.radii[k]));
  }
  return box;
}

// Of the curve at a point: the mean of the directions before and after it.
Vec3 tangent(const Strand& strand, std::size_t k) {
  Vec3 sum = Vec3::Zero();
  if (k > 0) sum += (strand.points[k] - strand.points[k - 1]).normalized();
  if (k + 1 < strand.points.size()) sum += (strand.points[k + 1] - strand.points[k]).normalized();
  return sum.normalized();
}

struct Laid {
  std::int32_t strand = -1;
  Vec3 fiber = Vec3::Zero();
};

// The shares that cells have apart from strands, and those of cells that hold one and are not full of tissue.
std::vector<MaterialShare> shares_with(const Lattice& lattice, std::span<const Strand> strands,
                                       std::span<const Laid> laid, std::span<const MaterialShare> before) {
  std::vector<MaterialShare> shares;
  auto next = before.begin();
  for (std::size_t c = 0; c < laid.size(); ++c) {
    const bool is_laid = laid[c].strand >= 0;
    for (; next != before.end() && next->cell == to_index(c); ++next)
      if (!is_laid) shares.push_back(*next);
    if (!is_laid || lattice.cell_fill[c] == 1.0F) continue;
    const auto material = std::uint8_t(strands[static_cast<std::size_t>(laid[c].strand)].material);
    if (const auto share = share_of_fill(lattice, c, material)) shares.push_back(*share);
  }
  return shares;
}

}  // namespace

InStrand in_strand(const Strand& strand, const Vec3& point) {
  InStrand found{std::numeric_limits<double>::infinity(), Vec3::Zero()};
  for (std::size_t k = 0; k + 1 < strand.points.size(); ++k) {
    const Vec3 &a = strand.points[k], along = strand.points[k + 1] - a;
    const double length = along.norm();
    if (!(length > 0.0)) continue;
    const double t = std::clamp((point - a).dot(along) / (length * length), 0.0, 1.0);
    const double radius = std::max((1.0 - t) * strand.radii[k] + t * strand.radii[k + 1], kMinRadius);
    const Vec3 off = point - a - t * along;
    const double share = off.norm() / radius;
    if (!(share < found.share)) continue;
    const Vec3 course = ((1.0 - t) * tangent(strand, k) + t * tangent(strand, k + 1)).normalized();
    const double taper = (strand.radii[k + 1] - strand.radii[k]) / length;
    found = {share, (course + taper / radius * off).normalized()};
  }
  return found;
}

void lay_strands(const Lattice& lattice, std::span<const Strand> strands, CellMaterials& materials,
                 const Interrupt& interrupt) {
  if (strands.empty()) return;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Strand& strand : strands) boxes.push_back(box_around(strand));
  const std::size_t count = lattice.cell_nodes.size();
  const double h = lattice.settings.spacing;
  std::vector<Laid> laid(count);
  tbb::parallel_for(std::size_t{0}, (count + kCellsPerChunk - 1) / kCellsPerChunk, [&](std::size_t chunk) {
    interrupt.check();
    for (std::size_t c = chunk * kCellsPerChunk; c < std::min(count, (chunk + 1) * kCellsPerChunk); ++c) {
      const auto& [x, y, z] = lattice.cell_position(c);
      const Vec3 middle = lattice.settings.origin + h * Vec3(x + 0.5, y + 0.5, z + 0.5);
      double deepest = 1.0;
      for (std::size_t k = 0; k < strands.size(); ++k) {
        if (!boxes[k].contains(middle)) continue;
        const InStrand found = in_strand(strands[k], middle);
        if (!(found.share < deepest)) continue;
        deepest = found.share;
        laid[c] = {static_cast<std::int32_t>(k), found.fiber};
      }
    }
  });
  if (materials.of_cell.empty()) materials.of_cell.assign(count, 0);
  if (materials.direction_of_cell.empty()) materials.direction_of_cell.assign(count, Eigen::Vector3f::Zero());
  for (std::size_t c = 0; c < count; ++c) {
    if (laid[c].strand < 0) continue;
    materials.of_cell[c] = std::uint8_t(strands[static_cast<std::size_t>(laid[c].strand)].material);
    materials.direction_of_cell[c] = laid[c].fiber.cast<float>();
  }
  materials.shares = shares_with(lattice, strands, laid, materials.shares);
}

}  // namespace lappet
