// The surface against itself: distances against search, the barrier and its sums against differences, the largest step
// against a walk along it, pressures of flat surfaces against the formula.
#include "force/self_contact/self_contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "force/self_contact/barrier.h"
#include "force/self_contact/continuous_collision.h"
#include "force/self_contact/distances.h"
#include "force/two_boxes.h"

namespace lappet {
namespace {

TEST(SelfContact, NothingOnATriangleIsNearerThanItsClosestPoint) {
  Random random;
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3 p = random.vector(2), a = random.vector(1), b = random.vector(1), c = random.vector(1);
    const ClosestOnTriangle found = closest_on_triangle(p, a, b, c);
    const auto& w = found.weights;
    EXPECT_NEAR(w[0] + w[1] + w[2], 1.0, 1e-12);
    EXPECT_NEAR((p - w[0] * a - w[1] * b - w[2] * c).squaredNorm(), found.squared_distance, 1e-12);
    for (int i = 0; i <= 20; ++i)
      for (int k = 0; k <= 20 - i; ++k) {
        const double s = i / 20.0, t = k / 20.0;
        EXPECT_GE((p - (1 - s - t) * a - s * b - t * c).squaredNorm(), found.squared_distance - 1e-12);
      }
  }
}

TEST(SelfContact, NothingOnTwoSegmentsIsNearerThanTheirClosestPointsAlsoWhereTheyAreParallel) {
  Random random;
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3 a = random.vector(1), b = random.vector(1), c = random.vector(1);
    const Vec3 d = trial % 3 == 0 ? Vec3(c + random.number(-2, 2) * (b - a)) : random.vector(1);
    const ClosestOnSegments found = closest_on_segments(a, b, c, d);
    EXPECT_NEAR(((1 - found.first) * a + found.first * b - (1 - found.second) * c - found.second * d).squaredNorm(),
                found.squared_distance, 1e-12);
    for (int i = 0; i <= 40; ++i)
      for (int k = 0; k <= 40; ++k) {
        const double s = i / 40.0, t = k / 40.0;
        EXPECT_GE(((1 - s) * a + s * b - (1 - t) * c - t * d).squaredNorm(), found.squared_distance - 1e-12);
      }
  }
}

TEST(SelfContact, TheBarrierIsZeroFromItsReachOnAndItsSlopeAndCurvatureAreThoseOfItsEnergy) {
  const double reach = 0.05, stiffness = 10.0, step = 1e-7;
  EXPECT_EQ(barrier(reach, reach, stiffness).energy, 0.0);
  EXPECT_EQ(barrier(1.1 * reach, reach, stiffness).slope, 0.0);
  EXPECT_NEAR(barrier(0.5 * reach, reach, stiffness).slope, -(std::log(2.0) + 0.5) * stiffness, 1e-9);
  for (double x = 0.02; x < 1.0; x += 0.02) {
    const BarrierValue at = barrier(x * reach, reach, stiffness), above = barrier(x * reach + step, reach, stiffness),
                       below = barrier(x * reach - step, reach, stiffness);
    EXPECT_NEAR(at.slope, (above.energy - below.energy) / (2 * step), 1e-4 * stiffness) << x;
    EXPECT_NEAR(at.curvature, (above.slope - below.slope) / (2 * step), 1e-3 * at.curvature + 1e-4) << x;
    EXPECT_LT(at.slope, 0.0);
    EXPECT_GT(at.curvature, 0.0);
  }
  EXPECT_LT(barrier((1 - 1e-4) * reach, reach, stiffness).curvature, 1e-3 * barrier(0.5 * reach, reach, 10).curvature);
}

TEST(SelfContact, TheMollifierOfParallelEdgesIsOneFarFromThemAndItsGradientIsThatOfDifferences) {
  const Vec3 edge(1.2, 0.1, 0), other(0.9, 0.08, 0.01);
  const double at_rest = edge.squaredNorm() * other.squaredNorm(), step = 1e-6;
  EXPECT_EQ(ParallelMollifier(edge, Vec3::UnitY(), at_rest).value, 1.0);
  EXPECT_EQ(ParallelMollifier(edge, 2.0 * edge, at_rest).value, 0.0);
  const ParallelMollifier at(edge, other, at_rest);
  ASSERT_LT(at.value, 1.0);
  ASSERT_GT(at.value, 0.0);
  for (int i = 0; i < 3; ++i) {
    const Vec3 h = step * Vec3::Unit(i);
    const double first =
        (ParallelMollifier(edge + h, other, at_rest).value - ParallelMollifier(edge - h, other, at_rest).value) /
        (2 * step);
    const double second =
        (ParallelMollifier(edge, other + h, at_rest).value - ParallelMollifier(edge, other - h, at_rest).value) /
        (2 * step);
    EXPECT_NEAR(at.first[i], first, 1e-4);
    EXPECT_NEAR(at.second[i], second, 1e-4);
  }
}

using Four = std::array<Vec3, 4>;

Four walked(const Four& from, const Four& way, double share) {
  Four result;
  for (int i = 0; i < 4; ++i) result[i] = from[i] + share * way[i];
  return result;
}

// However the primitives tumble: nowhere on the way is less of the distance left than what is to be kept, and where the
// way was cut not much more.
TEST(SelfContact, TheLargestStepKeepsRandomPairsApartAllTheWay) {
  Random random;
  int stopped = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const bool edges = trial % 2 == 0;
    Four from, way;
    for (int i = 0; i < 4; ++i) {
      from[i] = random.vector(1);
      way[i] = random.vector(trial % 5 == 0 ? 20 : 2);
    }
    const auto distance = [&](const Four& x) {
      return std::sqrt(edges ? closest_on_segments(x[0], x[1], x[2], x[3]).squared_distance
                             : closest_on_triangle(x[0], x[1], x[2], x[3]).squared_distance);
    };
    const double share = edges ? segments_way(from, way, 1.0, 1e9) : point_triangle_way(from, way, 1.0, 1e9);
    const double start = distance(from);
    ASSERT_GT(share, 0.0);
    stopped += share < 1.0;
    for (int k = 1; k <= 2000; ++k)
      ASSERT_GE(distance(walked(from, way, share * k / 2000.0)), (1 - 1e-9) * kDistanceKept * start) << trial;
    if (share < 1.0) {
      ASSERT_LE(distance(walked(from, way, share)), 1.2 * kDistanceKept * start) << trial;
    }
  }
  EXPECT_GT(stopped, 500);
  EXPECT_LT(stopped, 3900);
}

TEST(SelfContact, AVertexThatFallsOnAFaceGoesMostOfTheWay) {
  const Four from{Vec3(0.2, 0.2, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const Vec3 fall(0, 0, -10);
  const double share = point_triangle_way(from, {fall, Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}, 1.0, 1e9);
  EXPECT_GT(share, 0.079);
  EXPECT_LE(share, 0.0801);
  const Vec3 all(3, 2, -7);  // together they may go wherever they like
  EXPECT_EQ(point_triangle_way(from, {all, all, all, all}, 1.0, 1e9), 1.0);
}

TEST(SelfContact, SurfacesThatAreCloseAtRestDoNotPushEachOther) {
  for (const double gap : {0.002, 0.01, 0.05, 0.3}) {
    TwoBoxes boxes(gap);
    const SelfContactState state = boxes.evaluate();
    EXPECT_FALSE(state.touches()) << gap;
    EXPECT_EQ(state.energy, 0.0);
    for (const double g : boxes.gradient()) EXPECT_EQ(g, 0.0);
  }
}

TEST(SelfContact, TheGradientIsThatOfTheEnergyWhereVerticesFacesAndEdgesTouch) {
  TwoBoxes boxes(0.4, true, 0.7);
  boxes.move(Vec3(0.13, 0.07, -0.385), 0.004);
  const SelfContactState state = boxes.evaluate();
  int of_faces = 0, of_edges = 0;
  for (const TouchingPair& pair : state.pairs) ++(pair.vertices[3] >= 0 && pair.weights[1] > 0 ? of_edges : of_faces);
  ASSERT_GT(of_faces, 10);
  ASSERT_GT(of_edges, 10);
  const std::vector<double> gradient = boxes.gradient();
  Random random;
  for (int trial = 0; trial < 10; ++trial) {
    std::vector<double> way(boxes.u().size());
    for (double& w : way) w = random.number(-1, 1);
    const double step = 1e-7;
    const std::vector<double> from = boxes.u();
    const auto energy_at = [&](double share) {
      for (std::size_t i = 0; i < way.size(); ++i) boxes.u()[i] = from[i] + share * way[i];
      return boxes.evaluate().energy;
    };
    const double difference = (energy_at(step) - energy_at(-step)) / (2 * step);
    boxes.u() = from;
    double slope = 0.0, size = 0.0;
    for (std::size_t i = 0; i < way.size(); ++i) {
      slope += gradient[i] * way[i];
      size += std::abs(gradient[i] * way[i]);
    }
    EXPECT_NEAR(slope, difference, 1e-5 * size) << trial;
  }
}

void add_product(const SparseRows& rows, double sign, const std::vector<double>& way, std::vector<double>& to) {
  for (std::size_t row = 0; row < rows.count(); ++row) {
    double along = 0.0;
    for (auto k = rows.start[row]; k < rows.start[row + 1]; ++k)
      for (int i = 0; i < 3; ++i) along += rows.factors[k][i] * way[offset_of(3, rows.nodes[k]) + i];
    for (auto k = rows.start[row]; k < rows.start[row + 1]; ++k)
      for (int i = 0; i < 3; ++i) to[offset_of(3, rows.nodes[k]) + i] += sign * along * rows.factors[k][i];
  }
}

// Where faces lie flat on each other nothing is left out of the exact tangent.
TEST(SelfContact, TheTangentOfFlatSurfacesIsThatOfTheGradient) {
  TwoBoxes boxes(0.4);
  boxes.move(Vec3(0, 0, -0.37));
  const SelfContactState state = boxes.evaluate();
  ASSERT_TRUE(state.touches());
  const SparseRows rows = boxes.contact().rows(state), negative = boxes.contact().negative_rows(state.pairs);
  ASSERT_GE(rows.count(), state.pairs.size());
  ASSERT_LE(rows.count(), 3 * state.pairs.size());
  std::vector<double> way(boxes.u().size());
  for (std::size_t n = 0; n < way.size() / 3; ++n) way[3 * n + 2] = std::sin(7.0 * double(n));
  std::vector<double> product(way.size(), 0.0);
  add_product(rows, 1.0, way, product);
  add_product(negative, -1.0, way, product);
  const double step = 1e-7;
  const std::vector<double> from = boxes.u();
  const auto gradient_at = [&](double share) {
    for (std::size_t i = 0; i < way.size(); ++i) boxes.u()[i] = from[i] + share * way[i];
    boxes.evaluate();
    return boxes.gradient();
  };
  const auto above = gradient_at(step), below = gradient_at(-step);
  double off = 0.0, size = 0.0;
  for (std::size_t n = 0; n < way.size() / 3; ++n) {
    off = std::max(off, std::abs(product[3 * n + 2] - (above[3 * n + 2] - below[3 * n + 2]) / (2 * step)));
    size = std::max(size, std::abs(product[3 * n + 2]));
  }
  EXPECT_LT(off, 1e-3 * size);
}

// Half of the surface has slid by less than makes friction whole, half by more.
TEST(SelfContact, FrictionHasAnEnergyAGradientAndATangentThatAgree) {
  const double friction = 0.4, slide = 2e-3, step = 1e-8;
  TwoBoxes with(0.4, true, 0.7, friction), without(0.4, true, 0.7);
  SelfContactState rubbing, pressed;
  for (TwoBoxes* boxes : {&with, &without}) {
    boxes->move(Vec3(0.13, 0.07, -0.385), 0.004);
    boxes->contact().begin<double>(boxes->u());
    EXPECT_EQ(boxes->contact().look_for_friction(boxes->evaluate()), boxes == &with);
    for (std::size_t n = 0; n < boxes->u().size() / 3; ++n) {
      boxes->u()[3 * n] += 1.2 * slide * std::sin(double(n));
      boxes->u()[3 * n + 1] += 0.7 * slide * std::cos(3.0 * double(n));
    }
  }
  const auto evaluate = [&] {
    rubbing = with.evaluate();
    pressed = without.evaluate();
    std::vector<double> gradient = with.gradient();
    for (std::size_t i = 0; i < gradient.size(); ++i) gradient[i] -= without.gradient()[i];
    return gradient;
  };
  const std::vector<double> gradient = evaluate();
  ASSERT_FALSE(rubbing.sliding.empty());
  ASSERT_TRUE(pressed.sliding.empty());
  int held = 0;
  for (const SlidingPair& pair : rubbing.sliding) held += pair.roots[0].squaredNorm() > 0.0;
  EXPECT_GT(held, 10);
  EXPECT_LT(held, int(rubbing.sliding.size()) - 10);
  const auto product_of = [&](const SparseRows& rows, const std::vector<double>& way) {
    std::vector<double> product(way.size(), 0.0);
    add_product(rows, 1.0, way, product);
    return product;
  };
  Random random;
  const std::vector<double> from = with.u();
  for (int trial = 0; trial < 5; ++trial) {
    std::vector<double> way(from.size());
    for (double& w : way) w = random.number(-1, 1);
    const auto at = [&](double share) {
      for (std::size_t i = 0; i < way.size(); ++i) with.u()[i] = without.u()[i] = from[i] + share * way[i];
      std::vector<double> found = evaluate();
      return std::pair(rubbing.energy - pressed.energy, found);
    };
    const auto above = at(step), below = at(-step);
    at(0.0);
    std::vector<double> product = product_of(with.contact().rows(rubbing), way);
    const std::vector<double> of_pressure = product_of(without.contact().rows(pressed), way);
    double slope = 0.0, size = 0.0, off = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < way.size(); ++i) {
      slope += gradient[i] * way[i];
      size += std::abs(gradient[i] * way[i]);
      product[i] -= of_pressure[i];
      off = std::max(off, std::abs(product[i] - (above.second[i] - below.second[i]) / (2 * step)));
      largest = std::max(largest, std::abs(product[i]));
    }
    EXPECT_NEAR(slope, (above.first - below.first) / (2 * step), 1e-4 * size) << trial;
    EXPECT_LT(off, 1e-3 * largest) << trial;
  }
}

// Whatever the triangles: what is over a face, an edge or a corner of the other surface is pushed alike.
TEST(SelfContact, AVertexOverAFlatSurfaceIsPushedByHalfThePressureTimesItsAreaWhereverItIs) {
  TwoBoxes boxes(0.4);
  const double gap = 0.03;
  for (const Vec3& aside : {Vec3(0, 0, 0), Vec3(0.5, 0, 0), Vec3(0.1, 0.23, 0), Vec3(0.25, 0.25, 0)}) {
    boxes.move(aside - Vec3(0, 0, 0.4 - gap));
    const SelfContactState state = boxes.evaluate();
    const double pressure = -barrier(gap, boxes.contact().surface().reach(), boxes.contact().stiffness()).slope;
    std::map<Index, double> push;  // per upper vertex, as the one that comes near a face
    for (const TouchingPair& pair : state.pairs)
      if (pair.vertices[0] >= boxes.first_of_upper() && pair.weights[0] == 1.0)
        push[pair.vertices[0]] -= pair.slope * pair.normal[2];
    int inner = 0;
    for (const auto& [vertex, force] : push) {
      const Vec3 at = boxes.surface().points[vertex];
      if (at[0] < 0.9 || at[0] > 3.1 || at[1] < 0.9 || at[1] > 3.1) continue;
      EXPECT_NEAR(force, 0.5 * pressure * boxes.contact().surface().area(vertex), 1e-9 * force) << aside.transpose();
      ++inner;
    }
    EXPECT_EQ(inner, 25);
  }
}

TEST(SelfContact, AStepThatWouldTakeABoxThroughAnotherEndsBeforeItAndOneThatCarriesBothIsWhole) {
  TwoBoxes boxes(0.5);
  boxes.move(Vec3(0, 0, -10));
  const std::vector<double> step = boxes.u();
  std::ranges::fill(boxes.u(), 0.0);
  const double share = boxes.contact().largest_step<double>(boxes.u(), step, 1.0);
  EXPECT_GT(share, 0.039);
  EXPECT_LT(share, 0.05);
  const std::vector<double> together(step.size(), 3.0);
  EXPECT_EQ(boxes.contact().largest_step<double>(boxes.u(), together, 1.0), 1.0);
  boxes.u() = step;
  EXPECT_EQ(boxes.contact().count_piercings<double>(std::vector<double>(step.size(), 0.0)), 0U);
  boxes.move(Vec3(0.3, 0.2, -1.0));
  EXPECT_GT(boxes.contact().count_piercings<double>(boxes.u()), 10U);
}

TEST(SelfContact, WhatGoesThroughItselfAtTheStartIsLeftOutAndComesFree) {
  TwoBoxes boxes(0.5);
  boxes.move(Vec3(0.31, 0.17, -0.52));
  EXPECT_GT(boxes.contact().begin<double>(boxes.u()), 0U);
  EXPECT_GT(boxes.contact().candidates().left_out(), 0U);
  boxes.move(Vec3(0.31, 0.17, 0.0));
  EXPECT_EQ(boxes.contact().begin<double>(boxes.u()), 0U);
  EXPECT_EQ(boxes.contact().candidates().left_out(), 0U);
}

TEST(SelfContact, PairsAreLookedForAgainOnlyOnceTheSurfaceHasMovedByMoreThanTheSlack) {
  TwoBoxes boxes(0.5);
  boxes.evaluate();
  const auto searches = boxes.contact().candidates().searches();
  boxes.move(Vec3(0, 0, -0.02));
  boxes.evaluate();
  EXPECT_EQ(boxes.contact().candidates().searches(), searches);
  boxes.move(Vec3(0, 0, -0.2));
  boxes.evaluate();
  EXPECT_EQ(boxes.contact().candidates().searches(), searches + 1);
}

// Pairs that are kept must be those that a search from nothing finds, wherever the tissue went meanwhile.
TEST(SelfContact, WhatTouchesDoesNotDependOnTheWayToAState) {
  TwoBoxes walked(0.4, true, 0.7), fresh(0.4, true, 0.7);
  Random random;
  for (int trial = 0; trial < 30; ++trial) {
    const Vec3 to(random.number(-0.5, 0.5), random.number(-0.5, 0.5), random.number(-0.39, -0.2));
    const std::vector<double> before = walked.u();
    walked.move(to, 0.003);
    std::vector<double> step = walked.u();
    for (std::size_t i = 0; i < step.size(); ++i) step[i] -= before[i];
    const std::vector<double> end = walked.u();
    walked.contact().largest_step<double>(before, step, 1.0);
    fresh.u() = end;
    fresh.contact().begin<double>(end);
    EXPECT_EQ(walked.evaluate().energy, fresh.evaluate().energy) << trial;
  }
}

// A search goes only for pairs of what has moved: among those are pairs with what has stayed, and those that it left.
TEST(SelfContact, WhatStaysIsPairedWithWhatComesToIt) {
  TwoBoxes walked(0.4, true, 0.7);
  const Vec3 near(0.1, 0.0, -0.38);
  walked.move(near, 0.003);
  Random random;
  for (int trial = 0; trial < 300; ++trial) {
    const std::vector<double> before = walked.u();
    std::vector<double> step(before.size(), 0.0);
    for (double& part : step)
      if (random.number(0, 1) < 0.02) part = random.number(-0.08, 0.08);
    const double share = walked.contact().largest_step<double>(before, step, 1.0);
    for (std::size_t i = 0; i < step.size(); ++i) walked.u()[i] += 0.9 * share * step[i];
    SelfContact fresh(walked.lattice(), walked.surface(), 50.0);
    std::vector<double> gradient(before.size(), 0.0);
    SelfContactState found;
    fresh.evaluate<double>(walked.u(), gradient, found);
    const SelfContactState state = walked.evaluate();
    ASSERT_TRUE(state.touches());
    EXPECT_EQ(state.pairs.size(), found.pairs.size()) << trial;
    EXPECT_EQ(state.energy, found.energy) << trial;
    EXPECT_EQ(walked.gradient(), gradient) << trial;
  }
}

}  // namespace
}  // namespace lappet
