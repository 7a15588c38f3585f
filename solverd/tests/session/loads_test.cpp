// Tractions, pressures and rollers against formulas, the balance of forces and the energy.
#include <gtest/gtest.h>

#include "force/constraints/loaded_faces.h"
#include "material_formulas.h"
#include "session/pulled_bar.h"
#include "solve/system/reaction.h"
#include "solve/system/system.h"

namespace lappet {
namespace {

using Kind = Holder::Kind;
using Where = std::function<bool(const Vec3&)>;

SessionSettings settings(const std::string& model = "neoHookean", double poissons_ratio = 0.3) {
  SessionSettings s;
  s.materials[0].model = model;
  s.materials[0].poissons_ratio = poissons_ratio;
  s.tolerance = 1e-6;
  s.gap_tolerance = 1e-6;
  s.precision = "double";
  return s;
}

// Loads act on the faces of set 0 whose centers are there.
void load(EpochInput& epoch, const Where& where) {
  epoch.loaded_index = {0};
  for (std::size_t t = 0; t < epoch.surface.triangles.size(); ++t)
    epoch.loaded_faces.push_back(where(center(epoch.surface, t)));
}

// One roller for each of some places.
void roll(EpochInput& epoch, const std::vector<Where>& places) {
  epoch.roller.assign(epoch.surface.triangles.size(), -1);
  epoch.roller_normals.assign(places.size(), Vec3::Zero());
  for (std::size_t k = 0; k < places.size(); ++k)
    for (std::size_t t = 0; t < epoch.roller.size(); ++t)
      if (places[k](center(epoch.surface, t))) epoch.roller[t] = to_index(k);
}

Where below(int axis) {
  return [axis](const Vec3& c) { return c[axis] < 1e-9; };
}
Where above(int axis, double at) {
  return [axis, at](const Vec3& c) { return c[axis] > at - 1e-9; };
}

FrameOutput solve(Session& session, const Vec3& traction, double pressure) {
  FrameInput frame;
  frame.loads.push_back({0, traction, pressure});
  FrameOutput out = session.solve(frame, {}, kNever);
  EXPECT_TRUE(out.converged) << out.failure.message;
  return out;
}

Vec3 reaction(const FrameOutput& out, Kind kind, std::int32_t index = 0) {
  for (std::size_t k = 0; k + 1 < out.holders.size(); k += 2)
    if (out.holders[k] == static_cast<std::int32_t>(kind) && out.holders[k + 1] == index)
      return Vec3::Map(&out.reactions[3 * (k / 2)]);
  ADD_FAILURE() << "no reaction of kind " << static_cast<int>(kind) << ", " << index;
  return Vec3::Constant(std::nan(""));
}

Vec3 sum(const std::vector<double>& vectors) {
  Vec3 total = Vec3::Zero();
  for (std::size_t k = 0; k < vectors.size(); k += 3) total += Vec3::Map(&vectors[k]);
  return total;
}

// On rollers against three planes the state is uniform: the nominal stress is the traction, in every model.
TEST(Loads, ABarOnRollersStretchesUnderATractionAsItsMaterialDoes) {
  for (const char* model : {"corotated", "neoHookean", "stableNeoHookean", "mooneyRivlin"}) {
    SessionSettings s = settings(model, 0.4);
    EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {10, 4, 3}), {});
    load(epoch, above(0, 10));
    roll(epoch, {below(0), below(1), below(2)});
    add_landmark(epoch, Vec3(10, 4, 3));
    Session session(s);
    session.set_epoch(epoch);
    const FrameOutput out = solve(session, Vec3(15, 0, 0), 0);
    const Vec3 corner = landmark(out, 0);
    const Matrix3 f = Vec3(corner[0] / 10, corner[1] / 4, corner[2] / 3).asDiagonal();
    const Matrix3 p = isotropic_piola(s.materials[0], f);
    EXPECT_GT(f(0, 0), 1.2) << model;
    EXPECT_NEAR(p(0, 0), 15, 15e-4) << model;
    EXPECT_NEAR(p(1, 1), 0, 15e-4) << model;
    EXPECT_NEAR(p(2, 2), 0, 15e-4) << model;
    EXPECT_LT((reaction(out, Kind::kRoller, 0) + Vec3(15 * 4 * 3, 0, 0)).norm(), 1e-3 * 15 * 12) << model;
    EXPECT_LT((reaction(out, Kind::kLoad) - Vec3(15 * 4 * 3, 0, 0)).norm(), 1e-6) << model;
  }
}

TEST(Loads, RollersOffTheLatticeHoldAsThoseOnItDo) {
  SessionSettings s = settings();
  s.origin = Vec3(-0.4, -0.3, -0.2);
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {10, 4, 3}), {});
  load(epoch, above(0, 10));
  roll(epoch, {below(0), below(1), below(2)});
  add_landmark(epoch, Vec3(10, 4, 3));
  Session session(s);
  session.set_epoch(epoch);
  const FrameOutput out = solve(session, Vec3(15, 0, 0), 0);
  const Vec3 corner = landmark(out, 0);
  const Matrix3 f = Vec3(corner[0] / 10, corner[1] / 4, corner[2] / 3).asDiagonal();
  // cells that the tissue fills in part have its volume to a fine voxel
  EXPECT_NEAR(isotropic_piola(s.materials[0], f)(0, 0), 15, 0.05 * 15);
  EXPECT_LT((reaction(out, Kind::kRoller, 0) + Vec3(15 * 4 * 3, 0, 0)).norm(), 1e-3 * 15 * 12);
}

// Held sideways by rollers all around: uniaxial strain.
TEST(Loads, ABlockBetweenRollersIsStrainedAlongOneAxisOnly) {
  SessionSettings s = settings();
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {4, 4, 6}), {});
  load(epoch, above(2, 6));
  roll(epoch, {below(0), above(0, 4), below(1), above(1, 4), below(2)});
  add_landmark(epoch, Vec3(1, 2, 6));
  Session session(s);
  session.set_epoch(epoch);
  const FrameOutput out = solve(session, Vec3(0, 0, -20), 0);
  const Vec3 top = landmark(out, 0);
  EXPECT_LT((top - Vec3(1, 2, top[2])).norm(), 1e-5);
  const Matrix3 p = isotropic_piola(s.materials[0], Vec3(1, 1, top[2] / 6).asDiagonal());
  EXPECT_NEAR(p(2, 2), -20, 2e-3);
  EXPECT_NEAR(reaction(out, Kind::kRoller, 1)[0], p(0, 0) * 24, 1e-3 * 20 * 24);
}

TEST(Loads, HalfAModelInAPlaneOfSymmetryMovesAsTheWholeDoes) {
  SessionSettings s = settings();
  const auto epoch_of = [&](double low) {
    EpochInput epoch = make_epoch(box_surface({low, 0, 0}, {8, 4, 4}),
                                  [](const Vec3& c) { return std::abs(std::abs(c[0]) - 8) < 1e-9; });
    load(epoch, above(2, 4));
    for (const double x : {0.0, 3.0, 6.0}) add_landmark(epoch, Vec3(x, 4, 2));
    return epoch;
  };
  s.origin = Vec3(-8, 0, 0);
  Session whole(s), half(s);
  whole.set_epoch(epoch_of(-8));
  EpochInput epoch = epoch_of(0);
  roll(epoch, {below(0)});
  epoch.roller_normals[0] = Vec3(3, 0, 0);
  half.set_epoch(epoch);
  const FrameOutput a = solve(whole, Vec3(0, 0.5, -3), 0.5), b = solve(half, Vec3(0, 0.5, -3), 0.5);
  EXPECT_LT(landmark(a, 0)[2], 2 - 0.5);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_LT((landmark(a, k) - landmark(b, k)).norm(), 1e-4) << k;
  EXPECT_NEAR(reaction(b, Kind::kFixed)[2], reaction(a, Kind::kFixed)[2] / 2, 1e-3 * 3 * 32);
  EXPECT_LT(sum(b.reactions).norm(), 1e-3 * 3 * 32);
}

TEST(Loads, ACantileverBendsUnderATransverseTractionAsABeamDoes) {
  SessionSettings s = settings("corotated", 0.0);
  s.quadrature = 8;
  s.spacing = 0.5;
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {20, 2, 4}), below(0));
  load(epoch, above(0, 20));
  add_landmark(epoch, Vec3(20, 1, 2));
  Session session(s);
  session.set_epoch(epoch);
  const double traction = 0.02, force = traction * 8, e = s.materials[0].youngs_modulus, g = e / 2;
  const FrameOutput out = solve(session, Vec3(0, 0, traction), 0);
  // Timoshenko: F L^3 / (3 E I) + F L / (k G A), k = 5/6
  const double inertia = 2 * 64 / 12.0, sag = force * 8000 / (3 * e * inertia) + force * 20 / (5.0 / 6 * g * 8);
  EXPECT_NEAR(landmark(out, 0)[2] - 2, sag, 0.02 * sag);
  EXPECT_LT((reaction(out, Kind::kFixed) + Vec3(0, 0, force)).norm(), 1e-4 * force);
}

TEST(Loads, APressureAllAroundChangesTheVolumeByTheBulkModulus) {
  SessionSettings s = settings("neoHookean", 0.3);
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {6, 5, 4}), {});
  load(epoch, [](const Vec3&) { return true; });
  add_landmark(epoch, Vec3(0, 0, 0));
  add_landmark(epoch, Vec3(6, 5, 4));
  Session session(s);
  session.set_epoch(epoch);
  for (const double pressure : {0.5, 15.0, -8.0}) {
    const FrameOutput out = solve(session, Vec3::Zero(), pressure);
    const Vec3 size = landmark(out, 1) - landmark(out, 0);
    const Matrix3 f = Vec3(size[0] / 6, size[1] / 5, size[2] / 4).asDiagonal();
    const Matrix3 cauchy = isotropic_piola(s.materials[0], f) * f.transpose() / f.determinant();
    EXPECT_LT((cauchy + pressure * Matrix3::Identity()).norm(), 1e-3 * std::abs(pressure)) << pressure;
    EXPECT_LT(reaction(out, Kind::kLoad).norm(), 1e-6 * std::abs(pressure) * 30);
    if (pressure == 0.5) {
      const double bulk = s.materials[0].youngs_modulus / (3 * (1 - 2 * 0.3));
      EXPECT_NEAR(f.determinant() - 1, -pressure / bulk, 0.02 * pressure / bulk);
    }
  }
}

// The border is held: all of the pressure has an energy.
TEST(Loads, APressureUnderAHeldSheetIsInBalanceWithItsRim) {
  SessionSettings s = settings("neoHookean", 0.45);
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {16, 8, 2}), [](const Vec3& c) {
    return c[0] < 1e-9 || c[0] > 16 - 1e-9 || c[1] < 1e-9 || c[1] > 8 - 1e-9;
  });
  load(epoch, below(2));
  add_landmark(epoch, Vec3(8, 4, 2));
  Session session(s);
  session.set_epoch(epoch);
  const FrameOutput out = solve(session, Vec3::Zero(), 6);
  EXPECT_GT(landmark(out, 0)[2], 2.8);
  EXPECT_GT(out.lowest_stiffness, 0);
  EXPECT_LT(sum(out.reactions).norm(), 1e-4 * 6 * 128);
  // over a rim that stays the pushes of a pressure add up to those on the area at rest
  EXPECT_LT((reaction(out, Kind::kLoad) - Vec3(0, 0, 6 * 128)).norm(), 1e-6 * 6 * 128);
}

// Its border moves with it: the end of a bar that a pulled end bends away keeps the pressure across it.
TEST(Loads, APressureOnAFreeEndTurnsWithIt) {
  SessionSettings s = settings("corotated", 0.3);
  s.gravity = Vec3(0, 0, -30);
  s.gap_tolerance = 1e-5;
  EpochInput epoch = make_epoch(box_surface({0, 0, 0}, {20, 4, 4}), below(0));
  load(epoch, above(0, 20));
  for (const Vec3& corner : {Vec3(20, 0, 0), Vec3(20, 4, 0), Vec3(20, 0, 4), Vec3(20, 4, 4)})
    add_landmark(epoch, corner);
  Session session(s);
  session.set_epoch(epoch);
  const FrameOutput out = solve(session, Vec3::Zero(), -2.0);  // pulls
  const Vec3 across = landmark(out, 1) - landmark(out, 0), up = landmark(out, 2) - landmark(out, 0);
  const Vec3 normal = across.cross(up).normalized(), force = reaction(out, Kind::kLoad);
  EXPECT_LT(normal[2], -0.1);
  EXPECT_EQ(out.saddles_left, 0);
  EXPECT_TRUE(std::isnan(out.lowest_stiffness));  // without an energy nothing is a minimum of it
  EXPECT_GT(normal.dot(force.normalized()), 0.999);
  const Vec3 weight = s.gravity * (s.materials[0].density * 1e-6 * 320);
  EXPECT_LT((sum(out.reactions) + weight).norm(), 1e-4 * force.norm());
}

// A box whose nodes are moved about, under a traction and a pressure on its top or all around.
struct Shaken {
  explicit Shaken(bool closed) {
    std::vector<std::uint8_t> chosen;
    for (std::size_t t = 0; t < box.triangles.size(); ++t) chosen.push_back(closed || center(box, t)[2] > 2 - 1e-9);
    faces = std::make_shared<const LoadedFaces>(lattice, box, chosen);
    for (std::size_t i = 0; i < 3 * lattice.node_rest.size(); ++i) {
      u.push_back(0.3 * std::sin(1.7 * static_cast<double>(i)));
      along.push_back(std::cos(2.3 * static_cast<double>(i)));
    }
    system.fit(multipliers);
    system.set_loads({{0, faces, Vec3(1, -2, 3), 4.0}}, u);
  }
  Evaluation at(double t) {
    std::vector<double> moved(u);
    for (std::size_t i = 0; i < u.size(); ++i) moved[i] += t * along[i];
    return system.evaluate(moved, multipliers);
  }
  double slope(const Evaluation& here) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) sum += here.gradient[i] * along[i];
    return sum;
  }

  Surface box = box_surface({0, 0, 0}, {3, 2, 2});
  std::vector<std::uint8_t> none = std::vector<std::uint8_t>(box.triangles.size(), 0);
  std::vector<Index> grip = std::vector<Index>(box.triangles.size(), -1);
  Lattice lattice = build_lattice(box, {});
  System<double> system{
      lattice, CellMaterials{{MaterialParameters{}}}, 1, attach(lattice, box, none, none, grip), 0, {}, Vec3::Zero()};
  std::shared_ptr<const LoadedFaces> faces;
  std::vector<double> u, along;
  Multipliers multipliers;
};

TEST(Loads, TheForceIsTheDerivativeOfTheEnergyAlongAnyStepFromTheTangent) {
  for (const bool closed : {false, true}) {
    Shaken shaken(closed);
    EXPECT_NEAR(shaken.faces->area(), closed ? 32 : 6, 1e-12);
    shaken.system.linearize(shaken.at(0), PsdProjection::kExact);
    for (const double t : {0.0, 0.2}) {
      const double step = 1e-5, less = shaken.at(t - step).energy, more = shaken.at(t + step).energy;
      const double slope = shaken.slope(shaken.at(t));
      EXPECT_NEAR((more - less) / (2 * step), slope, 1e-6 * std::abs(slope)) << closed << " " << t;
    }
  }
}

TEST(Loads, APressureAllAroundHasAnEnergyThatDoesNotDependOnTheWay) {
  Shaken shaken(true);
  shaken.system.linearize(shaken.at(0), PsdProjection::kExact);
  const double straight = shaken.at(0.3).pressure_energy;
  shaken.along[4] += 5.0;
  shaken.system.linearize(shaken.at(0.2), PsdProjection::kExact);
  shaken.along[4] -= 5.0;
  EXPECT_NEAR(shaken.at(0.3).pressure_energy, straight, 1e-9 * std::abs(straight));
}

TEST(Loads, TheTangentIsTheDerivativeOfTheForceOrItsSymmetricPart) {
  for (const bool closed : {false, true}) {
    Shaken shaken(closed);
    const double step = 1e-5;
    const Evaluation less = shaken.at(-step), more = shaken.at(step);
    shaken.system.linearize(shaken.at(0), PsdProjection::kExact);
    std::vector<double> product(shaken.u.size());
    shaken.system.multiply(shaken.along, product);
    double error = 0.0, size = 0.0, bend = 0.0, form = 0.0;
    for (std::size_t i = 0; i < product.size(); ++i) {
      const double change = (more.gradient[i] - less.gradient[i]) / (2 * step);
      error = std::max(error, std::abs(change - product[i]));
      size = std::max(size, std::abs(change));
      bend += change * shaken.along[i];
      form += product[i] * shaken.along[i];
    }
    EXPECT_NEAR(form, bend, 1e-6 * std::abs(bend)) << closed;  // what is not symmetric has no part in it
    EXPECT_EQ(shaken.system.pressures_have_energy(shaken.u), closed);
    if (closed)
      EXPECT_LT(error, 1e-6 * size);
    else
      EXPECT_GT(error, 1e-3 * size);
  }
}

TEST(Loads, AFaceThatIsLiftedSweepsItsAreaTimesTheHeight) {
  Shaken shaken(false);
  for (std::size_t n = 0; n < shaken.lattice.node_rest.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i) shaken.u[3 * n + i] = i == 2 ? 0.5 + 0.1 * shaken.lattice.node_rest[n][0] : 0.0;
  shaken.system.set_loads({{0, shaken.faces, Vec3::Zero(), 4.0}}, std::vector<double>(shaken.u.size(), 0.0));
  EXPECT_NEAR(shaken.at(0).pressure_energy, 4.0 * 6 * (0.5 + 0.15), 1e-9);
}

}  // namespace
}  // namespace lappet
