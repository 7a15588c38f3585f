// Boxes that lie in each other by little come apart, by no more than they lie in each other and only there.
#include "force/self_contact/untangling.h"

#include <gtest/gtest.h>

#include "force/two_boxes.h"

namespace lappet {
namespace {

double largest_difference(std::span<const double> a, std::span<const double> b) {
  double most = 0.0;
  for (std::size_t n = 0; 3 * n < a.size(); ++n)
    most = std::max(most, (Vec3::Map(&a[3 * n]) - Vec3::Map(&b[3 * n])).norm());
  return most;
}

class BoxesInEachOther : public testing::TestWithParam<Vec3> {};

TEST_P(BoxesInEachOther, ComeApartByTwiceWhatTheyLieInEachOtherAtMost) {
  const double gap = 0.3;
  TwoBoxes boxes(gap, true);
  boxes.move(GetParam(), 0.01);
  const std::vector<double> before = boxes.u();
  const std::size_t places = boxes.contact().count_piercings<double>(boxes.u());
  ASSERT_GT(places, 0U);
  EXPECT_EQ(boxes.contact().untangle<double>(boxes.u(), kAllMove), places);
  EXPECT_EQ(boxes.contact().count_piercings<double>(boxes.u()), 0U);
  EXPECT_EQ(boxes.contact().begin<double>(boxes.u()), 0U);  // nothing lies on anything
  const double depth = -GetParam()[2] - gap;
  EXPECT_LT(largest_difference(boxes.u(), before), 2.0 * (depth + 0.05));
  EXPECT_TRUE(std::isfinite(boxes.evaluate().energy));
}

INSTANTIATE_TEST_SUITE_P(ByLittle, BoxesInEachOther,
                         testing::Values(Vec3(0.3, 0.2, -0.31), Vec3(0.3, 0.2, -0.35), Vec3(1.4, -0.7, -0.4),
                                         Vec3(3.7, 0.2, -0.45), Vec3(3.4, 3.4, -0.5), Vec3(0.0, 0.0, -0.6)));

TEST(Untangling, BoxesThatLieDeepInEachOtherStayAsTheyAre) {
  TwoBoxes boxes(0.3);
  boxes.move(Vec3(0.3, 0.2, -1.3));
  const std::vector<double> before = boxes.u();
  EXPECT_EQ(boxes.contact().untangle<double>(boxes.u(), kAllMove), 0U);
  EXPECT_EQ(boxes.u(), before);
}

TEST(Untangling, WhatIsApartStaysAsItIs) {
  TwoBoxes boxes(0.3);
  boxes.move(Vec3(0.3, 0.2, -0.25), 0.01);
  const std::vector<double> before = boxes.u();
  EXPECT_EQ(boxes.contact().untangle<double>(boxes.u(), kAllMove), 0U);
  EXPECT_EQ(boxes.u(), before);
}

TEST(Untangling, NodesThatAreHeldStayAndTheOthersMakeWay) {
  TwoBoxes boxes(0.3);
  boxes.move(Vec3(0.3, 0.2, -0.4));
  const std::vector<double> before = boxes.u();
  const auto moves = [&](Index n) { return boxes.lattice().node_rest[n][2] > 2.2; };  // the upper box does
  EXPECT_GT(boxes.contact().untangle<double>(boxes.u(), moves), 0U);
  EXPECT_EQ(boxes.contact().count_piercings<double>(boxes.u()), 0U);
  for (std::size_t n = 0; 3 * n < before.size(); ++n)
    if (!moves(to_index(n))) {
      EXPECT_EQ(Vec3::Map(&boxes.u()[3 * n]), Vec3::Map(&before[3 * n]));
    }
}

TEST(Untangling, OnlyTissueBesideThePlaceMoves) {
  TwoBoxes boxes(0.3);
  boxes.move(Vec3(3.7, 3.7, -0.4));
  const std::vector<double> before = boxes.u();
  EXPECT_GT(boxes.contact().untangle<double>(boxes.u(), kAllMove), 0U);
  for (std::size_t n = 0; 3 * n < before.size(); ++n) {
    const Vec3 now = boxes.lattice().node_rest[n] + Vec3::Map(&before[3 * n]);
    if (now[0] < 1.5 || now[1] < 1.5) {
      EXPECT_EQ(Vec3::Map(&boxes.u()[3 * n]), Vec3::Map(&before[3 * n]));
    }
  }
}

}  // namespace
}  // namespace lappet
