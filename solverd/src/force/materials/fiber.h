// Fibers and active muscle along one rest direction a (unit), added on any isotropic material, on any Number.
//
// Notation: I1 = |F|^2, I4 = |F a|^2, J = det F, C = cof F = dJ/dF, lambda = sqrt(I4), kappa the dispersion.
//
// Fibers (Gasser, Ogden, Holzapfel 2006, "Hyperelastic modelling of arterial layers with distributed collagen fiber
// orientations", one family; k1 in kPa, kappa from 0, all along a, to 1/3, none preferred):
//   Psi = k1/(2 k2) (exp(k2 m^2) - 1), and k1/2 m^2 for k2 = 0,   m = <E> smoothed at its onset,
//   E = kappa (I1 - 3 + v(J)) + (1 - 3 kappa)(I4 - 1) - (slack^2 - 1).
// The mean square of the fibers' stretches must exceed slack^2 before they bear load. From E = -w/2 to w/2, with
// w = (slack^2 - 1)/2 (chosen), they are recruited: m = w (t^3 - t^4/2), t = E/w + 1/2; above, m = E. So the stress has
// a continuous derivative for slack > 1; for slack 1 it is the published law.
//
// v(J) keeps the volume; at J = 1 it is 0 and the law is the published one. Gasser et al. write it for isochoric
// invariants, which leaves the volume to the isotropic material: a fixed bulk modulus beside a stress that grows
// a thousandfold loses tens of percent. Here the dispersed part is a stable neo-Hookean measure (Smith, de Goes, Kim
// 2018) of its own, whose bulk modulus is kVolume times the shear modulus 2 kappa dPsi/dE that the fibers have just
// now,
//   v = -2 x + 2 kVolume d^2 (sqrt(1 + (x/d)^2) - 1),   x = J - 1,   d = kVolumeWidth,
// quadratic near J = 1 and linear far from it, so that a flattened or inverted cell has a moderate E. E is convex in
// (F, J) and Psi increasing and convex in E: the energy is polyconvex.
// Beyond k2 m^2 = kMaxExponent (a stress 2*10^4 times that of k2 = 0) Psi goes on as its Taylor polynomial of
// second order in m: float does not overflow, and a Newton step from far away sees a quadratic in E.
//
// Muscle: the active part of Teran, Blemker, Ng Thow Hing, Fedkiw 2003 ("Finite volume methods for the simulation of
// skeletal muscle"), with the force-length curve of Blemker, Pinsky, Delp 2005 (table 1) at the optimal fiber stretch
// 1, so that rest is where the muscle pulls hardest. In the Cauchy stress along the fiber, s_max alpha f(lambda) lambda
// at J = 1, alpha f is the nominal stress; it is therefore the derivative of an energy of lambda alone:
//   W(lambda) = s_max alpha integral from 1 to lambda of f,
//   f = 1 - 4 (lambda - 1)^2        |lambda - 1| <= 0.4
//       9 (|lambda - 1| - 0.6)^2    up to 0.6, and 0 beyond (lambda < 0.4, lambda > 1.6).
// f is continuous; its slope steps from 3.2 to 3.6 where the pieces meet, as published.
#pragma once
#include "force/materials/material.h"
#include "math/features.h"
#include "math/number.h"

namespace lappet {

// k1: kPa. dispersion: kappa. threshold: slack^2 - 1. muscle: maximal isometric stress times activation, kPa. active:
// some muscle is; where none is, `muscle` is 0 and its curve is passed over.
template <class Number>
struct FiberParameters {
  Number k1, k2, dispersion, threshold, muscle;
  bool active = true;
};

// P = shear F + pressure C + along (F a) a^T, and
// dP = shear dF + pressure dC + bulk C (C : dF) + along (dF a) a^T + curvature B (B : dF)
//      + muscle_curvature (F a . dF a) (F a) a^T,
// B = kappa (F + volume C) + (1 - 3 kappa) (F a) a^T. Everything in kPa but `volume`, which has no unit.
template <class Number>
struct FiberResponse {
  Number energy;
  Number shear, pressure, bulk, along;
  Number curvature, volume, muscle_curvature;
};

namespace fiber_detail {

inline constexpr double kMaxExponent = 10.0;
inline constexpr double kVolume = 50.0;           // chosen: Poisson's ratio 0.49 of the dispersed part
inline constexpr double kVolumeWidth = 0.1;       // chosen
inline constexpr double kRecruitment = 0.5;       // w over the threshold, chosen
inline constexpr double kPeak = 0.4, kEnd = 0.6;  // of |lambda - 1|

// (exp(x) - 1)/x for x >= 0, with growth = exp(x): a series near 0, where the difference loses digits.
template <class Number>
inline Number mean_growth(Number x, Number growth) {
  using std::max;
  constexpr double kSeries = 1.0 / 16.0;  // the first term left out is 6e-16 there
  Number series = Number(1);
  for (int n = 8; n >= 2; --n) series = Number(1) + series * x * Number(1.0 / n);
  return select(x < Number(kSeries), series, (growth - Number(1)) / max(x, Number(kSeries)));
}

// v of J and its first and second derivatives.
template <class Number>
inline void volume_measure(Number j, Number& value, Number& slope, Number& curvature) {
  using std::sqrt;
  const Number x = j - Number(1), y = x * Number(1.0 / kVolumeWidth), square = y * y;
  const Number root = sqrt(Number(1) + square), inverse = Number(1) / root;
  value = Number(-2) * x + Number(2.0 * kVolume * kVolumeWidth * kVolumeWidth) * square / (root + Number(1));
  slope = Number(-2) + Number(2.0 * kVolume) * x * inverse;
  curvature = Number(2.0 * kVolume) * inverse * inverse * inverse;
}

// m of E and its first and second derivatives.
template <class Number>
inline void recruited_strain(Number strain, Number threshold, Number& value, Number& slope, Number& curvature) {
  using std::max;
  using std::min;
  const Number width = Number(kRecruitment) * threshold;
  const Number inverse = Number(1) / max(width, Number(tiny_number<Number>()));
  const Number t = min(max((strain + Number(0.5) * width) * inverse, Number(0)), Number(1));
  value = width * t * t * t * (Number(1) - Number(0.5) * t) + max(strain - Number(0.5) * width, Number(0));
  slope = t * t * (Number(3) - Number(2) * t);
  curvature = Number(6) * t * (Number(1) - t) * inverse;
}

// W, W' and W'' of a muscle of unit strength.
template <class Number>
inline void muscle_curve(Number stretch, Number& energy, Number& force, Number& stiffness) {
  using std::abs;
  using std::max;
  using std::min;
  const Number signed_change = stretch - Number(1), change = abs(signed_change);
  const Number on_peak = min(change, Number(kPeak));
  const Number to_end = min(max(change, Number(kPeak)), Number(kEnd)) - Number(kEnd);  // <= 0
  constexpr double kSide = (kEnd - kPeak) * (kEnd - kPeak) * (kEnd - kPeak);
  const Number work = on_peak * (Number(1) - Number(4.0 / 3.0) * on_peak * on_peak) +
                      Number(3) * (to_end * to_end * to_end + Number(kSide));
  const auto peak = change < Number(kPeak);
  force = select(peak, Number(1) - Number(4) * change * change, Number(9) * to_end * to_end);
  const Number slope = select(peak, Number(-8) * change, Number(18) * to_end);  // in change
  const auto shorter = signed_change < Number(0);
  energy = select(shorter, -work, work);
  stiffness = select(shorter, -slope, slope);
}

}  // namespace fiber_detail

// The response at F with these invariants. Polyconvex but for the muscle beyond its optimal length.
template <class Number>
inline FiberResponse<Number> fiber_response(Number i1, Number i4, Number j, const FiberParameters<Number>& p) {
  using std::exp;
  using std::max;
  using std::min;
  using std::sqrt;
  namespace detail = fiber_detail;
  Number measure, measure_slope, measure_curvature;
  detail::volume_measure(j, measure, measure_slope, measure_curvature);
  const Number aligned = Number(1) - Number(3) * p.dispersion;
  const Number strain = p.dispersion * (i1 - Number(3) + measure) + aligned * (i4 - Number(1)) - p.threshold;
  Number recruited, recruited_slope, recruited_curvature;
  detail::recruited_strain(strain, p.threshold, recruited, recruited_slope, recruited_curvature);
  const Number max_strain = sqrt(Number(detail::kMaxExponent) / max(p.k2, Number(tiny_number<Number>())));
  const Number e = min(recruited, max_strain), beyond = recruited - e;
  const Number exponent = p.k2 * e * e, growth = exp(exponent);
  const Number slope = p.k1 * e * growth;  // dPsi/dm at e
  const Number curvature = p.k1 * growth * (Number(1) + Number(2) * exponent);
  const Number first = slope + curvature * beyond;  // dPsi/dm
  const Number stress = first * recruited_slope;    // dPsi/dE

  FiberResponse<Number> r;
  r.energy = Number(0.5) * p.k1 * e * e * detail::mean_growth(exponent, growth) +
             beyond * (slope + Number(0.5) * curvature * beyond);
  r.shear = Number(2) * p.dispersion * stress;
  r.pressure = p.dispersion * stress * measure_slope;
  r.bulk = p.dispersion * stress * measure_curvature;
  r.along = Number(2) * aligned * stress;
  r.curvature = Number(4) * (curvature * recruited_slope * recruited_slope + first * recruited_curvature);
  r.volume = Number(0.5) * measure_slope;
  r.muscle_curvature = Number(0);
  if (!kHasMuscle || !p.active) return r;

  // Below the curve's end the muscle is slack, so a stretch near 0 needs no division.
  const Number shortest = Number(1.0 - detail::kEnd);
  const Number stretch = max(sqrt(max(i4, Number(0))), shortest), inverse = Number(1) / stretch;
  Number work, force, stiffness;
  detail::muscle_curve(stretch, work, force, stiffness);
  const Number tension = p.muscle * force * inverse;
  r.energy += p.muscle * work;
  r.along += tension;
  r.muscle_curvature = (p.muscle * stiffness - tension) * inverse * inverse;
  return r;
}

// What the fibers give to the tangent in the frame of the SVD, of the terms of shear, pressure and bulk. To be added
// before the isotropic material's is made definite, so that both are together.
template <class Number>
inline void add_isotropic(const FiberResponse<Number>& r, const Number (&s)[3], TangentHat<Number>& t) {
  const Number c[3] = {s[1] * s[2], s[0] * s[2], s[0] * s[1]};
  constexpr int kDiagonal[3] = {0, 3, 5}, kOff[3] = {1, 2, 4};
  for (int i = 0; i < 3; ++i) t.hessian[kDiagonal[i]] += r.shear + r.bulk * c[i] * c[i];
  for (int k = 0; k < 3; ++k) {
    const Number opposite = r.pressure * s[2 - k];
    t.hessian[kOff[k]] += r.bulk * c[kTangentPairs[k][0]] * c[kTangentPairs[k][1]] + opposite;
    t.stretch[k] += r.shear - opposite;
    t.rotation[k] += r.shear + opposite;
  }
}

// Makes the terms of `along` and of the muscle positive semidefinite: on dF a they act as `along` across F a and as
// along + muscle_curvature I4 in the direction of F a. The term of `curvature` is so anyway.
template <class Number>
inline void make_definite(FiberResponse<Number>& r, Number i4, PsdProjection how) {
  using std::abs;
  using std::max;
  if (how == PsdProjection::kExact) return;
  constexpr double kShortest = 1.0 - fiber_detail::kEnd;
  r.along = max(r.along, Number(0));
  const Number value = r.along + r.muscle_curvature * i4;
  const Number definite = how == PsdProjection::kAbsolute ? Number(abs(value)) : max(value, Number(0));
  r.muscle_curvature = r.muscle_curvature + (definite - value) / max(i4, Number(kShortest * kShortest));
}

}  // namespace lappet
