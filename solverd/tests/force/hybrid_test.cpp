// Forces, products and diagonals on the hybrid lattice against a plain loop over its cells: no blocks, no lanes, every
// cell with its eight nodes, in double.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <Eigen/Dense>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "cut_lattices.h"
#include "force/elastic/elastic.h"
#include "force/kernels/quadrature.h"
#include "force/materials/material_models.h"

namespace lappet {
namespace {

using Matrix3 = Eigen::Matrix3d;
using test::CutLattice;

// The explicit mesh. Energy, stress and tangent of a cell by the formulas, its decomposition by Eigen.
class ExplicitMesh {
 public:
  ExplicitMesh(const Lattice& lattice, const CellMaterials& materials, int quadrature)
      : lattice_(lattice), materials_(materials), points_(quadrature_points(quadrature)), one_point_(quadrature == 1) {}

  // Energy and forces at u, or with `direction` the product of the exact tangent at u with it.
  double evaluate(const std::vector<double>& u, const std::vector<double>* direction,
                  std::vector<double>& result) const {
    result.assign(u.size(), 0.0);
    double energy = 0.0;
    for (std::size_t c = 0; c < lattice_.cell_nodes.size(); ++c) {
      const auto& material = materials_.of(c);
      MaterialModels::with(MaterialModels::index(material.model),
                           [&]<class Model>() { energy += cell<Model>(c, material, u, direction, result); });
    }
    return energy;
  }

 private:
  template <class Model>
  double cell(std::size_t c, const MaterialParameters& material, const std::vector<double>& u,
              const std::vector<double>* direction, std::vector<double>& result) const {
    const double h = lattice_.settings.spacing;
    const double volume = h * h * h * double(lattice_.cell_fill[c]);
    const Moduli<double> moduli{material.mu(), material.lambda(), material.mooney_ratio};
    const auto& nodes = lattice_.cell_nodes[c];
    Eigen::Matrix<double, 3, 8> at, toward = Eigen::Matrix<double, 3, 8>::Zero(), force;
    for (int k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i) {
        const auto n = offset_of(3, nodes[k]) + i;
        at(i, k) = u[n];
        if (direction != nullptr) toward(i, k) = (*direction)[n];
      }
    force.setZero();
    double energy = 0.0;
    for (const auto& point : points_) {
      const Eigen::Matrix<double, 8, 3> gradient =
          Eigen::Map<const Eigen::Matrix<double, 3, 8, Eigen::RowMajor>>(point.gradient.data()).transpose() / h;
      const Matrix3 f = Matrix3::Identity() + at * gradient;
      const Eigen::JacobiSVD<Matrix3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
      Matrix3 rotation_u = svd.matrixU(), rotation_v = svd.matrixV();
      Eigen::Vector3d s = svd.singularValues();
      for (Matrix3* r : {&rotation_u, &rotation_v})
        if (r->determinant() < 0) {
          r->col(2) *= -1;
          s[2] = -s[2];
        }
      const double sigma[3] = {s[0], s[1], s[2]};
      Matrix3 stress;
      if (direction == nullptr) {
        double p[3];
        Model::p_hat(sigma, moduli, p);
        stress = rotation_u * Eigen::Vector3d(p[0], p[1], p[2]).asDiagonal() * rotation_v.transpose();
        energy += volume * point.weight * Model::energy(sigma, moduli);
      } else {
        TangentHat<double> t;
        Model::dpdf_hat(sigma, moduli, t);
        Matrix3 hessian;
        hessian << t.hessian[0], t.hessian[1], t.hessian[2], t.hessian[1], t.hessian[3], t.hessian[4], t.hessian[2],
            t.hessian[4], t.hessian[5];
        const Matrix3 d = rotation_u.transpose() * (toward * gradient) * rotation_v;
        Matrix3 hat = Eigen::Vector3d(hessian * d.diagonal()).asDiagonal();
        for (int k = 0; k < 3; ++k) {
          const int i = kTangentPairs[k][0], j = kTangentPairs[k][1];
          const double even = 0.5 * t.stretch[k] * (d(i, j) + d(j, i)), odd = 0.5 * t.rotation[k] * (d(i, j) - d(j, i));
          hat(i, j) = even + odd;
          hat(j, i) = even - odd;
        }
        stress = rotation_u * hat * rotation_v.transpose();
      }
      force += volume * point.weight * stress * gradient.transpose();
    }
    if (one_point_)  // the Laplacian that the point misses
      for (std::size_t m = 0; m < 4; ++m) {
        Eigen::Matrix<double, 8, 1> mode;
        for (int k = 0; k < 8; ++k) mode[k] = kHourglassModes[m][k];
        const double stiffness = Model::kLaplacian * moduli.mu * volume * kHourglass[m] / (h * h);
        const Eigen::Vector3d amplitude = (direction == nullptr ? at : toward) * mode;
        energy += 0.5 * stiffness * amplitude.squaredNorm();
        force += stiffness * amplitude * mode.transpose();
      }
    for (int k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i) result[offset_of(3, nodes[k]) + i] += force(i, k);
    return energy;
  }

  const Lattice& lattice_;
  const CellMaterials& materials_;
  std::vector<QuadraturePoint> points_;
  bool one_point_;
};

class HybridLattice : public ::testing::TestWithParam<CutLattice> {
 protected:
  HybridLattice() : lattice_(test::make_lattice(GetParam())) {
    MaterialParameters skin, fat;
    skin.model = fat.model = "stableNeoHookean";
    skin.youngs_modulus = 80;
    skin.poissons_ratio = 0.4;
    fat.youngs_modulus = 7;
    fat.poissons_ratio = 0.3;
    materials_.table = {skin, fat};
    for (std::size_t c = 0; c < lattice_.cell_nodes.size(); ++c) materials_.of_cell.push_back(c % 3 == 0 ? 1 : 0);
  }
  std::size_t size() const { return 3 * lattice_.node_rest.size(); }
  // What float holds exactly, so that both precisions start from the same numbers.
  std::vector<double> random_field(double amplitude, unsigned seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
    std::vector<double> u(size());
    for (double& value : u) value = double(float(uniform(random)));
    return u;
  }
  template <class Real>
  void expect_agreement(InstructionSet set, int quadrature, double wide, double narrow) const {
    Elastic<Real> elastic(lattice_, materials_, quadrature, set);
    const ExplicitMesh mesh(lattice_, materials_, quadrature);
    const auto u = random_field(0.25, 1), direction = random_field(1.0, 2);
    std::vector<double> expected, gradient(size()), scale(size() / 3);
    const double energy = mesh.evaluate(u, nullptr, expected);
    const std::vector<Real> at(u.begin(), u.end()), toward(direction.begin(), direction.end());
    std::vector<Real> product(size());
    EXPECT_NEAR(elastic.evaluate(at, gradient, scale).energy, energy, wide * energy);
    const double force = *std::max_element(scale.begin(), scale.end());
    for (std::size_t i = 0; i < size(); ++i) ASSERT_NEAR(gradient[i], expected[i], wide * force) << i;
    mesh.evaluate(u, &direction, expected);
    elastic.linearize(PsdProjection::kExact);
    elastic.multiply(toward, product);
    double most = 0.0;
    for (const double value : expected) most = std::max(most, std::abs(value));
    for (std::size_t i = 0; i < size(); ++i) ASSERT_NEAR(double(product[i]), expected[i], narrow * most) << i;
  }
  Lattice lattice_;
  CellMaterials materials_;
};

TEST_P(HybridLattice, ForcesAndProductsInDoubleAreThoseOfTheExplicitMesh) {
  for (const auto set : available_instruction_sets())
    for (const int quadrature : {1, 4, 8}) {
      SCOPED_TRACE(std::string(name(set)) + ", " + std::to_string(quadrature) + " points");
      expect_agreement<double>(set, quadrature, 1e-13, 1e-13);
    }
}

TEST_P(HybridLattice, ForcesAndProductsInFloatAreThoseOfTheExplicitMesh) {
  for (const auto set : available_instruction_sets())
    for (const int quadrature : {1, 4, 8}) {
      SCOPED_TRACE(std::string(name(set)) + ", " + std::to_string(quadrature) + " points");
      expect_agreement<float>(set, quadrature, 2e-7, 4e-6);  // moduli and volumes are stored as float
    }
}

TEST_P(HybridLattice, OneTwoThreeAndFourThreadsGiveTheSameBits) {
  for (const auto set : available_instruction_sets()) {
    std::vector<char> first;
    for (const int threads : {1, 2, 3, 4, 4, 3}) {
      tbb::task_arena arena(threads);
      arena.execute([&] {
        Elastic<float> elastic(lattice_, materials_, 1, set);
        const auto u = random_field(0.3, 7), direction = random_field(1.0, 8);
        const std::vector<float> at(u.begin(), u.end()), toward(direction.begin(), direction.end());
        std::vector<double> gradient(size()), scale(size() / 3);
        std::vector<float> product(size()), blocks(2 * size());
        const double energy = elastic.evaluate(at, gradient, scale).energy;
        elastic.linearize(PsdProjection::kClamp);
        elastic.multiply(toward, product);
        elastic.diagonal_blocks(blocks);
        std::vector<char> bits(sizeof energy);
        std::memcpy(bits.data(), &energy, sizeof energy);
        const auto add = [&](const auto& values) {
          const auto* from = reinterpret_cast<const char*>(values.data());
          bits.insert(bits.end(), from, from + values.size() * sizeof(values[0]));
        };
        add(gradient);
        add(scale);
        add(product);
        add(blocks);
        if (first.empty()) first = bits;
        EXPECT_TRUE(bits == first) << threads << " threads, " << name(set);
      });
    }
  }
}

INSTANTIATE_TEST_SUITE_P(RandomCuts, HybridLattice, ::testing::ValuesIn(test::kCutLattices),
                         [](const auto& info) { return test::name(info.param); });

}  // namespace
}  // namespace lappet
