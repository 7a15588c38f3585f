#include "solve/multigrid/rigid_modes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "force/kernels/projected_stiffness_kernel.h"
#include "lattice/node_field.h"
#include "solve/multigrid/contact_groups.h"

namespace lappet {

namespace {

constexpr int kCoarsening = 4;
// Coarse cells whose blocks (5 kB each in float) are held before they go into the matrix.
constexpr std::size_t kBatch = 256;

template <class Real>
using Block = Eigen::Matrix<Real, 6, 6, Eigen::RowMajor>;

// The penalties on the cells of each coarse cell.
Groups by_coarse_cell(const CoarseLattice& coarse, std::span<const ContactPenalty> penalties) {
  std::vector<Index> coarse_of(coarse.cells.items.size());
  for (std::size_t c = 0; c < coarse.cell_nodes.size(); ++c)
    for (const Index cell : coarse.cells[c]) coarse_of[cell] = to_index(c);
  std::vector<Index> keys;
  keys.reserve(penalties.size());
  for (const ContactPenalty& penalty : penalties) keys.push_back(coarse_of[penalty.cell]);
  return group_by(keys, coarse.cell_nodes.size());
}

template <class Real>
Vec3 now(const Lattice& lattice, std::span<const Real> u, std::size_t n) {
  return lattice.node_rest[n] + NodeField(u)[n];
}

}  // namespace

template <class Real>
RigidModes<Real>::RigidModes(const Lattice& lattice, std::size_t max_direct)
    : lattice_(lattice),
      coarse_(coarsen(lattice.cell_nodes, lattice.cell_positions(), lattice.node_rest.size(), kCoarsening)),
      level_(coarse_, max_direct) {
  for (const auto& entry : coarse_.weights()) {
    auto& to = weights_.emplace_back();
    for (std::size_t k = 0; k < 8; ++k) to[k] = Real(entry[k]);
  }
  weights_.push_back({});
  weight_of_.resize(lattice.node_rest.size());
  arm_.resize(3 * lattice.node_rest.size());
  corner_arm_.resize(24 * coarse_.cell_nodes.size());
  partial_.resize(48 * coarse_.cell_nodes.size());
  restricted_.resize(unknowns());
  solved_.resize(unknowns());
}

template <class Real>
void RigidModes<Real>::place_modes(const System<Real>& system, std::span<const Real> u) {
  const double inverse = 1.0 / (kCoarsening * lattice_.settings.spacing);
  const std::size_t cells = coarse_.cell_nodes.size();
  std::vector<std::array<double, 4>> sums(8 * cells);
  for_each_row(cells, [&](std::size_t c) {
    std::array<double, 4> local[8] = {};
    for (const std::size_t slot : coarse_.slots.places(c)) {
      const Vec3 x = now(lattice_, u, coarse_.node_of(slot));
      const auto& weight = weights_[coarse_.weight_index(slot)];
      for (std::size_t k = 0; k < 8; ++k) {
        const double w = weight[k];
        for (int i = 0; i < 3; ++i) local[k][i] += w * x[i];
        local[k][3] += w;
      }
    }
    for (std::size_t k = 0; k < 8; ++k) sums[8 * c + k] = local[k];
  });
  place_.assign(coarse_.nodes, Vec3::Zero());
  for (std::size_t n = 0; n < coarse_.nodes; ++n) {
    double total = 0.0;
    for (const Index corner : coarse_.corners[n]) {
      const auto& sum = sums[corner];
      place_[n] += Vec3(sum[0], sum[1], sum[2]);
      total += sum[3];
    }
    if (total > 0) place_[n] /= total;
  }
  center_.resize(cells);
  for_each_row(cells, [&](std::size_t c) {
    center_[c] = Vec3::Zero();
    for (const Index n : coarse_.cell_nodes[c]) center_[c] += place_[n] / 8;
    for (std::size_t k = 0; k < 8; ++k) {
      const Vec3 arm = inverse * (place_[coarse_.cell_nodes[c][k]] - center_[c]);
      for (int i = 0; i < 3; ++i) corner_arm_[24 * c + 8 * i + k] = Real(arm[i]);
    }
    for (const std::size_t slot : coarse_.slots.places(c)) {
      const Index n = coarse_.node_of(slot);
      const Vec3 arm = inverse * (now(lattice_, u, n) - center_[c]);
      for (int i = 0; i < 3; ++i) arm_[3 * slot + i] = Real(arm[i]);
      weight_of_[slot] = std::uint8_t(system.is_free(n) ? coarse_.weight_index(slot) : weights_.size() - 1);
    }
  });
}

template <class Real>
void RigidModes<Real>::assemble(const System<Real>& system, std::span<const Real> u) {
  level_.release();
  place_modes(system, u);
  assemble_cells(system, u);
  assemble_constraints(system);
  level_.prepare(place_, kCoarsening * lattice_.settings.spacing);
}

// Projects the cells of a coarse cell, kLanes at a time; blocks: [kModePairSize][lane], added to.
template <class Real>
void RigidModes<Real>::project_cells(const System<Real>& system, std::span<const Real> u, std::size_t coarse,
                                     Real* blocks) const {
  constexpr std::size_t kLanes = Elastic<Real>::kProjectionLanes;
  const double inverse = 1.0 / (kCoarsening * lattice_.settings.spacing);
  alignas(64) Real weights[64 * kLanes], arms[24 * kLanes];
  const std::span<const Index> cells = coarse_.cells[coarse];
  for (std::size_t first = 0; first < cells.size(); first += kLanes) {
    const auto batch = cells.subspan(first, std::min(kLanes, cells.size() - first));
    std::fill_n(weights, 64 * kLanes, Real(0));
    std::fill_n(arms, 24 * kLanes, Real(0));
    for (std::size_t lane = 0; lane < batch.size(); ++lane)
      for (int corner = 0; corner < 8; ++corner) {
        const Index c = batch[lane], n = lattice_.cell_nodes[c][corner];
        const auto place = coarse_.corner_place(lattice_.cell_position(c), coarse, corner);
        const auto& weight = system.is_free(n) ? weights_[coarse_.weight_index(place)] : weights_.back();
        for (std::size_t k = 0; k < 8; ++k) weights[kLanes * (8 * k + corner) + lane] = weight[k];
        const Vec3 arm = inverse * (now(lattice_, u, n) - center_[coarse]);
        for (int i = 0; i < 3; ++i) arms[kLanes * (3 * corner + i) + lane] = Real(arm[i]);
      }
    system.elastic().add_projected_stiffness(batch, weights, arms, blocks);
  }
}

// A contact penalty couples nodes of one cell, so that it goes where the cell does; blocks: [kModePairSize], added to.
template <class Real>
void RigidModes<Real>::project_penalty(const System<Real>& system, std::span<const Real> u, std::size_t coarse,
                                       const ContactPenalty& penalty, Real* blocks) const {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const double inverse = 1.0 / (kCoarsening * lattice_.settings.spacing);
  Vector6 rows[8];
  for (auto& row : rows) row.setZero();
  for (int corner = 0; corner < 8; ++corner) {
    const Index n = lattice_.cell_nodes[penalty.cell][corner];
    if (penalty.weights[corner] == 0.0 || !system.is_free(n)) continue;
    const auto place = coarse_.corner_place(lattice_.cell_position(penalty.cell), coarse, corner);
    const auto& weight = weights_[coarse_.weight_index(place)];
    const Vec3 arm = inverse * (now(lattice_, u, n) - center_[coarse]);
    Vector6 push;
    push << penalty.direction, arm.cross(penalty.direction);
    for (int k = 0; k < 8; ++k) rows[k] += penalty.weights[corner] * double(weight[k]) * push;
  }
  for (int k = 0; k < 8; ++k)
    for (int l = 0; l <= k; ++l)
      Eigen::Map<Block<Real>>(blocks + 36 * pair_of(k, l)) +=
          (penalty.stiffness * rows[k] * rows[l].transpose()).template cast<Real>();
}

// Moves the blocks of a coarse cell from rigid modes about its center to those about the places of its corners.
template <class Real>
void RigidModes<Real>::shift_to_corners(std::size_t coarse, Real* blocks) const {
  Block<Real> shift[8];
  for (std::size_t k = 0; k < 8; ++k) {
    const Real *x = &corner_arm_[24 * coarse], a = x[k], b = x[8 + k], c = x[16 + k];
    shift[k].setIdentity();
    shift[k].template topRightCorner<3, 3>() << 0, -c, b, c, 0, -a, -b, a, 0;
  }
  for (int k = 0; k < 8; ++k)
    for (int l = 0; l <= k; ++l) {
      Eigen::Map<Block<Real>> block(blocks + 36 * pair_of(k, l));
      block = (shift[k].transpose() * block * shift[l]).eval();
    }
}

template <class Real>
void RigidModes<Real>::assemble_cells(const System<Real>& system, std::span<const Real> u) {
  constexpr std::size_t kLanes = Elastic<Real>::kProjectionLanes;
  const std::size_t coarse_cells = coarse_.cell_nodes.size();
  std::vector<Real> pairs(kModePairSize * std::min(kBatch, coarse_cells));
  const std::span<const ContactPenalty> penalties = system.contact_penalties();
  const Groups penalties_of = by_coarse_cell(coarse_, penalties);
  const auto project = [&](std::size_t coarse, Real* out) {
    alignas(64) Real blocks[kModePairSize * kLanes] = {};
    project_cells(system, u, coarse, blocks);
    for (std::size_t i = 0; i < kModePairSize; ++i) {
      Real sum = 0;
      for (std::size_t lane = 0; lane < kLanes; ++lane) sum += blocks[kLanes * i + lane];
      out[i] = sum;
    }
    for (const Index p : penalties_of[coarse]) project_penalty(system, u, coarse, penalties[p], out);
    shift_to_corners(coarse, out);
  };
  auto& matrix = level_.matrix();
  matrix.set_zero();
  for (std::size_t first = 0; first < coarse_cells; first += kBatch) {
    const std::size_t count = std::min(kBatch, coarse_cells - first);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t k) { project(first + k, &pairs[kModePairSize * k]); });
    matrix.add(coarse_, first, std::span(pairs).first(kModePairSize * count));
  }
}

template <class Real>
template <class Weight>
void RigidModes<Real>::add_rows(Index node, const Weight& weight, ConstraintRows& rows) const {
  const std::size_t slot = coarse_.slot_of[node], cell = coarse_.owner(coarse_.slot_of[node]);
  const auto& shares = weights_[weight_of_[slot]];
  for (std::size_t k = 0; k < 8; ++k) {
    if (shares[k] == Real(0)) continue;
    const Real* corner = &corner_arm_[24 * cell];
    const double ax = double(arm_[3 * slot]) - double(corner[k]),
                 ay = double(arm_[3 * slot + 1]) - double(corner[8 + k]),
                 az = double(arm_[3 * slot + 2]) - double(corner[16 + k]);
    Eigen::Matrix<double, 3, 6> row;
    row << 1, 0, 0, 0, az, -ay, 0, 1, 0, -az, 0, ax, 0, 0, 1, ay, -ax, 0;
    rows.add(coarse_.cell_nodes[cell][k], weight * double(shares[k]) * row);
  }
}

template <class Real>
void RigidModes<Real>::assemble_constraints(const System<Real>& system) {
  auto& constraints = level_.constraints();
  constraints.clear();
  const std::vector<PointConstraint>& points = system.point_constraints();
  const Eigen::Matrix3d* tangent = system.point_tangent().roots.data();
  const Vec3* along = system.point_tangent().rows.data();
  for (const PointConstraint& point : points) {
    ConstraintRows of_thread;  // the row of a thread that slides, and two that are zero
    for (const Piece& piece : point.pieces) {
      ConstraintRows rows;
      for (std::size_t i = 0; i < piece.nodes.size(); ++i) add_rows(piece.nodes[i], piece.weights[i], rows);
      constraints.push_back(rows.constraint(point.stiffness));
      CoarseConstraint& projected = constraints.back();
      if (point.slides()) {
        const Eigen::Matrix3d first = Vec3::UnitX() * (*along++ / std::sqrt(point.stiffness)).transpose();
        for (std::size_t k = 0; k < projected.nodes.size(); ++k)
          of_thread.add(projected.nodes[k], first * projected.rows[k]);
      }
      const Eigen::Matrix3d root = *tangent++ / std::sqrt(point.stiffness);
      for (auto& row : projected.rows) row = (root * row).eval();
    }
    if (point.slides()) constraints.push_back(of_thread.constraint(point.stiffness));
  }
  if (system.self_contact_rows().count() > 0) assemble_self_contact(system);
}

template <class Real>
void RigidModes<Real>::assemble_self_contact(const System<Real>& system) {
  std::vector<Index> coarse_of(coarse_.cells.items.size());
  for (std::size_t c = 0; c < coarse_.cell_nodes.size(); ++c)
    for (const Index cell : coarse_.cells[c]) coarse_of[cell] = to_index(c);
  for (const ContactGroup& group :
       group_contacts(system.self_contact_rows(), system.self_contact_places(), coarse_of)) {
    double stiffness = 0.0;
    for (const auto& [node, factors] : group) stiffness = std::max(stiffness, factors.squaredNorm());
    if (!(stiffness > 0.0)) continue;
    ConstraintRows rows;
    for (const auto& [node, factors] : group) add_rows(node, Eigen::Matrix3d(factors / std::sqrt(stiffness)), rows);
    CoarseConstraint projected = rows.constraint(stiffness);
    if (!projected.nodes.empty()) level_.constraints().push_back(std::move(projected));
  }
}

template <class Real>
void RigidModes<Real>::correct(std::span<const Real> product, std::span<Real> r, std::span<Real> x) {
  for_each_row(coarse_.cell_nodes.size(), [&](std::size_t c) {
    Real sums[6][8] = {};
    for (const std::size_t slot : coarse_.slots.places(c)) {
      const std::size_t n = offset_of(3, coarse_.node_of(slot));
      const Real fx = r[n] -= product[n], fy = r[n + 1] -= product[n + 1], fz = r[n + 2] -= product[n + 2];
      const Real ax = arm_[3 * slot], ay = arm_[3 * slot + 1], az = arm_[3 * slot + 2];
      const Real force[6] = {fx, fy, fz, ay * fz - az * fy, az * fx - ax * fz, ax * fy - ay * fx};
      const Real* w = weights_[weight_of_[slot]].data();
      for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 8; ++k) sums[i][k] += w[k] * force[i];
    }
    const Real* a = &corner_arm_[24 * c];
    for (int k = 0; k < 8; ++k) {
      Real* out = &partial_[48 * c + 6 * k];
      for (int i = 0; i < 3; ++i) out[i] = sums[i][k];
      out[3] = sums[3][k] - (a[8 + k] * sums[2][k] - a[16 + k] * sums[1][k]);
      out[4] = sums[4][k] - (a[16 + k] * sums[0][k] - a[k] * sums[2][k]);
      out[5] = sums[5][k] - (a[k] * sums[1][k] - a[8 + k] * sums[0][k]);
    }
  });
  for_each_index(coarse_.nodes, [&](std::size_t n) {
    Real sum[6] = {};
    for (const Index corner : coarse_.corners[n]) {
      const Real* from = &partial_[offset_of(6, corner)];
      for (int j = 0; j < 6; ++j) sum[j] += from[j];
    }
    for (std::size_t j = 0; j < 6; ++j) restricted_[6 * n + j] = sum[j];
  });
  level_.solve(restricted_, solved_);
  prolong(solved_, x);
}

template <class Real>
void RigidModes<Real>::prolong(std::span<const Real> q, std::span<Real> x) const {
  for_each_row(coarse_.cell_nodes.size(), [&](std::size_t c) {
    const Real* a = &corner_arm_[24 * c];
    Real modes[8][8] = {};  // [corner][t', omega, 0, 0]
    for (std::size_t k = 0; k < 8; ++k) {
      const Real* f = &q[offset_of(6, coarse_.cell_nodes[c][k])];
      modes[k][0] = f[0] - (f[4] * a[16 + k] - f[5] * a[8 + k]);
      modes[k][1] = f[1] - (f[5] * a[k] - f[3] * a[16 + k]);
      modes[k][2] = f[2] - (f[3] * a[8 + k] - f[4] * a[k]);
      for (int i = 3; i < 6; ++i) modes[k][i] = f[i];
    }
    for (const std::size_t slot : coarse_.slots.places(c)) {
      const Real* w = weights_[weight_of_[slot]].data();
      Real sum[8] = {};
      for (int k = 0; k < 8; ++k)
        for (int i = 0; i < 8; ++i) sum[i] += w[k] * modes[k][i];
      const Real ax = arm_[3 * slot], ay = arm_[3 * slot + 1], az = arm_[3 * slot + 2];
      Real* to = &x[offset_of(3, coarse_.node_of(slot))];
      to[0] = sum[0] + sum[4] * az - sum[5] * ay;
      to[1] = sum[1] + sum[5] * ax - sum[3] * az;
      to[2] = sum[2] + sum[3] * ay - sum[4] * ax;
    }
  });
}

template <class Real>
std::size_t RigidModes<Real>::bytes() const {
  return coarse_.bytes() + level_.bytes() + weight_of_.size() +
         sizeof(Real) * (arm_.size() + corner_arm_.size() + partial_.size() + 12 * coarse_.nodes);
}

template class RigidModes<float>;
template class RigidModes<double>;

}  // namespace lappet
