#include "force/self_contact/contact_tangent.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace lappet {

namespace {

constexpr double kLittle = 1e-3;  // of the largest eigenvalue
constexpr int kMaxColumns = 5;
using Columns = Eigen::Matrix<double, 12, Eigen::Dynamic, 0, 12, kMaxColumns>;
using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxColumns, kMaxColumns>;

}  // namespace

std::vector<TangentRow> tangent_rows(const TouchingPair& pair) {
  const int turns = pair.parameters;
  const Vec3& n = pair.normal;
  const Vec3 a = n.unitOrthogonal(), b = n.cross(a);
  Columns columns = Columns::Zero(12, 3 + turns);
  for (int k = 0; k < 4 && pair.vertices[k] >= 0; ++k) {
    columns.block<3, 1>(3 * k, 0) = pair.weights[k] * n;
    columns.block<3, 1>(3 * k, 1) = pair.weights[k] * a;
    columns.block<3, 1>(3 * k, 2) = pair.weights[k] * b;
    for (int i = 0; i < turns; ++i) columns.block<3, 1>(3 * k, 3 + i) = pair.turns[i][k] * n;
  }
  // The Hessian in these columns.
  Small hessian = Small::Zero(3 + turns, 3 + turns);
  const double share = pair.slope / pair.distance;
  hessian(1, 1) = hessian(2, 2) = share;
  if (turns > 0) {
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxColumns, 2> along =
        Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxColumns, 2>::Zero(3 + turns, turns);
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2, 2> gram(turns, turns);
    for (int i = 0; i < turns; ++i) {
      along(1, i) = pair.edges[i].dot(a);
      along(2, i) = pair.edges[i].dot(b);
      along(3 + i, i) = pair.distance;
      for (int j = 0; j < turns; ++j) gram(i, j) = pair.edges[i].dot(pair.edges[j]);
    }
    if (!(gram.determinant() > 0.0)) {
      hessian.setZero();
    } else {
      hessian -= share * along * gram.inverse() * along.transpose();
    }
  }
  hessian(0, 0) += pair.stiffness;
  const Small overlaps = columns.transpose() * columns;
  const Eigen::LLT<Small> factor(overlaps);
  std::vector<TangentRow> rows;
  if (factor.info() != Eigen::Success) return rows;
  const Small lower = factor.matrixL();
  const Eigen::SelfAdjointEigenSolver<Small> eigen(lower.transpose() * hessian * lower);
  if (eigen.info() != Eigen::Success) return rows;
  const auto& values = eigen.eigenvalues();
  const int last = 2 + turns;
  for (int i = last; i >= 0 && values[i] > 0.0 && values[i] > kLittle * values[last]; --i) {
    // An orthonormal basis of the columns is columns times the inverse of the transposed lower factor.
    const Eigen::VectorXd shares = lower.transpose().triangularView<Eigen::Upper>().solve(eigen.eigenvectors().col(i));
    const Eigen::Matrix<double, 12, 1> row = std::sqrt(values[i]) * (columns * shares);
    TangentRow& to = rows.emplace_back();
    for (int k = 0; k < 4; ++k) to[k] = row.segment<3>(3 * k);
  }
  return rows;
}

}  // namespace lappet
