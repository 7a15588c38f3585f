#include "force/elastic.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <random>

#include "box.h"

namespace lappet {
namespace {

struct Case {
  const char* model;
  int quadrature;
};

class ElasticCells : public ::testing::TestWithParam<Case> {
 protected:
  ElasticCells() {
    LatticeSettings settings;
    settings.spacing = 1.5;
    lattice_ = build_lattice(box_surface(Vec3::Zero(), Vec3(6, 4.5, 3)), settings);
    material_.model = GetParam().model;
    material_.poissons_ratio = 0.4;
  }
  std::size_t size() const { return 3 * lattice_.node_rest.size(); }
  std::vector<double> random_field(double amplitude, unsigned seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
    std::vector<double> u(size());
    for (double& value : u) value = uniform(random);
    return u;
  }
  Lattice lattice_;
  MaterialParameters material_;
};

TEST_P(ElasticCells, RigidMotionGivesNoForceAndNoEnergy) {
  Elastic<double> elastic(lattice_, material_, GetParam().quadrature);
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  std::vector<double> u(size()), gradient(size()), scale(size() / 3);
  for (std::size_t n = 0; n < size() / 3; ++n) {
    const Vec3 moved = rotation * lattice_.node_rest[n] + Vec3(3, -2, 8) - lattice_.node_rest[n];
    for (int i = 0; i < 3; ++i) u[3 * n + static_cast<std::size_t>(i)] = moved[i];
  }
  const ElasticState state = elastic.evaluate(u, gradient, scale);
  EXPECT_NEAR(state.energy, 0.0, 1e-11);
  for (const double g : gradient) EXPECT_NEAR(g, 0.0, 1e-11);
}

TEST_P(ElasticCells, ForceIsTheGradientOfTheEnergy) {
  Elastic<double> elastic(lattice_, material_, GetParam().quadrature);
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
  Elastic<double> elastic(lattice_, material_, GetParam().quadrature);
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
  elastic.linearize(Definiteness::kExact);
  elastic.multiply(direction, product);
  double size_of = 0;
  for (const double p : product) size_of = std::max(size_of, std::abs(p));
  for (std::size_t i = 0; i < size(); ++i) EXPECT_NEAR((a[i] - b[i]) / (2 * step), product[i], 2e-6 * size_of);
}

TEST_P(ElasticCells, DefiniteTangentIsPositiveAndAgreesWithItsCellsAndBlocks) {
  Elastic<double> elastic(lattice_, material_, GetParam().quadrature);
  std::vector<double> gradient(size()), scale(size() / 3), product(size());
  const auto u = random_field(1.0, 5), direction = random_field(1.0, 6);
  elastic.evaluate(u, gradient, scale);
  for (const auto how : {Definiteness::kClamp, Definiteness::kAbsolute}) {
    elastic.linearize(how);
    elastic.multiply(direction, product);
    double assembled = 0, matrix_free = 0;
    for (std::size_t i = 0; i < size(); ++i) matrix_free += direction[i] * product[i];
    std::vector<double> blocks(6 * lattice_.node_rest.size()), summed(blocks.size(), 0.0);
    elastic.diagonal_blocks(blocks);
    for (std::size_t c = 0; c < lattice_.cell_nodes.size(); ++c) {
      const Matrix24 k = elastic.cell_stiffness(static_cast<std::int32_t>(c));
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix24>(k).eigenvalues()[0], -1e-9 * k.norm());
      Eigen::Matrix<double, 24, 1> x;
      for (int n = 0; n < 8; ++n)
        for (int i = 0; i < 3; ++i) {
          const auto node = static_cast<std::size_t>(lattice_.cell_nodes[c][static_cast<std::size_t>(n)]);
          x[3 * n + i] = direction[3 * node + static_cast<std::size_t>(i)];
          for (int j = i; j < 3; ++j)
            summed[6 * node + static_cast<std::size_t>(i == 0 ? j : i + j + 1)] += k(3 * n + i, 3 * n + j);
        }
      assembled += x.dot(k * x);
    }
    EXPECT_NEAR(assembled, matrix_free, 1e-10 * matrix_free);
    for (std::size_t i = 0; i < blocks.size(); ++i)
      EXPECT_NEAR(blocks[i], summed[i], 1e-9 * std::abs(summed[i]) + 1e-9);
  }
}

TEST_P(ElasticCells, FloatAgreesWithDouble) {
  Elastic<double> exact(lattice_, material_, GetParam().quadrature);
  Elastic<float> single(lattice_, material_, GetParam().quadrature);
  const auto u = random_field(0.3, 7), direction = random_field(1.0, 8);
  std::vector<float> uf(u.begin(), u.end()), df(direction.begin(), direction.end()), pf(size());
  const std::vector<double> rounded_u(uf.begin(), uf.end()), rounded_d(df.begin(), df.end());
  std::vector<double> gradient(size()), scale(size() / 3), product(size());
  const double energy = exact.evaluate(rounded_u, gradient, scale).energy;
  exact.linearize(Definiteness::kClamp);
  exact.multiply(rounded_d, product);
  EXPECT_NEAR(single.evaluate(uf, gradient, scale).energy, energy, 2e-7 * energy);  // the moduli are stored as float
  single.linearize(Definiteness::kClamp);
  single.multiply(df, pf);
  double most = 0;
  for (const double p : product) most = std::max(most, std::abs(p));
  for (std::size_t i = 0; i < size(); ++i) EXPECT_NEAR(pf[i], product[i], 4e-6 * most);
}

INSTANTIATE_TEST_SUITE_P(ModelsAndQuadratures, ElasticCells,
                         ::testing::Values(Case{"corotated", 1}, Case{"corotated", 4}, Case{"corotated", 8},
                                           Case{"neoHookean", 1}, Case{"neoHookean", 4}, Case{"neoHookean", 8}),
                         [](const auto& info) {
                           return std::string(info.param.model) + std::to_string(info.param.quadrature);
                         });

}  // namespace
}  // namespace lappet
