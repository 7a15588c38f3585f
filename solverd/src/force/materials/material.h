// What the isotropic hyperelastic models share: functions of the singular values sigma of F. Each model is a file of
// its own in this folder, listed in material_models.h. It offers, on any Number:
//   kName             as procedures write it
//   kInverts          whether J < 0 is a state the model describes
//   kLaplacian        Psi contains kLaplacian mu/2 |F|^2; the stabilization integrates that part exactly
//   energy            (sigma, moduli of the cell): Psi, kPa
//   p_hat             (sigma, moduli, p): the diagonal of the first Piola stress in the frame of the SVD
//   dpdf_hat          (sigma, moduli, t): its derivative, 12 numbers (Teran et al. 2005): the Hessian of Psi in sigma,
//                     then for each pair (01, 02, 12) the eigenvalues of the stretch mode, (p_i - p_j)/(s_i - s_j), and
//                     of the rotation mode, (p_i + p_j)/(s_i + s_j), as closed forms that hold for equal values too
#pragma once
#include <cmath>

#include "math/number.h"
#include "math/symmetric_eigen3.h"

namespace lappet {

inline constexpr int kTangentPairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};

template <class Number>
struct Moduli {
  Number mu, lambda;  // kPa
  Number mooney;      // mu01 / mu10, for the models that have a second modulus
};

template <class Number>
struct TangentHat {
  Number hessian[6];  // 00 01 02 11 12 22
  Number stretch[3];  // pairs 01 02 12
  Number rotation[3];
};

// The smallest eigenvalue that a definite tangent keeps, over mu.
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
