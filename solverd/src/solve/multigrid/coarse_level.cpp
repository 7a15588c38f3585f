#include "solve/multigrid/coarse_level.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <limits>

namespace lappet {

namespace {

constexpr int kRatio = 2;
constexpr int kDegree = 4;
constexpr double kRange = 5.0;  // chosen, of the smoothing: the fewest iterations
// Relative shift of the diagonal. At rest turning all rigid modes alike moves nothing, sum_k w_k (x - x_k) = 0, and
// rigid modes that move no free node are empty: the shift must be above the rounding of the blocks.
template <class Real>
constexpr double kShift = 30.0 * std::numeric_limits<Real>::epsilon();

using Block = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// omega x a as a matrix acting on omega
Eigen::Matrix3d turning(const Vec3& a) {
  Eigen::Matrix3d m;
  m << 0, a[2], -a[1], -a[2], 0, a[0], a[1], -a[0], 0;
  return m;
}

template <class Real>
Block block_at(const Real* entries) {
  return Eigen::Map<const Eigen::Matrix<Real, 6, 6, Eigen::RowMajor>>(entries).template cast<double>();
}

}  // namespace

// What couples one node (kRows = 1) or the corners of a coarse cell (kRows = 8) with the corners of a coarse cell.
template <std::size_t kRows>
struct CornerCoupling {
  std::size_t cell;
  std::array<Block, 8 * kRows> blocks;
  std::array<bool, 8 * kRows> used{};

  // The coupling with a cell, appended where there was none.
  static CornerCoupling& with(std::size_t cell, std::vector<CornerCoupling>& list) {
    const auto found = std::ranges::find(list, cell, &CornerCoupling::cell);
    if (found != list.end()) return *found;
    auto& added = list.emplace_back(CornerCoupling{cell, {}, {}});
    added.blocks.fill(Block::Zero());
    return added;
  }
};

template <class Real>
CoarseLevel<Real>::CoarseLevel(const CoarseLattice& lattice, std::size_t max_direct)
    : lattice_(lattice), matrix_(lattice), chebyshev_(kDegree, kRange) {
  if (6 * lattice.nodes > max_direct) {
    coarse_ =
        std::make_unique<CoarseLattice>(coarsen(lattice.cell_nodes, lattice.cell_position, lattice.nodes, kRatio));
    if (2 * coarse_->nodes <= lattice.nodes) {
      next_ = std::make_unique<CoarseLevel>(*coarse_, max_direct);
      weights_ = coarse_->weights();
      next_b_.resize(6 * coarse_->nodes);
      next_x_.resize(6 * coarse_->nodes);
      partial_.resize(8 * coarse_->cell_nodes.size());
      return;
    }
    coarse_.reset();  // cuts keep it from becoming smaller
  }
  direct_.emplace();
}

template <class Real>
void CoarseLevel<Real>::release() {
  if (direct_)
    direct_->release();
  else
    next_->release();
}

template <class Real>
void CoarseLevel<Real>::prepare(std::span<const Vec3> places, double spacing) {
  if (direct_) {
    direct_->factor<Real>(matrix_, constraints_, kShift<Real>);
    return;
  }
  place_next(places, spacing);
  assemble_next();
  project_constraints();
  next_->prepare(next_place_, kRatio * spacing);
  set_diagonal();
}

template <class Real>
void CoarseLevel<Real>::solve(std::span<const Real> b, std::span<Real> x) {
  if (direct_) {
    direct_->solve<Real>(b, x);
    return;
  }
  const auto product = [this](std::span<const Real> v, std::span<Real> y) { multiply(v, y); };
  chebyshev_.before(product, b, x);
  restrict_residual();
  next_->solve(next_b_, next_x_);
  prolong();
  multiply(chebyshev_.correction(), chebyshev_.product());
  chebyshev_.after(product, x);
}

template <class Real>
void CoarseLevel<Real>::multiply(std::span<const Real> x, std::span<Real> y) const {
  matrix_.multiply(x, y);
  for (const auto& constraint : constraints_) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < constraint.nodes.size(); ++k)
      sum += constraint.rows[k] *
             Eigen::Map<const Eigen::Matrix<Real, 6, 1>>(&x[offset_of(6, constraint.nodes[k])]).template cast<double>();
    sum *= constraint.stiffness;
    for (std::size_t k = 0; k < constraint.nodes.size(); ++k)
      Eigen::Map<Eigen::Matrix<Real, 6, 1>>(&y[offset_of(6, constraint.nodes[k])]) +=
          (constraint.rows[k].transpose() * sum).template cast<Real>();
  }
}

template <class Real>
void CoarseLevel<Real>::place_next(std::span<const Vec3> places, double spacing) {
  const double inverse = 1.0 / (kRatio * spacing);
  next_place_.assign(coarse_->nodes, Vec3::Zero());
  std::vector<double> total(coarse_->nodes, 0.0);
  const std::size_t cells = coarse_->cell_nodes.size();
  for (std::size_t c = 0; c < cells; ++c)
    for (const std::size_t slot : coarse_->slots.places(c)) {
      const auto& weight = weight_of(slot);
      for (std::size_t k = 0; k < 8; ++k) {
        const std::size_t node = coarse_->cell_nodes[c][k];
        next_place_[node] += weight[k] * places[coarse_->node_of(slot)];
        total[node] += weight[k];
      }
    }
  for (std::size_t n = 0; n < coarse_->nodes; ++n)
    if (total[n] > 0) next_place_[n] /= total[n];
  arm_.resize(lattice_.nodes);
  corner_arm_.resize(8 * cells);
  for (std::size_t c = 0; c < cells; ++c) {
    Vec3 center = Vec3::Zero();
    for (const Index n : coarse_->cell_nodes[c]) center += next_place_[n] / 8;
    for (std::size_t k = 0; k < 8; ++k)
      corner_arm_[8 * c + k] = inverse * (next_place_[coarse_->cell_nodes[c][k]] - center);
    for (const std::size_t slot : coarse_->slots.places(c)) {
      arm_[slot] = inverse * (places[coarse_->node_of(slot)] - center);
    }
  }
}

template <class Real>
Eigen::Matrix<double, 6, 6> CoarseLevel<Real>::transfer_of(std::size_t slot) const {
  Block m = Block::Identity();
  m.template topRightCorner<3, 3>() = turning(arm_[slot]);
  m.template bottomRightCorner<3, 3>() /= kRatio;
  return m;
}

template <class Real>
Eigen::Matrix<double, 6, 6> CoarseLevel<Real>::shift_of(std::size_t cell, std::size_t corner) const {
  Block m = Block::Identity();
  m.template topRightCorner<3, 3>() = -turning(corner_arm_[8 * cell + corner]);
  return m;
}

template <class Real>
void CoarseLevel<Real>::couple_node(std::size_t slot, std::span<const Index> cell_of,
                                    std::vector<CornerCoupling<1>>& row) const {
  row.clear();
  const Block left = transfer_of(slot).transpose();
  matrix_.for_each(coarse_->node_of(slot), [&](Index j, const Real* entries, bool turned) {
    auto& coupling = CornerCoupling<1>::with(cell_of[j], row);
    const std::size_t other = coarse_->slot_of[j];
    const Block entry = block_at(entries);
    const Block block = left * (turned ? Block(entry.transpose()) : entry) * transfer_of(other);
    const auto& weight = weight_of(other);
    for (std::size_t l = 0; l < 8; ++l)
      if (weight[l] != 0.0) {
        coupling.blocks[l] += weight[l] * block;
        coupling.used[l] = true;
      }
  });
}

template <class Real>
void CoarseLevel<Real>::couple_cell(std::size_t c, std::span<const Index> cell_of,
                                    std::vector<CornerCoupling<8>>& list) const {
  list.clear();
  std::vector<CornerCoupling<1>> row;
  for (const std::size_t slot : coarse_->slots.places(c)) {
    couple_node(slot, cell_of, row);
    const auto& weight = weight_of(slot);
    for (const auto& from : row) {
      auto& to = CornerCoupling<8>::with(from.cell, list);
      for (std::size_t k = 0; k < 8; ++k)
        for (std::size_t l = 0; l < 8; ++l)
          if (weight[k] != 0.0 && from.used[l]) {
            to.blocks[8 * k + l] += weight[k] * from.blocks[l];
            to.used[8 * k + l] = true;
          }
    }
  }
  for (auto& coupling : list)
    for (std::size_t k = 0; k < 8; ++k)
      for (std::size_t l = 0; l < 8; ++l) {
        bool& used = coupling.used[8 * k + l];
        used = used && coarse_->cell_nodes[c][k] <= coarse_->cell_nodes[coupling.cell][l];  // of the upper triangle
        Block& block = coupling.blocks[8 * k + l];
        if (used) block = shift_of(c, k).transpose() * block * shift_of(coupling.cell, l);
      }
}

template <class Real>
void CoarseLevel<Real>::assemble_next() {
  const std::size_t cells = coarse_->cell_nodes.size();
  // A coupling takes 18 kB and a cell has up to 27: a batch of cells at a time, some for each thread.
  const std::size_t batch = 2 * tbb::this_task_arena::max_concurrency();
  std::vector<std::vector<CornerCoupling<8>>> couplings(std::min(batch, cells));
  std::vector<Index> cell_of(lattice_.nodes);
  for (std::size_t c = 0; c < cells; ++c)
    for (const Index node : coarse_->slots[c]) cell_of[node] = to_index(c);
  auto& to = next_->matrix();
  to.set_zero();
  for (std::size_t first = 0; first < cells; first += batch) {
    const std::size_t count = std::min(batch, cells - first);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t k) { couple_cell(first + k, cell_of, couplings[k]); });
    for (std::size_t c = first; c < first + count; ++c)
      for (const auto& coupling : couplings[c - first])
        for (std::size_t k = 0; k < 8; ++k)
          for (std::size_t l = 0; l < 8; ++l)
            if (coupling.used[8 * k + l])
              Eigen::Map<Eigen::Matrix<Real, 6, 6, Eigen::RowMajor>>(
                  to.block(to.slot(coarse_->cell_nodes[c][k], coarse_->cell_nodes[coupling.cell][l]))) +=
                  coupling.blocks[8 * k + l].template cast<Real>();
  }
}

template <class Real>
void CoarseLevel<Real>::project_constraints() {
  auto& constraints = next_->constraints();
  constraints.clear();
  for (const auto& constraint : constraints_) {
    ConstraintRows rows;
    for (std::size_t n = 0; n < constraint.nodes.size(); ++n) {
      const Index slot = coarse_->slot_of[constraint.nodes[n]], cell = coarse_->owner(slot);
      const Eigen::Matrix<double, 3, 6> centered = constraint.rows[n] * transfer_of(slot);
      const auto& weight = weight_of(slot);
      for (std::size_t k = 0; k < 8; ++k)
        if (weight[k] != 0.0) rows.add(coarse_->cell_nodes[cell][k], weight[k] * centered * shift_of(cell, k));
    }
    constraints.push_back(rows.constraint(constraint.stiffness));
  }
}

template <class Real>
void CoarseLevel<Real>::set_diagonal() {
  auto& diagonal = chebyshev_.diagonal();
  diagonal.resize(lattice_.nodes);
  const double floor = kShift<Real> * std::max(matrix_.largest_diagonal(), 1e-30);
  for_each_row(lattice_.nodes, [&](std::size_t n) {
    Block block = block_at(matrix_.diagonal(n));
    block.diagonal().array() += floor;
    diagonal.set(n, block);
  });
  diagonal.set_constraints(constraints_);
  chebyshev_.resize();
}

template <class Real>
void CoarseLevel<Real>::restrict_residual() {
  const auto residual = chebyshev_.residual(), product = chebyshev_.product();
  for_each_row(coarse_->cell_nodes.size(), [&](std::size_t c) {
    Vector6 sums[8];
    for (auto& sum : sums) sum.setZero();
    for (const std::size_t slot : coarse_->slots.places(c)) {
      const std::size_t n = offset_of(6, coarse_->node_of(slot));
      Vector6 r;
      for (std::size_t i = 0; i < 6; ++i) r[i] = double(residual[n + i]) - double(product[n + i]);
      r.template tail<3>() = turning(arm_[slot]).transpose() * r.template head<3>() + r.template tail<3>() / kRatio;
      const auto& weight = weight_of(slot);
      for (std::size_t k = 0; k < 8; ++k) sums[k] += weight[k] * r;
    }
    for (std::size_t k = 0; k < 8; ++k) {
      sums[k].template tail<3>() -= turning(corner_arm_[8 * c + k]).transpose() * sums[k].template head<3>();
      partial_[8 * c + k] = sums[k];
    }
  });
  for_each_row(coarse_->nodes, [&](std::size_t n) {
    Vector6 sum = Vector6::Zero();
    for (const Index corner : coarse_->corners[n]) sum += partial_[corner];
    for (std::size_t i = 0; i < 6; ++i) next_b_[6 * n + i] = Real(sum[i]);
  });
  for_each_index(residual.size(), [&](std::size_t i) { residual[i] -= product[i]; });
}

template <class Real>
void CoarseLevel<Real>::prolong() {
  const auto correction = chebyshev_.correction();
  for_each_row(coarse_->cell_nodes.size(), [&](std::size_t c) {
    Vector6 modes[8];
    for (std::size_t k = 0; k < 8; ++k) {
      const std::size_t node = coarse_->cell_nodes[c][k];
      for (std::size_t i = 0; i < 6; ++i) modes[k][i] = double(next_x_[6 * node + i]);
      modes[k].template head<3>() -= turning(corner_arm_[8 * c + k]) * modes[k].template tail<3>();
    }
    for (const std::size_t slot : coarse_->slots.places(c)) {
      const auto& weight = weight_of(slot);
      Vector6 q = Vector6::Zero();
      for (std::size_t k = 0; k < 8; ++k) q += weight[k] * modes[k];
      q.template head<3>() += turning(arm_[slot]) * q.template tail<3>();
      q.template tail<3>() /= kRatio;
      const std::size_t n = offset_of(6, coarse_->node_of(slot));
      for (std::size_t i = 0; i < 6; ++i) correction[n + i] = Real(q[i]);
    }
  });
}

template <class Real>
std::size_t CoarseLevel<Real>::bytes() const {
  if (direct_) return matrix_.bytes() + direct_->bytes();
  return matrix_.bytes() + chebyshev_.bytes() + coarse_->bytes() + next_->bytes();
}

template class CoarseLevel<float>;
template class CoarseLevel<double>;

}  // namespace lappet
