// Equilibria against formulas: each state is one that a box takes under fixed faces, retractors, hooks, a suture.
#include "session/session.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "box.h"
#include "force/constraints/attachments.h"
#include "lattice/refused.h"

namespace lappet {
namespace {

Surface two_halves(double gap) {
  Surface surface = box_surface({0, 0, 0}, {10 - gap / 2, 6, 3});
  append(surface, box_surface({10 + gap / 2, 0, 0}, {20, 6, 3}));
  return surface;
}

TEST(Session, AThroughCutLeavesTwoBodiesThatMoveApartWithoutForce) {
  for (const double gap : {0.01, 0.3}) {
    SessionSettings s;
    s.spacing = 1;
    s.retractors = 1;
    Session session(s);
    EpochInput epoch = make_epoch(
        two_halves(gap), [](const Vec3& c) { return c[0] < 1e-9; },
        [](const Vec3& c) { return c[0] > 20 - 1e-9 ? 0 : -1; });
    EXPECT_EQ(session.set_epoch(epoch).fragments, 2);
    const FrameOutput out = session.solve(pulled({Vec3(7, 1, 2)}), {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    EXPECT_LT(out.energy, 1e-6 * 50 * 180);  // of a fully strained box
    for (std::size_t v = 0; v < epoch.surface.points.size(); ++v) {
      const Vec3 moved =
          Vec3(out.points[3 * v], out.points[3 * v + 1], out.points[3 * v + 2]) - epoch.surface.points[v];
      EXPECT_NEAR((moved - (v < 8 ? Vec3::Zero() : Vec3(7, 1, 2))).norm(), 0.0, 2e-3) << v;
    }
  }
}

// A block with a slot from above, as one closed surface: an extruded U.
Surface slotted(double gap, double depth) {
  const double l = 10 - gap / 2, r = 10 + gap / 2, z = 3 - depth;
  const std::vector<std::array<double, 2>> outline = {{0, 0}, {l, 0}, {r, 0}, {20, 0}, {20, 3},
                                                      {r, 3}, {r, z}, {l, z}, {l, 3},  {0, 3}};
  Surface s;
  for (const double y : {0.0, 6.0})
    for (const auto& p : outline) s.points.emplace_back(p[0], y, p[1]);
  const std::vector<std::array<int, 3>> cap = {{0, 1, 7}, {0, 7, 8}, {0, 8, 9}, {1, 2, 6},
                                               {1, 6, 7}, {2, 3, 4}, {2, 4, 5}, {2, 5, 6}};
  for (const auto& t : cap) {
    s.triangles.push_back({t[0], t[1], t[2]});                 // y = 0, outward -y
    s.triangles.push_back({t[0] + 10, t[2] + 10, t[1] + 10});  // y = 6
  }
  for (int i = 0; i < 10; ++i) {
    const int j = (i + 1) % 10;
    s.triangles.push_back({i, i + 10, j + 10});
    s.triangles.push_back({i, j + 10, j});
  }
  return s;
}

TEST(Session, APartialCutStaysOneBodyThatResists) {
  SessionSettings s;
  s.spacing = 1;
  s.retractors = 1;
  Session session(s);
  EpochInput epoch = make_epoch(
      slotted(0.05, 2.0), [](const Vec3& c) { return c[0] < 1e-9; },
      [](const Vec3& c) { return c[0] > 20 - 1e-9 ? 0 : -1; });
  const EpochReport report = session.set_epoch(epoch);
  EXPECT_EQ(report.fragments, 1);
  EXPECT_GT(report.mesh_cells, 0);
  const FrameOutput out = session.solve(pulled({Vec3(2, 0, 0)}), {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  EXPECT_GT(out.energy, 0.5);
  // the slot opens
  const auto x = [&](std::size_t v) { return out.points[3 * v]; };
  EXPECT_GT(x(5) - x(8), 0.5);
}

SutureState suture(const EpochInput& epoch, const Vec3& a, const Vec3& b, double closure, std::int32_t index = 0) {
  EpochInput copy = epoch;
  copy.landmarks.clear();
  copy.landmark_triangles.clear();
  add_landmark(copy, a);
  add_landmark(copy, b);
  return {index, {a, copy.landmark_triangles[0]}, {b, copy.landmark_triangles[1]}, closure, 1000.0};
}

TEST(Session, ASutureClosesItsGapWhateverItsStiffness) {
  for (const double stiffness : {1e-2, 1e3, 1e8}) {
    SessionSettings s;
    s.spacing = 1;
    s.sutures = 1;
    s.tolerance = 1e-4;
    Session session(s);
    EpochInput epoch = make_epoch(two_halves(1.0), [](const Vec3& c) { return c[0] < 1e-9 || c[0] > 20 - 1e-9; });
    session.set_epoch(epoch);
    FrameInput frame;
    frame.sutures = {suture(epoch, {9.5, 3, 1.6}, {10.5, 3, 1.6}, 1.0)};
    frame.sutures[0].stiffness = stiffness;
    const FrameOutput out = session.solve(frame, {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    EXPECT_LE(out.suture_gaps[0], 1e-3);
    EXPECT_GT(out.suture_forces[0], 1.0);
    // The tissue at the first end, on the left, is pulled to the right.
    const Vec3 force = Vec3::Map(out.suture_force_vectors.data());
    EXPECT_NEAR(force.norm(), out.suture_forces[0], 1e-9 * out.suture_forces[0]);
    EXPECT_GT(force[0], 0.99 * out.suture_forces[0]);
    // both halves stretch alike
    EXPECT_NEAR(out.suture_points[0], 10.0, 0.01);
    EXPECT_NEAR(out.suture_points[3], 10.0, 0.01);
  }
}

// A suture holds the mean of the tissue around its anchor, which a held wall lets bulge by half a millimeter: walls
// that are farther apart than that contradict it.
TEST(Session, ASutureBetweenTwoHeldPlacesIsReportedAsUnconverged) {
  SessionSettings s;
  s.sutures = 1;
  s.max_newton = 30;
  s.quadrature = 8;
  Session session(s);
  EpochInput epoch = make_epoch(two_halves(4.0), [](const Vec3& c) { return std::abs(c[0] - 10) < 2.01; });
  session.set_epoch(epoch);
  FrameInput frame;
  frame.sutures = {suture(epoch, {8, 3, 1.6}, {12, 3, 1.6}, 1.0)};
  const FrameOutput out = session.solve(frame, {}, kNever);
  EXPECT_FALSE(out.converged);
  EXPECT_NE(out.failure.code, FailureCode::kNone);
  EXPECT_GT(out.largest_gap, s.gap_tolerance * s.spacing) << out.failure.message;
}

// A tilted bar has its held faces off the lattice planes; it stretches as the aligned one.
TEST(Session, HeldFacesOffTheLatticePlanesHoldToTheGapTolerance) {
  double middle[2];
  for (const bool tilted : {false, true}) {
    SessionSettings s;
    s.spacing = 1;
    s.retractors = 1;
    const Eigen::Matrix3d rotation =
        tilted ? Eigen::AngleAxisd(0.4, Vec3(1, 1, 2).normalized()).toRotationMatrix() : Eigen::Matrix3d::Identity();
    Surface surface = box_surface({0, 0, 0}, {24, 6, 6});
    EpochInput epoch = make_epoch(
        surface, [](const Vec3& c) { return c[0] < 1e-9; }, [](const Vec3& c) { return c[0] > 24 - 1e-9 ? 0 : -1; });
    add_landmark(epoch, Vec3(12, 0, 3));
    add_landmark(epoch, Vec3(12, 6, 3));
    for (auto& p : epoch.surface.points) p = rotation * p;
    for (auto& p : epoch.landmarks) p = rotation * p;
    Vec3 low = epoch.surface.points[0];
    for (const auto& p : epoch.surface.points) low = low.cwiseMin(p);
    s.origin = low;
    Session session(s);
    session.set_epoch(epoch);
    const FrameOutput out = session.solve(pulled({rotation * Vec3(5, 0, 0)}), {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    EXPECT_LE(out.largest_gap, 1e-3);
    middle[tilted] = (landmark(out, 1) - landmark(out, 0)).norm();
  }
  EXPECT_NEAR(middle[0], middle[1], 0.02 * middle[0]);
  EXPECT_LT(middle[0], 5.7);
}

TEST(Session, AResumedSolveRepeatsTheFrameBitForBit) {
  for (const char* precision : {"float", "double"}) {
    SessionSettings s;
    s.spacing = 1;
    s.sutures = 1;
    s.retractors = 1;
    s.precision = precision;
    s.threads = 2;
    const EpochInput epoch = make_epoch(
        two_halves(1.0), [](const Vec3& c) { return c[0] < 1e-9; },
        [](const Vec3& c) { return c[0] > 20 - 1e-9 ? 0 : -1; });
    const auto frame = [&](double closure, double x) {
      FrameInput f = pulled({Vec3(x, 0, 0)});
      f.sutures = {suture(epoch, {9.5, 3, 1.6}, {10.5, 3, 1.6}, closure)};
      return f;
    };
    Session first(s);
    first.set_epoch(epoch);
    first.solve(frame(0.0, 0.2), {}, kNever);
    const FrameOutput second = first.solve(frame(0.5, 0.4), {}, kNever);
    const FrameOutput third = first.solve(frame(1.0, 0.6), {}, kNever);
    s.threads = 1;  // whatever the number of threads
    Session resumed(s);
    resumed.set_epoch(epoch);
    resumed.set_state(second.state);
    const FrameOutput again = resumed.solve(frame(1.0, 0.6), {}, kNever);
    ASSERT_TRUE(third.converged && again.converged);
    EXPECT_EQ(third.points, again.points);
    EXPECT_EQ(third.state.nodes, again.state.nodes);
    EXPECT_EQ(third.state.suture_multipliers, again.state.suture_multipliers);
  }
}

TEST(Session, AFragmentThatNothingHoldsStaysAtRest) {
  SessionSettings s;
  Session session(s);
  const EpochInput epoch = make_epoch(two_halves(0.1), [](const Vec3& c) { return c[0] < 1e-9; });
  session.set_epoch(epoch);
  const FrameOutput out = session.solve(FrameInput{}, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  for (std::size_t v = 0; v < epoch.surface.points.size(); ++v)
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(out.points[3 * v + static_cast<std::size_t>(i)], epoch.surface.points[v][i], 1e-4);
}

TEST(Session, AHookPullsWithItsSpringForce) {
  SessionSettings s;
  s.tolerance = 1e-5;
  Session session(s);
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {10, 6, 3}), [](const Vec3& c) { return c[0] < 1e-9; });
  session.set_epoch(epoch);
  FrameInput frame;
  const SutureState where = suture(epoch, {9.5, 3, 3}, {9.5, 3, 3}, 0);
  frame.hooks = {{where.a, Vec3(11, 3, 6), 200.0}};
  const FrameOutput out = session.solve(frame, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  const Vec3 at(out.hook_points[0], out.hook_points[1], out.hook_points[2]);
  const Vec3 force(out.hook_forces[0], out.hook_forces[1], out.hook_forces[2]);
  EXPECT_NEAR((force - 200.0 * (Vec3(11, 3, 6) - at)).norm(), 0, 1e-3 * force.norm());
  EXPECT_GT(force.norm(), 10);
}

// Found by the stability matrix: the weak bed of floating tissue grew with the number of its cells.
TEST(Session, AHookCarriesLooseTissueAllTheWayWhateverTheSpacing) {
  for (const double spacing : {1.0, 0.5, 0.25}) {
    SessionSettings s;
    s.spacing = spacing;
    Session session(s);
    const EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {4, 4, 4}), {});
    session.set_epoch(epoch);
    FrameInput frame;
    frame.hooks = {{suture(epoch, {2, 2, 4}, {2, 2, 4}, 0).a, Vec3(5, 4, 9), 50.0}};
    const FrameOutput out = session.solve(frame, {}, kNever);
    ASSERT_TRUE(out.converged) << out.failure.message;
    const Vec3 at(out.hook_points[0], out.hook_points[1], out.hook_points[2]);
    EXPECT_LT((at - Vec3(5, 4, 9)).norm(), 0.05) << spacing;
  }
}

// Found by the stability matrix: rounding of the displacement times such a stiffness was more than the tolerance.
TEST(Session, AHookFarStifferThanTissueDrawsItsAnchorToTheTargetInSinglePrecision) {
  const auto drawn = [](double stiffness) {
    Session session(SessionSettings{});
    const EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {12, 12, 6}), [](const Vec3& c) { return c[2] < 1e-9; });
    session.set_epoch(epoch);
    FrameInput frame;
    frame.hooks = {{suture(epoch, {6, 6, 6}, {6, 6, 6}, 0).a, Vec3(6, 6, 8), stiffness}};
    return session.solve(frame, {}, kNever);
  };
  const FrameOutput plain = drawn(2e4), stiff = drawn(1e8);
  ASSERT_TRUE(plain.converged) << plain.failure.message;
  ASSERT_TRUE(stiff.converged) << stiff.failure.message;
  EXPECT_NEAR(stiff.hook_points[2], 8.0, 1e-3);  // the gap tolerance
  EXPECT_NEAR(stiff.hook_forces[2], plain.hook_forces[2], 0.01 * plain.hook_forces[2]);
  EXPECT_GT(stiff.hook_forces[2], 10.0);
}

// Between the two kinds of hook the force goes on without a step: the compliance is the spring's own.
TEST(Session, AHookHeldByAMultiplierPullsAsTheSpringItIs) {
  SessionSettings s;
  s.precision = "double";
  s.tolerance = 1e-7;
  s.gap_tolerance = 1e-7;
  s.materials[0].youngs_modulus = 0.01;  // makes a hook of 500 mN/mm a stiff one
  Session session(s);
  const EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {12, 12, 6}), [](const Vec3& c) { return c[2] < 1e-9; });
  session.set_epoch(epoch);
  FrameInput frame;
  frame.hooks = {{suture(epoch, {6, 6, 6}, {6, 6, 6}, 0).a, Vec3(6, 6, 8), 500.0}};
  const FrameOutput out = session.solve(frame, {}, kNever);
  ASSERT_TRUE(out.converged) << out.failure.message;
  const double stretch = 8.0 - out.hook_points[2];
  EXPECT_GT(stretch, 1e-5);
  EXPECT_NEAR(out.hook_forces[2], 500.0 * stretch, 500.0 * 2e-7);
}

// Found by the stability matrix: a stencil of 1 mm radius took hold of tissue that is 0.2 mm thick as a whole.
TEST(Session, ATissueOfATenthTheSizeIsLiftedToATenth) {
  const auto lifted = [](double unit) {
    SessionSettings s;
    s.spacing = unit;
    Session session(s);
    const EpochInput epoch = make_epoch(box_surface({0, 0, 0}, unit * Vec3(24, 16, 2)),
                                        [&](const Vec3& c) { return c[0] < 1e-9 || c[0] > (24 - 1e-9) * unit; });
    session.set_epoch(epoch);
    FrameInput frame;
    const Vec3 at = unit * Vec3(12, 8, 2);
    frame.hooks = {{suture(epoch, at, at, 0).a, at + unit * Vec3(0, 0, 3), 20.0 * unit}};
    return session.solve(frame, {}, kNever);
  };
  const FrameOutput large = lifted(1.0), small = lifted(0.1);
  ASSERT_TRUE(large.converged) << large.failure.message;
  ASSERT_TRUE(small.converged) << small.failure.message;
  EXPECT_GT(large.hook_points[2], 2.5);
  EXPECT_NEAR(small.hook_points[2] / 0.1, large.hook_points[2], 0.01);
  EXPECT_NEAR(small.hook_forces[2] / 0.01, large.hook_forces[2], 0.01 * large.hook_forces[2]);
}

// Found by the end-to-end tests: the coarse operator could not be factored, which ended as a fault.
TEST(Session, AHookOfAbsurdForceIsReportedAsUnconverged) {
  SessionSettings s;
  s.max_newton = 10;
  Session session(s);
  const EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {12, 8, 2}), [](const Vec3& c) { return c[0] < 1e-9; });
  session.set_epoch(epoch);
  FrameInput frame;
  frame.hooks = {{suture(epoch, {11, 4, 2}, {11, 4, 2}, 0).a, Vec3(0, 0, -1e6), 1e9}};
  const FrameOutput out = session.solve(frame, {}, kNever);
  EXPECT_FALSE(out.converged);
  EXPECT_FALSE(out.failure.message.empty());
  for (const float x : out.points) EXPECT_TRUE(std::isfinite(x));
}

TEST(Session, CancelKeepsTheStateAndSaysSo) {
  SessionSettings s;
  s.retractors = 1;
  Session session(s);
  session.set_epoch(make_epoch(
      box_surface({0, 0, 0}, {10, 6, 3}), [](const Vec3& c) { return c[0] < 1e-9; },
      [](const Vec3& c) { return c[0] > 10 - 1e-9 ? 0 : -1; }));
  const std::atomic<bool> cancelled{true};
  try {
    session.solve(pulled({Vec3(3, 0, 0)}), {}, cancelled);
    FAIL() << "the solve was not cancelled";
  } catch (const RefusedError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCancelled);
  }
  EXPECT_TRUE(session.solve(pulled({Vec3(3, 0, 0)}), {}, kNever).converged);
}

TEST(Session, RefusesRegionsAndActivationsThatMakeNoSense) {
  SessionSettings s;
  s.materials.resize(2);
  Session session(s);
  const EpochInput good = [] {
    EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {4, 4, 4}), [](const Vec3& c) { return c[2] < 1e-9; });
    epoch.skin = epoch.surface;
    epoch.regions = {{1, 1.0, 2.0, std::vector<std::uint8_t>(12, 1)}};
    return epoch;
  }();
  const auto refused = [&](const std::function<void(EpochInput&)>& spoil, const char* word) {
    EpochInput epoch = good;
    spoil(epoch);
    try {
      session.set_epoch(epoch);
      ADD_FAILURE() << word << " was accepted";
    } catch (const RefusedError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidInput);
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  refused([](auto& e) { e.regions[0].material = 2; }, "material 2 of 2");
  refused([](auto& e) { e.regions[0].from_depth = -1; }, "-1 to 2 mm");
  refused([](auto& e) { e.regions[0].to_depth = 1.0; }, "1 to 1 mm");
  refused([](auto& e) { e.regions[0].to_depth = std::nan(""); }, "nan mm");
  refused([](auto& e) { e.regions[0].faces.pop_back(); }, "labels 11 triangles");
  refused([](auto& e) { e.skin = Surface{}; }, "no skin");
  refused([](auto& e) { e.skin.triangles[3][0] = 8; }, "names point 8");
  session.set_epoch(good);
  for (const std::vector<double>& activation : {std::vector<double>{0.5}, {0.5, 1.5}, {-0.1, 0.0}}) {
    FrameInput frame;
    frame.activation = activation;
    EXPECT_THROW(session.solve(frame, {}, kNever), RefusedError);
  }
  FrameInput frame;
  frame.activation = {0.0, 1.0};
  const FrameOutput out = session.solve(frame, {}, kNever);
  EXPECT_EQ(out.state.activation, frame.activation);
  SolverState state = out.state;
  session.set_state(state);
  state.activation.pop_back();
  EXPECT_THROW(session.set_state(state), RefusedError);
}

TEST(Session, RefusesSettingsThatMakeNoSense) {
  const auto refused = [](const std::function<void(SessionSettings&)>& spoil, const char* word) {
    SessionSettings s;
    spoil(s);
    try {
      Session session(s);
      ADD_FAILURE() << word << " was accepted";
    } catch (const RefusedError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidInput);
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  refused([](auto& s) { s.spacing = 0; }, "spacing");
  refused([](auto& s) { s.materials[0].poissons_ratio = 0.5; }, "Poisson's ratio of material 0 is 0.5");
  refused([](auto& s) { s.materials[0].model = "jelly"; }, "jelly");
  refused([](auto& s) { s.materials[0].youngs_modulus = -1; }, "Young's modulus");
  refused([](auto& s) { s.materials.clear(); }, "0 materials");
  refused([](auto& s) { s.materials.resize(257); }, "257 materials");
  const auto second = [&](const std::function<void(MaterialParameters&)>& spoil, const char* word) {
    refused(
        [&](auto& s) {
          s.materials.resize(2);
          spoil(s.materials[1]);
        },
        word);
  };
  second([](auto& m) { m.poissons_ratio = -0.1; }, "Poisson's ratio of material 1 is -0.1");
  second([](auto& m) { m.poissons_ratio = 0.49995; }, "0.4999");
  second([](auto& m) { m.density = -1; }, "density of material 1");
  second([](auto& m) { m.mooney_ratio = -1; }, "Mooney");
  second([](auto& m) { m.fiber_k1 = -1; }, "k1");
  second([](auto& m) { m.fiber_k2 = std::nan(""); }, "k2");
  second([](auto& m) { m.fiber_dispersion = 0.34; }, "dispersion");
  second([](auto& m) { m.fiber_direction = Vec3(1, 1, 0); }, "direction");
  second([](auto& m) { m.muscle_stress = -1; }, "muscle");
  second([](auto& m) { m.prestretch[1] = 2.1; }, "prestretch");
  second([](auto& m) { m.prestretch[0] = std::nan(""); }, "prestretch");
  refused([](auto& s) { s.quadrature = 3; }, "quadrature");
  refused([](auto& s) { s.precision = "half"; }, "half");
  refused([](auto& s) { s.tolerance = 1e-9; }, "double");
}

}  // namespace
}  // namespace lappet
