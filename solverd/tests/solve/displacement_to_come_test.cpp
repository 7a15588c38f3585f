// The displacement still to come, its limits, and forces that are compared where they act.
#include "solve/newton/displacement_to_come.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "cut_sheet.h"
#include "solve/system/residual_clusters.h"

namespace lappet {
namespace {

TEST(SeriesEstimate, KnowsWhatIsLeftOfAGeometricSeries) {
  for (const double rate : {0.35, 0.6, 0.9}) {
    SeriesEstimate series;
    double piece = 2.0, sum = 0.0;
    for (int k = 0; k < 3; ++k, piece *= rate) {
      series.add(piece);
      EXPECT_EQ(std::isinf(series.left()), k == 0);
      sum += piece;
    }
    EXPECT_NEAR(sum + series.left(), 2.0 / (1.0 - rate), 1e-9) << rate;
  }
}

// As where a floppy piece is found late by conjugate gradients: the pieces grow before they fall.
TEST(SeriesEstimate, DoesNotTakeGrowingPiecesForTheEnd) {
  SeriesEstimate series;
  double sum = 0.0;
  for (const double piece : {0.06, 0.09, 0.5, 0.43}) {
    series.add(piece);
    sum += piece;
    EXPECT_GT(series.left(), sum) << piece;
  }
}

CellMaterials of_kilopascals(double youngs_modulus) {
  CellMaterials materials{{MaterialParameters{}}};
  materials.table[0].youngs_modulus = youngs_modulus;
  return materials;
}

Attachments all_free(const Lattice& lattice) {
  Attachments attachments;
  attachments.node_group.assign(lattice.node_rest.size(), kFree);
  return attachments;
}

TEST(DisplacementLimits, AreEachFragmentsOwn) {
  // Two sheets apart: the one moves by 5 mm, the other by 0.5 mm.
  CutSheet sheet = make_cut_sheet(4, 3, 1, 0, 1.0);
  Lattice lattice = sheet.lattice;
  const std::size_t nodes = lattice.node_rest.size();
  for (std::size_t n = 0; n < nodes; ++n) {
    GridPoint at = lattice.node_rest.grid_point(n);
    at[0] += 100;
    lattice.node_rest.push_back(at);
  }
  for (std::size_t c = sheet.lattice.cell_nodes.size(); c-- > 0;) {
    auto corners = lattice.cell_nodes[c];
    for (std::int32_t& n : corners) n += to_index(nodes);
    lattice.cell_nodes.push_back(corners);
    lattice.cell_fill.push_back(1.0f);
  }
  const System<double> system(lattice, of_kilopascals(50.0), 1, all_free(lattice), 0, {10.0, 10.0}, Vec3::Zero());
  std::vector<double> u(6 * nodes, 0.0), step(6 * nodes, 0.0);
  u[0] = 5.0;
  u[3 * nodes] = 0.5;
  const DisplacementLimits<double> limits(system, u, {.at_most = 0.02, .share = 0.01, .least = 1e-3});
  step[4] = 0.02;  // as much as a node may have left, in the first sheet
  EXPECT_NEAR(limits.share(step), 1.0, 1e-12);
  step[3 * nodes + 4] = 0.02;  // 4 % of what the second moves
  EXPECT_NEAR(limits.share(step), 4.0, 1e-12);
  u.assign(u.size(), 0.0);  // nothing moves: what a gap may leave open
  const DisplacementLimits<double> least(system, u, {.at_most = 0.02, .share = 0.01, .least = 1e-3});
  EXPECT_NEAR(least.share(step), 20.0, 1e-12);
}

// One node out of equilibrium at the middle of a sheet, in which every node bears the same force.
TEST(ResidualClusters, AskTheSameOfAPlaceInAPatchOfAnySize) {
  const auto relative = [](int size, double force) {
    const CutSheet sheet = make_cut_sheet(size, size, 2, 0, 1.0);
    const ResidualClusters clusters(sheet.lattice, of_kilopascals(50.0), {});
    const std::size_t nodes = sheet.lattice.node_rest.size();
    std::vector<double> gradient(3 * nodes, 0.0), scale(nodes, force);
    gradient[0] = 1.0;
    return clusters.norms<double>(gradient, scale, std::vector<std::uint8_t>(nodes, 1), std::vector(3 * nodes, 0.0));
  };
  for (const double force : {0.0, 10.0}) {
    const ResidualNorms wide = relative(48, force), wider = relative(96, force);
    EXPECT_NEAR(wider.relative, wide.relative, 1e-9 * wide.relative);
    EXPECT_GT(wider.force_scale, 1.9 * wide.force_scale);  // what one norm would have divided by
    EXPECT_GT(wide.relative, 1.0 / wide.force_scale);
  }
  // In a tissue no larger than a cluster it is one norm.
  const ResidualNorms small = relative(6, 10.0);
  EXPECT_NEAR(small.relative, small.residual / small.force_scale, 1e-12);
}

// Skin that has turned by a degree and come 32 mm far bears no force but that of single precision.
TEST(ResidualClusters, DoNotCountWhatRoundingLeaves) {
  const CutSheet sheet = make_cut_sheet(12, 12, 2, 0, 1.0);
  CellMaterials skin = of_kilopascals(50.0);
  skin.table[0].poissons_ratio = 0.49;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(std::numbers::pi / 180.0, Vec3(1.0, 2.0, 3.0).normalized()).matrix();
  Attachments held = all_free(sheet.lattice);
  held.node_group[0] = kFixedGroup;  // what nothing holds lies on a weak bed
  const auto evaluate = [&]<class Real>(Real, double stretch) {
    System<Real> system(sheet.lattice, skin, 1, held, 0, {10.0, 10.0}, Vec3::Zero());
    std::vector<Real> u;
    for (const Vec3& x : sheet.lattice.node_rest.all())
      for (const double way : Vec3(stretch * turn * x - x + Vec3(3.0, -2.0, -32.0))) u.push_back(Real(way));
    return system.evaluate(u, Multipliers{}, {});
  };
  const Evaluation exact = evaluate(0.0, 1.0), rounded = evaluate(0.0f, 1.0), stretched = evaluate(0.0f, 1.0003);
  EXPECT_LT(exact.residual / exact.force_scale, 1e-9);
  EXPECT_GT(rounded.residual / rounded.force_scale, 1e-3);
  EXPECT_LT(rounded.relative_residual, 1e-3);
  EXPECT_GT(stretched.relative_residual, 0.9 * evaluate(0.0, 1.0003).relative_residual);
  EXPECT_GT(stretched.relative_residual, 1e-2);
}

}  // namespace
}  // namespace lappet
