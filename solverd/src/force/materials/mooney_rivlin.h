// Compressible Mooney-Rivlin elasticity:
//   Psi = mu10 (I1bar - 3) + mu01 (I2bar - 3) + kappa/2 (ln J)^2,   I1bar = J^{-2/3} I1,  I2bar = J^{-4/3} I2,
// with I1 = sum s_i^2 and I2 = sum of s_i^2 s_j^2 over the pairs. 2 (mu10 + mu01) = mu, mu01 = mooney mu10 and
// kappa = lambda + 2/3 mu give the moduli of Lame at small strains. Below J = kSmallJ the logarithm and both powers of
// J go on as their Taylor polynomials of second order: Psi stays finite and twice differentiable for every F, and since
// each of the powers has a negative slope and a positive curvature there, it grows as J falls.
#pragma once
#include "force/materials/material.h"
#include "force/materials/neo_hookean.h"

namespace lappet {

struct MooneyRivlin {
  static constexpr const char* kName = "mooneyRivlin";
  static constexpr double kLaplacian = 1.0;  // at rest; the factors of I1 and I2 change with J
  static constexpr bool kInverts = false;
  static constexpr double kSmallJ = NeoHookean::kSmallJ;

  template <class Number>
  static Number energy(const Number (&s)[3], const Moduli<Number>& m) {
    const Terms<Number> t(s, m);
    return t.m10 * (t.a * t.i1 - Number(3)) + t.m01 * (t.b * t.i2 - Number(3)) + Number(0.5) * t.kappa * t.g * t.g;
  }
  template <class Number>
  static void p_hat(const Number (&s)[3], const Moduli<Number>& m, Number (&p)[3]) {
    const Terms<Number> t(s, m);
    const Number pressure = t.slope(), first = Number(2) * t.m10 * t.a, second = Number(2) * t.m01 * t.b;
    for (int i = 0; i < 3; ++i) p[i] = (first + second * t.others[i]) * s[i] + pressure * t.c[i];
  }
  template <class Number>
  static void dpdf_hat(const Number (&s)[3], const Moduli<Number>& m, TangentHat<Number>& h) {
    const Terms<Number> t(s, m);
    const Number pressure = t.slope(), curvature = t.curvature();
    const Number first = Number(2) * t.m10 * t.a, second = Number(2) * t.m01 * t.b;
    Number q[3];  // the derivative of dPsi/dJ in s_i at constant J
    for (int i = 0; i < 3; ++i) q[i] = Number(2) * (t.m10 * t.da + t.m01 * t.db * t.others[i]) * s[i];
    constexpr int kDiagonal[3] = {0, 3, 5}, kOff[3] = {1, 2, 4};
    for (int i = 0; i < 3; ++i)
      h.hessian[kDiagonal[i]] = first + second * t.others[i] + t.c[i] * (Number(2) * q[i] + curvature * t.c[i]);
    for (int k = 0; k < 3; ++k) {
      const int i = kTangentPairs[k][0], j = kTangentPairs[k][1];
      const Number third = s[2 - k], product = s[i] * s[j];
      h.hessian[kOff[k]] =
          Number(2) * second * product + q[i] * t.c[j] + q[j] * t.c[i] + curvature * t.c[i] * t.c[j] + pressure * third;
      h.stretch[k] = first + second * (third * third - product) - pressure * third;
      h.rotation[k] = first + second * (third * third + product) + pressure * third;
    }
  }

  // J^{-2/3} (a), J^{-4/3} (b) and ln J (g), continued below kSmallJ, with their first and second derivatives.
  template <class Number>
  struct PowersOfJ {
    Number a, da, dda, b, db, ddb, g, dg, ddg;

    explicit PowersOfJ(Number j) {
      using std::exp;
      using std::log;
      using std::max;
      NeoHookean::logarithm(j, g, dg, ddg);
      const Number safe = max(j, Number(kSmallJ));
      const Number inverse = Number(1) / safe, below = (j - safe) * inverse;  // 0 where regular
      const Number power = exp(Number(-2.0 / 3.0) * log(safe));
      power_of_j(-2.0 / 3.0, power, inverse, below, a, da, dda);
      power_of_j(-4.0 / 3.0, power * power, inverse, below, b, db, ddb);
    }

   private:
    static void power_of_j(double exponent, Number at, Number inverse, Number below, Number& value, Number& slope,
                           Number& curvature) {
      const Number n = Number(exponent), falling = Number(exponent * (exponent - 1.0));
      value = at * (Number(1) + below * (n + Number(0.5) * falling * below));
      slope = at * inverse * (n + falling * below);
      curvature = at * inverse * inverse * falling;
    }
  };

 private:
  template <class Number>
  struct Terms : PowersOfJ<Number> {
    Number m10, m01, kappa, i1, i2;
    Number others[3];  // s_j^2 + s_k^2: dI2/ds_i = 2 s_i others_i
    Number c[3];       // dJ/ds_i

    Terms(const Number (&s)[3], const Moduli<Number>& m) : PowersOfJ<Number>(s[0] * s[1] * s[2]) {
      m10 = Number(0.5) * m.mu / (Number(1) + m.mooney);
      m01 = m.mooney * m10;
      kappa = m.lambda + Number(2.0 / 3.0) * m.mu;
      const Number square[3] = {s[0] * s[0], s[1] * s[1], s[2] * s[2]};
      i1 = square[0] + square[1] + square[2];
      i2 = square[0] * (square[1] + square[2]) + square[1] * square[2];
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        others[i] = square[j] + square[k];
        c[i] = s[j] * s[k];
      }
    }
    // dPsi/dJ and its derivative in J, at constant I1 and I2
    Number slope() const { return m10 * this->da * i1 + m01 * this->db * i2 + kappa * this->g * this->dg; }
    Number curvature() const {
      return m10 * this->dda * i1 + m01 * this->ddb * i2 + kappa * (this->dg * this->dg + this->g * this->ddg);
    }
  };
};

}  // namespace lappet
