// Local relaxation: a subdomain against the whole system, and what it does to creased tissue.
#include "solve/newton/local_relaxation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "box.h"
#include "cut_sheet.h"
#include "grid_box.h"
#include "solve/newton/equilibrium.h"
#include "solve/subdomain/subdomain.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

MaterialParameters skin() {
  MaterialParameters m;
  m.model = "neoHookean";
  m.youngs_modulus = 50.0;
  m.poissons_ratio = 0.45;
  return m;
}

// A slab on a ball of bone with everything that acts on tissue: weight, a fixed end, a bed that holds and one that only
// carries, a grip off the lattice planes, rollers, loads, a suture and a hook; multipliers are at work everywhere.
struct EverythingActs {
  Surface tissue = box_surface({0, 0, 0}, {12, 8, 3.6});
  Lattice lattice;
  std::unique_ptr<System<double>> system;
  std::vector<double> u;
  Multipliers multipliers;

  EverythingActs() {
    LatticeSettings settings;
    settings.spacing = 1.0;
    lattice = build_lattice(tissue, settings);
    const std::size_t triangles = tissue.triangles.size();
    std::vector<std::uint8_t> fixed(triangles, 0), bed(triangles, 0);
    std::vector<std::int32_t> grip(triangles, -1), rolling(triangles, -1);
    std::vector<std::uint8_t> loaded(triangles, 0);
    int below = 0;
    Surface underside{tissue.points, {}};
    for (std::size_t t = 0; t < triangles; ++t) {
      const Vec3 c = center(tissue, t);
      fixed[t] = c[0] < 1e-9;
      if (c[2] < 1e-9) {
        bed[t] = below++ ? kAttachedToBed : kRestsOnBed;
        underside.triangles.push_back(tissue.triangles[t]);
      }
      if (c[2] > 3.6 - 1e-9) grip[t] = 0;
      if (c[1] < 1e-9) rolling[t] = 0;
      loaded[t] = c[1] > 8 - 1e-9;
    }
    const auto ground = std::make_shared<const Ground>(underside, settings.spacing, 1 << 28);
    Attachments attachments = attach(lattice, tissue, fixed, bed, grip, ground);
    attachments.rollers = roller_rows(lattice, tissue, rolling, std::vector<Vec3>{Vec3(0.2, 1, 0)});
    system = std::make_unique<System<double>>(lattice, CellMaterials{{skin()}}, 1, std::move(attachments), 1,
                                              BedStiffness{20.0, 20.0}, Vec3(0, 0, -9810));
    const Surface bone = test::sphere({6, 4, -6}, 6.3, 60);
    auto contact = std::make_unique<Contact>(
        BoneDistance({std::make_shared<const SignedDistance>(bone, 0.5, 3.0, 1 << 28)}), lattice, tissue, fixed, 500.0);
    system->set_contact(std::move(contact));
    const Eigen::Matrix4d motion = translation({0.05, 0.0, -0.1});
    const std::int32_t gripped = 0;
    system->set_retractors({&gripped, 1}, {&motion, 1});
    PointConstraint suture;
    suture.pieces = {{{node({4, 4, 2}), node({8, 4, 2})}, {1.0, -1.0}, Vec3(-1.0, 0.2, 0.0)}};
    suture.stiffness = 400.0;
    suture.exact = true;
    PointConstraint hook = suture;
    hook.pieces[0].nodes = {node({5, 5, 1}), node({6, 5, 1})};
    hook.pieces[0].weights = {0.5, 0.5};
    hook.exact = false;
    hook.id.index = 1;
    PointConstraint thread;  // with anchors in the subdomain of the test and outside it
    const auto between = [&](const Vec3& a, const Vec3& b) {
      return Piece{{node(a), node(b)}, {1.0, -1.0}, lattice.node_rest[node(a)] - lattice.node_rest[node(b)]};
    };
    thread.pieces = {between({3, 4, 1}, {5, 4, 2}), between({5, 4, 2}, {9, 5, 2}), between({9, 5, 2}, {10, 2, 1})};
    thread.stiffness = 90.0;
    thread.exact = true;
    thread.compliance = 1e-3;
    thread.thread = Thread{6.0};
    thread.id.index = 2;
    system->set_point_constraints({suture, hook, thread});
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    u.resize(3 * system->nodes());
    for (auto& x : u) x = 0.04 * normal(random);
    const auto faces = std::make_shared<const LoadedFaces>(lattice, tissue, loaded);
    system->set_loads({{0, faces, Vec3(3, 1, -2), 5.0}, {1, faces, Vec3(0, 0, 1), 0.0}}, u);
    system->fit(multipliers);
    system->update(multipliers, u, system->evaluate(u, multipliers));
  }
  std::int32_t node(const Vec3& at) const {
    std::int32_t best = 0;
    for (std::size_t n = 0; n < lattice.node_rest.size(); ++n)
      if ((lattice.node_rest[n] - at).norm() < (lattice.node_rest[best] - at).norm()) best = to_index(n);
    return best;
  }
};

// What the energy of the whole at u is more than that of a subdomain, whose forces and tangent are those of the whole.
double rest_of_the_energy(System<double>& whole, const Subdomain<double>& subdomain, const Multipliers& multipliers,
                          const std::vector<double>& u) {
  System<double>& local = *subdomain.system;
  const auto& nodes = subdomain.nodes;
  const auto& moves = subdomain.moves;
  std::vector<double> v;
  for (const std::int32_t n : nodes)
    for (int i = 0; i < 3; ++i) v.push_back(u[offset_of(3, n) + i]);
  const Evaluation all = whole.evaluate(u, multipliers), own = local.evaluate(v, subdomain.multipliers);
  whole.linearize(all, PsdProjection::kExact);
  local.linearize(own, PsdProjection::kExact);
  std::vector<double> x(u.size(), 0.0), y(u.size()), xv(v.size()), yv(v.size());
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i)
      if (moves[n]) x[offset_of(3, nodes[n]) + i] = xv[3 * n + i] = normal(random);
  whole.multiply(x, y);
  local.multiply(xv, yv);
  double most = 0.0, off = 0.0, tangent_off = 0.0, tangent_most = 0.0;
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t at = offset_of(3, nodes[n]) + i;
      EXPECT_TRUE(moves[n] || own.gradient[3 * n + i] == 0.0);
      if (!moves[n]) continue;
      most = std::max(most, std::abs(all.gradient[at]));
      off = std::max(off, std::abs(all.gradient[at] - own.gradient[3 * n + i]));
      tangent_most = std::max(tangent_most, std::abs(y[at]));
      tangent_off = std::max(tangent_off, std::abs(y[at] - yv[3 * n + i]));
    }
  EXPECT_LT(off, 1e-12 * most);
  EXPECT_LT(tangent_off, 1e-12 * tangent_most);
  return all.energy - own.energy;
}

TEST(LocalRelaxation, TheSubdomainsEnergyForcesAndTangentAreThoseOfTheWholeWhenOnlyItMoves) {
  EverythingActs scene;
  System<double>& whole = *scene.system;
  ASSERT_GT(whole.evaluate(scene.u, scene.multipliers).contact.count(), 3);
  ASSERT_TRUE(whole.has_exact_constraints());
  // what moves: a slice around one end of the suture, not the other, with faces on rollers and loaded ones
  std::vector<std::uint8_t> moving(whole.nodes(), 0);
  for (std::size_t n = 0; n < moving.size(); ++n)
    moving[n] = whole.is_free(n) && std::abs(scene.lattice.node_rest[n][0] - 4) < 1.6;
  const Subdomain<double> subdomain = restrict_to<double>(moving, whole, scene.u, scene.multipliers);
  EXPECT_EQ(subdomain.system->point_constraints().size(), 3u);
  EXPECT_LT(subdomain.system->nodes(), whole.nodes() / 2);

  const double rest = rest_of_the_energy(whole, subdomain, scene.multipliers, scene.u);
  auto moved = scene.u;
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < moved.size(); ++i)
    if (moving[i / 3]) moved[i] += 0.05 * normal(random);
  const double before = whole.evaluate(scene.u, scene.multipliers).energy;
  EXPECT_GT(std::abs(whole.evaluate(moved, scene.multipliers).energy - before), 0.1);
  EXPECT_NEAR(rest_of_the_energy(whole, subdomain, scene.multipliers, moved), rest, 1e-10 * std::abs(before));
}

// One block that is held from below, and another one above, held at one side; in millimeters.
struct TwoBlocks {
  Surface tissue;
  Lattice lattice;
  std::unique_ptr<System<double>> system;
  std::vector<double> u;

  explicit TwoBlocks(double side) : tissue(grid_box({0, 0, 0}, {side, side, 2}, 1.0)) {
    append(tissue, grid_box({0, 0, 2.5}, {side, side, 4.5}, 0.7));
    lattice = build_lattice(tissue, {});
    const std::size_t triangles = tissue.triangles.size();
    std::vector<std::uint8_t> fixed(triangles, 0);
    for (std::size_t t = 0; t < triangles; ++t)
      fixed[t] = center(tissue, t)[2] < 1e-9 || (center(tissue, t)[0] < 1e-9 && center(tissue, t)[2] > 2.5);
    system = std::make_unique<System<double>>(lattice, CellMaterials{{skin()}}, 1,
                                              attach(lattice, tissue, fixed, std::vector<std::uint8_t>(triangles, 0),
                                                     std::vector<std::int32_t>(triangles, -1), nullptr),
                                              0, BedStiffness{}, Vec3::Zero());
    system->set_self_contact(std::make_unique<SelfContact>(lattice, tissue, skin().youngs_modulus));
    u.assign(3 * system->nodes(), 0.0);
  }
  // The upper one is pressed on the lower one, and bent.
  void press() {
    for (std::size_t n = 0; n < system->nodes(); ++n)
      if (is_upper(n)) {
        const double x = lattice.node_rest[n][0] - 4;
        u[3 * n + 2] = -0.48 + 0.004 * x * x;
      }
  }
  bool is_upper(std::size_t n) const { return system->fragment_of_node()[n] != system->fragment_of_node()[0]; }
};

TEST(LocalRelaxation, ASubdomainsPartOfWhatPressesIsThatOfTheWhole) {
  TwoBlocks scene(8);
  scene.press();
  System<double>& whole = *scene.system;
  const std::size_t pairs = whole.evaluate(scene.u, {}).self_contact.pairs.size();
  ASSERT_GT(pairs, 20U);
  // what moves: a part of the upper block alone, above what stays, and a part of both
  for (const bool both : {false, true}) {
    std::vector<std::uint8_t> moving(whole.nodes(), 0);
    for (std::size_t n = 0; n < moving.size(); ++n)
      moving[n] = whole.is_free(n) && (both || scene.is_upper(n)) && scene.lattice.node_rest[n][0] < 3.5;
    const Subdomain<double> subdomain = restrict_to<double>(moving, whole, scene.u, {});
    const std::size_t own = subdomain.system->evaluate(subdomain.u, {}).self_contact.pairs.size();
    EXPECT_GT(own, 10U);
    EXPECT_LT(own, pairs);
    const double rest = rest_of_the_energy(whole, subdomain, {}, scene.u);
    auto moved = scene.u;
    std::mt19937 random(6);
    std::normal_distribution<double> normal;
    for (std::size_t i = 0; i < moved.size(); ++i)
      if (moving[i / 3]) moved[i] += 2e-3 * normal(random);
    const double before = whole.evaluate(scene.u, {}).energy;
    EXPECT_NEAR(rest_of_the_energy(whole, subdomain, {}, moved), rest, 1e-10 * std::abs(before));
    // and no farther does it go
    std::vector<double> fall(3 * subdomain.nodes.size(), 0.0), whole_fall(scene.u.size(), 0.0);
    for (std::size_t n = 0; n < subdomain.nodes.size(); ++n)
      if (subdomain.moves[n] && scene.is_upper(static_cast<std::size_t>(subdomain.nodes[n])))
        fall[3 * n + 2] = whole_fall[offset_of(3, subdomain.nodes[n]) + 2] = -1.0;
    const double share = whole.largest_step(scene.u, whole_fall, 1.0);
    EXPECT_GT(share, 0.0);
    EXPECT_LT(share, 0.1);
    EXPECT_NEAR(subdomain.system->largest_step(subdomain.u, fall, 1.0), share, 1e-12);
  }
}

TEST(LocalRelaxation, WhatIsRelaxedBesideTissueThatItTouchesDoesNotGoThroughIt) {
  TwoBlocks scene(20);
  SelfContact& contact = *scene.system->self_contact();
  // at one place what lies above is as far down as it may go
  std::vector<double> fall(scene.u.size(), 0.0);
  for (std::size_t n = 0; n < scene.system->nodes(); ++n)
    if (scene.is_upper(n) && (scene.lattice.node_rest[n] - Vec3(10, 10, 2)).norm() < 1.5) fall[3 * n + 2] = -1.0;
  for (int step = 0; step < 2; ++step) {
    const double share = scene.system->largest_step(scene.u, fall, 1.0);
    for (std::size_t i = 0; i < fall.size(); ++i) scene.u[i] += share * fall[i];
  }
  const Evaluation before = scene.system->evaluate(scene.u, {});
  const LocalRelaxation relaxed =
      relax_locally<double>(*scene.system, scene.u, {}, before, 1e-6, false, [] { return false; });
  EXPECT_TRUE(before.self_contact.touches());
  EXPECT_GT(relaxed.newton_iterations, 1);
  const Evaluation after = scene.system->evaluate(scene.u, {});
  EXPECT_LT(after.energy, before.energy);
  EXPECT_LT(after.residual, 0.3 * before.residual);
  EXPECT_EQ(contact.count_piercings<double>(scene.u), 0U);
}

// An uncut sheet at rest in which some nodes are somewhere else.
struct DentedSheet {
  CutSheet sheet = make_cut_sheet(90, 90, 4, 0, 0.0);
  System<double> system{sheet.lattice, CellMaterials{{skin()}}, 1, sheet.attachments, 0, {}, Vec3::Zero()};
  std::vector<double> u = std::vector<double>(3 * system.nodes(), 0.0);

  void dent(const Vec3& where, double radius) {
    for (std::size_t n = 0; n < system.nodes(); ++n)
      if ((sheet.lattice.node_rest[n] - where).norm() < radius && system.is_free(n)) u[3 * n + 2] -= 0.4;
  }
};

TEST(LocalRelaxation, DentsGoBackAsClustersOfTheirOwnAndWhatIsFarFromThemStaysToTheBit) {
  DentedSheet scene;
  const Vec3 one(10, 10, 4), other(30, 29, 4);
  scene.dent(one, 1.1);
  scene.dent(other, 1.1);
  const auto start = scene.u;
  const Evaluation before = scene.system.evaluate(scene.u, {});
  const LocalRelaxation relaxed =
      relax_locally<double>(scene.system, scene.u, {}, before, 1e-6, false, [] { return false; });
  EXPECT_EQ(relaxed.clusters, 2);
  EXPECT_GT(relaxed.newton_iterations, 1);
  const Evaluation after = scene.system.evaluate(scene.u, {});
  EXPECT_LT(after.energy, 0.02 * before.energy);  // at rest it is zero
  EXPECT_LT(after.residual, 0.2 * before.residual);
  std::size_t moved = 0;
  for (std::size_t n = 0; n < scene.system.nodes(); ++n) {
    const Vec3 x = scene.sheet.lattice.node_rest[n];
    bool same = true;
    for (std::size_t i = 3 * n; i < 3 * n + 3; ++i) same = same && scene.u[i] == start[i];
    moved += !same;
    EXPECT_TRUE(same || std::min((x - one).norm(), (x - other).norm()) < 8.0);
  }
  EXPECT_EQ(moved, relaxed.nodes);
}

TEST(LocalRelaxation, NothingMovesWhereTheResidualIsEverywhere) {
  DentedSheet scene;
  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < scene.u.size(); ++i)
    if (scene.system.is_free(i / 3)) scene.u[i] = 0.05 * normal(random);
  const auto start = scene.u;
  const Evaluation now = scene.system.evaluate(scene.u, {});
  const LocalRelaxation relaxed =
      relax_locally<double>(scene.system, scene.u, {}, now, 1e-6, false, [] { return false; });
  EXPECT_EQ(relaxed.nodes, 0u);
  EXPECT_EQ(scene.u, start);
}

// A sheet with a Z-shaped cut whose sutures join what lies slip / 2 mm apart along the central limb, from rest.
EquilibriumOutcome sutured(bool relaxes, int slip, std::vector<double>& u) {
  CutSheet sheet = make_cut_sheet(40, 40, 5, slip, 100.0 * skin().youngs_modulus);
  System<double> system(sheet.lattice, CellMaterials{{skin()}}, 1, sheet.attachments, 0, {}, Vec3::Zero());
  system.set_point_constraints(sheet.constraints);
  TwoLevel<double> preconditioner(system, 4);
  u.assign(3 * system.nodes(), 0.0);
  EquilibriumOptions options;
  options.tolerance = 1e-4;
  options.accuracy = relaxes ? Accuracy::kLoadStep : Accuracy::kRelaxation;
  Multipliers multipliers;
  return find_equilibrium<double>(system, preconditioner, u, multipliers, options,
                                  {[](int, double, double) {}, [] { return false; }});
}

TEST(LocalRelaxation, TissueThatSuturesPressTogetherReachesTheSameEquilibriumInFewerIterationsOfTheWhole) {
  std::vector<double> u, v;
  const EquilibriumOutcome without = sutured(false, 16, u), with = sutured(true, 16, v);
  ASSERT_TRUE(without.converged) << without.failure.message;
  ASSERT_TRUE(with.converged) << with.failure.message;
  EXPECT_LE(with.newton_iterations, 10);
  EXPECT_LT(with.newton_iterations, without.newton_iterations);
  EXPECT_NEAR(with.energy, without.energy, 1e-7 * without.energy);
  double off = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) off = std::max(off, std::abs(u[i] - v[i]));
  EXPECT_LT(off, 5e-3);  // mm, of a slip by 8
}

}  // namespace
}  // namespace lappet
