// Which material a cell gets, against what the geometry of a painted box and a ball says.
#include "force/materials/cell_materials.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <map>

#include "test_surfaces.h"

namespace lappet {
namespace {

constexpr double kDeep = std::numeric_limits<double>::infinity();

Vec3 center(const Surface& s, std::size_t t) {
  Vec3 sum = Vec3::Zero();
  for (const std::int32_t p : s.triangles[t]) sum += s.points[p];
  return sum / 3;
}

// The top of a box as a grid of triangles, 1 mm wide.
Surface top(int length, int width, double height) {
  Surface skin;
  for (int x = 0; x <= length; ++x)
    for (int y = 0; y <= width; ++y) skin.points.emplace_back(x, y, height);
  for (int x = 0; x < length; ++x)
    for (int y = 0; y < width; ++y) {
      const std::int32_t a = x * (width + 1) + y, b = a + width + 1;
      skin.triangles.push_back({a, b, b + 1});
      skin.triangles.push_back({a, b + 1, a + 1});
    }
  return skin;
}

MaterialRegion region(const Surface& skin, std::int32_t material, double from, double to,
                      const std::function<bool(const Vec3&)>& painted = {}) {
  MaterialRegion result{material, from, to, {}};
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) result.faces.push_back(!painted || painted(center(skin, t)));
  return result;
}

std::vector<MaterialParameters> table(std::size_t count) { return std::vector<MaterialParameters>(count); }

Vec3 middle(const Lattice& lattice, std::size_t c) {
  const auto& p = lattice.cell_position(c);
  return lattice.settings.origin + lattice.settings.spacing * Vec3(p[0] + 0.5, p[1] + 0.5, p[2] + 0.5);
}

Lattice lattice_of(const Surface& surface, double spacing) {
  LatticeSettings settings;
  settings.spacing = spacing;
  return build_lattice(surface, settings);
}

TEST(CellMaterials, ALayeredBoxHasTheLayersThatTheDepthsSay) {
  const Lattice lattice = lattice_of(test::box({0, 0, 0}, {8, 6, 5}), 0.5);
  const Surface skin = top(8, 6, 5);
  const std::vector<MaterialRegion> regions = {region(skin, 1, 1.0, 3.0), region(skin, 2, 3.0, kDeep)};
  const CellMaterials materials = assign_materials(lattice, table(3), skin, regions);
  std::map<int, int> counts;
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    const double depth = 5 - middle(lattice, c)[2];
    EXPECT_EQ(materials.of_cell[c], depth < 1 ? 0 : depth < 3 ? 1 : 2) << depth;
    ++counts[materials.of_cell[c]];
  }
  EXPECT_EQ(counts, (std::map<int, int>{{0, 16 * 12 * 2}, {1, 16 * 12 * 4}, {2, 16 * 12 * 4}}));
}

TEST(CellMaterials, AHalfPaintedBoxSplitsWhereItIsPaintedAndTheLaterRegionWins) {
  const Lattice lattice = lattice_of(test::box({0, 0, 0}, {8, 6, 5}), 1.0);
  const Surface skin = top(8, 6, 5);
  const std::vector<MaterialRegion> regions = {
      region(skin, 1, 0.0, kDeep, [](const Vec3& c) { return c[0] < 5; }),
      region(skin, 2, 2.0, 4.0, [](const Vec3& c) { return c[1] > 3; }),
  };
  const CellMaterials materials = assign_materials(lattice, table(3), skin, regions);
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    const Vec3 m = middle(lattice, c);
    const double depth = 5 - m[2];
    EXPECT_EQ(materials.of_cell[c], m[1] > 3 && depth > 2 && depth < 4 ? 2 : m[0] < 5 ? 1 : 0) << m.transpose();
  }
}

TEST(CellMaterials, ACutChangesNoMaterialAndBothCopiesOfACellAtAWoundHaveTheSame) {
  const Surface skin = top(8, 6, 5);
  const std::vector<MaterialRegion> regions = {region(skin, 1, 0.0, 2.0, [](const Vec3& c) { return c[0] < 5; }),
                                               region(skin, 2, 2.0, kDeep)};
  const auto by_place = [&](const Lattice& lattice) {
    const CellMaterials materials = assign_materials(lattice, table(3), skin, regions);
    std::map<std::array<std::int32_t, 3>, int> found;
    for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
      const auto [at, fresh] = found.emplace(lattice.cell_position(c), materials.of_cell[c]);
      EXPECT_TRUE(fresh || at->second == materials.of_cell[c]);
    }
    return found;
  };
  const auto whole = by_place(lattice_of(test::box({0, 0, 0}, {8, 6, 5}), 1.0));
  for (const double kerf : {0.01, 3.0}) {  // a cut, and what is left where an ellipse was taken out
    const Lattice cut = lattice_of(test::cut_slab(8, 6, 5, {{4.3, 0}, {4.7, 6}}, kerf).surface, 1.0);
    EXPECT_EQ(cut.fragments, 2);
    const auto after = by_place(cut);
    EXPECT_LE(after.size(), whole.size());
    for (const auto& [position, material] : after) EXPECT_EQ(material, whole.at(position));
  }
}

TEST(CellMaterials, TheLayersOfABallAreShells) {
  const Surface ball = test::sphere({0, 0, 0}, 6.0, 40);
  LatticeSettings settings;
  settings.spacing = 0.5;
  settings.origin = Vec3(-6, -6, -6);
  const Lattice lattice = build_lattice(ball, settings);
  const CellMaterials materials =
      assign_materials(lattice, table(2), ball, std::vector<MaterialRegion>{region(ball, 1, 2.0, kDeep)});
  const double sag = 6.0 * (1 - std::cos(3.15 / 40));  // of the facets below the ball
  int inner = 0;
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    const double radius = middle(lattice, c).norm();
    if (std::abs(radius - 4.0) > sag + 1e-9) {
      EXPECT_EQ(materials.of_cell[c], radius < 4.0 ? 1 : 0) << radius;
    }
    inner += materials.of_cell[c];
  }
  EXPECT_NEAR(inner * 0.125, 4.0 / 3.0 * 3.14159265 * 64, 0.05 * 4.0 / 3.0 * 3.14159265 * 64);
}

TEST(CellMaterials, CellsOfADirectedMaterialHaveTheNormalOfTheSkinAboveThem) {
  const Surface ball = test::sphere({0, 0, 0}, 6.0, 24);
  LatticeSettings settings;
  settings.spacing = 0.5;
  settings.origin = Vec3(-6, -6, -6);
  const Lattice lattice = build_lattice(ball, settings);
  auto directed = table(2);
  directed[1].fiber_k1 = 10;
  EXPECT_TRUE(assign_materials(lattice, table(2), ball, {}).normal_of_cell.empty());
  const CellMaterials materials = assign_materials(lattice, directed, ball, {});
  ASSERT_EQ(materials.normal_of_cell.size(), lattice.cell_nodes.size());
  EXPECT_TRUE(materials.of_cell.empty());
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    const Vec3 radius = middle(lattice, c);
    if (radius.norm() < 3) continue;  // further in a facet's width counts
    EXPECT_GT(materials.normal_of_cell[c].cast<double>().dot(radius.normalized()), std::cos(2.5 * 3.1416 / 180));
  }
}

TEST(CellMaterials, BelowAFlatSkinNoNormalIsKeptUnlessADirectionHasToBeTurned) {
  const Lattice lattice = lattice_of(test::box({0, 0, 0}, {8, 6, 5}), 1.0);
  auto directed = table(1);
  directed[0].prestretch = {1.2, 1.1};
  EXPECT_TRUE(assign_materials(lattice, directed, top(8, 6, 5), {}).normal_of_cell.empty());
  directed[0].fiber_direction = Vec3(0.8, 0, 0.6);
  EXPECT_FALSE(assign_materials(lattice, directed, top(8, 6, 5), {}).normal_of_cell.empty());
}

// Volume, first and second moment in z of each material, from the shares and the cells of one material.
struct LayerMoments {
  double volume = 0.0, first = 0.0, second = 0.0;
};
std::map<int, LayerMoments> moments_of(const Lattice& lattice, const CellMaterials& materials) {
  std::map<int, LayerMoments> layers;
  const double h = lattice.settings.spacing;
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    const double volume = h * h * h * double(lattice.cell_fill[c]), z = middle(lattice, c)[2];
    const auto add = [&](int material, double part, double center, double scale) {
      const double at = z + 0.5 * h * center, variance = h * h / 12 * scale * scale;
      layers[material].volume += part * volume;
      layers[material].first += part * volume * at;
      layers[material].second += part * volume * (at * at + variance);
    };
    const auto shares = materials.shares_of(c);
    const std::uint8_t own = materials.of_cell.empty() ? std::uint8_t{0} : materials.of_cell[c];
    double sum = 0.0;
    for (const auto& share : shares) {
      add(share.material, double(share.volume), double(share.center[2]), double(share.scale[2]));
      sum += double(share.volume);
      EXPECT_LE(share.center.cwiseAbs().maxCoeff(), 1.0F);
      EXPECT_LE(share.volume, shares[0].volume);
    }
    if (shares.empty()) add(own, 1.0, 0.0, 1.0);
    if (!shares.empty()) {
      EXPECT_NEAR(sum, 1.0, 1e-6);
      EXPECT_EQ(own, shares[0].material);
    }
  }
  return layers;
}

TEST(CellMaterials, LayersKeepTheirVolumePlaceAndThicknessWhereverTheLatticeLies) {
  const Surface skin = top(8, 6, 5);
  const std::vector<MaterialRegion> regions = {region(skin, 1, 0.7, 2.0), region(skin, 2, 2.0, kDeep)};
  for (const double spacing : {1.0, 2.0})
    for (const double shift : {0.0, 0.25, 0.5, 0.75}) {
      LatticeSettings settings;
      settings.spacing = spacing;
      settings.origin = Vec3(0, 0, -spacing * shift);  // by whole voxels
      const Lattice lattice = build_lattice(test::box({0, 0, 0}, {8, 6, 5}), settings);
      const auto layers = moments_of(lattice, assign_materials(lattice, table(3), skin, regions));
      ASSERT_EQ(layers.size(), 3U);
      const double from[] = {4.3, 3.0, 0.0}, to[] = {5.0, 4.3, 3.0};
      for (const auto& [material, found] : layers) {
        const double low = from[material], high = to[material];
        EXPECT_NEAR(found.volume, 48 * (high - low), 1e-4) << material << " " << shift;
        EXPECT_NEAR(found.first, 24 * (high * high - low * low), 1e-3) << material << " " << shift;
        EXPECT_NEAR(found.second, 16 * (std::pow(high, 3) - std::pow(low, 3)), 5e-3) << material << " " << shift;
      }
    }
}

TEST(CellMaterials, TissueOfOneMaterialKeepsItsVolumePlaceAndThicknessWhereverTheLatticeLies) {
  for (const double spacing : {1.0, 2.0})
    for (const double shift : {0.25, 0.5, 0.75}) {
      LatticeSettings settings;
      settings.spacing = spacing;
      settings.origin = Vec3(0, 0, -spacing * shift);  // by whole voxels
      const Lattice lattice = build_lattice(test::box({0, 0, 0}, {8, 6, 5}), settings);
      const CellMaterials materials = assign_materials(lattice, table(1), {}, {});
      EXPECT_TRUE(materials.of_cell.empty());
      for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c)
        EXPECT_EQ(materials.shares_of(c).size(), lattice.cell_fill[c] != 1.0F ? 1U : 0U);
      const LayerMoments found = moments_of(lattice, materials).at(0);
      EXPECT_NEAR(found.volume, 48 * 5.0, 1e-4) << shift;
      EXPECT_NEAR(found.first, 24 * 25.0, 1e-3) << shift;
      EXPECT_NEAR(found.second, 16 * 125.0, 5e-3) << shift;
    }
}

// A cut through the middle of a row of cells: each copy of a cell has its own half, less half of the cut's width.
TEST(CellMaterials, EachCopyOfACellAtAWoundHasItsOwnTissue) {
  constexpr double kKerf = 0.01, kSpacing = 2.0;
  constexpr float kHalf = 0.5F - float(0.5 * kKerf / kSpacing);
  const Lattice lattice = lattice_of(test::cut_slab(8, 6, 4, {{5.0, 0}, {5.0, 6}}, kKerf).surface, kSpacing);
  ASSERT_EQ(lattice.fragments, 2);
  const CellMaterials materials = assign_materials(lattice, table(1), {}, {});
  std::map<std::array<std::int32_t, 3>, std::vector<float>> centers;
  for (const MaterialShare& share : materials.shares) {
    const auto cell = static_cast<std::size_t>(share.cell);
    EXPECT_EQ(lattice.cell_position(cell)[0], 2);
    EXPECT_NEAR(std::abs(share.center[0]), 1.0F - kHalf, 1e-4F);
    EXPECT_NEAR(share.scale[0], kHalf, 1e-4F);
    EXPECT_NEAR(share.scale[2], 1.0F, 1e-6F);
    centers[lattice.cell_position(cell)].push_back(share.center[0]);
  }
  EXPECT_EQ(centers.size(), 6U);
  for (const auto& [position, found] : centers) {
    ASSERT_EQ(found.size(), 2U);
    EXPECT_NEAR(found[0] + found[1], 0.0F, 1e-6F);
  }
}

TEST(CellMaterials, ALayerOfABallHasItsVolumeOnALatticeAsCoarseAsItsThickness) {
  const Surface ball = test::sphere({0, 0, 0}, 6.0, 40);
  LatticeSettings settings;
  settings.spacing = 1.0;
  settings.fine_ratio = 8;
  settings.origin = Vec3(-6.3, -6.1, -6.4);
  const Lattice lattice = build_lattice(ball, settings);
  const auto layers = moments_of(
      lattice, assign_materials(lattice, table(2), ball, std::vector<MaterialRegion>{region(ball, 1, 1.0, kDeep)}));
  const double inner = 4.0 / 3.0 * 3.14159265 * 125;
  EXPECT_NEAR(layers.at(1).volume, inner, 0.01 * inner);
}

TEST(CellMaterials, ACellIsSharedWhereARegionEndsBesideAnother) {
  const Lattice lattice = lattice_of(test::box({0, 0, 0}, {8, 6, 5}), 2.0);
  const Surface skin = top(8, 6, 5);
  const auto painted = [](const Vec3& c) { return c[0] < 5; };
  const CellMaterials materials =
      assign_materials(lattice, table(2), skin, std::vector<MaterialRegion>{region(skin, 1, 0.0, kDeep, painted)});
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    const double x = middle(lattice, c)[0];  // cells from 4 to 6 are half of either
    const auto shares = materials.shares_of(c);
    if (x < 4 || x > 6) {
      EXPECT_EQ(materials.of_cell[c], x < 4 ? 1 : 0);
      EXPECT_LE(shares.size(), 1U);
    } else {
      ASSERT_EQ(shares.size(), 2U);
      EXPECT_NEAR(shares[0].volume, 0.5, 1e-6);
      EXPECT_NEAR(std::abs(shares[0].center[0]), 0.5, 1e-6);
    }
  }
}

// A wheel of directions about the box's middle axis: each cell has that of the place above it, along the skin.
TEST(CellMaterials, DirectionsAndStretchesOfTheSkinReachTheCellsBelow) {
  const Lattice lattice = lattice_of(test::box({0, 0, 0}, {8, 6, 5}), 1.0);
  const Surface skin = top(8, 6, 5);
  auto directed = table(1);
  directed[0].prestretch = {1.2, 1.1};
  SkinFields fields;
  for (const Vec3& p : skin.points) {
    fields.directions.push_back(Vec3(-(p[1] - 3.1), p[0] - 4.1, 7.0));  // what points out of the skin does not count
    fields.stretch.push_back({1.0 + 0.02 * p[0], 1.0 + 0.01 * p[1]});
  }
  const CellMaterials materials = assign_materials(lattice, directed, skin, {}, fields);
  ASSERT_EQ(materials.direction_of_cell.size(), lattice.cell_nodes.size());
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    const Vec3 m = middle(lattice, c), expected = Vec3(-(m[1] - 3.1), m[0] - 4.1, 0).normalized();
    EXPECT_NEAR((materials.direction_of_cell[c].cast<double>() - expected).norm(), 0.0, 1e-6) << m.transpose();
    EXPECT_NEAR(materials.stretch_of_cell[c][0], 1.0 + 0.02 * m[0], 1e-6);
    EXPECT_NEAR(materials.stretch_of_cell[c][1], 1.0 + 0.01 * m[1], 1e-6);
  }
  fields.directions.assign(skin.points.size(), Vec3::Zero());  // where nothing is said the material's own holds
  for (const auto& direction : assign_materials(lattice, directed, skin, {}, fields).direction_of_cell)
    EXPECT_TRUE(direction.isZero());
}

TEST(CellMaterials, WithoutRegionsNothingIsKeptPerCell) {
  const Lattice lattice = lattice_of(test::box({0, 0, 0}, {4, 4, 4}), 1.0);
  const CellMaterials materials = assign_materials(lattice, table(1), {}, {});
  EXPECT_TRUE(materials.of_cell.empty());
  EXPECT_TRUE(materials.shares.empty());
  EXPECT_EQ(&materials.of(3), &materials.table[0]);
}

}  // namespace
}  // namespace lappet
