// The tangent of cells as matrices: diagonal blocks for smoothers, cell stiffness for exact blocks, projections for
// coarse spaces. The product without matrices is in elastic.cpp.
#include <cmath>

#include "force/elastic.h"
#include "force/projected_stiffness_kernel.h"
#include "math/parallel.h"

namespace lappet {

template <class Real>
struct NumberTraits<Eigen::Array<Real, 8, 1>> {
  using Scalar = Real;
};

template <class Real>
void Elastic<Real>::diagonal_blocks(std::span<double> blocks) const {
  const std::size_t point_count = quadrature_.size();
  const double stabilization =
      laplacian_ * mu_ * lattice_.settings.spacing * (kHourglass[0] + kHourglass[1] + kHourglass[2] + kHourglass[3]);
  for_each_index(lattice_.node_rest.size(), [&](std::size_t n) {
    Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
    for (auto k = incidence_start_[n]; k < incidence_start_[n + 1]; ++k) {
      const auto entry = static_cast<std::size_t>(incidence_[static_cast<std::size_t>(k)]);
      const std::size_t c = entry / 8, corner = entry % 8;
      for (std::size_t q = 0; q < point_count; ++q) {
        const Real* g = &gradients_[24 * q];
        const Point& t = points_[c * point_count + q];
        double gh[3];
        for (int j = 0; j < 3; ++j)
          gh[j] = double(t.v[j]) * double(g[corner]) + double(t.v[3 + j]) * double(g[8 + corner]) +
                  double(t.v[6 + j]) * double(g[16 + corner]);
        Eigen::Matrix3d hat, u;
        const double h[3][3] = {{double(t.hessian[0]), double(t.hessian[1]), double(t.hessian[2])},
                                {double(t.hessian[1]), double(t.hessian[3]), double(t.hessian[4])},
                                {double(t.hessian[2]), double(t.hessian[4]), double(t.hessian[5])}};
        for (int i = 0; i < 3; ++i) {
          hat(i, i) = h[i][i] * gh[i] * gh[i];
          for (int j = 0; j < 3; ++j) u(i, j) = double(t.u[3 * i + j]);
        }
        for (int p = 0; p < 3; ++p) {
          const int i = kTangentPairs[p][0], j = kTangentPairs[p][1];
          hat(i, i) += double(t.same[p]) * gh[j] * gh[j];
          hat(j, j) += double(t.same[p]) * gh[i] * gh[i];
          hat(i, j) = hat(j, i) = (h[i][j] + double(t.cross[p])) * gh[i] * gh[j];
        }
        block += u * hat * u.transpose();
      }
      double scalar = stabilization * static_cast<double>(lattice_.cell_fill[c]);
      if (!quadratic_of_cell_.empty() && quadratic_of_cell_[c] >= 0)
        scalar += double(quadratics_[64 * static_cast<std::size_t>(quadratic_of_cell_[c]) + 9 * corner]);
      block.diagonal().array() += scalar;
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) blocks[9 * n + static_cast<std::size_t>(3 * i + j)] = block(i, j);
  });
}

template <class Real>
Matrix24 Elastic<Real>::cell_stiffness(std::int32_t cell) const {
  const auto c = static_cast<std::size_t>(cell);
  const std::size_t point_count = quadrature_.size();
  Matrix24 result = Matrix24::Zero();
  for (std::size_t q = 0; q < point_count; ++q) {
    const Point& t = points_[c * point_count + q];
    Eigen::Matrix3d u, v;
    Eigen::Matrix<double, 3, 8> g;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        u(i, j) = double(t.u[3 * i + j]);
        v(i, j) = double(t.v[3 * i + j]);
      }
      for (int k = 0; k < 8; ++k) g(i, k) = double(gradients_[24 * q + static_cast<std::size_t>(8 * i + k)]);
    }
    const Eigen::Matrix<double, 3, 8> gh = v.transpose() * g;
    // rows of b: the nine entries of U^T dF V as functions of the 24 unknowns
    Eigen::Matrix<double, 9, 24> b;
    for (int k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          for (int component = 0; component < 3; ++component)
            b(3 * i + j, 3 * k + component) = u(component, i) * gh(j, k);
    Eigen::Matrix<double, 9, 9> tangent = Eigen::Matrix<double, 9, 9>::Zero();
    int index = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j, ++index) tangent(4 * i, 4 * j) = tangent(4 * j, 4 * i) = double(t.hessian[index]);
    for (int p = 0; p < 3; ++p) {
      const int ij = 3 * kTangentPairs[p][0] + kTangentPairs[p][1], ji = 3 * kTangentPairs[p][1] + kTangentPairs[p][0];
      tangent(ij, ij) = tangent(ji, ji) = double(t.same[p]);
      tangent(ij, ji) = tangent(ji, ij) = double(t.cross[p]);
    }
    result.noalias() += b.transpose() * (tangent * b);
  }
  Eigen::Matrix<double, 8, 8> scalar = Eigen::Matrix<double, 8, 8>::Zero();
  if (laplacian_ != 0.0) {
    const double coefficient =
        laplacian_ * mu_ * lattice_.settings.spacing * static_cast<double>(lattice_.cell_fill[c]);
    for (std::size_t m = 0; m < 4; ++m)
      for (int a = 0; a < 8; ++a)
        for (int b = 0; b < 8; ++b)
          scalar(a, b) += coefficient * kHourglass[m] * kHourglassModes[m][static_cast<std::size_t>(a)] *
                          kHourglassModes[m][static_cast<std::size_t>(b)];
  }
  if (!quadratic_of_cell_.empty() && quadratic_of_cell_[c] >= 0)
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        scalar(a, b) += double(
            quadratics_[64 * static_cast<std::size_t>(quadratic_of_cell_[c]) + static_cast<std::size_t>(8 * a + b)]);
  for (int a = 0; a < 8; ++a)
    for (int b = 0; b < 8; ++b)
      for (int i = 0; i < 3; ++i) result(3 * a + i, 3 * b + i) += scalar(a, b);
  return result;
}

template <class Real>
void Elastic<Real>::add_projected_stiffness(std::int32_t cell, const Eigen::Matrix<Real, 24, 48>& p,
                                            Eigen::Matrix<Real, 48, 48>& block) const {
  const auto c = static_cast<std::size_t>(cell);
  const std::size_t point_count = quadrature_.size();
  using Rows = Eigen::Matrix<Real, 9, 48, Eigen::RowMajor>;
  for (std::size_t q = 0; q < point_count; ++q) {
    const Point& t = points_[c * point_count + q];
    const Real* g = &gradients_[24 * q];
    Rows df = Rows::Zero(), rotated, hat, dp;
    for (int k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) df.row(3 * i + j) += g[8 * j + k] * p.row(3 * k + i);
    for (int a = 0; a < 3; ++a)
      for (int j = 0; j < 3; ++j)
        rotated.row(3 * a + j) = t.u[a] * df.row(j) + t.u[3 + a] * df.row(3 + j) + t.u[6 + a] * df.row(6 + j);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        hat.row(3 * a + b) =
            t.v[b] * rotated.row(3 * a) + t.v[3 + b] * rotated.row(3 * a + 1) + t.v[6 + b] * rotated.row(3 * a + 2);
    dp.row(0) = t.hessian[0] * hat.row(0) + t.hessian[1] * hat.row(4) + t.hessian[2] * hat.row(8);
    dp.row(4) = t.hessian[1] * hat.row(0) + t.hessian[3] * hat.row(4) + t.hessian[4] * hat.row(8);
    dp.row(8) = t.hessian[2] * hat.row(0) + t.hessian[4] * hat.row(4) + t.hessian[5] * hat.row(8);
    for (int k = 0; k < 3; ++k) {
      const int ij = 3 * kTangentPairs[k][0] + kTangentPairs[k][1], ji = 3 * kTangentPairs[k][1] + kTangentPairs[k][0];
      dp.row(ij) = t.same[k] * hat.row(ij) + t.cross[k] * hat.row(ji);
      dp.row(ji) = t.same[k] * hat.row(ji) + t.cross[k] * hat.row(ij);
    }
    block.noalias() += hat.transpose() * dp;
  }
  if (laplacian_ != 0.0) {
    Eigen::Matrix<Real, 12, 48, Eigen::RowMajor> amplitude = Eigen::Matrix<Real, 12, 48, Eigen::RowMajor>::Zero();
    const double coefficient =
        laplacian_ * mu_ * lattice_.settings.spacing * static_cast<double>(lattice_.cell_fill[c]);
    for (std::size_t m = 0; m < 4; ++m) {
      const auto root = static_cast<Real>(std::sqrt(coefficient * kHourglass[m]));
      for (int k = 0; k < 8; ++k)
        for (int i = 0; i < 3; ++i)
          amplitude.row(static_cast<Eigen::Index>(3 * m) + i) +=
              (root * static_cast<Real>(kHourglassModes[m][static_cast<std::size_t>(k)])) * p.row(3 * k + i);
    }
    block.noalias() += amplitude.transpose() * amplitude;
  }
  if (!quadratic_of_cell_.empty() && quadratic_of_cell_[c] >= 0) {
    const Real* matrix = &quadratics_[64 * static_cast<std::size_t>(quadratic_of_cell_[c])];
    Eigen::Matrix<Real, 24, 48> product = Eigen::Matrix<Real, 24, 48>::Zero();
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        product.template middleRows<3>(3 * a) += matrix[8 * a + b] * p.template middleRows<3>(3 * b);
    block.noalias() += p.transpose() * product;
  }
}

template <class Real>
void Elastic<Real>::add_projected_stiffness(std::span<const std::int32_t> cells, const Real* weights, const Real* arms,
                                            Real* blocks) const {
  using Lanes = Eigen::Array<Real, kProjectionLanes, 1>;
  Lanes weight[64], arm[24];
  for (int i = 0; i < 64; ++i) weight[i] = Eigen::Map<const Lanes>(weights + kProjectionLanes * i);
  for (int i = 0; i < 24; ++i) arm[i] = Eigen::Map<const Lanes>(arms + kProjectionLanes * i);
  auto* out = reinterpret_cast<Lanes*>(blocks);
  const auto lane_cell = [&](int lane) {
    return static_cast<std::size_t>(cells[std::min(static_cast<std::size_t>(lane), cells.size() - 1)]);
  };
  for (std::size_t q = 0; q < quadrature_.size(); ++q) {
    Lanes u[9], v[9], hessian[6], same[3], cross[3];
    for (int lane = 0; lane < kProjectionLanes; ++lane) {
      const Point& t = points_[lane_cell(lane) * quadrature_.size() + q];
      for (int i = 0; i < 9; ++i) {
        u[i][lane] = t.u[i];
        v[i][lane] = t.v[i];
      }
      for (int i = 0; i < 6; ++i) hessian[i][lane] = t.hessian[i];
      for (int i = 0; i < 3; ++i) {
        same[i][lane] = t.same[i];
        cross[i][lane] = t.cross[i];
      }
    }
    add_projected_tangent(u, v, hessian, same, cross, &gradients_[24 * q], weight, arm, out);
  }
  if (laplacian_ != 0.0) {
    Lanes coefficient;
    for (int lane = 0; lane < kProjectionLanes; ++lane)
      coefficient[lane] = static_cast<Real>(laplacian_ * mu_ * lattice_.settings.spacing *
                                            static_cast<double>(lattice_.cell_fill[lane_cell(lane)]));
    add_projected_hourglass(coefficient, weight, arm, out);
  }
  if (quadratic_of_cell_.empty()) return;
  for (int lane = 0; lane < static_cast<int>(cells.size()); ++lane) {
    const std::int32_t index = quadratic_of_cell_[lane_cell(lane)];
    if (index < 0) continue;
    Real w[64], a[24], sum[kFramePairSize] = {};
    for (int i = 0; i < 64; ++i) w[i] = weight[i][lane];
    for (int i = 0; i < 24; ++i) a[i] = arm[i][lane];
    add_projected_form(&quadratics_[64 * static_cast<std::size_t>(index)], w, a, sum);
    for (int i = 0; i < kFramePairSize; ++i) out[i][lane] += sum[i];
  }
}

template void Elastic<float>::diagonal_blocks(std::span<double>) const;
template void Elastic<double>::diagonal_blocks(std::span<double>) const;
template Matrix24 Elastic<float>::cell_stiffness(std::int32_t) const;
template Matrix24 Elastic<double>::cell_stiffness(std::int32_t) const;
template void Elastic<float>::add_projected_stiffness(std::int32_t, const Eigen::Matrix<float, 24, 48>&,
                                                      Eigen::Matrix<float, 48, 48>&) const;
template void Elastic<double>::add_projected_stiffness(std::int32_t, const Eigen::Matrix<double, 24, 48>&,
                                                       Eigen::Matrix<double, 48, 48>&) const;
template void Elastic<float>::add_projected_stiffness(std::span<const std::int32_t>, const float*, const float*,
                                                      float*) const;
template void Elastic<double>::add_projected_stiffness(std::span<const std::int32_t>, const double*, const double*,
                                                       double*) const;

}  // namespace lappet
