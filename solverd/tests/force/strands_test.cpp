// Strands of muscle: which cells they hold, and the direction of their fibers.
#include "force/materials/strands.h"

#include <gtest/gtest.h>

#include <cmath>

#include "force/materials/cell_materials.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

Lattice block(double spacing) {
  LatticeSettings settings;
  settings.spacing = spacing;
  return build_lattice(test::box({0, 0, 0}, {12, 6, 6}), settings);
}

Strand along_x() { return {1, {{-1, 3, 3}, {13, 3, 3}}, {2.0, 2.0}}; }

TEST(Strands, HoldTheCellsWhoseMiddleIsNearerThanTheirRadius) {
  const Lattice lattice = block(1.0);
  const std::array strands{along_x()};
  const CellMaterials found =
      assign_materials(lattice, {MaterialParameters{}, MaterialParameters{}}, {}, {}, {}, {}, strands);
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    const auto& [x, y, z] = lattice.cell_position(c);
    const bool inside = std::hypot(y + 0.5 - 3.0, z + 0.5 - 3.0) < 2.0;
    ASSERT_EQ(int(found.of_cell[c]), inside ? 1 : 0) << x << " " << y << " " << z;
    ASSERT_EQ(found.direction_of_cell[c].isZero(), !inside);
    if (inside) {
      ASSERT_NEAR(found.direction_of_cell[c][0], 1.0F, 1e-6F);
    }
  }
}

TEST(Strands, ThatTaperTurnTheirFibersTowardsTheirCourseAsPointsOfOneShareOfTheRadiusLie) {
  const Strand strand{0, {{0, 0, 0}, {20, 0, 0}}, {4.0, 1.0}};
  const double share = 0.6, at = 7.0, step = 1e-4;
  const auto point = [&](double x) { return Vec3(x, share * (4.0 - 3.0 * x / 20.0), 0.0); };
  const InStrand found = in_strand(strand, point(at));
  const Vec3 way = (point(at + step) - point(at - step)).normalized();
  EXPECT_NEAR(found.share, share, 1e-9);
  EXPECT_LT((found.fiber - way).norm(), 1e-6);
}

TEST(Strands, OfSeveralTheOneCountsInWhichTheMiddleLiesDeepestByItsRadius) {
  const Lattice lattice = block(1.0);
  const std::array strands{along_x(), Strand{2, {{6.5, 3.5, -1}, {6.5, 3.5, 7}}, {4.0, 4.0}}};
  const CellMaterials found = assign_materials(lattice, std::vector<MaterialParameters>(3), {}, {}, {}, {}, strands);
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    const auto& [x, y, z] = lattice.cell_position(c);
    const Vec3 middle(x + 0.5, y + 0.5, z + 0.5);
    const double first = in_strand(strands[0], middle).share, second = in_strand(strands[1], middle).share;
    const int wanted = std::min(first, second) >= 1.0 ? 0 : first <= second ? 1 : 2;
    ASSERT_EQ(int(found.of_cell[c]), wanted);
  }
}

}  // namespace
}  // namespace lappet
