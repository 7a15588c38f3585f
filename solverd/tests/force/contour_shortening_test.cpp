// Contours along which a surface goes through itself: the direction in which they get shorter, and tissue that comes
// apart by it.
#include "force/self_contact/contour_shortening.h"

#include <gtest/gtest.h>

#include "force/two_boxes.h"

namespace lappet {
namespace {

// A box and a tetrahedron above it, of which the tip points down.
class BoxAndTip {
 public:
  BoxAndTip() : surface_(grid_box({0, 0, 0}, {6, 6, 2}, 3.0)) {
    first_of_tip_ = surface_.points.size();
    Surface tip;
    tip.points = {{2.3, 1.1, 2.2}, {0.6, 0.3, 5.0}, {3.9, 0.2, 5.2}, {2.1, 3.4, 4.7}};
    tip.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}};
    append(surface_, tip);
    lattice_ = build_lattice(surface_, {});
    contact_ = std::make_unique<ContactSurface>(lattice_, surface_, 0.05, Interrupt{});
    candidates_ = std::make_unique<ContactCandidates>(*contact_, 0.05);
  }
  // With the tip moved.
  std::vector<Vec3> places(const Vec3& by) const {
    std::vector<Vec3> result = surface_.points;
    for (std::size_t v = first_of_tip_; v < result.size(); ++v) result[v] += by;
    return result;
  }
  std::vector<ContourPoint> points(const Vec3& by, double near) {
    const std::vector<Vec3> at = places(by);
    return contour_points(*contact_, at, candidates_->piercings(at), near);
  }
  const ContactSurface& contact() const { return *contact_; }
  // The contour is a triangle.
  double contour_length(const Vec3& by) {
    const std::vector<Vec3> at = places(by);
    std::vector<Vec3> corners;
    for (const ContourPoint& point : points(by, 0.0)) {
      const auto& [a, b] = contact_->edges()[point.edge];
      corners.push_back((1.0 - point.share) * at[a] + point.share * at[b]);
    }
    EXPECT_EQ(corners.size(), 3U);
    double length = 0.0;
    for (std::size_t k = 0; k < corners.size(); ++k) length += (corners[k] - corners[(k + 1) % corners.size()]).norm();
    return length;
  }

 private:
  Surface surface_;
  std::size_t first_of_tip_ = 0;
  Lattice lattice_;
  std::unique_ptr<ContactSurface> contact_;
  std::unique_ptr<ContactCandidates> candidates_;
};

TEST(IntersectionContours, OneOfATipGetsShorterFastestWhereTheTipIsDrawnBack) {
  BoxAndTip scene;
  const Vec3 in(0.1, -0.05, -0.6);
  const double step = 1e-4;
  Vec3 gradient;
  for (int i = 0; i < 3; ++i)
    gradient[i] = (scene.contour_length(in + step * Vec3::Unit(i)) - scene.contour_length(in - step * Vec3::Unit(i))) /
                  (2.0 * step);
  for (const ContourPoint& point : scene.points(in, 10.0)) {
    EXPECT_NEAR((point.direction.normalized() + gradient.normalized()).norm(), 0.0, 1e-3);
    EXPECT_GT(point.direction.norm(), 0.9);
    EXPECT_LE(point.direction.norm(), 1.0);
  }
}

TEST(IntersectionContours, WeightsAndSharesMeetAtOnePoint) {
  BoxAndTip scene;
  const Vec3 in(0.1, -0.05, -0.6);
  const std::vector<Vec3> at = scene.places(in);
  for (const ContourPoint& point : scene.points(in, 0.0)) {
    const auto& [a, b] = scene.contact().edges()[point.edge];
    Vec3 on_face = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) on_face += point.weights[k] * at[scene.contact().triangles()[point.face][k]];
    EXPECT_NEAR(((1.0 - point.share) * at[a] + point.share * at[b] - on_face).norm(), 0.0, 1e-9);
  }
  EXPECT_TRUE(scene.points(Vec3::Zero(), 1.0).empty());
}

// A box and a plate above its edge, moved down into it.
struct BoxAndPlate {
  explicit BoxAndPlate(double depth, double edge = 0.5) : surface(grid_box({0, 0, 0}, {4, 4, 2}, 1.0)) {
    const std::size_t first_of_plate = surface.points.size();
    append(surface, grid_box({-0.3, 1, 2.3}, {0.2, 3, 5}, edge));
    lattice = build_lattice(surface, {});
    u.assign(3 * lattice.node_rest.size(), 0.0);
    for (std::size_t v = first_of_plate; v < surface.points.size(); ++v)
      for (const Index n : lattice.cell_nodes[lattice.surface_points[v].cell]) u[3 * n + 2] = -0.3 - depth;
  }

  Surface surface;
  Lattice lattice;
  std::vector<double> u;
};

// Rounds until nothing goes through anything; -1 where a round says that it has come to its end.
int rounds_apart(BoxAndPlate& scene) {
  ContactSurface contact(scene.lattice, scene.surface, 0.05, Interrupt{});
  ContactCandidates candidates(contact, 0.05);
  ContourShortening shortening(contact, kAllMove, scene.u);
  std::vector<Vec3> places;
  for (int round = 0;; ++round) {
    contact.positions<double>(scene.u, places);
    const auto& piercings = candidates.piercings(places);
    if (piercings.empty()) return round;
    if (!shortening.push(places, piercings, scene.u)) return -1;
  }
}

TEST(ContourShortening, DrawsAPlateBackFromTheEdgeOfABox) {
  for (const double depth : {0.02, 0.1, 0.2}) {
    BoxAndPlate scene(depth);
    const std::vector<double> before = scene.u;
    EXPECT_GT(rounds_apart(scene), 0) << depth;
    double most = 0.0;
    for (std::size_t n = 0; 3 * n < before.size(); ++n)
      most = std::max(most, (Vec3::Map(&scene.u[3 * n]) - Vec3::Map(&before[3 * n])).norm());
    EXPECT_LT(most, depth + 0.05);
  }
}

TEST(ContourShortening, WhatCannotMoveStaysAndTheRestIsTakenApart) {
  BoxAndPlate scene(0.1, 0.1);
  Surface tip;  // beside the plate, above the box
  tip.points = {{3.3, 3.1, 2.2}, {3.2, 3.0, 4.0}, {3.5, 3.0, 4.0}, {3.3, 3.4, 4.0}};
  tip.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}};
  const std::size_t first_of_tip = scene.surface.points.size();
  append(scene.surface, tip);
  scene.lattice = build_lattice(scene.surface, {});
  scene.u.resize(3 * scene.lattice.node_rest.size(), 0.0);
  std::vector<std::uint8_t> held(scene.lattice.node_rest.size(), 0);
  for (std::size_t v = 0; v < scene.surface.points.size(); ++v)
    for (const Index n : scene.lattice.cell_nodes[scene.lattice.surface_points[v].cell]) {
      if (v >= first_of_tip) scene.u[3 * n + 2] = -0.3;
      if (v >= first_of_tip || scene.surface.points[v][0] > 3.0) held[n] = 1;
    }
  SelfContact contact(scene.lattice, scene.surface, 50.0);
  const std::size_t places = contact.count_piercings<double>(scene.u), of_tip = 3;
  ASSERT_GT(places, 20 * of_tip);
  EXPECT_EQ(contact.untangle<double>(scene.u, [&](Index n) { return held[n] == 0; }), places - of_tip);
  EXPECT_EQ(contact.count_piercings<double>(scene.u), of_tip);
}

TEST(ContourShortening, StopsBeforeNodesGoFarther) {
  BoxAndPlate scene(1.2);
  EXPECT_EQ(rounds_apart(scene), -1);
}

}  // namespace
}  // namespace lappet
