// The tangent of cells as matrices: diagonal blocks for smoothers, cell stiffness for exact blocks, projections for
// coarse spaces. The product without matrices is in product_kernel.h.
#include <algorithm>
#include <array>

#include "force/elastic/elastic.h"
#include "force/kernels/projected_stiffness_kernel.h"
#include "math/parallel.h"

namespace lappet {

template <class Real>
void Elastic<Real>::diagonal_blocks(std::span<Real> blocks) const {
  for_each_index(blocks.size(), [&](std::size_t i) { blocks[i] = Real(0); });
  layout_.for_each_slab([&](std::size_t, std::int64_t begin, std::int64_t end) {
    kernels_.diagonal(arrays_, begin, end, blocks.data());
  });
}

template <class Real>
Matrix9 Elastic<Real>::point_tangent(std::size_t slot, std::size_t point) const {
  const auto lanes = static_cast<std::size_t>(layout_.lanes);
  const std::size_t place = slot / lanes, lane = slot % lanes;
  const auto take = [&](const Real* from, std::size_t fields, double* to) {
    for (std::size_t k = 0; k < fields; ++k) to[k] = static_cast<double>(from[k * lanes + lane]);
  };
  double tangent[kTangentFields], sigma[3], fiber[kFiberFields], material[kMaterialFields];
  const std::size_t index = place * quadrature_.size() + point;
  take(&tangent_[index * kTangentFields * lanes], kTangentFields, tangent);
  take(&sigma_[index * 3 * lanes], 3, sigma);
  take(&material_[(uniform_ ? 0 : place) * kMaterialFields * lanes], kMaterialFields, material);
  if (features_.fibers) take(&fiber_tangent_[index * kFiberFields * lanes], kFiberFields, fiber);
  const double h = lattice_.settings.spacing;
  Matrix9 result;
  for (int k = 0; k < 9; ++k) {
    double df[9] = {};
    df[k] = 16.0 * h * h;
    if (features_.fibers)
      features_.prestretched ? differential<true, true>(tangent, sigma, fiber, material, df)
                             : differential<true, false>(tangent, sigma, fiber, material, df);
    else
      features_.prestretched ? differential<false, true>(tangent, sigma, fiber, material, df)
                             : differential<false, false>(tangent, sigma, fiber, material, df);
    for (int i = 0; i < 9; ++i) result(i, k) = df[i];
  }
  return result;
}

// The part that is the same for each component: hourglass terms and attachments.
template <class Real>
Eigen::Matrix<double, 8, 8> Elastic<Real>::scalar_stiffness(std::size_t slot) const {
  Eigen::Matrix<double, 8, 8> scalar = Eigen::Matrix<double, 8, 8>::Zero();
  if (features_.one_point)
    for (std::size_t m = 0; m < 4; ++m)
      for (std::size_t a = 0; a < 8; ++a)
        for (std::size_t b = 0; b < 8; ++b)
          scalar(static_cast<int>(a), static_cast<int>(b)) += static_cast<double>(stabilization_[slot]) *
                                                              kHourglass[m] / kHourglass[0] * kHourglassModes[m][a] *
                                                              kHourglassModes[m][b];
  const auto lanes = static_cast<std::size_t>(layout_.lanes);
  if (!quadratic_of_.empty() && quadratic_of_[slot / lanes] >= 0) {
    const Real* entry = &quadratics_[static_cast<std::size_t>(quadratic_of_[slot / lanes]) * 36 * lanes + slot % lanes];
    for (int a = 0; a < 8; ++a)
      for (int b = a; b < 8; ++b, entry += lanes) {
        scalar(a, b) += static_cast<double>(*entry);
        if (a != b) scalar(b, a) += static_cast<double>(*entry);
      }
  }
  return scalar;
}

template <class Real>
Matrix24 Elastic<Real>::cell_stiffness(std::int32_t cell) const {
  const std::int32_t found = layout_.slot_of_cell[static_cast<std::size_t>(cell)];
  Matrix24 result = Matrix24::Zero();
  if (found < 0) return result;
  const auto slot = static_cast<std::size_t>(found);
  const double inverse_h = 1.0 / lattice_.settings.spacing;
  for (std::size_t q = 0; q < quadrature_.size(); ++q) {
    const Matrix9 tangent = point_tangent(slot, q);
    // dF_ij = sum_k x_ki g_jk
    Eigen::Matrix<double, 9, 24> b = Eigen::Matrix<double, 9, 24>::Zero();
    for (int k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          b(3 * i + j, 3 * k + i) = inverse_h * quadrature_[q].gradient[static_cast<std::size_t>(8 * j + k)];
    result.noalias() += b.transpose() * (tangent * b);
  }
  const auto scalar = scalar_stiffness(slot);
  for (int a = 0; a < 8; ++a)
    for (int b = 0; b < 8; ++b)
      for (int i = 0; i < 3; ++i) result(3 * a + i, 3 * b + i) += scalar(a, b);
  return result;
}

template <class Real>
void Elastic<Real>::add_projected_stiffness(std::span<const std::int32_t> cells, const Real* weights, const Real* arms,
                                            Real* blocks) const {
  std::array<std::int32_t, kProjectionLanes> slots;
  for (std::size_t lane = 0; lane < slots.size(); ++lane)
    // A cell that is not computed has no weight: any slot will do.
    slots[lane] = std::max(layout_.slot_of_cell[static_cast<std::size_t>(cells[std::min(lane, cells.size() - 1)])], 0);
  kernels_.project(arrays_, slots.data(), weights, arms, blocks);
}

template void Elastic<float>::diagonal_blocks(std::span<float>) const;
template void Elastic<double>::diagonal_blocks(std::span<double>) const;
template Matrix9 Elastic<float>::point_tangent(std::size_t, std::size_t) const;
template Matrix9 Elastic<double>::point_tangent(std::size_t, std::size_t) const;
template Eigen::Matrix<double, 8, 8> Elastic<float>::scalar_stiffness(std::size_t) const;
template Eigen::Matrix<double, 8, 8> Elastic<double>::scalar_stiffness(std::size_t) const;
template Matrix24 Elastic<float>::cell_stiffness(std::int32_t) const;
template Matrix24 Elastic<double>::cell_stiffness(std::int32_t) const;
template void Elastic<float>::add_projected_stiffness(std::span<const std::int32_t>, const float*, const float*,
                                                      float*) const;
template void Elastic<double>::add_projected_stiffness(std::span<const std::int32_t>, const double*, const double*,
                                                       double*) const;

}  // namespace lappet
