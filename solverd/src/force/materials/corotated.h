// Corotated linear elasticity: linear in the stretches, so it turns with the tissue but does not stiffen.
//   Psi = mu sum (s_i - 1)^2 + lambda/2 (sum s_i - 3)^2
#pragma once
#include <cmath>

#include "force/materials/material.h"

namespace lappet {

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

}  // namespace lappet
