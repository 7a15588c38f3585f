// The elastic energy of a lattice, its gradient and its tangent (GRIDiron Algorithm 1), per cell of edge h:
//   F = I + (sum_c u_c (x) grad N_c) / h,   P = U P_hat(sigma) V^T,   dP = U (T : U^T dF V) V^T.
// Works on displacements u (3 per node, node-major), so that float keeps its digits far from the origin. Loops over
// cells write per cell and are gathered per node in a fixed order: the result does not depend on the number of threads.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "force/material.h"
#include "force/material_parameters.h"
#include "force/quadrature.h"
#include "lattice/lattice.h"

namespace lappet {

struct ElasticState {
  double energy = 0.0;        // mN mm
  double minimum_j = 1.0;     // over the quadrature points
  std::int32_t inverted = 0;  // cells with J <= 0 at a quadrature point
};

// What the surface shows of a cell: strain and stress measures at its centre.
struct CellMeasures {
  double stretch;    // largest principal stretch
  double von_mises;  // Cauchy, kPa
  double tension;    // largest principal Cauchy stress, kPa
};

using Matrix24 = Eigen::Matrix<double, 24, 24>;

template <class Real>
class Elastic {
 public:
  // quadrature: 1, 4 or 8. Keeps a reference to the lattice.
  Elastic(const Lattice& lattice, const MaterialParameters& material, int quadrature);

  // Energy and gradient (3 per node, written) at u; remembers the decomposition for linearize. node_scale (1 per node,
  // written): the sum of the magnitudes of the cells' forces on the node.
  ElasticState evaluate(std::span<const Real> u, std::span<double> gradient, std::span<double> node_scale);
  // Computes the tangent at the last evaluated u.
  void linearize(Definiteness how);
  // y = K x; `extra` adds for each cell c with extra_of_cell[c] >= 0 the 8x8 matrix of that index (times identity).
  void multiply(std::span<const Real> x, std::span<Real> y) const;
  // Quadratic terms on cells (attachments): 64 numbers each, symmetric, row-major; index per cell or -1.
  void set_cell_quadratics(std::vector<std::int32_t> of_cell, std::vector<Real> matrices);
  // 3x3 diagonal blocks of K, 9 per node.
  void diagonal_blocks(std::span<double> blocks) const;
  // K of one cell, ordered corner-major (3 corner + component), with the cell's quadratic term.
  Matrix24 cell_stiffness(std::int32_t cell) const;
  // Adds P^T K P of one cell to a coarse block; P: 24 fine unknowns (corner-major) by 48 coarse ones.
  void add_projected_stiffness(std::int32_t cell, const Eigen::Matrix<Real, 24, 48>& p,
                               Eigen::Matrix<Real, 48, 48>& block) const;
  // The same for up to kProjectionLanes cells of one coarse cell, in the layouts of projected_stiffness_kernel.h with
  // the lanes innermost: weights [64][lane] (zero in lanes without a cell), arms [24][lane], blocks
  // [kFramePairSize][lane].
  static constexpr int kProjectionLanes = 8;
  void add_projected_stiffness(std::span<const std::int32_t> cells, const Real* weights, const Real* arms,
                               Real* blocks) const;
  CellMeasures measures(std::int32_t cell, std::span<const Real> u) const;

  std::size_t bytes() const;
  const Lattice& lattice() const { return lattice_; }
  const MaterialParameters& material() const { return material_; }

 private:
  struct Point {  // the tangent at a quadrature point
    Real u[9], v[9];
    Real hessian[6];
    Real same[3], cross[3];  // dP_ij = same dF_ij + cross dF_ji, pairs 01 02 12
  };
  template <class Model>
  ElasticState evaluate_cells(std::span<const Real> u);
  template <class Model>
  void linearize_cells(Definiteness how);
  double cell_volume(std::size_t cell) const;

  const Lattice& lattice_;
  MaterialParameters material_;
  double mu_, lambda_, laplacian_;
  std::vector<QuadraturePoint> quadrature_;
  std::vector<Real> gradients_;  // 24 per quadrature point, divided by h
  std::vector<Point> points_;
  std::vector<std::array<double, 3>> sigma_;
  std::vector<std::int32_t> incidence_start_, incidence_;  // node -> cell * 8 + corner
  std::vector<double> cell_gradient_;                      // 24 per cell
  mutable std::vector<Real> cell_product_;                 // 24 per cell
  std::vector<std::int32_t> quadratic_of_cell_;
  std::vector<Real> quadratics_;
};

extern template class Elastic<float>;
extern template class Elastic<double>;

}  // namespace lappet
