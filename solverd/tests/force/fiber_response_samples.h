// The stress and the tangent that a fiber's response stands for, and random deformations to try it on.
#pragma once
#include <Eigen/Dense>
#include <random>
#include <vector>

#include "force/materials/fiber.h"

namespace lappet::fiber_samples {

using Matrix = Eigen::Matrix3d;
using Vector = Eigen::Vector3d;
using Parameters = FiberParameters<double>;

// dJ/dF and its derivative in the direction d.
inline Matrix cofactor(const Matrix& f) {
  Matrix c;
  for (int i = 0; i < 3; ++i) c.col(i) = f.col((i + 1) % 3).cross(f.col((i + 2) % 3));
  return c;
}
inline Matrix cofactor_change(const Matrix& f, const Matrix& d) { return cofactor(f + d) - cofactor(f) - cofactor(d); }

inline FiberResponse<double> response(const Matrix& f, const Vector& a, const Parameters& p) {
  return fiber_response(f.squaredNorm(), (f * a).squaredNorm(), f.determinant(), p);
}
inline Matrix stress(const Matrix& f, const Vector& a, const FiberResponse<double>& r) {
  return r.shear * f + r.pressure * cofactor(f) + r.along * (f * a) * a.transpose();
}
inline Matrix stress(const Matrix& f, const Vector& a, const Parameters& p) { return stress(f, a, response(f, a, p)); }
// dP as fiber.h states it: the terms that fibers have alone, and those that join the isotropic material's
inline Matrix directed_tangent(const Matrix& f, const Vector& a, double dispersion, const FiberResponse<double>& r,
                               const Matrix& d) {
  const Vector y = f * a, dy = d * a;
  const Matrix b = dispersion * (f + r.volume * cofactor(f)) + (1 - 3 * dispersion) * y * a.transpose();
  return r.along * dy * a.transpose() + r.curvature * b.cwiseProduct(d).sum() * b +
         r.muscle_curvature * y.dot(dy) * y * a.transpose();
}
inline Matrix isotropic_tangent(const Matrix& f, const FiberResponse<double>& r, const Matrix& d) {
  return r.shear * d + r.pressure * cofactor_change(f, d) + r.bulk * cofactor(f).cwiseProduct(d).sum() * cofactor(f);
}
inline Eigen::Matrix<double, 9, 9> assembled(const Matrix& f, const Vector& a, double dispersion,
                                             const FiberResponse<double>& r) {
  Eigen::Matrix<double, 9, 9> k;
  for (int c = 0; c < 9; ++c) {
    Matrix d = Matrix::Zero();
    d.data()[c] = 1;
    k.col(c) = directed_tangent(f, a, dispersion, r, d).reshaped();
  }
  return k;
}
inline double lowest_eigenvalue(const Eigen::Matrix<double, 9, 9>& k) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>>(k).eigenvalues()[0];
}

struct Sample {
  Matrix f;
  Vector a;
  Parameters p;
};

// Random F about I, a fifth of them inverted, a fifth flattened and a fifth stretched so far that the exponent is
// capped.
inline std::vector<Sample> samples() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0), sign(-1.0, 1.0);
  std::vector<Sample> all;
  for (int k = 0; k < 400; ++k) {
    Sample s;
    for (double& x : s.f.reshaped()) x = 0.5 * sign(random);
    s.f += Matrix::Identity();
    if (k % 5 == 1) s.f.col(k % 3) *= -1;
    if (k % 5 == 2) s.f.row(k % 3) *= 1e-6;
    if (k % 5 == 3) s.f *= 4;
    s.a = Vector(sign(random), sign(random), sign(random)).normalized();
    const double slack = k % 7 < 3 ? 1.0 : 1.0 + 0.5 * unit(random);
    s.p = {5 * unit(random), k % 4 == 0 ? 0.0 : 20 * unit(random), k % 6 == 0 ? 0.0 : unit(random) / 3,
           slack * slack - 1, k % 3 == 0 ? 0.0 : 40 * unit(random)};
    all.push_back(s);
  }
  return all;
}

}  // namespace lappet::fiber_samples
