// Isotropic hyperelastic materials as functions of the singular values sigma of F: what the models share, and the first
// two of them. The others have headers of their own; material_models.h lists all.
//
// A model offers, on any Number:
//   kName             as procedures write it
//   energy            (sigma, moduli of the cell): Psi, kPa
//   p_hat             (sigma, moduli, p): the diagonal of the first Piola stress in the frame of the SVD
//   dpdf_hat          (sigma, moduli, t): its derivative, 12 numbers (Teran et al. 2005): the Hessian of Psi in sigma,
//                     then for each pair (01, 02, 12) the eigenvalues of the stretch mode, (p_i - p_j)/(s_i - s_j), and
//                     of the rotation mode, (p_i + p_j)/(s_i + s_j), as closed forms that hold for equal values too
//   kLaplacian        Psi contains kLaplacian mu/2 |F|^2; the stabilization integrates that part exactly
//   kInverts          whether J < 0 is a state the model describes
#pragma once
#include <cmath>

#include "math/number.h"
#include "math/symmetric_eigen3.h"

namespace lappet {

inline constexpr int kTangentPairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};

template <class Number>
struct Moduli {
  Number mu, lambda;  // kPa
  Number mooney;      // mu01 / mu10; Mooney-Rivlin only
};

template <class Number>
struct TangentHat {
  Number hessian[6];  // 00 01 02 11 12 22
  Number stretch[3];  // pairs 01 02 12
  Number rotation[3];
};

struct Corotated {
  static constexpr const char* kName = "corotated";
  static constexpr double kLaplacian = 2.0;
  static constexpr bool kInverts = true;

  template <class Number>
  static Number energy(const Number (&s)[3], const Moduli<Number>& m) {
    const Number d0 = s[0] - Number(1), d1 = s[1] - Number(1), d2 = s[2] - Number(1);
    const Number trace = d0 + d1 + d2;
    return m.mu * (d0 * d0 + d1 * d1 + d2 * d2) + Number(0.5) * m.lambda * trace * trace;
  }
  template <class Number>
  static void p_hat(const Number (&s)[3], const Moduli<Number>& m, Number (&p)[3]) {
    const Number volume = m.lambda * (s[0] + s[1] + s[2] - Number(3));
    for (int i = 0; i < 3; ++i) p[i] = Number(2) * m.mu * (s[i] - Number(1)) + volume;
  }
  template <class Number>
  static void dpdf_hat(const Number (&s)[3], const Moduli<Number>& m, TangentHat<Number>& t) {
    using std::max;
    const Number twice = m.mu + m.mu;
    t.hessian[0] = t.hessian[3] = t.hessian[5] = twice + m.lambda;
    t.hessian[1] = t.hessian[2] = t.hessian[4] = m.lambda;
    const Number bulk = Number(2) * (m.lambda * (s[0] + s[1] + s[2] - Number(3)) - twice);
    const Number sums[3] = {s[0] + s[1], s[0] + s[2], s[1] + s[2]};  // never negative
    for (int k = 0; k < 3; ++k) {
      t.stretch[k] = twice;
      t.rotation[k] = twice + bulk / max(sums[k], Number(1e-6));
    }
  }
};

// ln J, continued below kSmallJ by its second-order Taylor polynomial so that inverted cells have finite energy.
struct NeoHookean {
  static constexpr const char* kName = "neoHookean";
  static constexpr double kLaplacian = 1.0;
  static constexpr bool kInverts = false;
  static constexpr double kSmallJ = 0.2;

  template <class Number>
  static void logarithm(Number j, Number& g, Number& dg, Number& ddg) {
    using std::log;
    using std::max;
    const Number safe = max(j, Number(kSmallJ));
    const Number inverse = Number(1) / safe, below = (j - safe) * inverse;  // 0 where regular
    g = log(safe) + below - Number(0.5) * below * below;
    dg = inverse * (Number(1) - below);
    ddg = -inverse * inverse;
  }
  template <class Number>
  static Number energy(const Number (&s)[3], const Moduli<Number>& m) {
    Number g, dg, ddg;
    logarithm(s[0] * s[1] * s[2], g, dg, ddg);
    return Number(0.5) * m.mu * (s[0] * s[0] + s[1] * s[1] + s[2] * s[2] - Number(3)) - m.mu * g +
           Number(0.5) * m.lambda * g * g;
  }
  template <class Number>
  static void p_hat(const Number (&s)[3], const Moduli<Number>& m, Number (&p)[3]) {
    Number g, dg, ddg;
    logarithm(s[0] * s[1] * s[2], g, dg, ddg);
    const Number pressure = (m.lambda * g - m.mu) * dg;  // dPsi/dJ
    p[0] = m.mu * s[0] + pressure * s[1] * s[2];
    p[1] = m.mu * s[1] + pressure * s[0] * s[2];
    p[2] = m.mu * s[2] + pressure * s[0] * s[1];
  }
  template <class Number>
  static void dpdf_hat(const Number (&s)[3], const Moduli<Number>& m, TangentHat<Number>& t) {
    Number g, dg, ddg;
    logarithm(s[0] * s[1] * s[2], g, dg, ddg);
    const Number pressure = (m.lambda * g - m.mu) * dg;
    const Number curvature = m.lambda * dg * dg + (m.lambda * g - m.mu) * ddg;  // d2Psi/dJ2
    const Number c[3] = {s[1] * s[2], s[0] * s[2], s[0] * s[1]};                // dJ/dsigma
    t.hessian[0] = m.mu + curvature * c[0] * c[0];
    t.hessian[3] = m.mu + curvature * c[1] * c[1];
    t.hessian[5] = m.mu + curvature * c[2] * c[2];
    t.hessian[1] = curvature * c[0] * c[1] + pressure * s[2];
    t.hessian[2] = curvature * c[0] * c[2] + pressure * s[1];
    t.hessian[4] = curvature * c[1] * c[2] + pressure * s[0];
    const Number opposite[3] = {s[2], s[1], s[0]};
    for (int k = 0; k < 3; ++k) {
      t.stretch[k] = m.mu - pressure * opposite[k];
      t.rotation[k] = m.mu + pressure * opposite[k];
    }
  }
};

// The least eigenvalue that a definite tangent keeps, over mu.
inline constexpr double kDefiniteFloor = 1e-4;

// How a tangent is made positive definite (Teran et al. 2005; absolute values after Chen et al. 2024).
enum class PsdProjection { kExact, kClamp, kAbsolute };

template <class Number>
inline void make_definite(TangentHat<Number>& t, Number floor, PsdProjection how) {
  using std::abs;
  using std::max;
  if (how == PsdProjection::kExact) return;
  const bool absolute = how == PsdProjection::kAbsolute;
  make_definite3(t.hessian, floor, absolute);
  for (int k = 0; k < 3; ++k) {
    t.stretch[k] = max(absolute ? Number(abs(t.stretch[k])) : t.stretch[k], floor);
    t.rotation[k] = max(absolute ? Number(abs(t.rotation[k])) : t.rotation[k], floor);
  }
}

}  // namespace lappet
