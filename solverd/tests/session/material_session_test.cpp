// Every isotropic model through a Session: tension, shear and equibiaxial stretch of boxes against the models' own
// formulas (material_formulas.h), at default settings and in double with 8 points.
#include <gtest/gtest.h>

#include <tuple>

#include "material_formulas.h"
#include "pulled_bar.h"

namespace lappet {
namespace {

struct Model {
  const char* name;
  const char* model;
  double ratio;
};
struct Accuracy {
  int quadrature;
  const char* precision;
  double tolerance, error;
};

const Accuracy kDefault{1, "float", 1e-3, 1e-2}, kReference{8, "double", 1e-8, 1e-3};

SessionSettings settings_of(const Model& model, const Accuracy& accuracy, double poisson) {
  SessionSettings s;
  s.quadrature = accuracy.quadrature;
  s.precision = accuracy.precision;
  s.tolerance = accuracy.tolerance;
  s.materials[0].model = model.model;
  s.materials[0].mooney_ratio = model.ratio;
  s.materials[0].youngs_modulus = 50;
  s.materials[0].poissons_ratio = poisson;
  s.retractors = 1;
  s.threads = 2;
  return s;
}

Piola piola_of(const SessionSettings& s) {
  return [m = s.materials[0]](const Matrix3& f) { return isotropic_piola(m, f); };
}

// What the surface shows at a vertex against F there.
void expect_measures(const FrameOutput& out, std::size_t vertex, const Piola& piola, const Matrix3& f, double error) {
  const Matrix3 cauchy = cauchy_of(piola, f);
  const double tension = Eigen::SelfAdjointEigenSolver<Matrix3>(cauchy).eigenvalues()[2];
  const double stretch = Eigen::JacobiSVD<Matrix3>(f).singularValues()[0];
  EXPECT_NEAR(out.tension[vertex], tension, error * std::abs(tension));
  EXPECT_NEAR(out.stress[vertex], von_mises(cauchy), error * von_mises(cauchy));
  EXPECT_NEAR(out.strain[vertex], stretch - 1, error * stretch);
}

using Case = std::tuple<Model, bool>;
class EveryModel : public ::testing::TestWithParam<Case> {
 protected:
  const Model& model() const { return std::get<0>(GetParam()); }
  const Accuracy& accuracy() const { return std::get<1>(GetParam()) ? kReference : kDefault; }
  double error() const { return accuracy().error; }
};

TEST_P(EveryModel, ABarsForceAndItsLateralStretchAreThoseOfUniaxialTension) {
  const SessionSettings s = settings_of(model(), accuracy(), 0.45);
  Session session(s);
  const Bar bar;
  session.set_epoch(bar_epoch(bar));
  for (const double elongation : {-1.0, 14.0}) {  // less than the Euler load of 3 %
    const Gauge gauge = read_gauge(pull(session, elongation), bar);
    const Matrix3 f = free_sides(piola_of(s), gauge.axial);
    EXPECT_NEAR(gauge.axial - 1, elongation / bar.length, 0.1 * std::abs(elongation) / bar.length);
    EXPECT_NEAR(gauge.lateral_y, f(1, 1), error() * f(1, 1)) << elongation;
    EXPECT_NEAR(gauge.lateral_z, f(2, 2), error() * f(2, 2)) << elongation;
    const double force = piola_of(s)(f)(0, 0) * bar.area();
    EXPECT_NEAR(pulling_force(session, elongation, 0.2), force, error() * std::abs(force)) << elongation;
  }
}

TEST_P(EveryModel, ALayerBetweenTwoPlatesIsInSimpleShear) {
  const SessionSettings s = settings_of(model(), accuracy(), 0.4);
  Session session(s);
  Surface surface = box_surface({0, 0, 0}, {32, 32, 2});
  const auto middle = static_cast<std::size_t>(add_vertex(surface, {16, 16, 2}));
  session.set_epoch(make_epoch(
      surface, [](const Vec3& c) { return c[2] < 1e-9; }, [](const Vec3& c) { return c[2] > 2 - 1e-9 ? 0 : -1; }));
  const double gamma = 0.5;
  const FrameOutput out = pull(session, 2 * gamma);
  Matrix3 f = Matrix3::Identity();
  f(0, 2) = gamma;
  expect_measures(out, middle, piola_of(s), f, error());
}

TEST_P(EveryModel, TheMiddleOfASheetIsInEquibiaxialTension) {
  SessionSettings s = settings_of(model(), accuracy(), 0.4);
  s.spacing = 2;
  s.retractors = 4;
  Session session(s);
  Surface surface = box_surface({0, 0, 0}, {64, 64, 2});
  const auto middle = static_cast<std::size_t>(add_vertex(surface, {32, 32, 2}));
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
  double low = 0.3, high = 1.1;  // of the thickness, which grows with the stress across
  const auto state = [&](double t) { return Matrix3(Vec3(stretch, stretch, t).asDiagonal()); };
  for (int k = 0; k < 60; ++k) {
    const double t = 0.5 * (low + high);
    (piola_of(s)(state(t))(2, 2) > 0 ? high : low) = t;
  }
  EXPECT_GT(stretch, 1.15);
  EXPECT_NEAR((landmark(out, 3) - landmark(out, 2)).norm() / 2, low, error() * low);
  expect_measures(out, middle, piola_of(s), state(low), error());
}

const Model kModels[] = {{"Corotated", "corotated", 0},
                         {"NeoHookean", "neoHookean", 0},
                         {"Stable", "stableNeoHookean", 0},
                         {"MooneyRivlin0", "mooneyRivlin", 0},
                         {"MooneyRivlinHalf", "mooneyRivlin", 0.5},
                         {"MooneyRivlin2", "mooneyRivlin", 2}};

std::string case_name(const ::testing::TestParamInfo<Case>& info) {
  return std::string(std::get<0>(info.param).name) + (std::get<1>(info.param) ? "Double8" : "Default");
}

INSTANTIATE_TEST_SUITE_P(Session, EveryModel, ::testing::Combine(::testing::ValuesIn(kModels), ::testing::Bool()),
                         case_name);

class NearlyIncompressible : public ::testing::TestWithParam<std::tuple<Model, double>> {};

TEST_P(NearlyIncompressible, ABarKeepsItsVolumeAndHasTheForceOfUniaxialTension) {
  const auto& [model, poisson] = GetParam();
  const SessionSettings s = settings_of(model, kDefault, poisson);
  Session session(s);
  const Bar bar;
  session.set_epoch(bar_epoch(bar));
  const Gauge gauge = read_gauge(pull(session, 10), bar);
  const Matrix3 f = free_sides(piola_of(s), gauge.axial);
  EXPECT_NEAR(gauge.lateral_y, f(1, 1), 1e-2 * f(1, 1));
  EXPECT_NEAR(gauge.lateral_z, f(2, 2), 1e-2 * f(2, 2));
  const double force = piola_of(s)(f)(0, 0) * bar.area();
  EXPECT_NEAR(pulling_force(session, 10, 0.2), force, 1e-2 * force);
}

INSTANTIATE_TEST_SUITE_P(Session, NearlyIncompressible,
                         ::testing::Combine(::testing::ValuesIn(kModels), ::testing::Values(0.49, 0.499)),
                         [](const auto& info) {
                           return std::string(std::get<0>(info.param).name) +
                                  (std::get<1>(info.param) < 0.495 ? "At49" : "At499");
                         });

}  // namespace
}  // namespace lappet
