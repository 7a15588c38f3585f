// Tissue under its own weight, against formulas: hanging, on a bed, in layers, as a beam.
#include <gtest/gtest.h>

#include <limits>

#include "box.h"
#include "force/constraints/attachments.h"
#include "session/session.h"

namespace lappet {
namespace {

TEST(Weight, ABarHangingUnderItsOwnWeightLengthensAsTheFormulaSays) {
  SessionSettings s;
  s.spacing = 1;
  s.materials[0].model = "corotated";
  s.materials[0].poissons_ratio = 0.0;
  s.materials[0].youngs_modulus = 50;
  s.gravity = Vec3(0, 0, -9.81);
  s.tolerance = 1e-5;
  s.precision = "double";
  Session session(s);
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {3, 3, 30}), [](const Vec3& c) { return c[2] > 30 - 1e-9; });
  add_landmark(epoch, Vec3(1.5, 1.5, 0));
  session.set_epoch(epoch);
  FrameInput frame;
  const FrameOutput out = session.solve(frame, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  const double weight = s.materials[0].density * 9.81 * 1e-6;  // mN/mm^3
  EXPECT_NEAR(-landmark(out, 0)[2], weight * 30 * 30 / (2 * 50), 1e-3 * weight * 9);
}

TEST(Weight, ATissueOnABedSinksByItsWeightOverTheBedsStiffness) {
  SessionSettings s;
  s.spacing = 1;
  s.materials[0].model = "corotated";
  s.materials[0].poissons_ratio = 0.0;  // no sideways swelling: the weight stays even
  s.gravity = Vec3(0, 0, -9.81);
  s.bed_stiffness = s.bed_shear = 2.0;
  s.tolerance = 1e-6;
  s.precision = "double";
  Session session(s);
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {6, 6, 4}), {}, {}, [](const Vec3& c) { return c[2] < 1e-9; });
  add_landmark(epoch, Vec3(3, 3, 0));
  session.set_epoch(epoch);
  const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  const double expected = s.materials[0].density * 9.81e-6 * 4 / 2.0;
  EXPECT_NEAR(-landmark(out, 0)[2], expected, 1e-3 * expected);
}

// On a bed that is tilted against gravity and against the lattice: each direction gives way by its own stiffness.
TEST(Weight, ATissueOnABedSlidesByItsWeightOverTheBedsShearStiffness) {
  for (const bool tilted : {false, true}) {
    SessionSettings s;
    s.spacing = 1;
    s.materials[0].model = "corotated";
    s.materials[0].poissons_ratio = 0.0;
    s.bed_stiffness = 2.0;
    s.bed_shear = 0.25;
    s.tolerance = 1e-6;
    s.precision = "double";
    const Eigen::AngleAxisd turn(tilted ? 0.4 : 0.0, Vec3(1, 2, 0).normalized());
    const Vec3 down = turn * Vec3(0, 0, -1), along = turn * Vec3(1, 0, 0);
    s.gravity = 9.81 * (down + along);
    Surface box = box_surface({0, 0, 0}, {8, 8, 4});
    std::vector<std::uint8_t> bed;
    for (std::size_t t = 0; t < box.triangles.size(); ++t) bed.push_back(center(box, t)[2] < 1e-9);
    for (Vec3& point : box.points) point = turn * point;
    EpochInput epoch = make_epoch(box, {});
    epoch.bed = bed;
    const Vec3 middle = turn * Vec3(4, 4, 0);
    add_landmark(epoch, middle);
    Session session(s);
    session.set_epoch(epoch);
    const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    const double weight = s.materials[0].density * 9.81e-6 * 4;  // kPa
    const Vec3 moved = landmark(out, 0) - middle;
    // The weight turns the tissue too, whose middle stays; a tilted lattice has not quite the tissue's volume.
    const double within = tilted ? 0.06 : 1e-2;
    EXPECT_NEAR(moved.dot(down), weight / s.bed_stiffness, within * weight / s.bed_stiffness) << tilted;
    EXPECT_NEAR(moved.dot(along), weight / s.bed_shear, within * weight / s.bed_shear) << tilted;
  }
}

TEST(Weight, ARestingTissueSinksLikeAnAttachedOneButLiftsOffFreely) {
  SessionSettings s;
  s.materials[0].model = "corotated";
  s.materials[0].poissons_ratio = 0.0;
  s.bed_stiffness = s.bed_shear = 2.0;
  s.tolerance = 1e-6;
  s.precision = "double";
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {6, 6, 4}), {});
  for (std::size_t t = 0; t < epoch.bed.size(); ++t)
    epoch.bed[t] = center(epoch.surface, t)[2] < 1e-9 ? kRestsOnBed : 0;
  add_landmark(epoch, Vec3(3, 3, 0));
  const double weight = s.materials[0].density * 9.81e-6 * 4;  // kPa
  {
    s.gravity = Vec3(0, 0, -9.81);
    Session session(s);
    session.set_epoch(epoch);
    const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    // within what the weak bed of floating fragments carries
    EXPECT_NEAR(-landmark(out, 0)[2], weight / s.bed_stiffness, 1e-2 * weight / s.bed_stiffness);
  }
  {
    // a retractor on one side lifts it: nothing pulls back but the elastic forces, of which a rigid motion has none
    s.gravity = Vec3::Zero();
    s.retractors = 1;
    for (std::size_t t = 0; t < epoch.grip.size(); ++t) epoch.grip[t] = center(epoch.surface, t)[0] < 1e-9 ? 0 : -1;
    Session session(s);
    session.set_epoch(epoch);
    const FrameOutput out = session.solve(pulled({Vec3(0, 0, 3)}), {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    EXPECT_NEAR(landmark(out, 0)[2], 3, 1e-6);
    EXPECT_LT(out.energy, 1e-9);
  }
}

// Two materials without stiffness between them: each half hangs by its own density.
TEST(Weight, GravityPullsEveryLayerByItsOwnDensity) {
  SessionSettings s;
  s.materials.resize(2);
  for (auto& m : s.materials) {
    m.model = "corotated";
    m.poissons_ratio = 0.0;
  }
  s.materials[0].density = 1000;
  s.materials[1].density = 3000;
  s.gravity = Vec3(0, 0, -9.81);
  s.tolerance = 1e-5;
  s.precision = "double";
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {3, 3, 30}), [](const Vec3& c) { return c[2] > 30 - 1e-9; });
  add_landmark(epoch, Vec3(1.5, 1.5, 0));
  epoch.skin = box_surface({0, 0, 30}, {3, 3, 30});  // flat: only its top counts
  epoch.regions = {
      {1, 15.0, std::numeric_limits<double>::infinity(), std::vector<std::uint8_t>(epoch.skin.triangles.size(), 1)}};
  Session session(s);
  session.set_epoch(epoch);
  const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  // The integral of the weight below, over E: the lower half by itself, then the upper half under it.
  const double light = 1000 * 9.81e-6, heavy = 3000 * 9.81e-6, l = 15;
  const double expected = (heavy * l * l / 2 + heavy * l * l + light * l * l / 2) / s.materials[0].youngs_modulus;
  EXPECT_NEAR(-landmark(out, 0)[2], expected, 2e-3 * expected);
}

// What bends a beam is a small force beside its modulus: no tolerance may take the start for equilibrium.
TEST(Weight, ASlenderBeamSagsWhateverTheTolerance) {
  SessionSettings s;
  s.spacing = 1;
  s.materials[0].youngs_modulus = 50;
  s.gravity = Vec3(0, 0, -9.81);
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {20, 4, 4}), [](const Vec3& c) { return c[0] < 1e-9; });
  add_landmark(epoch, Vec3(20, 2, 2));
  const auto sag = [&](double tolerance) {
    s.tolerance = tolerance;
    Session session(s);
    session.set_epoch(epoch);
    const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
    EXPECT_TRUE(out.converged) << out.failure.message;
    return 2 - landmark(out, 0)[2];
  };
  const double exact = sag(1e-5);
  // Euler and Bernoulli: q L^4 / (8 E I), I = b t^3 / 12, q = b t w
  const double weight = s.materials[0].density * 9.81e-6;
  EXPECT_NEAR(exact, 12 * weight * 20 * 20 * 20 * 20 / (8 * 50 * 4 * 4), 0.02 * exact);
  EXPECT_NEAR(sag(1e-3), exact, 0.01 * exact);
  EXPECT_NEAR(sag(1e-2), exact, 0.03 * exact);
  EXPECT_GT(sag(1e-1), 0.05 * exact);
}

}  // namespace
}  // namespace lappet
