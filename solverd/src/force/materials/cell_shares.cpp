#include "force/materials/cell_shares.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "lattice/voxelize.h"

namespace lappet {

namespace {

constexpr double kMinShare = 0.01;  // of a cell's tissue; less joins the others
constexpr double kMargin = 1.1;     // for what a curved skin adds to the reach of a cell
constexpr std::size_t kSamples = 8;
constexpr double kFullVariance = 1.0 / 3.0;  // of a coordinate in [-1, 1]

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

// The tissue of an eighth of a cell, as a box, in coordinates of the cell from -1 to 1.
struct CellShares::Sample {
  double volume = 0.0;                               // of the cell's
  Vec3 center = Vec3::Zero(), edges = Vec3::Ones();  // a whole eighth has edges of 1
};

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

// Fills the samples that hold tissue and returns how many there are.
std::size_t CellShares::samples(std::size_t cell, Sample* found) const {
  const FineVoxels& fine = *lattice_.fine;
  const std::int32_t r = fine.box().ratio;
  const GridPoint& position = lattice_.cell_position(cell);
  Voxel at;
  for (std::size_t a = 0; a < 3; ++a) at[a] = position[a] - fine.box().low[a];
  const Index place = fine.occupied_at(at[0], at[1], at[2]);
  if (r == 1 || place < 0 || fine.is_whole(place)) {
    for (std::size_t k = 0; k < kSamples; ++k)
      found[k] = {1.0 / kSamples, Vec3(k & 4 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 1 ? 0.5 : -0.5), Vec3::Ones()};
    return kSamples;
  }
  struct Moments {
    int count = 0;
    Vec3 first = Vec3::Zero(), second = Vec3::Zero();
  } moments[kSamples];
  for (std::int32_t i = 0; i < r * r * r; ++i) {
    const Voxel local{i / (r * r), i / r % r, i % r};
    if (fine.lattice_cell({at[0] * r + local[0], at[1] * r + local[1], at[2] * r + local[2]}) != to_index(cell))
      continue;
    std::size_t eighth = 0;
    Vec3 x;
    for (std::size_t a = 0; a < 3; ++a) {
      eighth = 2 * eighth + (2 * local[a] + 1 < r ? 0 : 1);
      x[a] = (2.0 * local[a] + 1.0) / r - 1.0;
    }
    ++moments[eighth].count;
    moments[eighth].first += x;
    moments[eighth].second += x.cwiseAbs2();
  }
  std::size_t count = 0;
  for (const Moments& m : moments) {
    if (m.count == 0) continue;
    const Vec3 center = m.first / m.count;
    const Vec3 variance = m.second / m.count - center.cwiseAbs2() + Vec3::Constant(kFullVariance / (r * r));
    found[count++] = {double(m.count) / (r * r * r), center, (12.0 * variance).cwiseMax(0.0).cwiseSqrt()};
  }
  return count;
}

// Cuts a sample where the layers below the closest triangle of the skin begin and end.
void CellShares::add(const Vec3& middle, const Sample& sample, std::vector<Sum>& sums) const {
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
  Sample found[kSamples];
  const std::size_t count = samples(cell, found);
  const auto& [x, y, z] = lattice_.cell_position(cell);
  const Vec3 middle = lattice_.settings.origin + lattice_.settings.spacing * Vec3(x + 0.5, y + 0.5, z + 0.5);
  std::vector<Sum> sums;
  if (!mixed) sums.push_back({only});
  double tissue = 0.0;
  for (const Sample& sample : std::span(found, count)) {
    tissue += sample.volume;
    if (mixed) {
      add(middle, sample, sums);
      continue;
    }
    sums[0].volume += sample.volume;
    sums[0].first += sample.volume * sample.center;
    sums[0].second += sample.volume * (sample.center.cwiseAbs2() + sample.edges.cwiseAbs2() / 12.0);
  }
  if (!(tissue > 0.0)) return only;
  std::erase_if(sums, [&](const Sum& s) { return s.volume < kMinShare * tissue; });
  std::ranges::sort(sums, [](const Sum& a, const Sum& b) {
    return a.volume != b.volume ? a.volume > b.volume : a.material < b.material;
  });
  const bool full = tissue > 1.0 - 1e-9;
  if (sums.size() == 1 && full) return sums[0].material;
  double kept = 0.0;
  for (const Sum& sum : sums) kept += sum.volume;
  for (const Sum& sum : sums) {
    const Vec3 center = sum.first / sum.volume;
    const Vec3 variance = (sum.second / sum.volume - center.cwiseAbs2()).cwiseMax(0.0) / kFullVariance;
    shares.push_back({to_index(cell), sum.material, float(sum.volume / kept), center.cast<float>(),
                      variance.cwiseSqrt().cwiseMin(1.0).cast<float>()});
  }
  return sums[0].material;
}

}  // namespace lappet
