// Several materials in one bar through a Session: layers side by side share the stretch, layers in series the force.
#include <gtest/gtest.h>

#include "material_formulas.h"
#include "pulled_bar.h"

namespace lappet {
namespace {

constexpr double kDeep = std::numeric_limits<double>::infinity();

// The bar's top with a vertex row at `split`, so that both parts can be painted.
Surface top_of(const Bar& bar, double split) {
  Surface skin;
  for (const double x : {0.0, split, bar.length})
    for (const double y : {0.0, bar.width}) skin.points.emplace_back(x, y, bar.height);
  skin.triangles = {{0, 2, 3}, {0, 3, 1}, {2, 4, 5}, {2, 5, 3}};
  return skin;
}

SessionSettings two_materials(double first, double second) {
  SessionSettings s;
  s.retractors = 1;
  s.threads = 2;
  s.materials.resize(2);
  s.materials[0].youngs_modulus = first;
  s.materials[1].youngs_modulus = second;
  return s;
}

Piola piola_of(const MaterialParameters& m) {
  return [m](const Matrix3& f) { return isotropic_piola(m, f); };
}
double tension(const MaterialParameters& m, double stretch) {
  return piola_of(m)(free_sides(piola_of(m), stretch))(0, 0);
}

// The softer material lies below or behind; its modulus is 5 kPa.
class Contrast : public ::testing::TestWithParam<std::tuple<double, bool>> {
 protected:
  double contrast() const { return std::get<0>(GetParam()); }
  SessionSettings settings() const {
    SessionSettings s = two_materials(5 * contrast(), 5);
    if (std::get<1>(GetParam())) {
      s.quadrature = 8;
      s.precision = "double";
      s.tolerance = 1e-8;
    }
    return s;
  }
};

// With one Poisson's ratio both layers narrow alike, so the state of each is that of a bar by itself.
TEST_P(Contrast, SkinOverFatPullsByTheSumOfBothLayers) {
  const SessionSettings s = settings();
  const Bar bar;
  EpochInput epoch = bar_epoch(bar);
  epoch.skin = top_of(bar, 20);
  epoch.regions = {{1, 1.0, kDeep, {1, 1, 1, 1}}};  // fat below 1 mm of skin
  Session session(s);
  session.set_epoch(epoch);
  const Gauge gauge = read_gauge(pull(session, 8), bar);
  const double expected = bar.width * (1.0 * tension(s.materials[0], gauge.axial) +
                                       (bar.height - 1.0) * tension(s.materials[1], gauge.axial));
  const double error = std::get<1>(GetParam()) ? 2e-3 : 1e-2;
  EXPECT_NEAR(gauge.lateral_y, free_sides(piola_of(s.materials[0]), gauge.axial)(1, 1), 1e-2);
  EXPECT_NEAR(pulling_force(session, 8, 0.1), expected, error * expected);
}

TEST_P(Contrast, InSeriesBothPartsBearTheSameForce) {
  const SessionSettings s = settings();
  const Bar bar{60, 4, 4};
  EpochInput epoch = bar_epoch(bar);
  epoch.skin = top_of(bar, 30);
  epoch.regions = {{1, 0.0, kDeep, {0, 0, 1, 1}}};
  add_gauge(epoch, bar, 15);
  add_gauge(epoch, bar, 45);
  Session session(s);
  session.set_epoch(epoch);
  const FrameOutput out = pull(session, 9);
  const Gauge stiff = read_gauge(out, bar, 1), soft = read_gauge(out, bar, 2);
  const double expected = tension(s.materials[1], soft.axial);
  const bool exact = std::get<1>(GetParam());
  EXPECT_GT(soft.axial, 1.2);
  EXPECT_NEAR(pulling_force(session, 9, 0.1) / bar.area(), expected, (exact ? 2e-3 : 1e-2) * expected);
  // By default a stretch is known to about the tolerance, 1e-3 of the whole.
  EXPECT_NEAR(tension(s.materials[0], stiff.axial), expected,
              exact ? 2e-3 * expected : std::max(0.02 * expected, 2e-4 * s.materials[0].youngs_modulus));
}

INSTANTIATE_TEST_SUITE_P(Session, Contrast, ::testing::Combine(::testing::Values(10.0, 1000.0), ::testing::Bool()),
                         [](const auto& info) {
                           return "Of" + std::to_string(static_cast<int>(std::get<0>(info.param))) +
                                  (std::get<1>(info.param) ? "Double8" : "Default");
                         });

}  // namespace
}  // namespace lappet
