#include "force/elastic/elastic.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <ostream>
#include <random>
#include <string>

#include "box.h"
#include "cell_stiffness.h"

namespace lappet {
namespace {

// What a tissue may have besides its isotropic model.
enum Extra { kFibers = 1, kMuscle = 2, kPrestretched = 4, kMixed = 8, kShares = 16 };

struct Case {
  std::string_view model;
  int quadrature;
  int extras;
};
std::string describe(const Case& c) {
  std::string text = std::string(c.model) + std::to_string(c.quadrature);
  if (c.extras & kFibers) text += "Fibers";
  if (c.extras & kMuscle) text += "Muscle";
  if (c.extras & kPrestretched) text += "Prestretch";
  if (c.extras & kMixed) text += "Mixed";
  if (c.extras & kShares) text += "Shares";
  return text;
}
void PrintTo(const Case& c, std::ostream* out) { *out << describe(c); }

class ElasticCells : public ::testing::TestWithParam<Case> {
 protected:
  ElasticCells() {
    LatticeSettings settings;
    settings.spacing = 1.5;
    lattice_ = build_lattice(box_surface(Vec3::Zero(), Vec3(6, 4.5, 3)), settings);
    MaterialParameters first, second;
    first.model = second.model = GetParam().model;
    first.poissons_ratio = 0.4;
    first.mooney_ratio = 0.3;
    first.fiber_direction = Vec3(1, 0.4, 0).normalized();
    if (has(kFibers)) {
      first.fiber_k1 = 12.0;
      first.fiber_k2 = kK2;
      first.fiber_dispersion = 0.12;
      if (has(kShares)) first.fiber_slack = 1.05;
    }
    if (has(kMuscle)) first.muscle_stress = 90.0;
    if (has(kPrestretched)) first.prestretch = {1.2, 1.05};
    // Fat below skin: softer, no fibers, no muscle, as taut or not.
    second.youngs_modulus = 6.0;
    second.poissons_ratio = 0.3;
    materials_.table = {first};
    if (has(kMixed)) {
      materials_.table.push_back(second);
      for (std::size_t c = 0; c < lattice_.cell_nodes.size(); ++c) {
        materials_.of_cell.push_back(lattice_.cell_position(c)[2] == 0 ? 1 : 0);
        materials_.normal_of_cell.push_back(Eigen::Vector3f(0.1F, 0.2F * float(c % 3), 1.0F).normalized());
      }
    }
    if (has(kShares)) add_shares();
  }
  // A third of the cells of one half are of one, two or three parts; a boundary passes through them in every direction.
  // Where one material is all there is they are filled in part.
  void add_shares() {
    if (has(kMixed)) materials_.table.push_back(materials_.table[0]);
    if (has(kMixed)) materials_.table.back().youngs_modulus = 300.0;
    for (std::size_t c = 0; c < lattice_.cell_nodes.size(); c += 3) {
      if (lattice_.cell_position(c)[0] > 1) continue;
      const std::size_t further = has(kMixed) ? c / 3 % 3 : 0;
      for (std::size_t part = 0; part <= further; ++part) {
        Eigen::Vector3f center(0.0F, 0.0F, 0.0F), scale(1.0F, 1.0F, 1.0F);
        const auto axis = Eigen::Index(c % 7 % 3);
        center[axis] = part == 0 ? -0.4F : part == 1 ? 0.6F : 0.1F;
        scale[axis] = part == 0 ? 0.6F : 0.4F;
        const auto material = has(kMixed) ? std::uint8_t((materials_.of_cell[c] + part) % 3) : std::uint8_t{0};
        const float volume = further == 0 ? 1.0F : part == 0 ? 0.5F : 0.5F / float(further);
        materials_.shares.push_back({to_index(c), material, volume, center, scale});
      }
    }
  }
  bool has(Extra extra) const { return (GetParam().extras & extra) != 0; }
  template <class Real>
  std::unique_ptr<Elastic<Real>> make() const {
    auto elastic = std::make_unique<Elastic<Real>>(lattice_, materials_, GetParam().quadrature);
    elastic->set_activation(std::vector<double>{0.7, 0.0, 0.4});
    return elastic;
  }
  std::size_t size() const { return 3 * lattice_.node_rest.size(); }
  std::vector<double> random_field(double amplitude, unsigned seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
    std::vector<double> u(size());
    for (double& value : u) value = uniform(random);
    return u;
  }
  static constexpr double kK2 = 2.0;
  Lattice lattice_;
  CellMaterials materials_;
};

TEST_P(ElasticCells, RigidMotionGivesNoForceAndNoEnergyUnlessTheTissueIsTautOrActive) {
  const auto made = make<double>();
  auto& elastic = *made;
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  std::vector<double> u(size()), gradient(size()), scale(size() / 3);
  for (std::size_t n = 0; n < size() / 3; ++n) {
    const Vec3 moved = rotation * lattice_.node_rest[n] + Vec3(3, -2, 8) - lattice_.node_rest[n];
    for (int i = 0; i < 3; ++i) u[3 * n + i] = moved[i];
  }
  const ElasticState state = elastic.evaluate(u, gradient, scale);
  if (has(kMuscle) || has(kPrestretched)) {
    EXPECT_GT(*std::max_element(scale.begin(), scale.end()), 1.0);
    return;
  }
  EXPECT_NEAR(state.energy, 0.0, 1e-11);
  for (const double g : gradient) EXPECT_NEAR(g, 0.0, 1e-11);
}

TEST_P(ElasticCells, RigidMotionTurnsTheForcesAndKeepsTheEnergy) {
  const auto made = make<double>();
  auto& elastic = *made;
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(2.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  const auto u = random_field(0.4, 9);
  std::vector<double> moved(size()), before(size()), after(size()), scale(size() / 3);
  for (std::size_t n = 0; n < size() / 3; ++n) {
    const Vec3 at = lattice_.node_rest[n] + Vec3(u[3 * n], u[3 * n + 1], u[3 * n + 2]);
    const Vec3 to = rotation * at + Vec3(3, -2, 8) - lattice_.node_rest[n];
    for (int i = 0; i < 3; ++i) moved[3 * n + i] = to[i];
  }
  const ElasticState first = elastic.evaluate(u, before, scale), second = elastic.evaluate(moved, after, scale);
  const double force = *std::max_element(scale.begin(), scale.end());
  EXPECT_NEAR(first.energy, second.energy, 1e-12 * std::abs(first.energy));
  EXPECT_NEAR(first.minimum_j, second.minimum_j, 1e-12);
  EXPECT_EQ(first.inverted, second.inverted);
  for (std::size_t n = 0; n < size() / 3; ++n) {
    const Vec3 turned = rotation * Vec3(before[3 * n], before[3 * n + 1], before[3 * n + 2]);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(after[3 * n + i], turned[i], 1e-11 * force);
  }
}

TEST_P(ElasticCells, ForceIsTheGradientOfTheEnergy) {
  const auto made = make<double>();
  auto& elastic = *made;
  std::vector<double> gradient(size()), other(size()), scale(size() / 3);
  for (const double amplitude : {0.1, 0.5, 3.0}) {  // the last inverts cells
    auto u = random_field(amplitude, 1);
    elastic.evaluate(u, gradient, scale);
    const auto direction = random_field(1.0, 2);
    double slope = 0;
    for (std::size_t i = 0; i < size(); ++i) slope += gradient[i] * direction[i];
    const double step = 1e-6;
    auto above = u, below = u;
    for (std::size_t i = 0; i < size(); ++i) {
      above[i] += step * direction[i];
      below[i] -= step * direction[i];
    }
    const double quotient =
        (elastic.evaluate(above, other, scale).energy - elastic.evaluate(below, other, scale).energy) / (2 * step);
    EXPECT_NEAR(quotient, slope, 1e-6 * (std::abs(slope) + 1.0)) << amplitude;
  }
}

TEST_P(ElasticCells, TangentIsTheDifferenceQuotientOfTheForce) {
  const auto made = make<double>();
  auto& elastic = *made;
  std::vector<double> a(size()), b(size()), scale(size() / 3), product(size());
  const auto u = random_field(0.3, 3), direction = random_field(1.0, 4);
  const double step = 1e-6;
  auto above = u, below = u;
  for (std::size_t i = 0; i < size(); ++i) {
    above[i] += step * direction[i];
    below[i] -= step * direction[i];
  }
  elastic.evaluate(above, a, scale);
  elastic.evaluate(below, b, scale);
  std::vector<double> at_u(size());
  elastic.evaluate(u, at_u, scale);
  elastic.linearize(PsdProjection::kExact);
  elastic.multiply(direction, product);
  double size_of = 0;
  for (const double p : product) size_of = std::max(size_of, std::abs(p));
  for (std::size_t i = 0; i < size(); ++i) EXPECT_NEAR((a[i] - b[i]) / (2 * step), product[i], 2e-6 * size_of);
}

TEST_P(ElasticCells, DefiniteTangentIsPositiveAndAgreesWithItsCellsAndBlocks) {
  const auto made = make<double>();
  auto& elastic = *made;
  std::vector<double> gradient(size()), scale(size() / 3), product(size());
  const auto u = random_field(1.0, 5), direction = random_field(1.0, 6);
  elastic.evaluate(u, gradient, scale);
  for (const auto how : {PsdProjection::kClamp, PsdProjection::kAbsolute}) {
    elastic.linearize(how);
    elastic.multiply(direction, product);
    double assembled = 0, matrix_free = 0;
    for (std::size_t i = 0; i < size(); ++i) matrix_free += direction[i] * product[i];
    std::vector<double> blocks(6 * lattice_.node_rest.size()), summed(blocks.size(), 0.0);
    elastic.diagonal_blocks(blocks);
    for (std::size_t c = 0; c < lattice_.cell_nodes.size(); ++c) {
      const test::Matrix24 k = test::cell_stiffness(elastic, to_index(c));
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<test::Matrix24>(k).eigenvalues()[0], -1e-9 * k.norm());
      Eigen::Matrix<double, 24, 1> x;
      for (int n = 0; n < 8; ++n)
        for (int i = 0; i < 3; ++i) {
          const std::size_t node = lattice_.cell_nodes[c][n];
          x[3 * n + i] = direction[3 * node + i];
          for (int j = i; j < 3; ++j) summed[6 * node + (i == 0 ? j : i + j + 1)] += k(3 * n + i, 3 * n + j);
        }
      assembled += x.dot(k * x);
    }
    EXPECT_NEAR(assembled, matrix_free, 1e-10 * matrix_free);
    for (std::size_t i = 0; i < blocks.size(); ++i)
      EXPECT_NEAR(blocks[i], summed[i], 1e-9 * std::abs(summed[i]) + 1e-9);
  }
}

TEST_P(ElasticCells, FloatAgreesWithDouble) {
  const auto made = make<double>();
  const auto made_single = make<float>();
  auto& exact = *made;
  auto& single = *made_single;
  const auto u = random_field(0.3, 7), direction = random_field(1.0, 8);
  std::vector<float> uf(u.begin(), u.end()), df(direction.begin(), direction.end()), pf(size());
  const std::vector<double> rounded_u(uf.begin(), uf.end()), rounded_d(df.begin(), df.end());
  std::vector<double> gradient(size()), scale(size() / 3), product(size());
  const double energy = exact.evaluate(rounded_u, gradient, scale).energy;
  // what the exponential of fibers makes of a rounding, see kernel_twins_check.cpp
  const double condition = has(kFibers) ? std::max(1.0, 2.0 * std::sqrt(10.0 * kK2)) : 1.0;
  exact.linearize(PsdProjection::kClamp);
  exact.multiply(rounded_d, product);
  EXPECT_NEAR(single.evaluate(uf, gradient, scale).energy, energy,
              2e-7 * condition * std::abs(energy));  // the moduli are stored as float
  single.linearize(PsdProjection::kClamp);
  single.multiply(df, pf);
  double most = 0;
  for (const double p : product) most = std::max(most, std::abs(p));
  for (std::size_t i = 0; i < size(); ++i) EXPECT_NEAR(pf[i], product[i], 4e-6 * condition * most);
}

// With one lane a block is a group: those without shares run kernels that know none. With more lanes all blocks of this
// lattice are one group.
TEST_P(ElasticCells, BlocksWithoutSharesHaveTheForcesThatTheyHaveBesideThoseWithShares) {
  std::vector<double> all[2];
  const auto u = random_field(0.1, 31), x = random_field(1.0, 32);
  const InstructionSet sets[] = {InstructionSet::kScalar, choose_instruction_set()};
  for (int k = 0; k < 2; ++k) {
    Elastic<double> elastic(lattice_, materials_, GetParam().quadrature, sets[k]);
    elastic.set_activation(std::vector<double>{0.7, 0.0, 0.4});
    std::vector<double> gradient(size()), scale(size() / 3), product(size()), blocks(2 * size());
    const ElasticState state = elastic.evaluate(u, gradient, scale);
    elastic.linearize(PsdProjection::kExact);
    elastic.multiply(x, product);
    elastic.diagonal_blocks(blocks);
    all[k] = {state.energy, state.minimum_j};
    for (const auto* values : {&gradient, &scale, &product, &blocks})
      all[k].insert(all[k].end(), values->begin(), values->end());
  }
  for (std::size_t i = 0; i < all[0].size(); ++i) EXPECT_NEAR(all[0][i], all[1][i], 1e-8 * (1.0 + std::abs(all[0][i])));
}

// Every model on 1, 4 and 8 points: plain, all extras at once, and each of them alone.
std::vector<Case> cases() {
  std::vector<Case> all;
  for (const std::string_view model : MaterialModels::kNames)
    for (const int quadrature : {1, 4, 8})
      for (const int extras :
           {0, int{kFibers}, int{kMuscle}, int{kPrestretched}, int{kMixed}, kFibers | kMuscle | kPrestretched | kMixed,
            int{kShares}, kFibers | kMuscle | kPrestretched | kShares, kMixed | kShares,
            kFibers | kMuscle | kPrestretched | kMixed | kShares})
        all.push_back({model, quadrature, extras});
  return all;
}

INSTANTIATE_TEST_SUITE_P(MaterialsAndQuadratures, ElasticCells, ::testing::ValuesIn(cases()),
                         [](const auto& info) { return describe(info.param); });

}  // namespace
}  // namespace lappet
