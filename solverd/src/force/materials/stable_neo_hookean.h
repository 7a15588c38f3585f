// Stable neo-Hookean elasticity (Smith, de Goes, Kim 2018, "Stable Neo-Hookean Flesh Simulation"), without the
// logarithm of I_C that they add against the collapse to a point:
//   Psi = mu/2 (I_C - 3) - mu (J - 1) + lambda'/2 (J - 1)^2,   lambda' = lambda + mu,
// so that mu and lambda are those of Lame at small strains. A polynomial, finite for every F.
#pragma once
#include "force/materials/material.h"

namespace lappet {

struct StableNeoHookean {
  static constexpr const char* kName = "stableNeoHookean";
  static constexpr double kLaplacian = 1.0;
  static constexpr bool kInverts = true;

  template <class Number>
  static Number energy(const Number (&s)[3], const Moduli<Number>& m) {
    const Number growth = s[0] * s[1] * s[2] - Number(1);
    return Number(0.5) * m.mu * (s[0] * s[0] + s[1] * s[1] + s[2] * s[2] - Number(3)) +
           growth * (Number(0.5) * (m.lambda + m.mu) * growth - m.mu);
  }
  template <class Number>
  static void p_hat(const Number (&s)[3], const Moduli<Number>& m, Number (&p)[3]) {
    const Number pressure = slope(s, m);
    p[0] = m.mu * s[0] + pressure * s[1] * s[2];
    p[1] = m.mu * s[1] + pressure * s[0] * s[2];
    p[2] = m.mu * s[2] + pressure * s[0] * s[1];
  }
  template <class Number>
  static void dpdf_hat(const Number (&s)[3], const Moduli<Number>& m, TangentHat<Number>& t) {
    const Number pressure = slope(s, m), curvature = m.lambda + m.mu;
    const Number c[3] = {s[1] * s[2], s[0] * s[2], s[0] * s[1]};  // dJ/dsigma
    t.hessian[0] = m.mu + curvature * c[0] * c[0];
    t.hessian[3] = m.mu + curvature * c[1] * c[1];
    t.hessian[5] = m.mu + curvature * c[2] * c[2];
    t.hessian[1] = curvature * c[0] * c[1] + pressure * s[2];
    t.hessian[2] = curvature * c[0] * c[2] + pressure * s[1];
    t.hessian[4] = curvature * c[1] * c[2] + pressure * s[0];
    for (int k = 0; k < 3; ++k) {
      const Number opposite = pressure * s[2 - k];
      t.stretch[k] = m.mu - opposite;
      t.rotation[k] = m.mu + opposite;
    }
  }

 private:
  // dPsi/dJ
  template <class Number>
  static Number slope(const Number (&s)[3], const Moduli<Number>& m) {
    return (m.lambda + m.mu) * (s[0] * s[1] * s[2] - Number(1)) - m.mu;
  }
};

}  // namespace lappet
