// Homogeneous states of boxes under retractors against the formulas of neo-Hookean elasticity.
#include <gtest/gtest.h>

#include <cmath>

#include "box.h"
#include "session/session.h"

namespace lappet {
namespace {

struct Accuracy {
  int quadrature;
  const char* precision;
  double tolerance;  // of the solver
  double error;      // relative, allowed
};

class BoxStates : public ::testing::TestWithParam<Accuracy> {
 protected:
  SessionSettings settings(const char* model, double poisson) const {
    SessionSettings s;
    s.quadrature = GetParam().quadrature;
    s.precision = GetParam().precision;
    s.tolerance = GetParam().tolerance;
    s.materials[0].model = model;
    s.materials[0].youngs_modulus = 50;
    s.materials[0].poissons_ratio = poisson;
    s.threads = 2;
    return s;
  }
};

// P_hat of neo-Hookean for given stretches, kPa.
Vec3 neo_hookean(const MaterialParameters& m, const Vec3& s) {
  const double j = s[0] * s[1] * s[2], p = m.lambda() * std::log(j) - m.mu();
  return {m.mu() * s[0] + p / s[0], m.mu() * s[1] + p / s[1], m.mu() * s[2] + p / s[2]};
}

// The stretch of the free directions for which they carry no stress, by bisection.
double free_stretch(const std::function<double(double)>& stress) {
  double low = 0.3, high = 1.5;
  for (int k = 0; k < 200; ++k) (stress(0.5 * (low + high)) < 0 ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

TEST_P(BoxStates, UniaxialTensionInTheMiddleOfALongBar) {
  SessionSettings s = settings("neoHookean", 0.45);
  s.retractors = 1;
  Session session(s);
  Surface surface = box_surface({0, 0, 0}, {40, 4, 4});
  const auto middle = static_cast<std::size_t>(add_vertex(surface, {20, 2, 4}));
  EpochInput epoch = make_epoch(
      surface, [](const Vec3& c) { return c[0] < 1e-9; }, [](const Vec3& c) { return c[0] > 40 - 1e-9 ? 0 : -1; });
  for (const Vec3& p : {Vec3(18, 2, 4), Vec3(22, 2, 4), Vec3(20, 0, 2), Vec3(20, 4, 2), Vec3(20, 2, 0), Vec3(20, 2, 4)})
    add_landmark(epoch, p);
  session.set_epoch(epoch);
  const FrameOutput out = session.solve(pulled({Vec3(12, 0, 0)}), {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  const double axial = (landmark(out, 1) - landmark(out, 0)).norm() / 4;
  const double lateral_y = (landmark(out, 3) - landmark(out, 2)).norm() / 4;
  const double lateral_z = (landmark(out, 5) - landmark(out, 4)).norm() / 4;
  const double expected = free_stretch([&](double t) { return neo_hookean(s.materials[0], {axial, t, t})[1]; });
  EXPECT_GT(axial, 1.25);
  EXPECT_NEAR(lateral_y, expected, GetParam().error * expected);
  EXPECT_NEAR(lateral_z, expected, GetParam().error * expected);
  const double cauchy = neo_hookean(s.materials[0], {axial, expected, expected})[0] / (expected * expected);
  EXPECT_NEAR(out.tension[middle], cauchy, GetParam().error * cauchy);
  EXPECT_NEAR(out.stress[middle], cauchy, GetParam().error * cauchy);
  EXPECT_NEAR(out.strain[middle], axial - 1, GetParam().error * axial);
}

TEST_P(BoxStates, EquibiaxialTensionInTheMiddleOfASheet) {
  SessionSettings s = settings("neoHookean", 0.4);
  s.spacing = 2;
  s.retractors = 4;
  Session session(s);
  Surface surface = box_surface({0, 0, 0}, {64, 64, 2});
  const std::int32_t middle = add_vertex(surface, {32, 32, 2});  // shows the stress there
  EpochInput epoch = make_epoch(surface, {}, [](const Vec3& c) {
    return c[0] < 1e-9 ? 0 : c[0] > 64 - 1e-9 ? 1 : c[1] < 1e-9 ? 2 : c[1] > 64 - 1e-9 ? 3 : -1;
  });
  for (const Vec3& p : {Vec3(30, 32, 2), Vec3(34, 32, 2), Vec3(32, 32, 0), Vec3(32, 32, 2)}) add_landmark(epoch, p);
  session.set_epoch(epoch);
  const double d = 8;
  const FrameOutput out =
      session.solve(pulled({Vec3(-d, 0, 0), Vec3(d, 0, 0), Vec3(0, -d, 0), Vec3(0, d, 0)}), {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  const double stretch = (landmark(out, 1) - landmark(out, 0)).norm() / 4;
  const double thickness = (landmark(out, 3) - landmark(out, 2)).norm() / 2;
  const double expected = free_stretch([&](double t) { return neo_hookean(s.materials[0], {stretch, stretch, t})[2]; });
  EXPECT_GT(stretch, 1.15);
  EXPECT_NEAR(thickness, expected, GetParam().error * expected);
  const Vec3 p = neo_hookean(s.materials[0], {stretch, stretch, expected});
  const double cauchy = p[0] / (stretch * expected);
  EXPECT_NEAR(out.tension[static_cast<std::size_t>(middle)], cauchy, std::max(GetParam().error, 1e-3) * cauchy);
  EXPECT_NEAR(out.stress[static_cast<std::size_t>(middle)], cauchy, std::max(GetParam().error, 1e-3) * cauchy);
  EXPECT_NEAR(out.strain[static_cast<std::size_t>(middle)], stretch - 1, std::max(GetParam().error, 1e-3) * stretch);
}

TEST_P(BoxStates, SimpleShearBetweenTwoPlates) {
  SessionSettings s = settings("neoHookean", 0.3);
  s.retractors = 1;
  s.spacing = 1;
  Session session(s);
  Surface surface = box_surface({0, 0, 0}, {32, 8, 4});
  const auto middle = static_cast<std::size_t>(add_vertex(surface, {16, 0, 2}));
  EpochInput epoch = make_epoch(
      surface, [](const Vec3& c) { return c[2] < 1e-9; }, [](const Vec3& c) { return c[2] > 4 - 1e-9 ? 0 : -1; });
  add_landmark(epoch, Vec3(16, 0, 1));
  add_landmark(epoch, Vec3(16, 0, 2));
  add_landmark(epoch, Vec3(16, 0, 3));
  session.set_epoch(epoch);
  const double gamma = 0.5;
  const FrameOutput out = session.solve(pulled({Vec3(4 * gamma, 0, 0)}), {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  for (std::size_t k = 0; k < 3; ++k) {
    const double z = 1.0 + static_cast<double>(k);
    EXPECT_NEAR(landmark(out, k)[0], 16 + gamma * z, std::max(GetParam().error, 1e-3) * 4 * gamma) << z;
  }
  // F = I + gamma e_x (x) e_z: sigma = mu (F F^T - I), and the largest stretch is gamma/2 + sqrt(1 + gamma^2/4)
  const double mu = s.materials[0].mu();
  const double tension = mu * (gamma * gamma / 2 + std::sqrt(std::pow(gamma, 4) / 4 + gamma * gamma));
  const double von_mises = mu * std::sqrt(std::pow(gamma, 4) + 3 * gamma * gamma);
  const double stretch = gamma / 2 + std::sqrt(1 + gamma * gamma / 4);
  EXPECT_NEAR(out.tension[middle], tension, GetParam().error * tension);
  EXPECT_NEAR(out.stress[middle], von_mises, GetParam().error * von_mises);
  EXPECT_NEAR(out.strain[middle], stretch - 1, GetParam().error * stretch);
}

INSTANTIATE_TEST_SUITE_P(DefaultAndReference, BoxStates,
                         ::testing::Values(Accuracy{1, "float", 1e-3, 0.01}, Accuracy{8, "double", 1e-8, 1e-3}),
                         [](const auto& info) {
                           return std::string(info.param.precision) + std::to_string(info.param.quadrature);
                         });

}  // namespace
}  // namespace lappet
