// Prestretch through a Session: what is held stays, what is cut free shrinks, and a straight incision gapes, more
// across the direction of the greater prestretch (the relaxed skin tension lines) than along it.
#include <gtest/gtest.h>

#include "force/materials/prestretch.h"
#include "material_formulas.h"
#include "pulled_bar.h"

namespace lappet {
namespace {

SessionSettings taut(double along, double across, std::string_view model = "neoHookean") {
  SessionSettings s;
  s.threads = 2;
  s.materials[0].model = model;
  s.materials[0].prestretch = {along, across};
  s.bed_stiffness = s.bed_shear = 0;
  return s;
}

bool on_rim(const Vec3& c, double width, double depth) {
  return c[0] < 1e-9 || c[0] > width - 1e-9 || c[1] < 1e-9 || c[1] > depth - 1e-9;
}

TEST(PrestretchSession, IntactSkinHeldAtItsRimStaysAsItIsWithTheStressOfItsPrestretch) {
  for (const std::string_view model : MaterialModels::kNames) {
    SessionSettings s = taut(1.25, 1.1, model);
    s.materials[0].fiber_k1 = 10;
    s.materials[0].fiber_k2 = 1;
    s.materials[0].fiber_dispersion = 0.2;
    Session session(s);
    Surface surface = box_surface({0, 0, 0}, {20, 16, 3});
    const auto middle = static_cast<std::size_t>(add_vertex(surface, {10, 8, 3}));
    session.set_epoch(make_epoch(surface, [](const Vec3& c) { return on_rim(c, 20, 16); }));
    const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    EXPECT_EQ(out.newton_iterations, 0) << model;
    for (std::size_t v = 0; v < surface.points.size(); ++v)
      for (std::size_t i = 0; i < 3; ++i)
        EXPECT_NEAR(out.points[3 * v + i], surface.points[v][static_cast<int>(i)], 1e-3);
    const Matrix3 a = Vec3(1.25, 1.1, free_prestretch(s.materials[0])).asDiagonal();
    const double expected = cauchy_of([&](const Matrix3& f) { return full_piola(s.materials[0], f); }, a)(0, 0);
    EXPECT_GT(expected, 10);
    EXPECT_NEAR(out.tension[middle], expected, 1e-3 * expected) << model;
    EXPECT_NEAR(out.strain[middle], 0.25, 1e-3);
  }
}

TEST(PrestretchSession, AFreePatchShrinksByItsPrestretch) {
  for (const auto& [along, across] : {std::pair(1.2, 1.05), std::pair(1.5, 1.25), std::pair(0.9, 1.1)}) {
    SessionSettings s = taut(along, across);
    s.bed_stiffness = s.bed_shear = 1e-3;  // keeps it in place
    s.tolerance = 1e-4;
    Session session(s);
    EpochInput epoch =
        make_epoch(box_surface({-8, -6, 0}, {8, 6, 2}), {}, {}, [](const Vec3& c) { return c[2] < 1e-9; });
    for (const Vec3& p : {Vec3(-8, 0, 1), Vec3(8, 0, 1), Vec3(0, -6, 1), Vec3(0, 6, 1), Vec3(0, 0, 0), Vec3(0, 0, 2)})
      add_landmark(epoch, p);
    session.set_epoch(epoch);
    const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    EXPECT_NEAR((landmark(out, 1) - landmark(out, 0)).norm(), 16 / along, 0.01 * 16);
    EXPECT_NEAR((landmark(out, 3) - landmark(out, 2)).norm(), 12 / across, 0.01 * 12);
    EXPECT_NEAR((landmark(out, 5) - landmark(out, 4)).norm(), 2 / free_prestretch(s.materials[0]), 0.01 * 2);
  }
}

// A block with a lens cut through it: outer walls and one inner wall, closed. The cut runs along x.
Surface slit_sheet(double half_width, double half_length, double thickness, double kerf) {
  Surface s;
  const double w = half_width, l = half_length, k = kerf / 2;
  const double outer[4][2] = {{-w, -w}, {w, -w}, {w, w}, {-w, w}};
  const double inner[4][2] = {{-l, 0}, {0, -k}, {l, 0}, {0, k}};
  for (const double z : {0.0, thickness}) {
    for (const auto& p : outer) s.points.emplace_back(p[0], p[1], z);
    for (const auto& p : inner) s.points.emplace_back(p[0], p[1], z);
  }
  // The top between both outlines: outer corners 0..3 and inner ones 4..7 (left, below, right, above).
  const std::array<std::int32_t, 3> top[8] = {{0, 1, 5}, {0, 5, 4}, {1, 6, 5}, {1, 2, 6},
                                              {2, 7, 6}, {2, 3, 7}, {3, 4, 7}, {3, 0, 4}};
  for (const auto& t : top) {
    s.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
    s.triangles.push_back({t[0], t[2], t[1]});
  }
  for (std::int32_t i = 0; i < 4; ++i) {
    const std::int32_t j = (i + 1) % 4;
    s.triangles.push_back({i, j, j + 8});
    s.triangles.push_back({i, j + 8, i + 8});
    s.triangles.push_back({i + 4, j + 12, j + 4});
    s.triangles.push_back({i + 4, i + 12, j + 12});
  }
  return s;
}

// How far the lips of a slit of 16 mm part in the middle when its sheet is prestretched (x along the slit, y across).
double gape(double along_slit, double across_slit, double k1 = 0) {
  SessionSettings s = taut(along_slit, across_slit);
  s.origin = Vec3(-20, -20, 0);
  s.materials[0].fiber_k1 = k1;
  Session session(s);
  const double kerf = 0.1;
  EpochInput epoch = make_epoch(slit_sheet(20, 8, 2, kerf),
                                [](const Vec3& c) { return std::abs(c[0]) > 20 - 1e-9 || std::abs(c[1]) > 20 - 1e-9; });
  add_landmark(epoch, Vec3(0, -kerf / 2, 1));
  add_landmark(epoch, Vec3(0, kerf / 2, 1));
  EXPECT_EQ(session.set_epoch(epoch).fragments, 1);
  const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
  EXPECT_TRUE(out.converged) << out.failure.message;
  EXPECT_EQ(out.inverted_cells, 0);
  return (landmark(out, 1) - landmark(out, 0)).norm() - kerf;
}

TEST(PrestretchSession, AnIncisionGapesMoreAcrossTheGreaterPrestretchThanAlongIt) {
  const double across_lines = gape(1.05, 1.25), along_lines = gape(1.25, 1.05);
  EXPECT_GT(along_lines, 0.3);
  // The ratio of the stresses across both in plane stress, at small stretch; lips that are taut along open less.
  const double small = (0.25 + 0.45 * 0.05) / (0.05 + 0.45 * 0.25);
  EXPECT_GT(across_lines, small * along_lines);
  EXPECT_LT(across_lines, 2 * small * along_lines);
}

TEST(PrestretchSession, TheGapeGrowsWithThePrestretchAndIsNoneWithoutIt) {
  EXPECT_NEAR(gape(1, 1), 0, 1e-6);
  double before = 0;
  for (const double stretch : {1.05, 1.1, 1.2, 1.3}) {
    const double found = gape(1.05, stretch);
    EXPECT_GT(found, 1.2 * before) << stretch;
    before = found;
  }
}

// Griffith's crack of length 2 a in a wide sheet of modulus E opens by 4 sigma a / E at small stretch; the held rim at
// 2.5 a takes some of it, and the lattice rounds its tips.
TEST(PrestretchSession, ASmallPrestretchOpensASlitAboutAsAGriffithCrack) {
  const double stretch = 1.02, sigma = 50 * 0.02 / (1 - 0.45 * 0.45), found = gape(1.0, stretch);
  const double griffith = 4 * sigma * 8 / 50;
  EXPECT_LT(found, griffith * 1.02);
  EXPECT_GT(found, 0.7 * griffith);
}

}  // namespace
}  // namespace lappet
