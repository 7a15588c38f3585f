// The sheet benchmark from rest in one step: few Newton iterations, and displacements against a fine reference.
#include "sheet.h"

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <map>

#include "force/elastic/elastic.h"

namespace lappet {
namespace {

constexpr double kRatios[] = {0.45, 0.49, 0.499};  // Poisson's

// Points 10 mm and more from the border in the middle of the thickness: x of 10, 30, .. 90, y of 10, 30, 50.
constexpr std::size_t kPoints = 15;
Vec3 reference_point(std::size_t k) {
  return {10.0 + 20.0 * static_cast<double>(k / 3), 10.0 + 20.0 * static_cast<double>(k % 3), 2.0};
}

// Their displacements, mm, for each of kRatios: extrapolated from spacings of 1 and 0.5 mm, u + (u - u_1) / 1.4. The
// differences between 2, 1 and 0.5 mm shrink by 2.4 each: the edges of the held faces are singular. The test
// DISABLED_ReferenceDisplacements prints this table (some ten minutes).
constexpr double kReference[3][kPoints][3] = {{{2.70491, 1.37497, -0.76112},
                                               {2.53477, 0.00000, 0.00000},
                                               {2.70491, -1.37497, 0.76112},
                                               {8.81594, 2.48349, -2.63379},
                                               {8.64233, 0.00000, 0.00000},
                                               {8.81594, -2.48349, 2.63379},
                                               {15.00000, 2.98838, -4.55825},
                                               {15.00000, 0.00000, 0.00000},
                                               {15.00000, -2.98838, 4.55825},
                                               {21.18406, 3.51336, -6.47733},
                                               {21.35767, 0.00000, 0.00000},
                                               {21.18406, -3.51336, 6.47732},
                                               {27.29509, 3.48970, -8.65337},
                                               {27.46523, 0.00000, 0.00000},
                                               {27.29509, -3.48970, 8.65337}},
                                              {{2.64788, 1.49253, -0.74723},
                                               {2.46786, 0.00000, 0.00000},
                                               {2.64788, -1.49253, 0.74723},
                                               {8.77869, 2.66472, -2.59960},
                                               {8.59221, 0.00000, 0.00000},
                                               {8.77869, -2.66472, 2.59960},
                                               {15.00000, 3.17006, -4.50956},
                                               {15.00000, 0.00000, 0.00000},
                                               {15.00000, -3.17006, 4.50956},
                                               {21.22131, 3.68741, -6.41631},
                                               {21.40779, 0.00000, 0.00000},
                                               {21.22131, -3.68741, 6.41631},
                                               {27.35212, 3.59845, -8.60661},
                                               {27.53214, 0.00000, 0.00000},
                                               {27.35212, -3.59845, 8.60661}},
                                              {{2.63467, 1.51866, -0.74420},
                                               {2.45252, 0.00000, 0.00000},
                                               {2.63467, -1.51866, 0.74420},
                                               {8.77007, 2.70477, -2.59208},
                                               {8.58078, 0.00000, 0.00000},
                                               {8.77007, -2.70477, 2.59208},
                                               {15.00000, 3.21014, -4.49883},
                                               {15.00000, 0.00000, 0.00000},
                                               {15.00000, -3.21014, 4.49883},
                                               {21.22993, 3.72585, -6.40280},
                                               {21.41922, 0.00000, 0.00000},
                                               {21.22993, -3.72585, 6.40280},
                                               {27.36533, 3.62259, -8.59617},
                                               {27.54748, 0.00000, 0.00000},
                                               {27.36533, -3.62259, 8.59617}}};

FrameOutput solve_from_rest(const SheetScene& scene) {
  Session session(sheet_settings(scene));
  session.set_epoch(sheet_epoch());
  return session.solve(sheet_frame(scene), {}, kNever);
}

Vec3 displacement(const FrameOutput& out, const Lattice& lattice, const Vec3& point) {
  for (std::size_t n = 0; n < lattice.node_rest.size(); ++n)
    if ((lattice.node_rest[n] - point).norm() < 1e-9)
      return {out.state.nodes[3 * n], out.state.nodes[3 * n + 1], out.state.nodes[3 * n + 2]};
  ADD_FAILURE() << "no node at " << point.transpose();
  return Vec3::Zero();
}

// |force on free nodes| / |force on held nodes|: the relative residual of finite-element codes.
double residual_to_reaction(const FrameOutput& out, const SheetScene& scene, const Lattice& lattice) {
  Elastic<double> elastic(lattice, sheet_settings(scene).materials[0], scene.quadrature);
  std::vector<double> gradient(out.state.nodes.size()), scale(gradient.size() / 3);
  elastic.evaluate(out.state.nodes, gradient, scale);
  double free = 0.0, held = 0.0;
  for (std::size_t n = 0; n < scale.size(); ++n) {
    const double x = lattice.node_rest[n][0];
    for (std::size_t i = 0; i < 3; ++i)
      (x < 1e-9 || x > kSheet[0] - 1e-9 ? held : free) += gradient[3 * n + i] * gradient[3 * n + i];
  }
  return std::sqrt(free / held);
}

TEST(Sheet, ConvergesFromRestInOneStepInFewNewtonIterationsAlsoWhenNearlyIncompressible) {
  constexpr int kMaxNewton[] = {10, 12, 15}, kMaxLinear[] = {50, 75, 200};
  for (std::size_t k = 0; k < 3; ++k) {
    SheetScene scene;
    scene.poissons_ratio = kRatios[k];
    scene.tolerance = 1e-7;  // the force scale is ten times the reaction
    const FrameOutput out = solve_from_rest(scene);
    ASSERT_TRUE(out.converged) << out.failure.message;
    EXPECT_EQ(out.load_steps, 1);
    EXPECT_EQ(out.inverted_cells, 0);
    EXPECT_LE(out.newton_iterations, kMaxNewton[k]) << "nu " << kRatios[k];
    EXPECT_LE(out.pcg_iterations, kMaxLinear[k]) << "nu " << kRatios[k];
    EXPECT_LE(residual_to_reaction(out, scene, sheet_lattice(scene)), 1e-6) << "nu " << kRatios[k];
  }
}

TEST(Sheet, DisplacementsAtTwoMillimetersAreWithinFourHundredthsOfAMillimeterWhateverPoissonsRatio) {
  for (std::size_t k = 0; k < 3; ++k) {
    SheetScene scene;
    scene.poissons_ratio = kRatios[k];
    const FrameOutput out = solve_from_rest(scene);
    ASSERT_TRUE(out.converged) << out.failure.message;
    const Lattice lattice = sheet_lattice(scene);
    for (std::size_t p = 0; p < kPoints; ++p) {
      const Vec3 u = displacement(out, lattice, reference_point(p));
      EXPECT_LE((u - Eigen::Map<const Vec3>(kReference[k][p])).norm(), 0.04)
          << "nu " << kRatios[k] << " at " << reference_point(p).transpose();
    }
  }
}

// Turned by 180 degrees about the long axis through its middle, the sheet and its load are what they were.
TEST(Sheet, TheEquilibriumHasTheSymmetryOfTheSheet) {
  SheetScene scene;
  const FrameOutput out = solve_from_rest(scene);
  ASSERT_TRUE(out.converged) << out.failure.message;
  const Lattice lattice = sheet_lattice(scene);
  std::map<std::array<long, 3>, std::size_t> node_at;
  const auto key = [](const Vec3& x) {
    return std::array<long, 3>{std::lround(1e3 * x[0]), std::lround(1e3 * x[1]), std::lround(1e3 * x[2])};
  };
  for (std::size_t n = 0; n < lattice.node_rest.size(); ++n) node_at[key(lattice.node_rest[n])] = n;
  constexpr double kSign[3] = {1, -1, -1};
  double most = 0.0;
  for (std::size_t n = 0; n < lattice.node_rest.size(); ++n) {
    const Vec3& x = lattice.node_rest[n];
    const std::size_t m = node_at.at(key(Vec3(x[0], kSheet[1] - x[1], kSheet[2] - x[2])));
    for (std::size_t i = 0; i < 3; ++i)
      most = std::max(most, std::abs(out.state.nodes[3 * n + i] - kSign[i] * out.state.nodes[3 * m + i]));
  }
  EXPECT_LT(most, 1e-4);
}

TEST(Sheet, DISABLED_ReferenceDisplacements) {
  for (const double ratio : kRatios) {
    Vec3 coarse[kPoints], fine[kPoints];
    for (const double spacing : {1.0, 0.5}) {
      SheetScene scene;
      scene.poissons_ratio = ratio;
      scene.spacing = spacing;
      const FrameOutput out = solve_from_rest(scene);
      ASSERT_TRUE(out.converged) << out.failure.message;
      const Lattice lattice = sheet_lattice(scene);
      for (std::size_t p = 0; p < kPoints; ++p)
        (spacing < 1.0 ? fine : coarse)[p] = displacement(out, lattice, reference_point(p));
    }
    for (std::size_t p = 0; p < kPoints; ++p) {
      const Vec3 u = fine[p] + (fine[p] - coarse[p]) / 1.4;
      fmt::print("{{{:.5f}, {:.5f}, {:.5f}}},\n", u[0], u[1], u[2]);
    }
  }
}

}  // namespace
}  // namespace lappet
