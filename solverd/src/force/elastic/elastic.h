// The elastic energy of a lattice, its gradient and its tangent (GRIDiron Algorithm 1), per cell of edge h:
//   F = I + (sum_c u_c (x) grad N_c) / h,   P = U P_hat(sigma) V^T,   dP = U (T : U^T dF V) V^T.
// Works on displacements u (3 per node, node-major), so that float keeps its digits far from the origin. The work is
// done by SIMD kernels on blocks of cells (elastic_kernels.h); sums do not depend on the number of threads.
#pragma once
#include <tbb/cache_aligned_allocator.h>

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "force/elastic/block_layout.h"
#include "force/kernels/elastic_kernels.h"
#include "force/kernels/quadrature.h"
#include "force/materials/material_parameters.h"
#include "lattice/lattice.h"

namespace lappet {

struct ElasticState {
  double energy = 0.0;        // mN mm
  double minimum_j = 1.0;     // over the quadrature points
  std::int32_t inverted = 0;  // cells with J <= 0 at a quadrature point
};

// What the surface shows of a cell: strain and stress measures at its center.
struct CellMeasures {
  double stretch;    // largest principal stretch
  double von_mises;  // Cauchy, kPa
  double tension;    // largest principal Cauchy stress, kPa
};

template <class Real>
class Elastic {
 public:
  // quadrature: 1, 4 or 8, points of each part of a cell that is of one material. All materials have the same model.
  // Keeps a reference to the lattice. still: per node, 1 where it stays at rest; blocks without any other have no
  // forces on what moves, and are not computed. Empty: none.
  Elastic(const Lattice& lattice, CellMaterials materials, int quadrature,
          InstructionSet set = choose_instruction_set(), std::span<const std::uint8_t> still = {},
          const Interrupt& interrupt = {});
  Elastic(const Lattice& lattice, const MaterialParameters& material, int quadrature)
      : Elastic(lattice, CellMaterials{{material}}, quadrature) {}
  Elastic(const Elastic&) = delete;
  Elastic& operator=(const Elastic&) = delete;

  // How far each material's muscle is active, 0 to 1 (empty: not at all). Holds from the next evaluation on.
  void set_activation(std::span<const double> activation);
  std::span<const double> activation() const { return activation_; }
  // Energy and gradient (3 per node, written) at u; keeps the decomposition for linearize. node_scale (1 per node,
  // written): the sum of the magnitudes of the cells' forces on the node.
  ElasticState evaluate(std::span<const Real> u, std::span<double> gradient, std::span<double> node_scale);
  // Computes the tangent at the last evaluated u.
  void linearize(PsdProjection how);
  // y = K x
  void multiply(std::span<const Real> x, std::span<Real> y) const;
  // Quadratic terms on cells (attachments): 64 numbers each, symmetric, row-major; index per cell or -1.
  void set_cell_quadratics(std::span<const Index> of_cell, std::span<const Real> matrices);
  // 3x3 diagonal blocks of K, 6 per node: 00 01 02 11 12 22.
  void diagonal_blocks(std::span<Real> blocks) const;
  // Adds P^T K P of up to kProjectionLanes cells to a coarse block, in the layouts of projected_stiffness_kernel.h with
  // the lanes innermost: weights [64][lane] (zero in lanes without a cell), arms [24][lane], blocks
  // [kModePairSize][lane], all aligned to 64 bytes.
  static constexpr int kProjectionLanes = 16;
  void add_projected_stiffness(std::span<const Index> cells, const Real* weights, const Real* arms, Real* blocks) const;
  // Of the middle of a cell's largest part; u: the displacements last evaluated, whose singular values are at hand.
  CellMeasures measures(Index cell, std::span<const Real> u) const;

  std::size_t bytes() const;
  const Lattice& lattice() const { return lattice_; }
  const CellMaterials& materials() const { return materials_; }
  const BlockLayout& layout() const { return layout_; }
  std::span<const Index> part_cells() const { return part_cells_; }  // of layout().slot_of_part
  const SceneFeatures& features() const { return features_; }
  const ElasticArrays<Real>& arrays() const { return arrays_; }
  const ElasticKernels<Real>& kernels() const { return kernels_; }
  int points() const { return int(quadrature_.size()); }  // of quadrature
  InstructionSet instruction_set() const { return set_; }

 private:
  // Calls body(kernels, begin, end) for runs of groups, those without shares with kernels that know none.
  template <class Body>
  void for_each_run(std::int64_t begin, std::int64_t end, const Body& body) const {
    while (begin < end) {
      std::int64_t stop = group_has_shares_.empty() ? end : begin + 1;
      while (stop < end && group_has_shares_[stop] == group_has_shares_[begin]) ++stop;
      body(group_has_shares_.empty() || group_has_shares_[begin] ? kernels_ : whole_kernels_, begin, stop);
      begin = stop;
    }
  }
  void fill_cells();
  void fill_shares(double laplacian);
  // Volume and stabilization of a part of a cell.
  void fill_volume(std::size_t slot, std::size_t cell, std::size_t material, double laplacian, double part);
  // Writes what a cell is made of, field by field with `stride` between them. family: MaterialShare's.
  void fill_record(Real* record, std::size_t stride, std::size_t material, std::size_t cell, int family = 0) const;
  // What the fibers and muscle of a record add to the Cauchy stress, in the frame of the decomposition of F.
  Eigen::Matrix3d fiber_stress(const Real* record, int lanes, const double (&sigma)[3],
                               const double (&rotation_v)[9]) const;
  // The material as it is in a cell, and its prestretch normal to the skin.
  std::pair<MaterialParameters, double> material_in(std::size_t material, std::size_t cell) const;
  // Calls body(slot, share, further) for each share of a cell that is computed; further: it is not the largest.
  template <class Body>
  void for_each_share(const Body& body) const;
  double muscle(std::size_t material) const {
    return material < activation_.size() ? materials_.table[material].muscle_stress * activation_[material] : 0.0;
  }
  std::size_t material_of(std::size_t cell) const { return materials_.of_cell.empty() ? 0 : materials_.of_cell[cell]; }
  Vec3 normal_of(std::size_t cell) const {
    return materials_.normal_of_cell.empty() ? Vec3::UnitZ()
                                             : Vec3(materials_.normal_of_cell[cell].template cast<double>());
  }
  // Of the middle of a cell's largest part, 3x3 by rows.
  void deformation_gradient(Index cell, std::span<const Real> u, double* f) const;

  const Lattice& lattice_;
  CellMaterials materials_;
  SceneFeatures features_;
  InstructionSet set_;
  ElasticKernels<Real> kernels_, whole_kernels_;  // of the scene, and of groups of cells without shares
  std::vector<std::uint8_t> group_has_shares_;    // empty where none has
  std::vector<Index> part_cells_;                 // the cell of each share but the largest, in their order
  BlockLayout layout_;
  std::vector<QuadraturePoint> quadrature_;
  bool uniform_;                                       // one record of material for all cells
  std::size_t record_fields_;                          // of MaterialField: those that the scene needs
  std::vector<double> third_prestretch_, activation_;  // of each material
  std::vector<double> gradients_, positions_, weights_;
  template <class T>
  using Aligned = std::vector<T, tbb::cache_aligned_allocator<T>>;
  Aligned<Real> volume_, stabilization_, material_, share_, tangent_, sigma_, fiber_tangent_, quadratics_;
  std::vector<Index> quadratic_of_;
  ElasticArrays<Real> arrays_;
};

extern template class Elastic<float>;
extern template class Elastic<double>;

}  // namespace lappet
