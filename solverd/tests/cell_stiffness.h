// The tangent of one cell as a matrix, put together from what the kernels have stored: the oracle of products, diagonal
// blocks and projections.
#pragma once
#include <Eigen/Core>

#include "force/elastic/elastic.h"
#include "force/kernels/product_kernel.h"

namespace lappet::test {

using Matrix24 = Eigen::Matrix<double, 24, 24>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

// d(volume weight P)/dF of a quadrature point, 9x9, row-major indices, in mN mm.
template <class Real>
Matrix9 point_tangent(const Elastic<Real>& elastic, Index slot, int point) {
  const auto& arrays = elastic.arrays();
  const auto& features = elastic.features();
  const int lanes = elastic.layout().lanes;
  const std::int64_t place = slot / lanes, index = place * arrays.points + point;
  const auto take = [&](const Real* from, int fields, double* to) {
    for (int k = 0; k < fields; ++k) to[k] = double(from[k * lanes + slot % lanes]);
  };
  double tangent[kTangentFields], sigma[3], fiber[kFiberFields], material[kMaterialFields] = {};
  take(arrays.tangent + index * kTangentFields * lanes, kTangentFields, tangent);
  take(arrays.sigma + index * 3 * lanes, 3, sigma);
  const int fields = features.prestretched ? kMaterialFields : features.fibers ? kPrestretch : kFiberK1;
  take(arrays.material + place * arrays.material_stride, fields, material);
  if (features.fibers) take(arrays.fiber_tangent + index * kFiberFields * lanes, kFiberFields, fiber);
  Matrix9 result;
  for (int k = 0; k < 9; ++k) {
    double df[9] = {};
    df[k] = 16.0 * arrays.spacing * arrays.spacing;
    if (features.fibers)
      features.prestretched ? differential<true, true>(tangent, sigma, fiber, material, df)
                            : differential<true, false>(tangent, sigma, fiber, material, df);
    else
      features.prestretched ? differential<false, true>(tangent, sigma, fiber, material, df)
                            : differential<false, false>(tangent, sigma, fiber, material, df);
    for (int i = 0; i < 9; ++i) result(i, k) = df[i];
  }
  return result;
}

// The part that is the same for each component: hourglass terms and attachments.
template <class Real>
Eigen::Matrix<double, 8, 8> scalar_stiffness(const Elastic<Real>& elastic, Index slot) {
  const auto& arrays = elastic.arrays();
  const int lanes = elastic.layout().lanes;
  Eigen::Matrix<double, 8, 8> scalar = Eigen::Matrix<double, 8, 8>::Zero();
  if (elastic.features().one_point)
    for (int m = 0; m < 4; ++m) {
      const double of_mode =
          arrays.share == nullptr
              ? kHourglass[m] / kHourglass[0]
              : double(arrays.share_of(slot / lanes, lanes)[(kShareHourglass + m) * lanes + slot % lanes]);
      for (int a = 0; a < 8; ++a)
        for (int b = 0; b < 8; ++b)
          scalar(a, b) += double(arrays.stabilization[slot]) * of_mode * kHourglassModes[m][a] * kHourglassModes[m][b];
    }
  if (arrays.quadratic_of != nullptr && arrays.quadratic_of[slot / lanes] >= 0) {
    const Real* entry = arrays.quadratics + arrays.quadratic_of[slot / lanes] * 36 * lanes + slot % lanes;
    for (int a = 0; a < 8; ++a)
      for (int b = a; b < 8; ++b, entry += lanes) {
        scalar(a, b) += double(*entry);
        if (a != b) scalar(b, a) += double(*entry);
      }
  }
  return scalar;
}

// Where a part of a cell has its quadrature points.
template <class Real>
std::vector<QuadraturePoint> points_of(const Elastic<Real>& elastic, Index slot) {
  auto points = quadrature_points(elastic.points());
  const auto& arrays = elastic.arrays();
  const int lanes = elastic.layout().lanes;
  if (arrays.share == nullptr) return points;
  for (auto& point : points) {
    double at[3];
    for (int i = 0; i < 3; ++i) {
      const Real* record = arrays.share + std::int64_t{slot / lanes} * kShareFields * lanes + slot % lanes;
      const double scale = double(record[(kShareScale + i) * lanes]),
                   center = double(record[(kShareCenter + i) * lanes]);
      at[i] = 0.5 + 0.5 * center + scale * (point.position[i] - 0.5);
    }
    point = quadrature_point(at[0], at[1], at[2], point.weight);
  }
  return points;
}

template <class Real>
Matrix24 part_stiffness(const Elastic<Real>& elastic, Index slot) {
  Matrix24 result = Matrix24::Zero();
  if (slot < 0) return result;
  const auto points = points_of(elastic, slot);
  for (int q = 0; q < elastic.points(); ++q) {
    const Matrix9 tangent = point_tangent(elastic, slot, q);
    // dF_ij = sum_k x_ki g_jk
    Eigen::Matrix<double, 9, 24> b = Eigen::Matrix<double, 9, 24>::Zero();
    for (int k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) b(3 * i + j, 3 * k + i) = points[q].gradient[8 * j + k] / elastic.arrays().spacing;
    result.noalias() += b.transpose() * (tangent * b);
  }
  const auto scalar = scalar_stiffness(elastic, slot);
  for (int a = 0; a < 8; ++a)
    for (int b = 0; b < 8; ++b)
      for (int i = 0; i < 3; ++i) result(3 * a + i, 3 * b + i) += scalar(a, b);
  return result;
}

// K of one cell, all its parts, ordered corner-major (3 corner + component), with the cell's quadratic term.
template <class Real>
Matrix24 cell_stiffness(const Elastic<Real>& elastic, Index cell) {
  Matrix24 result = part_stiffness(elastic, elastic.layout().slot_of_cell[cell]);
  for (std::size_t part = 0; part < elastic.part_cells().size(); ++part)
    if (elastic.part_cells()[part] == cell) result += part_stiffness(elastic, elastic.layout().slot_of_part[part]);
  return result;
}

}  // namespace lappet::test
