#include "solve/rigid_frames.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <unordered_map>

#include "solve/vectors.h"

namespace lappet {

namespace {

constexpr int kCoarsening = 4;
// Relative shift of the coarse diagonal. At rest turning all frames alike moves nothing, sum_k w_k (x - x_k) = 0, and
// frames that no free node feels are empty: the shift must be above the rounding of the blocks.
template <class Real>
constexpr double kShift = 30.0 * std::numeric_limits<Real>::epsilon();

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t find(std::int32_t a) {
    while (parent_[static_cast<std::size_t>(a)] != a)
      a = parent_[static_cast<std::size_t>(a)] =
          parent_[static_cast<std::size_t>(parent_[static_cast<std::size_t>(a)])];
    return a;
  }
  void unite(std::int32_t a, std::int32_t b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<std::int32_t> parent_;
};

// Calls body(a, b, axis) for all pairs of cells that share the four nodes of a face, b one step further along the axis.
template <class Body>
void for_each_face_pair(const Lattice& lattice, const Body& body) {
  for (int axis = 0; axis < 3; ++axis) {
    const int bit = 4 >> axis;
    const int low = axis == 0 ? 3 : axis == 1 ? 5 : 6;  // the corners of a face, as the bits left free
    std::unordered_map<std::int64_t, std::vector<std::int32_t>> by_node;
    const auto face = [&](std::size_t cell, bool upper) {
      std::array<std::int32_t, 4> nodes{};
      std::size_t k = 0;
      for (int c = 0; c < 8; ++c)
        if ((c & bit) == (upper ? bit : 0) && (c & ~bit & low) == (c & ~bit))
          nodes[k++] = lattice.cell_nodes[cell][static_cast<std::size_t>(c)];
      return nodes;
    };
    for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c)
      by_node[face(c, false)[0]].push_back(static_cast<std::int32_t>(c));
    for (std::size_t a = 0; a < lattice.cell_nodes.size(); ++a) {
      const auto upper = face(a, true);
      const auto found = by_node.find(upper[0]);
      if (found == by_node.end()) continue;
      for (const std::int32_t b : found->second)
        if (face(static_cast<std::size_t>(b), false) == upper) body(static_cast<std::int32_t>(a), b, axis);
    }
  }
}

int floor_div(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

}  // namespace

template <class Real>
RigidFrames<Real>::RigidFrames(const Lattice& lattice) : lattice_(lattice) {
  build_topology(lattice);
}

template <class Real>
void RigidFrames<Real>::build_topology(const Lattice& lattice) {
  const std::size_t cells = lattice.cell_nodes.size(), nodes = lattice.node_rest.size();
  const auto box = [&](std::int32_t cell) {
    const auto& p = lattice.cell_position[static_cast<std::size_t>(cell)];
    return std::array<std::int32_t, 3>{floor_div(p[0], kCoarsening), floor_div(p[1], kCoarsening),
                                       floor_div(p[2], kCoarsening)};
  };
  DisjointSets components(cells);
  for_each_face_pair(lattice, [&](std::int32_t a, std::int32_t b, int) {
    if (box(a) == box(b)) components.unite(a, b);
  });
  coarse_of_cell_.assign(cells, -1);
  for (std::size_t c = 0; c < cells; ++c) {
    const auto root = static_cast<std::size_t>(components.find(static_cast<std::int32_t>(c)));
    if (coarse_of_cell_[root] < 0) {
      coarse_of_cell_[root] = static_cast<std::int32_t>(coarse_cell_position_.size());
      coarse_cell_position_.push_back(box(static_cast<std::int32_t>(c)));
    }
    coarse_of_cell_[c] = coarse_of_cell_[root];
  }
  const std::size_t coarse_cells = coarse_cell_position_.size();
  DisjointSets corners(8 * coarse_cells);
  for_each_face_pair(lattice, [&](std::int32_t a, std::int32_t b, int axis) {
    const std::int32_t ca = coarse_of_cell_[static_cast<std::size_t>(a)],
                       cb = coarse_of_cell_[static_cast<std::size_t>(b)];
    if (ca == cb) return;
    const int bit = 4 >> axis;
    for (int c = 0; c < 8; ++c)
      if (c & bit) corners.unite(8 * ca + c, 8 * cb + (c & ~bit));
  });
  std::vector<std::int32_t> number(8 * coarse_cells, -1);
  coarse_cell_nodes_.resize(coarse_cells);
  for (std::size_t c = 0; c < coarse_cells; ++c)
    for (std::size_t k = 0; k < 8; ++k) {
      auto& id = number[static_cast<std::size_t>(corners.find(static_cast<std::int32_t>(8 * c + k)))];
      if (id < 0) id = static_cast<std::int32_t>(coarse_nodes_++);
      coarse_cell_nodes_[c][k] = id;
    }

  cell_start_.assign(coarse_cells + 1, 0);
  for (const std::int32_t c : coarse_of_cell_) ++cell_start_[static_cast<std::size_t>(c) + 1];
  std::partial_sum(cell_start_.begin(), cell_start_.end(), cell_start_.begin());
  cells_.resize(cells);
  std::vector<std::int32_t> next(cell_start_.begin(), cell_start_.end() - 1);
  for (std::size_t c = 0; c < cells; ++c)
    cells_[static_cast<std::size_t>(next[static_cast<std::size_t>(coarse_of_cell_[c])]++)] =
        static_cast<std::int32_t>(c);

  shares_.resize(8 * nodes);
  std::vector<std::uint8_t> placed(nodes, 0);
  for (std::size_t c = 0; c < cells; ++c)
    for (int corner = 0; corner < 8; ++corner) {
      const auto n = static_cast<std::size_t>(lattice.cell_nodes[c][static_cast<std::size_t>(corner)]);
      if (placed[n]) continue;
      placed[n] = 1;
      const auto coarse = static_cast<std::size_t>(coarse_of_cell_[c]);
      for (int k = 0; k < 8; ++k) {
        double weight = 1.0;
        for (int axis = 0; axis < 3; ++axis) {
          const int grid = lattice.cell_position[c][static_cast<std::size_t>(axis)] + (corner >> (2 - axis) & 1);
          const double local =
              static_cast<double>(grid) / kCoarsening - coarse_cell_position_[coarse][static_cast<std::size_t>(axis)];
          weight *= (k >> (2 - axis) & 1) ? local : 1.0 - local;
        }
        shares_[8 * n + static_cast<std::size_t>(k)] = {
            coarse_cell_nodes_[coarse][static_cast<std::size_t>(k)], static_cast<Real>(weight), {}};
      }
    }
  share_start_.assign(coarse_nodes_ + 1, 0);
  for (const auto& share : shares_)
    if (share.weight != Real(0)) ++share_start_[static_cast<std::size_t>(share.coarse) + 1];
  std::partial_sum(share_start_.begin(), share_start_.end(), share_start_.begin());
  share_of_.resize(static_cast<std::size_t>(share_start_.back()));
  next.assign(share_start_.begin(), share_start_.end() - 1);
  for (std::size_t s = 0; s < shares_.size(); ++s)
    if (shares_[s].weight != Real(0))
      share_of_[static_cast<std::size_t>(next[static_cast<std::size_t>(shares_[s].coarse)]++)] =
          static_cast<std::int32_t>(s);
}

template <class Real>
void RigidFrames<Real>::place_frames(const System<Real>& system, std::span<const Real> u) {
  const double inverse = 1.0 / (kCoarsening * lattice_.settings.spacing);
  place_.assign(coarse_nodes_, Vec3::Zero());
  const auto now = [&](std::size_t n) {
    return Vec3(lattice_.node_rest[n] + Vec3(static_cast<double>(u[3 * n]), static_cast<double>(u[3 * n + 1]),
                                             static_cast<double>(u[3 * n + 2])));
  };
  for_each_index(coarse_nodes_, [&](std::size_t k) {
    double total = 0.0;
    for (auto s = share_start_[k]; s < share_start_[k + 1]; ++s) {
      const auto share = static_cast<std::size_t>(share_of_[static_cast<std::size_t>(s)]);
      place_[k] += double(shares_[share].weight) * now(share / 8);
      total += double(shares_[share].weight);
    }
    if (total > 0) place_[k] /= total;
  });
  free_.resize(system.nodes());
  for_each_index(system.nodes(), [&](std::size_t n) {
    free_[n] = system.is_free(n);
    const Vec3 x = now(n);
    for (std::size_t k = 0; k < 8; ++k) {
      auto& share = shares_[8 * n + k];
      const Vec3 arm =
          system.is_free(n) ? Vec3(inverse * (x - place_[static_cast<std::size_t>(share.coarse)])) : Vec3::Zero();
      for (int i = 0; i < 3; ++i) share.arm[i] = static_cast<Real>(arm[i]);
    }
  });
}

template <class Real>
void RigidFrames<Real>::assemble(const System<Real>& system, std::span<const Real> u) {
  place_frames(system, u);
  using Prolongation = Eigen::Matrix<Real, 24, 48>;
  using Block = Eigen::Matrix<Real, 48, 48>;
  const double inverse = 1.0 / (kCoarsening * lattice_.settings.spacing);
  const std::size_t coarse_cells = coarse_cell_nodes_.size();
  std::vector<Block> blocks(coarse_cells, Block::Zero());
  tbb::parallel_for(std::size_t{0}, coarse_cells, [&](std::size_t coarse) {
    Prolongation p;
    for (auto index = cell_start_[coarse]; index < cell_start_[coarse + 1]; ++index) {
      const auto c = static_cast<std::size_t>(cells_[static_cast<std::size_t>(index)]);
      p.setZero();
      for (int corner = 0; corner < 8; ++corner) {
        const auto n = static_cast<std::size_t>(lattice_.cell_nodes[c][static_cast<std::size_t>(corner)]);
        if (!system.is_free(n)) continue;
        const Vec3 x = lattice_.node_rest[n] + Vec3(double(u[3 * n]), double(u[3 * n + 1]), double(u[3 * n + 2]));
        for (int k = 0; k < 8; ++k) {
          double weight = 1.0;
          for (int axis = 0; axis < 3; ++axis) {
            const int grid = lattice_.cell_position[c][static_cast<std::size_t>(axis)] + (corner >> (2 - axis) & 1);
            const double local =
                static_cast<double>(grid) / kCoarsening - coarse_cell_position_[coarse][static_cast<std::size_t>(axis)];
            weight *= (k >> (2 - axis) & 1) ? local : 1.0 - local;
          }
          if (weight == 0.0) continue;
          const Vec3 arm =
              inverse * (x - place_[static_cast<std::size_t>(coarse_cell_nodes_[coarse][static_cast<std::size_t>(k)])]);
          const auto w = static_cast<Real>(weight);
          const auto ax = static_cast<Real>(weight * arm[0]), ay = static_cast<Real>(weight * arm[1]),
                     az = static_cast<Real>(weight * arm[2]);
          const int row = 3 * corner, column = 6 * k;
          for (int i = 0; i < 3; ++i) p(row + i, column + i) = w;
          // omega x arm
          p(row, column + 4) = az;
          p(row, column + 5) = -ay;
          p(row + 1, column + 3) = -az;
          p(row + 1, column + 5) = ax;
          p(row + 2, column + 3) = ay;
          p(row + 2, column + 4) = -ax;
        }
      }
      system.elastic().add_projected_stiffness(static_cast<std::int32_t>(c), p, blocks[coarse]);
    }
  });

  // A push is one more rank in the block of its coarse cell, on whose corners all nodes of the cell hang.
  system.for_each_push([&](const Push& push) {
    const auto coarse = static_cast<std::size_t>(coarse_of_cell_[static_cast<std::size_t>(push.cell)]);
    Eigen::Matrix<Real, 48, 1> column = Eigen::Matrix<Real, 48, 1>::Zero();
    for (std::size_t c = 0; c < 8; ++c) {
      const auto n = static_cast<std::size_t>(lattice_.cell_nodes[static_cast<std::size_t>(push.cell)][c]);
      if (!system.is_free(n)) continue;
      for (std::size_t s = 8 * n; s < 8 * n + 8; ++s) {
        if (shares_[s].weight == Real(0)) continue;
        const auto& corners = coarse_cell_nodes_[coarse];
        const auto corner = std::find(corners.begin(), corners.end(), shares_[s].coarse) - corners.begin();
        const Vec3 arm(double(shares_[s].arm[0]), double(shares_[s].arm[1]), double(shares_[s].arm[2]));
        const double weight = push.weights[c] * double(shares_[s].weight);
        column.template segment<3>(6 * corner) += (weight * push.direction).cast<Real>();
        column.template segment<3>(6 * corner + 3) += (weight * arm.cross(push.direction)).cast<Real>();
      }
    }
    blocks[coarse] += static_cast<Real>(push.stiffness) * column * column.transpose();
  });

  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(coarse_cells * 48 * 25);
  const auto emplace = [&](Eigen::Index row, Eigen::Index column, double value) {
    if (row >= column && value != 0.0) entries.emplace_back(row, column, value);  // the lower half
  };
  for (std::size_t coarse = 0; coarse < coarse_cells; ++coarse)
    for (int a = 0; a < 48; ++a)
      for (int b = 0; b < 48; ++b)
        emplace(6 * coarse_cell_nodes_[coarse][static_cast<std::size_t>(a / 6)] + a % 6,
                6 * coarse_cell_nodes_[coarse][static_cast<std::size_t>(b / 6)] + b % 6, double(blocks[coarse](a, b)));
  // A functional of the fine displacements, sum_i weight_i u_i, as three rows in coarse unknowns by coarse node.
  using Rows = std::map<std::int32_t, Eigen::Matrix<double, 3, 6>>;
  const auto add_to = [&](Rows& rows, std::size_t n, double fine_weight) {
    if (!system.is_free(n)) return;
    for (std::size_t k = 0; k < 8; ++k) {
      const auto& share = shares_[8 * n + k];
      if (share.weight == Real(0)) continue;
      const double ax = double(share.arm[0]), ay = double(share.arm[1]), az = double(share.arm[2]);
      Eigen::Matrix<double, 3, 6> row;
      row << 1, 0, 0, 0, az, -ay, 0, 1, 0, -az, 0, ax, 0, 0, 1, ay, -ax, 0;
      auto [entry, inserted] = rows.try_emplace(share.coarse, Eigen::Matrix<double, 3, 6>::Zero());
      entry->second += fine_weight * double(share.weight) * row;
    }
  };
  const auto emplace_rows = [&](const Rows& rows, const Eigen::Matrix3d& stiffness) {
    for (const auto& [a, row_a] : rows)
      for (const auto& [b, row_b] : rows) {
        const Eigen::Matrix<double, 6, 6> block = row_a.transpose() * stiffness * row_b;
        for (int i = 0; i < 6; ++i)
          for (int j = 0; j < 6; ++j) emplace(6 * a + i, 6 * b + j, block(i, j));
      }
  };
  for (const auto& tie : system.ties()) {
    Rows rows;
    for (std::size_t i = 0; i < tie.nodes.size(); ++i)
      add_to(rows, static_cast<std::size_t>(tie.nodes[i]), tie.weights[i]);
    emplace_rows(rows, tie.stiffness * Eigen::Matrix3d::Identity());
  }
  const auto size = static_cast<Eigen::Index>(unknowns());
  double largest = 0.0;
  for (const auto& entry : entries)
    if (entry.row() == entry.col()) largest = std::max(largest, entry.value());
  for (Eigen::Index i = 0; i < size; ++i) entries.emplace_back(i, i, kShift<Real> * std::max(largest, 1e-30));
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  factor_.cholmod().print = 0;
  for (double shift = 0.0; shift < 1.0; shift = shift == 0.0 ? 1e-5 : 100 * shift) {
    if (shift > 0.0)
      for (Eigen::Index i = 0; i < size; ++i) matrix.coeffRef(i, i) += shift * largest;
    factor_.compute(matrix);
    if (factor_.info() == Eigen::Success) return;
  }
  throw NotDefiniteError("the coarse operator is not positive definite");
}

template <class Real>
void RigidFrames<Real>::correct(std::span<const Real> r, std::span<Real> x) const {
  restricted_.resize(static_cast<Eigen::Index>(unknowns()));
  for_each_index(coarse_nodes_, [&](std::size_t k) {
    double sum[6] = {};
    for (auto s = share_start_[k]; s < share_start_[k + 1]; ++s) {
      const auto index = static_cast<std::size_t>(share_of_[static_cast<std::size_t>(s)]);
      const auto& share = shares_[index];
      const std::size_t n = index / 8;
      const double w = double(share.weight), fx = w * double(r[3 * n]), fy = w * double(r[3 * n + 1]),
                   fz = w * double(r[3 * n + 2]);
      const double ax = double(share.arm[0]), ay = double(share.arm[1]), az = double(share.arm[2]);
      sum[0] += fx;
      sum[1] += fy;
      sum[2] += fz;
      sum[3] += ay * fz - az * fy;
      sum[4] += az * fx - ax * fz;
      sum[5] += ax * fy - ay * fx;
    }
    for (int i = 0; i < 6; ++i) restricted_[static_cast<Eigen::Index>(6 * k) + i] = sum[i];
  });
  solved_ = factor_.solve(restricted_);
  for_each_index(lattice_.node_rest.size(), [&](std::size_t n) {
    double sum[3] = {};
    for (std::size_t k = 0; k < 8 && free_[n]; ++k) {
      const auto& share = shares_[8 * n + k];
      if (share.weight == Real(0)) continue;
      const double* q = &solved_[6 * share.coarse];
      const double w = double(share.weight), ax = double(share.arm[0]), ay = double(share.arm[1]),
                   az = double(share.arm[2]);
      sum[0] += w * (q[0] + q[4] * az - q[5] * ay);
      sum[1] += w * (q[1] + q[5] * ax - q[3] * az);
      sum[2] += w * (q[2] + q[3] * ay - q[4] * ax);
    }
    for (std::size_t i = 0; i < 3; ++i) x[3 * n + i] = static_cast<Real>(sum[i]);
  });
}

template class RigidFrames<float>;
template class RigidFrames<double>;

}  // namespace lappet
