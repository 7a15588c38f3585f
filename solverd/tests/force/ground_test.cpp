// The ground below undermined tissue: its height, its energy against its forces, and tissue that slides over a dome.
#include "force/constraints/ground.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "box.h"
#include "lattice/refused.h"
#include "session/session.h"
#include "solve/system/system.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

constexpr std::size_t kBudget = std::size_t{1} << 30;
constexpr double kRadius = 40.0;

// A shell over a dome about the origin, n by n quads of an angle to either side: skin above, underside on the dome.
struct Shell {
  Surface surface;
  std::vector<std::uint8_t> rests;  // per triangle: its bed label
  Surface ground;
};

Vec3 on_dome(double radius, double x, double y) { return radius * Vec3(std::tan(x), std::tan(y), 1.0).normalized(); }

Shell shell(double angle, double thickness, int n) {
  Shell result;
  auto& [surface, rests, ground] = result;
  const auto at = [n](int i, int j, bool top) { return to_index((top ? (n + 1) * (n + 1) : 0) + i * (n + 1) + j); };
  for (const bool top : {false, true})
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j)
        surface.points.push_back(
            on_dome(kRadius + (top ? thickness : 0.0), angle * (2.0 * i / n - 1), angle * (2.0 * j / n - 1)));
  const auto quad = [&](Index a, Index b, Index c, Index d, bool below) {
    for (const auto& triangle : {std::array{a, b, c}, std::array{a, c, d}}) {
      surface.triangles.push_back(triangle);
      rests.push_back(below ? kRestsOnBed : 0);
    }
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      quad(at(i, j, true), at(i + 1, j, true), at(i + 1, j + 1, true), at(i, j + 1, true), false);
      quad(at(i, j, false), at(i, j + 1, false), at(i + 1, j + 1, false), at(i + 1, j, false), true);
    }
    quad(at(i, 0, false), at(i + 1, 0, false), at(i + 1, 0, true), at(i, 0, true), false);
    quad(at(i + 1, n, false), at(i, n, false), at(i, n, true), at(i + 1, n, true), false);
    quad(at(0, i + 1, false), at(0, i, false), at(0, i, true), at(0, i + 1, true), false);
    quad(at(n, i, false), at(n, i + 1, false), at(n, i + 1, true), at(n, i, true), false);
  }
  ground.points = surface.points;
  for (std::size_t t = 0; t < rests.size(); ++t)
    if (rests[t]) ground.triangles.push_back(surface.triangles[t]);
  return result;
}

class ShellOnDome {
 public:
  // The shell lies on a dome that is wider than it.
  ShellOnDome() : shell_(shell(0.25, 3.0, 20)) {
    lattice_ = build_lattice(shell_.surface, {});
    const std::vector<std::uint8_t> fixed(shell_.rests.size(), 0);
    const std::vector<Index> grip(shell_.rests.size(), -1);
    const auto ground = std::make_shared<const Ground>(shell(0.6, 3.0, 60).ground, 1.0, kBudget);
    const auto made = [&](double stiffness) {
      return std::make_unique<System<double>>(lattice_, CellMaterials{{MaterialParameters{}}}, 1,
                                              attach(lattice_, shell_.surface, fixed, shell_.rests, grip, ground), 0,
                                              BedStiffness{stiffness, stiffness}, Vec3::Zero());
    };
    system_ = made(kStiffness);
    without_ = made(0.0);
    for (const RestingFace& face : system_->attachments().resting) area_ += face.area;
  }
  static constexpr double kStiffness = 2.0;  // kPa/mm
  System<double>& system() { return *system_; }
  double area() const { return area_; }
  double resting_energy(const Eigen::Affine3d& motion) {
    const auto u = moved(motion);
    return system_->evaluate(u, {}).energy - without_->evaluate(u, {}).energy;
  }
  std::vector<double> moved(const Eigen::Affine3d& motion) const {
    std::vector<double> u;
    for (const Vec3& rest : lattice_.node_rest) {
      const Vec3 by = motion * rest - rest;
      u.insert(u.end(), by.begin(), by.end());
    }
    return u;
  }

 private:
  Shell shell_;
  Lattice lattice_;
  std::unique_ptr<System<double>> system_, without_;
  double area_ = 0.0;
};

Eigen::Affine3d slid(double angle, double sunk = 0.0) {
  return Eigen::AngleAxisd(angle, Vec3::UnitY()) * Eigen::Translation3d(Vec3(0, 0, -sunk));
}

TEST(Ground, HeightsAreDistancesToTheSheetPositiveOutsideAndNegativeBelow) {
  const Ground ground(shell(0.5, 3.0, 60).ground, 1.0, kBudget);
  for (const double x : {-0.3, 0.0, 0.2})
    for (const double above : {-1.2, -0.5, 0.0, 0.4})
      EXPECT_NEAR(ground.height(on_dome(kRadius + above, x, 0.1)).value, above, 0.03);
  EXPECT_LT((ground.height(on_dome(kRadius - 1, 0.2, 0.1)).gradient - on_dome(1.0, 0.2, 0.1)).norm(), 0.02);
  EXPECT_EQ(ground.height(on_dome(kRadius + 20, 0, 0)).gradient, Vec3::Zero());
  EXPECT_EQ(ground.height(Vec3(kRadius, 0, 0)).gradient, Vec3::Zero());  // beside the sheet
}

TEST(Ground, TheBodyBelowASheetIsClosed) {
  const Surface body = body_below(shell(0.5, 3.0, 6).ground, 4.0);
  std::map<std::pair<Index, Index>, int> sides;
  for (const auto& corners : body.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = corners[k], b = corners[(k + 1) % 3];
      sides[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  for (const auto& [edge, sum] : sides) EXPECT_EQ(sum, 0);
}

TEST(Ground, FacesThatRestAreRefusedWithoutOne) {
  const Shell resting = shell(0.25, 3.0, 4);
  const Lattice lattice = build_lattice(resting.surface, {});
  const std::vector<std::uint8_t> fixed(resting.rests.size(), 0), loose(fixed);
  const std::vector<Index> grip(resting.rests.size(), -1);
  EXPECT_THROW((void)attach(lattice, resting.surface, fixed, resting.rests, grip), RefusedError);
  EXPECT_FALSE(attach(lattice, resting.surface, fixed, loose, grip).ground);
}

TEST(Ground, TissueThatSlidesOverADomeIsPushedNoMoreThanAtRest) {
  ShellOnDome scene;
  EXPECT_TRUE(scene.system().evaluate(scene.moved(slid(0.0)), {}).contact_penalties.empty());
  // On planes that stay where the faces lay the shell's leading part, 5 mm away, would have sunk by 5^2/80 = 0.3 mm and
  // more; what is left are facets of the dome.
  EXPECT_LT(scene.resting_energy(slid(0.125)), 0.5 * ShellOnDome::kStiffness * scene.area() * 0.02 * 0.02);
  // Sunk by d everywhere along z: k/2 d^2 of the area, by the cosine of the dome's slope squared (here 1 to 0.94).
  const double d = 0.5;
  const double sunk = scene.resting_energy(slid(0.125, d));
  const double flat = 0.5 * ShellOnDome::kStiffness * scene.area() * d * d;
  EXPECT_GT(sunk, 0.90 * flat);
  EXPECT_LT(sunk, 1.02 * flat);
}

TEST(Ground, ForcesAreTheDerivativeOfTheEnergy) {
  ShellOnDome scene;
  auto u = scene.moved(slid(0.1, 0.3));
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<double> direction(u.size());
  for (auto& x : direction) x = normal(random);
  const auto energy = [&](double by) {
    auto v = u;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += by * direction[i];
    return scene.system().evaluate(v, {}).energy;
  };
  const Evaluation at = scene.system().evaluate(u, {});
  EXPECT_GT(at.contact_penalties.size(), 100U);
  double slope = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) slope += at.gradient[i] * direction[i];
  const double eps = 1e-6;
  EXPECT_NEAR((energy(eps) - energy(-eps)) / (2 * eps), slope, 1e-5 * std::abs(slope));
}

TEST(Ground, AnUnderminedSheetSinksByItsWeightOverTheBedAlsoWhereItHasSlid) {
  for (const double slid_by : {0.0, 6.0}) {
    SessionSettings s;
    s.materials[0].model = "corotated";
    s.materials[0].poissons_ratio = 0.0;
    s.gravity = Vec3(0, 0, -9.81);
    s.bed_shear = 0.0;
    s.bed_stiffness = 1.0;  // the weak bed of what floats has 0.004
    s.tolerance = 1e-6;
    s.precision = "double";
    Session session(s);
    EpochInput epoch = make_epoch(test::box({slid_by, 0, 0}, {slid_by + 8, 8, 2}), {});
    for (std::size_t t = 0; t < epoch.bed.size(); ++t) {
      bool below = true;
      for (const Index p : epoch.surface.triangles[t]) below = below && epoch.surface.points[p][2] == 0.0;
      if (below) epoch.bed[t] = kRestsOnBed;
    }
    epoch.ground = Surface{{{-10, -10, 0}, {-10, 30, 0}, {30, 30, 0}, {30, -10, 0}}, {{0, 1, 2}, {0, 2, 3}}};
    epoch.landmarks = {epoch.surface.points[0]};
    epoch.landmark_triangles = {0};
    for (std::size_t t = 0; t < epoch.surface.triangles.size(); ++t)
      if (std::ranges::find(epoch.surface.triangles[t], Index{0}) != epoch.surface.triangles[t].end())
        epoch.landmark_triangles[0] = to_index(t);
    session.set_epoch(epoch);
    const std::atomic<bool> never{false};
    const FrameOutput out = session.solve(FrameInput{}, {}, never);
    ASSERT_TRUE(out.converged) << out.failure.message;
    const double pressure = s.materials[0].density * 9.81e-6 * 2;  // kPa
    EXPECT_NEAR(out.landmarks[2] - epoch.landmarks[0][2], -pressure / s.bed_stiffness,
                0.01 * pressure / s.bed_stiffness);
  }
}

}  // namespace
}  // namespace lappet
