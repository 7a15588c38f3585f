#include "force/materials/cell_materials.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "force/materials/cell_fill.h"
#include "force/materials/cell_shares.h"
#include "force/materials/prestretch.h"
#include "force/materials/skin_tree.h"

namespace lappet {

namespace {

constexpr std::size_t kCellsPerChunk = 256;

// The normals of a surface's points: those of the triangles around, by their area.
std::vector<Vec3> point_normals(const Surface& surface) {
  std::vector<Vec3> normals(surface.points.size(), Vec3::Zero());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const auto& points = surface.points;
    const Vec3 normal = (points[b] - points[a]).cross(points[c] - points[a]);
    for (const Index p : surface.triangles[t]) normals[p] += normal;
  }
  for (Vec3& normal : normals) normal.normalize();
  return normals;
}

bool has_direction(const MaterialParameters& m) { return m.has_fibers() || m.has_muscle() || m.has_prestretch(); }

// Whether the normal z, which holds where none is kept, serves every cell as well.
bool flat(const CellMaterials& materials) {
  const auto is_z = [](const Eigen::Vector3f& n) { return std::abs(n[2]) > 1.0F - 1e-6F; };
  const auto lies_flat = [](const MaterialParameters& m) {
    return !has_direction(m) || (direction_in_plane(m, Vec3::UnitZ()) - m.fiber_direction.normalized()).norm() < 1e-6;
  };
  return std::ranges::all_of(materials.normal_of_cell, is_z) && std::ranges::all_of(materials.table, lies_flat);
}

// A direction in the skin's plane; 0 where there is none.
Vec3 in_plane(const Vec3& direction, const Vec3& normal) {
  const Vec3 flat = direction - normal.dot(direction) * normal;
  return flat.norm() > 1e-3 ? flat.normalized() : Vec3(Vec3::Zero());
}

constexpr auto kPartlyFilled = [](float fill) { return fill != 1.0F; };

// Of tissue of one material.
std::vector<MaterialShare> shares_of_fills(const Lattice& lattice) {
  std::vector<MaterialShare> shares;
  for (std::size_t c = 0; c < lattice.cell_fill.size(); ++c)
    if (kPartlyFilled(lattice.cell_fill[c]))
      if (const auto share = share_of_fill(lattice, c, 0)) shares.push_back(*share);
  return shares;
}

// Makes two halves of every share whose material has two families of fibers, and of every cell that has no shares.
void split_families(const Lattice& lattice, CellMaterials& materials) {
  if (std::ranges::none_of(materials.table, &MaterialParameters::has_families)) return;
  const std::size_t count = lattice.cell_nodes.size();
  if (materials.of_cell.empty()) materials.of_cell.assign(count, 0);
  std::vector<MaterialShare> split;
  const auto add = [&](MaterialShare share) {
    if (!materials.table[share.material].has_families()) return split.push_back(share);
    share.volume *= 0.5F;
    for (const int family : {1, -1}) {
      share.family = std::int8_t(family);
      split.push_back(share);
    }
  };
  const Eigen::Vector3f whole = Eigen::Vector3f::Ones(), middle = Eigen::Vector3f::Zero();
  auto known = materials.shares.begin();
  for (std::size_t c = 0; c < count; ++c) {
    if (known != materials.shares.end() && known->cell == to_index(c))
      for (; known != materials.shares.end() && known->cell == to_index(c); ++known) add(*known);
    else if (materials.table[materials.of_cell[c]].has_families())
      add({to_index(c), materials.of_cell[c], 1.0F, middle, whole});
  }
  materials.shares = std::move(split);
}

}  // namespace

CellMaterials assign_materials(const Lattice& lattice, std::vector<MaterialParameters> table, const Surface& skin,
                               std::span<const MaterialRegion> regions, const SkinFields& fields,
                               const Interrupt& interrupt, std::span<const Strand> strands) {
  CellMaterials result{std::move(table)};
  const bool directional = std::ranges::any_of(result.table, has_direction);
  if (regions.empty() || skin.triangles.empty()) result.shares = shares_of_fills(lattice);
  if ((regions.empty() && !directional) || skin.triangles.empty()) {
    lay_strands(lattice, strands, result, interrupt);
    split_families(lattice, result);
    return result;
  }
  const SkinTree tree(skin);
  const CellShares cell_shares(lattice, tree, regions);
  const std::size_t count = lattice.cell_nodes.size();
  if (!regions.empty()) result.of_cell.assign(count, 0);
  std::vector<Vec3> normals;
  if (directional) {
    result.normal_of_cell.resize(count);
    normals = point_normals(skin);
    if (!fields.directions.empty()) result.direction_of_cell.resize(count);
    if (!fields.stretch.empty()) result.stretch_of_cell.resize(count);
  }
  const double h = lattice.settings.spacing;
  std::vector<std::vector<MaterialShare>> chunks((count + kCellsPerChunk - 1) / kCellsPerChunk);
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t chunk) {
    interrupt.check();
    for (std::size_t c = chunk * kCellsPerChunk; c < std::min(count, (chunk + 1) * kCellsPerChunk); ++c) {
      const auto& [x, y, z] = lattice.cell_position(c);
      const SkinTree::Closest closest = tree.closest(lattice.settings.origin + h * Vec3(x + 0.5, y + 0.5, z + 0.5));
      if (directional) {
        const Vec3 normal = tree.interpolate(closest, normals).normalized();
        result.normal_of_cell[c] = normal.cast<float>();
        if (!fields.directions.empty())
          result.direction_of_cell[c] = in_plane(tree.interpolate(closest, fields.directions), normal).cast<float>();
        if (!fields.stretch.empty()) {
          Eigen::Vector2d stretch = Eigen::Vector2d::Zero();
          for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t i = 0; i < 2; ++i)
              stretch[i] += closest.weights[k] * fields.stretch[skin.triangles[closest.triangle][k]][i];
          result.stretch_of_cell[c] = stretch.cast<float>();
        }
      }
      if (regions.empty()) continue;
      const std::uint8_t material = cell_shares.material(closest.triangle, closest.distance);
      const bool mixed = cell_shares.may_be_mixed(c, closest);
      result.of_cell[c] = material;
      if (mixed || kPartlyFilled(lattice.cell_fill[c]))
        result.of_cell[c] = cell_shares.append(c, mixed, material, chunks[chunk]);
    }
  });
  for (const auto& chunk : chunks) result.shares.insert(result.shares.end(), chunk.begin(), chunk.end());
  lay_strands(lattice, strands, result, interrupt);
  split_families(lattice, result);
  if (result.direction_of_cell.empty() && flat(result)) result.normal_of_cell.clear();
  return result;
}

}  // namespace lappet
