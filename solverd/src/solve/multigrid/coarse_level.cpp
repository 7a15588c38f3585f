#include "solve/multigrid/coarse_level.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <limits>

namespace lappet {

namespace {

constexpr int kRatio = 2;
constexpr int kDegree = 4;
constexpr int kLanczosSteps = 8;
constexpr double kMargin = 1.1, kMaxEigenvalue = 27.0;
// Relative shift of the diagonal. At rest turning all rigid modes alike moves nothing, sum_k w_k (x - x_k) = 0, and
// rigid modes that move no free node are empty: the shift must be above the rounding of the blocks.
template <class Real>
constexpr double kShift = 30.0 * std::numeric_limits<Real>::epsilon();

// omega x a as a matrix acting on omega
Eigen::Matrix3d turning(const Vec3& a) {
  Eigen::Matrix3d m;
  m << 0, a[2], -a[1], -a[2], 0, a[0], a[1], -a[0], 0;
  return m;
}

}  // namespace

template <class Real>
CoarseLevel<Real>::CoarseLevel(const CoarseLattice& lattice, std::size_t max_direct)
    : lattice_(lattice), matrix_(lattice), chebyshev_(kDegree) {
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
             Eigen::Map<const Eigen::Matrix<Real, 6, 1>>(&x[6 * static_cast<std::size_t>(constraint.nodes[k])])
                 .template cast<double>();
    sum *= constraint.stiffness;
    for (std::size_t k = 0; k < constraint.nodes.size(); ++k)
      Eigen::Map<Eigen::Matrix<Real, 6, 1>>(&y[6 * static_cast<std::size_t>(constraint.nodes[k])]) +=
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
    for (auto s = coarse_->slot_start[c]; s < coarse_->slot_start[c + 1]; ++s) {
      const auto slot = static_cast<std::size_t>(s);
      const auto& weight = weights_[static_cast<std::size_t>(coarse_->weight_index(coarse_->local[slot]))];
      for (std::size_t k = 0; k < 8; ++k) {
        const auto node = static_cast<std::size_t>(coarse_->cell_nodes[c][k]);
        next_place_[node] += weight[k] * places[static_cast<std::size_t>(coarse_->slot_node[slot])];
        total[node] += weight[k];
      }
    }
  for (std::size_t n = 0; n < coarse_->nodes; ++n)
    if (total[n] > 0) next_place_[n] /= total[n];
  arm_.resize(lattice_.nodes);
  corner_arm_.resize(8 * cells);
  for (std::size_t c = 0; c < cells; ++c) {
    Vec3 center = Vec3::Zero();
    for (const std::int32_t n : coarse_->cell_nodes[c]) center += next_place_[static_cast<std::size_t>(n)] / 8;
    for (std::size_t k = 0; k < 8; ++k)
      corner_arm_[8 * c + k] = inverse * (next_place_[static_cast<std::size_t>(coarse_->cell_nodes[c][k])] - center);
    for (auto s = coarse_->slot_start[c]; s < coarse_->slot_start[c + 1]; ++s) {
      const auto slot = static_cast<std::size_t>(s);
      arm_[slot] = inverse * (places[static_cast<std::size_t>(coarse_->slot_node[slot])] - center);
    }
  }
}

template <class Real>
typename CoarseLevel<Real>::Block CoarseLevel<Real>::transfer_of(std::size_t slot) const {
  Block m = Block::Identity();
  m.template topRightCorner<3, 3>() = turning(arm_[slot]);
  m.template bottomRightCorner<3, 3>() /= kRatio;
  return m;
}

template <class Real>
typename CoarseLevel<Real>::Block CoarseLevel<Real>::shift_of(std::size_t cell, std::size_t corner) const {
  Block m = Block::Identity();
  m.template topRightCorner<3, 3>() = -turning(corner_arm_[8 * cell + corner]);
  return m;
}

// What couples a cell to another, itself or a neighbor: 8 x 8 blocks between their corners.
template <class Real>
struct CoarseLevel<Real>::Neighbor {
  std::size_t cell;
  std::array<Block, 64> blocks;
  std::array<bool, 64> used{};
};

// Of one node: its couplings summed over the nodes of a neighbor.
template <class Real>
struct CoarseLevel<Real>::Row {
  std::size_t cell;
  std::array<Block, 8> blocks;
  std::array<bool, 8> used;
};

template <class Real>
const std::array<double, 8>& CoarseLevel<Real>::weight_of(std::size_t slot) const {
  return weights_[static_cast<std::size_t>(coarse_->weight_index(coarse_->local[slot]))];
}

template <class Real>
void CoarseLevel<Real>::sum_row(std::size_t slot, std::span<const std::int32_t> owner, std::vector<Row>& row) const {
  row.clear();
  const Block left = transfer_of(slot).transpose();
  matrix_.for_each(static_cast<std::size_t>(coarse_->slot_node[slot]), [&](std::int32_t j, const Real* entries,
                                                                           bool turned) {
    const auto cell = static_cast<std::size_t>(owner[static_cast<std::size_t>(j)]);
    auto found = std::find_if(row.begin(), row.end(), [&](const Row& r) { return r.cell == cell; });
    if (found == row.end()) {
      found = row.insert(row.end(), Row{cell, {}, {}});
      found->blocks.fill(Block::Zero());
    }
    const auto other = static_cast<std::size_t>(coarse_->slot_of[static_cast<std::size_t>(j)]);
    const Block entry = Eigen::Map<const Eigen::Matrix<Real, 6, 6, Eigen::RowMajor>>(entries).template cast<double>();
    const Block block = left * (turned ? Block(entry.transpose()) : entry) * transfer_of(other);
    const auto& weight = weight_of(other);
    for (std::size_t l = 0; l < 8; ++l)
      if (weight[l] != 0.0) {
        found->blocks[l] += weight[l] * block;
        found->used[l] = true;
      }
  });
}

template <class Real>
void CoarseLevel<Real>::couple(std::size_t c, std::span<const std::int32_t> owner, std::vector<Neighbor>& list) const {
  list.clear();
  std::vector<Row> row;
  for (auto s = coarse_->slot_start[c]; s < coarse_->slot_start[c + 1]; ++s) {
    const auto slot = static_cast<std::size_t>(s);
    sum_row(slot, owner, row);
    const auto& weight = weight_of(slot);
    for (const Row& r : row) {
      auto found = std::find_if(list.begin(), list.end(), [&](const Neighbor& n) { return n.cell == r.cell; });
      if (found == list.end()) {
        found = list.insert(list.end(), Neighbor{r.cell, {}, {}});
        found->blocks.fill(Block::Zero());
      }
      for (std::size_t k = 0; k < 8; ++k)
        for (std::size_t l = 0; l < 8; ++l)
          if (weight[k] != 0.0 && r.used[l]) {
            found->blocks[8 * k + l] += weight[k] * r.blocks[l];
            found->used[8 * k + l] = true;
          }
    }
  }
  for (auto& neighbor : list)
    for (std::size_t k = 0; k < 8; ++k)
      for (std::size_t l = 0; l < 8; ++l) {
        // of the upper triangle
        neighbor.used[8 * k + l] =
            neighbor.used[8 * k + l] && coarse_->cell_nodes[c][k] <= coarse_->cell_nodes[neighbor.cell][l];
        if (neighbor.used[8 * k + l])
          neighbor.blocks[8 * k + l] =
              shift_of(c, k).transpose() * neighbor.blocks[8 * k + l] * shift_of(neighbor.cell, l);
      }
}

template <class Real>
void CoarseLevel<Real>::assemble_next() {
  const std::size_t cells = coarse_->cell_nodes.size();
  // A neighbor takes 18 kB and a cell has up to 27: a batch of cells at a time, some for each thread.
  const std::size_t batch = 2 * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  std::vector<std::vector<Neighbor>> couplings(std::min(batch, cells));
  std::vector<std::int32_t> owner(lattice_.nodes);
  for (std::size_t c = 0; c < cells; ++c)
    for (auto s = coarse_->slot_start[c]; s < coarse_->slot_start[c + 1]; ++s)
      owner[static_cast<std::size_t>(coarse_->slot_node[static_cast<std::size_t>(s)])] = static_cast<std::int32_t>(c);
  auto& to = next_->matrix();
  to.set_zero();
  for (std::size_t first = 0; first < cells; first += batch) {
    const std::size_t count = std::min(batch, cells - first);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t k) { couple(first + k, owner, couplings[k]); });
    for (std::size_t c = first; c < first + count; ++c)
      for (const auto& neighbor : couplings[c - first])
        for (std::size_t k = 0; k < 8; ++k)
          for (std::size_t l = 0; l < 8; ++l)
            if (neighbor.used[8 * k + l])
              Eigen::Map<Eigen::Matrix<Real, 6, 6, Eigen::RowMajor>>(
                  to.block(to.slot(coarse_->cell_nodes[c][k], coarse_->cell_nodes[neighbor.cell][l]))) +=
                  neighbor.blocks[8 * k + l].template cast<Real>();
  }
}

template <class Real>
void CoarseLevel<Real>::project_constraints() {
  auto& constraints = next_->constraints();
  constraints.clear();
  for (const auto& constraint : constraints_) {
    ConstraintRows rows;
    for (std::size_t n = 0; n < constraint.nodes.size(); ++n) {
      const auto slot = static_cast<std::size_t>(coarse_->slot_of[static_cast<std::size_t>(constraint.nodes[n])]);
      const auto cell = static_cast<std::size_t>(coarse_->owner(static_cast<std::int32_t>(slot)));
      const Eigen::Matrix<double, 3, 6> centered = constraint.rows[n] * transfer_of(slot);
      const auto& weight = weights_[static_cast<std::size_t>(coarse_->weight_index(coarse_->local[slot]))];
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
    Block block =
        Eigen::Map<const Eigen::Matrix<Real, 6, 6, Eigen::RowMajor>>(matrix_.diagonal(n)).template cast<double>();
    block.diagonal().array() += floor;
    diagonal.set(n, block);
  });
  diagonal.set_constraints(constraints_);
  chebyshev_.estimate([this](std::span<const Real> v, std::span<Real> y) { multiply(v, y); },
                      [](std::size_t) { return true; }, kLanczosSteps, kMargin, kMaxEigenvalue);
}

template <class Real>
void CoarseLevel<Real>::restrict_residual() {
  const auto residual = chebyshev_.residual(), product = chebyshev_.product();
  for_each_row(coarse_->cell_nodes.size(), [&](std::size_t c) {
    Eigen::Matrix<double, 6, 1> sums[8];
    for (auto& sum : sums) sum.setZero();
    for (auto s = coarse_->slot_start[c]; s < coarse_->slot_start[c + 1]; ++s) {
      const auto slot = static_cast<std::size_t>(s);
      const std::size_t n = 6 * static_cast<std::size_t>(coarse_->slot_node[slot]);
      Eigen::Matrix<double, 6, 1> r;
      for (std::size_t i = 0; i < 6; ++i)
        r[static_cast<Eigen::Index>(i)] = double(residual[n + i]) - double(product[n + i]);
      r.template tail<3>() = turning(arm_[slot]).transpose() * r.template head<3>() + r.template tail<3>() / kRatio;
      const auto& weight = weights_[static_cast<std::size_t>(coarse_->weight_index(coarse_->local[slot]))];
      for (std::size_t k = 0; k < 8; ++k) sums[k] += weight[k] * r;
    }
    for (std::size_t k = 0; k < 8; ++k) {
      sums[k].template tail<3>() -= turning(corner_arm_[8 * c + k]).transpose() * sums[k].template head<3>();
      partial_[8 * c + k] = sums[k];
    }
  });
  for_each_row(coarse_->nodes, [&](std::size_t n) {
    Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
    for (auto i = coarse_->corner_start[n]; i < coarse_->corner_start[n + 1]; ++i)
      sum += partial_[static_cast<std::size_t>(coarse_->corners[static_cast<std::size_t>(i)])];
    for (std::size_t i = 0; i < 6; ++i) next_b_[6 * n + i] = static_cast<Real>(sum[static_cast<Eigen::Index>(i)]);
  });
  for_each_index(residual.size(), [&](std::size_t i) { residual[i] -= product[i]; });
}

template <class Real>
void CoarseLevel<Real>::prolong() {
  const auto correction = chebyshev_.correction();
  for_each_row(coarse_->cell_nodes.size(), [&](std::size_t c) {
    Eigen::Matrix<double, 6, 1> modes[8];
    for (std::size_t k = 0; k < 8; ++k) {
      const auto node = static_cast<std::size_t>(coarse_->cell_nodes[c][k]);
      for (std::size_t i = 0; i < 6; ++i) modes[k][static_cast<Eigen::Index>(i)] = double(next_x_[6 * node + i]);
      modes[k].template head<3>() -= turning(corner_arm_[8 * c + k]) * modes[k].template tail<3>();
    }
    for (auto s = coarse_->slot_start[c]; s < coarse_->slot_start[c + 1]; ++s) {
      const auto slot = static_cast<std::size_t>(s);
      const auto& weight = weights_[static_cast<std::size_t>(coarse_->weight_index(coarse_->local[slot]))];
      Eigen::Matrix<double, 6, 1> q = Eigen::Matrix<double, 6, 1>::Zero();
      for (std::size_t k = 0; k < 8; ++k) q += weight[k] * modes[k];
      q.template head<3>() += turning(arm_[slot]) * q.template tail<3>();
      q.template tail<3>() /= kRatio;
      const std::size_t n = 6 * static_cast<std::size_t>(coarse_->slot_node[slot]);
      for (std::size_t i = 0; i < 6; ++i) correction[n + i] = static_cast<Real>(q[static_cast<Eigen::Index>(i)]);
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
