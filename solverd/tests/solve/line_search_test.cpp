// The line search where the energy of all of the tissue is rounded more coarsely than a step changes it.
#include "solve/newton/line_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "cut_sheet.h"

namespace lappet {
namespace {

constexpr double kSpring = 10.0;  // mN/mm

CellMaterials skin() {
  CellMaterials materials{{MaterialParameters{}}};
  materials.table[0].youngs_modulus = 50.0;
  return materials;
}

// A sheet whose middle a hook begins to pull up to a place `away` mm above it. A step moves the hooked node alone, by
// so many times the way that lowers the energy most.
struct HookedSheet {
  CutSheet sheet = make_cut_sheet(6, 6, 3, 0, 1.0);
  System<float> system;
  Multipliers multipliers;
  std::vector<float> u, step, trial;
  PointConstraint hook;

  HookedSheet(double away, double ways)
      : system(sheet.lattice, skin(), 1, sheet.attachments, 0, {10.0, 10.0}, Vec3::Zero()),
        u(3 * system.nodes(), 0.0f),
        step(u.size(), 0.0f),
        trial(u.size(), 0.0f) {
    Index middle = 0;
    for (std::size_t n = 0; n < system.nodes(); ++n)
      if (sheet.lattice.node_rest[n] == Vec3(3, 3, 3)) middle = to_index(n);
    hook.pieces = {{{middle}, {1.0}, Vec3(0, 0, -away)}};
    hook.stiffness = kSpring;
    system.set_point_constraints({hook});
    step[offset_of(3, middle) + 2] = 1.0f;
    const double length = -ways * slope() / curvature();
    step[offset_of(3, middle) + 2] = static_cast<float>(length);
  }
  // Where a share of the step is done the node meets a wall, from both sides.
  void add_wall(double share) {
    PointConstraint wall = hook;
    wall.pieces[0].offset = Vec3::Zero();
    wall.slack = share * largest<float>(step);
    wall.stiffness = 400.0 * kSpring;
    system.set_point_constraints({hook, wall});
  }
  double slope() { return LineSearch<float>::slope_of(system.evaluate(u, multipliers), step); }
  double curvature() {
    system.linearize(system.evaluate(u, multipliers), PsdProjection::kExact);
    std::vector<float> product(u.size());
    system.multiply(step, product);
    return dot<float>(step, product);
  }
  StepTaken descend(bool balanced) {
    const double bend = curvature();
    Evaluation start = system.evaluate(u, multipliers);
    const double first = LineSearch<float>::slope_of(start, step);
    return LineSearch<float>(system, multipliers, false, trial)
        .descend(u, step, std::move(start), first, bend, balanced);
  }
};

// As where a floppy bit of tissue meets other tissue: from either side Newton's step leads beyond the equilibrium, each
// time by as much, and within what the energy is rounded by.
TEST(LineSearch, EndsAtTheLowestPlaceWhereAStepWithinRoundingLeadsBeyondIt) {
  HookedSheet scene(2e-3, 1.9);
  const double first = scene.slope();
  const StepTaken taken = scene.descend(true);
  EXPECT_NEAR(taken.alpha, 1.0 / 1.9, 0.02);
  EXPECT_LT(std::abs(scene.slope()), 0.1 * std::abs(first));
}

// The slopes at both ends of the step have it lowest at a fortieth, the wall lies at three tenths.
TEST(LineSearch, GoesUpToAWallThatItMeetsLateOnItsWay) {
  HookedSheet scene(2e-3, 1.0);
  const double first = scene.slope();
  scene.add_wall(0.3);
  const StepTaken taken = scene.descend(true);
  EXPECT_NEAR(taken.alpha, 0.3, 0.01);
  EXPECT_LT(std::abs(scene.slope()), 0.8 * std::abs(first));
}

TEST(LineSearch, TakesAShortStepWithinRoundingWhole) {
  HookedSheet scene(2e-3, 0.05);
  EXPECT_EQ(scene.descend(true).alpha, 1.0);
}

TEST(LineSearch, LetsAStepLeadBeyondTheLowestPlaceWhileForcesAreNotBalanced) {
  HookedSheet scene(2e-3, 1.9);
  EXPECT_EQ(scene.descend(false).alpha, 1.0);
}

TEST(LineSearch, TakesALongStepWholeThatLowersTheEnergyBeyondRounding) {
  HookedSheet scene(2.0, 1.9);
  EXPECT_EQ(scene.descend(true).alpha, 1.0);
}

}  // namespace
}  // namespace lappet
