// Neo-Hookean elasticity: Psi = mu/2 (I_C - 3) - mu ln J + lambda/2 (ln J)^2. Below kSmallJ ln J is
// continued by its Taylor polynomial of second order, so that inverted cells have finite energy.
#pragma once
#include <cmath>

#include "force/materials/material.h"

namespace lappet {

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

}  // namespace lappet
