// Fibers and active muscle along one rest direction a (unit), added on any isotropic material, on any Number.
//
// Notation: I1 = |F|^2, I4 = |F a|^2, lambda = sqrt(I4), <E> = max(E, 0).
//
// Fibers (Gasser, Ogden, Holzapfel 2006, "Hyperelastic modelling of arterial layers with distributed collagen fiber
// orientations", one family; k1 in kPa, dispersion kappa from 0, all along a, to 1/3, none preferred):
//   Psi = k1/(2 k2) (exp(k2 <E>^2) - 1),   E = kappa (I1 - 3) + (1 - 3 kappa)(I4 - 1),   and k1/2 <E>^2 for k2 = 0.
// Beyond k2 E^2 = kMaxExponent (a stress 2*10^4 times that of k2 = 0) Psi goes on as its Taylor polynomial of
// second order in E: float does not overflow, and a Newton step from far away sees a convex quadratic.
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

// k1: kPa. dispersion: kappa. muscle: maximal isometric stress times activation, kPa. active: some muscle is; where
// none is, `muscle` is 0 and its curve is passed over.
template <class Number>
struct FiberParameters {
  Number k1, k2, dispersion, muscle;
  bool active = true;
};

// P = isotropic F + along (F a) a^T, and
// dP = isotropic dF + along (dF a) a^T + curvature B (B : dF) + muscle_curvature (F a . dF a) (F a) a^T,
// B = dispersion F + (1 - 3 dispersion) (F a) a^T. Everything in kPa.
template <class Number>
struct FiberResponse {
  Number energy;
  Number isotropic, along;
  Number curvature, muscle_curvature;
};

namespace fiber_detail {

inline constexpr double kMaxExponent = 10.0;
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

// The response at F with these invariants. Convex in F but for the muscle beyond its optimal length.
template <class Number>
inline FiberResponse<Number> fiber_response(Number i1, Number i4, const FiberParameters<Number>& p) {
  using std::exp;
  using std::max;
  using std::min;
  using std::sqrt;
  namespace detail = fiber_detail;
  const Number aligned = Number(1) - Number(3) * p.dispersion;
  const Number strain = max(p.dispersion * (i1 - Number(3)) + aligned * (i4 - Number(1)), Number(0));
  const Number max_strain = sqrt(Number(detail::kMaxExponent) / max(p.k2, Number(tiny_number<Number>())));
  const Number e = min(strain, max_strain), beyond = strain - e;
  const Number exponent = p.k2 * e * e, growth = exp(exponent);
  const Number slope = p.k1 * e * growth;  // dPsi/dE at e
  const Number curvature = p.k1 * growth * (Number(1) + Number(2) * exponent);
  const Number stress = slope + curvature * beyond;

  FiberResponse<Number> r;
  r.energy = Number(0.5) * p.k1 * e * e * detail::mean_growth(exponent, growth) +
             beyond * (slope + Number(0.5) * curvature * beyond);
  r.isotropic = Number(2) * p.dispersion * stress;
  r.along = Number(2) * aligned * stress;
  r.curvature = select(strain > Number(0), Number(4) * curvature, Number(0));
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

// Makes the tangent positive semidefinite: on dF a it acts as `along` across F a and as along + muscle_curvature I4 in
// the direction of F a; the term of `curvature` and, for dispersions up to 1/3, that of `isotropic` are so anyway.
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
