// Layers do not depend on how the lattice lies: skin over fat on a lattice that is raised by parts of a cell, as thick
// as a cell or thinner, in tension, in bending, and pulled at a patch of the skin. Small displacements, by the
// assembled tangent at rest.
#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>
#include <cmath>
#include <limits>

#include "box.h"
#include "cell_stiffness.h"
#include "force/elastic/elastic.h"
#include "force/materials/cell_materials.h"

namespace lappet {
namespace {

constexpr double kDeep = std::numeric_limits<double>::infinity();
constexpr double kShifts[] = {0.0, 0.25, 0.37, 0.5, 0.75};  // not only whole voxels

struct Layers {
  double skin, fat;                  // mm, from the top down; no fat: tissue of one material
  double skin_modulus, fat_modulus;  // kPa
};

// A bar of the layers along x, 8 mm wide, its bottom at z = 0.
class LayeredBar {
 public:
  LayeredBar(const Layers& layers, double length, double spacing, double shift, int quadrature)
      : length_(length), height_(layers.skin + layers.fat) {
    LatticeSettings settings;
    settings.spacing = spacing;
    settings.origin = Vec3(0, 0, -shift * spacing);
    lattice_ = build_lattice(box_surface(Vec3::Zero(), Vec3(length, kWidth, height_)), settings);
    Surface skin;
    for (const double x : {0.0, length})
      for (const double y : {0.0, kWidth}) skin.points.emplace_back(x, y, height_);
    skin.triangles = {{0, 2, 3}, {0, 3, 1}};
    std::vector<MaterialParameters> table(2);
    table[0].youngs_modulus = layers.skin_modulus;
    table[1].youngs_modulus = layers.fat_modulus;
    std::vector<MaterialRegion> regions;
    if (layers.fat > 0.0) regions.push_back({1, layers.skin, kDeep, {1, 1}});
    const CellMaterials materials = assign_materials(lattice_, table, skin, regions);
    Elastic<double> elastic(lattice_, materials, quadrature);
    std::vector<double> u(size()), gradient(size()), scale(size() / 3);
    elastic.evaluate(u, gradient, scale);
    elastic.linearize(PsdProjection::kExact);
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t c = 0; c < lattice_.cell_nodes.size(); ++c) {
      const test::Matrix24 k = test::cell_stiffness(elastic, to_index(c));
      for (int a = 0; a < 24; ++a)
        for (int b = 0; b < 24; ++b)
          entries.emplace_back(3 * lattice_.cell_nodes[c][a / 3] + a % 3, 3 * lattice_.cell_nodes[c][b / 3] + b % 3,
                               k(a, b));
    }
    stiffness_.resize(std::ptrdiff_t(size()), std::ptrdiff_t(size()));
    stiffness_.setFromTriplets(entries.begin(), entries.end());
  }

  // The elastic energy where the end at x = 0 is held and the other is moved, without turning.
  double energy_of_motion(const Vec3& motion) const {
    Eigen::VectorXd u = Eigen::VectorXd::Zero(stiffness_.rows());
    std::vector<bool> held(lattice_.node_rest.size());
    for (std::size_t n = 0; n < held.size(); ++n) {
      const double x = lattice_.node_rest[n][0];
      held[n] = x < 1e-9 || x > length_ - 1e-9;
      if (x > length_ - 1e-9) u.segment<3>(3 * std::ptrdiff_t(n)) = motion;
    }
    return solve(held, u, Eigen::VectorXd::Zero(u.size()));
  }

  // The energy where both ends are held and a patch of 8 mm of the top, in the middle, is pulled with 1 kPa.
  double energy_of_pull(const Vec3& direction) const {
    std::vector<bool> held(lattice_.node_rest.size());
    for (std::size_t n = 0; n < held.size(); ++n) {
      const double x = lattice_.node_rest[n][0];
      held[n] = x < 1e-9 || x > length_ - 1e-9;
    }
    Eigen::VectorXd force = Eigen::VectorXd::Zero(stiffness_.rows());
    const double step = 0.25, h = lattice_.settings.spacing;
    for (double x = 0.5 * (length_ - kWidth + step); x < 0.5 * (length_ + kWidth); x += step)
      for (double y = 0.5 * step; y < kWidth; y += step) {
        const Vec3 at = (Vec3(x, y, height_ - 1e-6) - lattice_.settings.origin) / h;
        for (std::size_t c = 0; c < lattice_.cell_nodes.size(); ++c) {
          const auto& p = lattice_.cell_position(c);
          const Vec3 w = at - Vec3(p[0], p[1], p[2]);
          if (w.minCoeff() < 0.0 || w.maxCoeff() >= 1.0) continue;
          for (int k = 0; k < 8; ++k)
            force.segment<3>(3 * lattice_.cell_nodes[c][k]) += step * step * (k & 4 ? w[0] : 1 - w[0]) *
                                                               (k & 2 ? w[1] : 1 - w[1]) * (k & 1 ? w[2] : 1 - w[2]) *
                                                               direction;
        }
      }
    return solve(held, Eigen::VectorXd::Zero(force.size()), force);
  }

  static constexpr double kWidth = 8.0;

 private:
  std::size_t size() const { return 3 * lattice_.node_rest.size(); }
  // u holds the displacements of the held nodes; returns u K u / 2 at the equilibrium.
  double solve(const std::vector<bool>& held, Eigen::VectorXd u, const Eigen::VectorXd& force) const {
    Eigen::SparseMatrix<double> k = stiffness_;
    const Eigen::VectorXd right = force - stiffness_ * u;
    Eigen::VectorXd free_part = right;
    for (Eigen::Index column = 0; column < k.outerSize(); ++column)
      for (Eigen::SparseMatrix<double>::InnerIterator it(k, column); it; ++it)
        if (held[std::size_t(it.row() / 3)] || held[std::size_t(column / 3)])
          it.valueRef() = it.row() == column ? 1.0 : 0.0;
    for (Eigen::Index i = 0; i < u.size(); ++i)
      if (held[std::size_t(i / 3)]) free_part[i] = 0.0;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(k);
    EXPECT_EQ(factor.info(), Eigen::Success);
    u += factor.solve(free_part);
    return 0.5 * u.dot(stiffness_ * u);
  }

  double length_, height_;
  Lattice lattice_;
  Eigen::SparseMatrix<double> stiffness_;
};

// 6 EI/L^3 (motion)^2, with the bending stiffness of the composite section about its neutral axis.
double composite_energy(const Layers& layers, double length, double motion) {
  const double e[] = {layers.fat_modulus, layers.skin_modulus}, t[] = {layers.fat, layers.skin};
  double sum = 0.0, first = 0.0, second = 0.0, z = 0.0;
  for (int k = 0; k < 2; ++k) {
    const double middle = z + 0.5 * t[k], area = e[k] * LayeredBar::kWidth * t[k];
    sum += area;
    first += area * middle;
    second += area * (middle * middle + t[k] * t[k] / 12);
    z += t[k];
  }
  return 6 * (second - first * first / sum) / std::pow(length, 3) * motion * motion;
}

constexpr Layers kSkinOverFat{2, 4, 200, 5};
constexpr double kLength = 24.0;

// The largest relative difference from the lattice that the layers are aligned with.
double spread(const Layers& layers, double spacing, int quadrature, const auto& energy) {
  double aligned = 0.0, most = 0.0;
  for (const double shift : kShifts) {
    const double found = energy(LayeredBar(layers, kLength, spacing, shift, quadrature));
    if (shift == 0.0) aligned = found;
    most = std::max(most, std::abs(found / aligned - 1.0));
  }
  return most;
}
double stretched(const LayeredBar& bar) { return bar.energy_of_motion(Vec3(1, 0, 0)); }
double bent(const LayeredBar& bar) { return bar.energy_of_motion(Vec3(0, 0, 1)); }
double pulled_along(const LayeredBar& bar) { return bar.energy_of_pull(Vec3(1, 0, 0)); }

TEST(LayerShift, SkinOverFatBetweenHeldEndsPullsAlikeWhereverTheLatticeLies) {
  for (const double spacing : {2.0, 1.0}) EXPECT_LT(spread(kSkinOverFat, spacing, 1, stretched), 0.002) << spacing;
}

TEST(LayerShift, APullAtThePatchOfTheSkinMovesItAlike) {
  EXPECT_LT(spread(kSkinOverFat, 2.0, 8, pulled_along), 0.04);
  EXPECT_LT(spread(kSkinOverFat, 1.0, 8, pulled_along), 0.015);
  EXPECT_LT(spread(kSkinOverFat, 1.0, 1, pulled_along), 0.03);
  // One point leaves skin that is a single cell thick to its hourglass modes, which bend too softly: aligned skin moves
  // more, shared cells do not have that error.
  EXPECT_LT(spread(kSkinOverFat, 2.0, 1, pulled_along), 0.13);
}

// Cells filled in part hold their tissue's strain where it lies: a sheet that the lattice does not match is no stiffer.
// Its bending stiffness lies between those of a beam and of a plate.
TEST(LayerShift, TissueOfOneMaterialPullsAndBendsAlikeWhereverTheLatticeLies) {
  struct {
    double thickness, spacing, most;
  } const sheets[] = {{3.0, 2.0, 0.11}, {4.0, 2.0, 0.04}, {2.0, 1.0, 0.04}, {3.0, 1.0, 0.01}, {4.0, 1.0, 0.005}};
  for (const auto& [thickness, spacing, most] : sheets) {
    const Layers sheet{thickness, 0.0, 50.0, 5.0};
    const double poisson = MaterialParameters{}.poissons_ratio, length = 12.0 * thickness;
    const double beam = composite_energy(sheet, length, 1.0);
    double aligned = 0.0, tension = 0.0;
    for (const double shift : kShifts) {
      const LayeredBar bar(sheet, length, spacing, shift, 1);
      const double found = bent(bar);
      EXPECT_GT(found, 0.95 * beam) << thickness << " " << spacing << " " << shift;
      EXPECT_LT(found, beam / (1 - poisson * poisson)) << thickness << " " << spacing << " " << shift;
      if (shift == 0.0) aligned = found, tension = stretched(bar);
      EXPECT_NEAR(found, aligned, most * aligned) << thickness << " " << spacing << " " << shift;
      EXPECT_NEAR(stretched(bar), tension, 0.001 * tension) << thickness << " " << spacing << " " << shift;
    }
  }
}

TEST(LayerShift, SkinOverFatBendsAlikeWithEightPoints) { EXPECT_LT(spread(kSkinOverFat, 2.0, 8, bent), 0.07); }

// On cells twice as fine as the skin is thick; see above for skin a cell thick.
TEST(LayerShift, SkinOverFatBendsAlikeWithOnePointOnCellsFinerThanTheSkin) {
  EXPECT_LT(spread(kSkinOverFat, 1.0, 1, bent), 0.08);
}

// A strip of 1 mm of skin on 1 mm of a softer layer, on a lattice of 1 mm: its bending stiffness lies between those of
// the composite beam and the composite plate, and its tension is the same to 0.1 %, wherever the layers end in the
// cells.
TEST(LayerShift, LayersAsThinAsACellKeepTheirStiffnessInTensionAndBending) {
  for (const auto& layers : {Layers{1, 1, 200, 20}, Layers{1, 1, 50, 50}}) {
    EXPECT_LT(spread(layers, 1.0, 1, stretched), 0.001);
    for (const double shift : kShifts) {
      const double poisson = MaterialParameters{}.poissons_ratio, beam = composite_energy(layers, kLength, 1.0);
      const double found = bent(LayeredBar(layers, kLength, 1.0, shift, 1));
      EXPECT_GT(found, 0.9 * beam) << shift;
      EXPECT_LT(found, 1.1 * beam / (1 - poisson * poisson)) << shift;
    }
  }
}

}  // namespace
}  // namespace lappet
