// What holds and loads the tissue, and what goes through a section of it, against formulas and the balance of forces.
#include <gtest/gtest.h>

#include "force/constraints/attachments.h"
#include "material_formulas.h"
#include "session/pulled_bar.h"
#include "solve/system/reaction.h"

namespace lappet {
namespace {

using Kind = Holder::Kind;

Vec3 reaction(const FrameOutput& out, Kind kind, std::int32_t index = 0) {
  for (std::size_t k = 0; k + 1 < out.holders.size(); k += 2)
    if (out.holders[k] == static_cast<std::int32_t>(kind) && out.holders[k + 1] == index)
      return Vec3::Map(&out.reactions[3 * (k / 2)]);
  ADD_FAILURE() << "no reaction of kind " << static_cast<int>(kind) << ", " << index;
  return Vec3::Constant(std::nan(""));
}

Vec3 sum(const std::vector<double>& vectors) {
  Vec3 total = Vec3::Zero();
  for (std::size_t k = 0; k < vectors.size(); k += 3) total += Vec3::Map(&vectors[k]);
  return total;
}

SessionSettings settings(const std::string& model = "neoHookean") {
  SessionSettings s;
  s.materials[0].model = model;
  s.materials[0].poissons_ratio = 0.45;
  s.tolerance = 1e-5;
  s.gap_tolerance = 1e-6;
  s.precision = "double";
  return s;
}

TEST(Reactions, ABarThatIsPulledHasTheForceOfItsStretchAtBothEnds) {
  for (const char* model : {"corotated", "neoHookean", "stableNeoHookean", "mooneyRivlin"}) {
    const Bar bar;
    SessionSettings s = settings(model);
    s.materials[0].poissons_ratio = 0.0;  // the held ends do not disturb it
    s.retractors = 1;
    Session session(s);
    session.set_epoch(bar_epoch(bar));
    const FrameOutput out = pull(session, 12);
    const Piola piola = [&](const Matrix3& f) { return isotropic_piola(s.materials[0], f); };
    const Matrix3 f = free_sides(piola, 1 + 12 / bar.length);
    const double force = piola(f)(0, 0) * bar.area();
    // Without Poisson's effect these models still draw in or out a little, and are held there at the ends.
    EXPECT_NEAR(reaction(out, Kind::kRetractor)[0], force, 5e-3 * force) << model;
    EXPECT_NEAR(reaction(out, Kind::kFixed)[0], -force, 5e-3 * force) << model;
    EXPECT_NEAR(sum(out.reactions).norm(), 0, 1e-4 * force) << model;
  }
}

TEST(Reactions, AGrippedEndHasTheForceThatTheEnergyTells) {
  const Bar bar{20, 4, 4};
  SessionSettings s = settings();
  s.retractors = 1;
  Session session(s);
  session.set_epoch(bar_epoch(bar));
  const double force = pulling_force(session, 5, 1e-3);
  EXPECT_NEAR(reaction(pull(session, 5), Kind::kRetractor)[0], force, 1e-4 * force);
}

TEST(Reactions, FacesOffTheLatticeHoldWithTheSameForce) {
  const Bar bar{20, 4, 4};
  SessionSettings s = settings();
  s.retractors = 1;
  s.origin = Vec3(-0.37, 0, 0);
  Session session(s);
  session.set_epoch(bar_epoch(bar));
  const FrameOutput out = pull(session, 5);
  const double force = pulling_force(session, 5, 1e-3);
  EXPECT_NEAR(reaction(out, Kind::kRetractor)[0], force, 1e-3 * force);
  EXPECT_NEAR(reaction(out, Kind::kFixed)[0], -force, 1e-3 * force);
}

TEST(Reactions, WeightHooksBedAndFixedFacesAreInBalance) {
  for (const bool undermined : {false, true}) {
    SessionSettings s = settings();
    s.bed_stiffness = 5;
    s.bed_shear = 0.5;
    s.gravity = Vec3(2, 0, -9);
    EpochInput epoch = make_epoch(
        box_surface({0, 0, 0}, {12, 8, 4}), [](const Vec3& c) { return c[0] < 1e-9; }, {},
        [](const Vec3& c) { return c[2] < 1e-9; });
    if (undermined)
      for (auto& label : epoch.bed) label *= kRestsOnBed;
    Session session(s);
    session.set_epoch(epoch);
    FrameInput frame;
    frame.hooks.push_back({{Vec3(9, 4, 4), 0}, Vec3(11, 5, 3.5), 100.0, 0});
    for (std::size_t t = 0; t < epoch.surface.triangles.size(); ++t)
      if (center(epoch.surface, t)[2] > 4 - 1e-9) frame.hooks[0].anchor.triangle = to_index(t);
    const FrameOutput out = session.solve(frame, {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    const Vec3 weight = s.gravity * (s.materials[0].density * 1e-6 * 12 * 8 * 4),
               hook = Vec3::Map(out.hook_forces.data());
    EXPECT_GT(reaction(out, Kind::kBed).norm(), 1.0);
    EXPECT_LT((sum(out.reactions) + weight + hook).norm(), 1e-3 * hook.norm()) << undermined;
  }
}

TEST(Reactions, EachPartOfTheFixedFacesHasItsOwn) {
  SessionSettings s = settings();
  s.gravity = Vec3(0, 0, -9.81);
  const Surface box = box_surface({0, 0, 0}, {20, 4, 4});
  EpochInput epoch = make_epoch(box, [](const Vec3& c) { return c[0] < 1e-9 || c[0] > 20 - 1e-9; });
  for (std::size_t t = 0; t < box.triangles.size(); ++t)
    epoch.fixed_parts.push_back(!epoch.fixed[t] ? -1 : center(box, t)[0] < 10 ? 0 : 1);
  Session session(s);
  session.set_epoch(epoch);
  const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  const double weight = s.materials[0].density * 9.81e-6 * 20 * 4 * 4;
  EXPECT_NEAR(reaction(out, Kind::kFixed, 0)[2], weight / 2, 1e-3 * weight);
  EXPECT_NEAR(reaction(out, Kind::kFixed, 1)[2], weight / 2, 1e-3 * weight);
  EXPECT_NEAR(reaction(out, Kind::kFixed, 0)[0], -reaction(out, Kind::kFixed, 1)[0], 1e-3 * weight);
}

TEST(Sections, ABarThatIsPulledPassesTheForceOfItsEndEverywhere) {
  const Bar bar{20, 4, 4};
  SessionSettings s = settings();
  s.retractors = 1;
  EpochInput epoch = bar_epoch(bar);
  for (const double x : {2.0, 5.3, 10.5, 17.0}) {
    epoch.section_points.emplace_back(x, 1, 1);
    epoch.section_normals.emplace_back(1, 0, 0);
  }
  epoch.section_points.emplace_back(10, 2, 2);
  epoch.section_normals.emplace_back(2, 1, 0.5);
  Session session(s);
  session.set_epoch(epoch);
  const FrameOutput out = pull(session, 5);
  const Vec3 force = reaction(out, Kind::kRetractor);
  ASSERT_EQ(out.section_forces.size(), 15U);
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_LT((Vec3::Map(&out.section_forces[3 * k]) - force).norm(), 1e-4 * force.norm()) << k;
}

TEST(Sections, ACantileverPassesTheWeightBeyondIt) {
  SessionSettings s = settings();
  s.gravity = Vec3(0, 0, -9.81);
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {20, 4, 4}), [](const Vec3& c) { return c[0] < 1e-9; });
  const std::vector<double> at{3.0, 8.0, 11.25, 16.5};
  for (const double x : at) {
    epoch.section_points.emplace_back(x, 0, 0);
    epoch.section_normals.emplace_back(1, 0, 0);
  }
  Session session(s);
  session.set_epoch(epoch);
  const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  const double weight = s.materials[0].density * 9.81e-6 * 4 * 4;  // mN/mm
  for (std::size_t k = 0; k < at.size(); ++k) {
    const Vec3 force = Vec3::Map(&out.section_forces[3 * k]);
    EXPECT_LT((force - Vec3(0, 0, -weight * (20 - at[k]))).norm(), 1e-3 * weight * 20) << at[k];
  }
  EXPECT_NEAR(reaction(out, Kind::kFixed)[2], weight * 20, 1e-3 * weight * 20);
}

}  // namespace
}  // namespace lappet
