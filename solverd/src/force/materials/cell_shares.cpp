#include "force/materials/cell_shares.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "force/materials/cell_fill.h"

namespace lappet {

namespace {

constexpr double kMinShare = 0.01;  // of a cell's tissue; less joins the others
constexpr double kMargin = 1.1;     // for what a curved skin adds to the reach of a cell

// Edges between triangles that differ in the regions they belong to.
Surface border_of(const Surface& skin, std::span<const MaterialRegion> regions) {
  const auto same = [&](Index a, Index b) {
    return std::ranges::all_of(regions, [&](const MaterialRegion& r) { return r.faces[a] == r.faces[b]; });
  };
  Surface border;
  border.points = skin.points;
  std::map<std::pair<Index, Index>, Index> open;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = skin.triangles[t][k], b = skin.triangles[t][(k + 1) % 3];
      const auto [at, fresh] = open.emplace(std::minmax(a, b), to_index(t));
      if (!fresh && !same(at->second, to_index(t))) border.triangles.push_back({a, b, b});
    }
  return border;
}

}  // namespace

// Moments of the tissue of one material.
struct CellShares::Sum {
  std::uint8_t material;
  double volume = 0.0;
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();
};

CellShares::CellShares(const Lattice& lattice, const SkinTree& skin, std::span<const MaterialRegion> regions)
    : lattice_(lattice), skin_(skin), regions_(regions) {
  bool uniform = true;
  for (const auto& region : regions) {
    if (region.from_depth > 0.0) boundaries_.push_back(region.from_depth);
    if (std::isfinite(region.to_depth)) boundaries_.push_back(region.to_depth);
    uniform = uniform && std::ranges::all_of(region.faces, [&](std::uint8_t f) { return f == region.faces[0]; });
  }
  if (uniform) return;
  border_ = border_of(skin.skin(), regions);
  if (!border_.triangles.empty()) border_tree_ = std::make_unique<SkinTree>(border_);
}

bool CellShares::may_be_mixed(std::size_t cell, const SkinTree::Closest& center) const {
  const double h = lattice_.settings.spacing;
  const auto& [x, y, z] = lattice_.cell_position(cell);
  const Vec3 middle = lattice_.settings.origin + h * Vec3(x + 0.5, y + 0.5, z + 0.5);
  const Vec3 foot = skin_.interpolate(center, skin_.skin().points);
  const double flat = center.distance > 1e-6 * h ? (middle - foot).lpNorm<1>() / center.distance : std::sqrt(3.0);
  const double reach = kMargin * 0.5 * h * flat;  // of the cell's corners, below a flat skin
  if (std::ranges::any_of(boundaries_, [&](double depth) { return std::abs(center.distance - depth) < reach; }))
    return true;
  return border_tree_ && border_tree_->closest(foot).distance < kMargin * 0.5 * std::sqrt(3.0) * h;
}

std::uint8_t CellShares::material(Index triangle, double depth) const {
  std::uint8_t found = 0;
  for (const auto& region : regions_)
    if (region.faces[triangle] != 0 && depth >= region.from_depth && depth < region.to_depth)
      found = std::uint8_t(region.material);
  return found;
}

// Cuts a sample where the layers below the closest triangle of the skin begin and end.
void CellShares::add(const Vec3& middle, const TissueSample& sample, std::vector<Sum>& sums) const {
  const double half = 0.5 * lattice_.settings.spacing;
  const Vec3 point = middle + half * sample.center;
  const SkinTree::Closest closest = skin_.closest(point);
  const auto& [a, b, c] = skin_.skin().triangles[closest.triangle];
  const auto& points = skin_.skin().points;
  Vec3 down = point - skin_.interpolate(closest, points);
  if (!(down.norm() > 1e-6 * half)) down = (points[c] - points[a]).cross(points[b] - points[a]);
  down.normalize();
  const double depth = closest.distance / half, extent = down.cwiseProduct(sample.edges).norm();
  std::vector<double> cuts = {depth - 0.5 * extent, depth + 0.5 * extent};
  for (const auto& region : regions_)
    for (const double boundary : {region.from_depth / half, region.to_depth / half})
      if (region.faces[closest.triangle] != 0 && boundary > cuts[0] && boundary < cuts[1]) cuts.push_back(boundary);
  std::ranges::sort(cuts);
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    const double length = cuts[k + 1] - cuts[k], at = 0.5 * (cuts[k] + cuts[k + 1]);
    if (!(length > 0.0)) continue;
    const std::uint8_t own = material(closest.triangle, std::max(half * at, 0.0));
    auto sum = std::ranges::find(sums, own, &Sum::material);
    if (sum == sums.end()) sum = sums.insert(sum, Sum{own});
    const double volume = sample.volume * length / extent;
    const Vec3 center = sample.center + (at - depth) * down;
    const Vec3 variance = (sample.edges.cwiseAbs2() + (length * length - extent * extent) * down.cwiseAbs2()) / 12.0;
    sum->volume += volume;
    sum->first += volume * center;
    sum->second += volume * (variance.cwiseMax(0.0) + center.cwiseAbs2());
  }
}

std::uint8_t CellShares::append(std::size_t cell, bool mixed, std::uint8_t only,
                                std::vector<MaterialShare>& shares) const {
  if (!mixed) {
    if (const auto share = share_of_fill(lattice_, cell, only)) shares.push_back(*share);
    return only;
  }
  std::array<TissueSample, 8> found;
  const std::size_t count = tissue_samples(lattice_, cell, found);
  const auto& [x, y, z] = lattice_.cell_position(cell);
  const Vec3 middle = lattice_.settings.origin + lattice_.settings.spacing * Vec3(x + 0.5, y + 0.5, z + 0.5);
  std::vector<Sum> sums;
  double tissue = 0.0;
  for (const TissueSample& sample : std::span(found).first(count)) {
    tissue += sample.volume;
    add(middle, sample, sums);
  }
  if (!(tissue > 0.0)) return only;
  std::erase_if(sums, [&](const Sum& s) { return s.volume < kMinShare * tissue; });
  std::ranges::sort(sums, [](const Sum& a, const Sum& b) {
    return a.volume != b.volume ? a.volume > b.volume : a.material < b.material;
  });
  const bool full = lattice_.cell_fill[cell] == 1.0F;
  if (sums.size() == 1 && full) return sums[0].material;
  double kept = 0.0;
  for (const Sum& sum : sums) kept += sum.volume;
  for (const Sum& sum : sums)
    shares.push_back(share_of_moments(cell, sum.material, sum.volume / kept, sum.volume, sum.first, sum.second));
  return sums[0].material;
}

}  // namespace lappet
