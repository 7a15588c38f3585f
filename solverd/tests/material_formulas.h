// The stress of every material in forms that share nothing with the solver's: tensors instead of singular values.
#pragma once
#include <Eigen/Dense>
#include <cmath>
#include <stdexcept>

#include "force/materials/material_parameters.h"

namespace lappet {

// First Piola stress of the isotropic part, kPa; one formula for each model of the registry.
//   corotated: 2 mu (F - R) + lambda tr(R^T F - I) R          stable: mu (F - F^-T J) + (lambda + mu)(J - 1) J F^-T
//   neo-Hookean: mu (F - F^-T) + lambda ln J F^-T
//   Mooney-Rivlin: Cauchy stress kappa ln J / J I + 2/J dev[(m10 + m01 tr b) b - m01 b^2], b = J^-2/3 F F^T
inline Eigen::Matrix3d isotropic_piola(const MaterialParameters& m, const Eigen::Matrix3d& f) {
  using Matrix = Eigen::Matrix3d;
  const double j = f.determinant(), mu = m.mu(), lambda = m.lambda();
  const Matrix inverse = f.inverse().transpose();
  if (m.model == "neoHookean") return mu * (f - inverse) + lambda * std::log(j) * inverse;
  if (m.model == "stableNeoHookean") return mu * (f - j * inverse) + (lambda + mu) * (j - 1) * j * inverse;
  if (m.model == "corotated") {
    const Eigen::SelfAdjointEigenSolver<Matrix> right(f.transpose() * f);
    const Matrix rotation = f * right.operatorInverseSqrt();
    return 2 * mu * (f - rotation) + lambda * ((rotation.transpose() * f).trace() - 3) * rotation;
  }
  if (m.model != "mooneyRivlin") throw std::invalid_argument("no formula for the model " + m.model);
  const double m10 = mu / 2 / (1 + m.mooney_ratio), m01 = m.mooney_ratio * m10, kappa = lambda + 2 * mu / 3;
  const Matrix b = std::pow(j, -2.0 / 3) * f * f.transpose();
  const Matrix stress = (m10 + m01 * b.trace()) * b - m01 * b * b;
  const Matrix deviator = stress - stress.trace() / 3 * Matrix::Identity();
  return (kappa * std::log(j) * Matrix::Identity() + 2 * deviator) * inverse;
}

// Fibers (Gasser, Ogden, Holzapfel 2006, equations 4.1 to 4.3, with the volume's own measure of the dispersed part and
// the recruitment that fiber.h states) and muscle (Blemker, Pinsky, Delp 2005, table 1).
inline Eigen::Matrix3d fiber_piola(const MaterialParameters& m, const Eigen::Matrix3d& f, double activation = 0) {
  const Eigen::Vector3d a = m.fiber_direction;
  const Eigen::Matrix3d structure =
      m.fiber_dispersion * Eigen::Matrix3d::Identity() + (1 - 3 * m.fiber_dispersion) * a * a.transpose();
  // v' and v of x = J - 1: -2 x and the integral of 100 x / sqrt(1 + 100 x^2)
  const double x = f.determinant() - 1, root = std::sqrt(1 + 100 * x * x);
  const double strain = (structure * (f.transpose() * f)).trace() - m.fiber_slack * m.fiber_slack +
                        m.fiber_dispersion * (root - 1 - 2 * x);
  // fibers whose slack lies in the half of slack^2 - 1 around it bear load one after the other
  const double width = 0.5 * (m.fiber_slack * m.fiber_slack - 1), t = width > 0 ? strain / width + 0.5 : 2.0;
  const double e = std::max(t >= 1 ? strain : t <= 0 ? 0.0 : width * (t * t * t - 0.5 * t * t * t * t), 0.0);
  const double borne = t >= 1 ? 1 : t <= 0 ? 0 : 3 * t * t - 2 * t * t * t;
  const Eigen::Matrix3d cofactor = f.determinant() * f.inverse().transpose();
  const double stretch = (f * a).norm(), off = std::abs(stretch - 1);
  const double curve = off < 0.4 ? 1 - 4 * off * off : off < 0.6 ? 9 * (off - 0.6) * (off - 0.6) : 0.0;
  return 2 * m.fiber_k1 * e * std::exp(m.fiber_k2 * e * e) * borne *
             (f * structure + m.fiber_dispersion * (50 * x / root - 1) * cofactor) +
         activation * m.muscle_stress * curve / stretch * f * a * a.transpose();
}

inline Eigen::Matrix3d full_piola(const MaterialParameters& m, const Eigen::Matrix3d& f, double activation = 0) {
  return isotropic_piola(m, f) + fiber_piola(m, f, activation);
}

}  // namespace lappet
