// P^T K P of one cell for a coarse space of blended rigid modes, written once for any Number (lanes: cells).
//
// The eight corners k of a coarse cell carry rigid modes: delta x_n = sum_k w_kn (t_k + omega_k x a_n), a_n the arm of
// fine node n from a point that all corners share. Then delta F = sum_k t_k g_k^T + [omega_k]x M_k with
//   g_k = sum_n w_kn G_n (3),   M_k = sum_n w_kn a_n G_n^T (3x3),   G_n = dN_n/dX,
// and the tangent U (T : U^T delta F V) V^T is contracted with g_l and M_l: about 9 500 multiplications and additions a
// cell. Prescribed nodes have the weight 0.
//
// Layout of blocks: 36 pairs of corners k >= l, pair_of(k, l), each a row-major 6x6 with the rows of k (three
// translations, three rotations) and the columns of l.
#pragma once
#include <cstddef>

#include "force/kernels/product_kernel.h"
#include "force/kernels/quadrature.h"
#include "math/number.h"

namespace lappet {

inline constexpr int kModePairs = 36, kModePairSize = 36 * kModePairs;

constexpr int pair_of(int k, int l) { return k * (k + 1) / 2 + l; }

// sum over the nodes a, b of a cell of a symmetric scalar form Q_ab on rigid modes k (at a) and l (at b): of w w, w (w
// a_b), (w a_a) w, (w a_a)(w a_b)^T.
template <class Number>
struct ModeMoments {
  Number ww, wa[3], aw[3], aa[9];
};

template <class Number>
inline void add_moments(const ModeMoments<Number>& s, Number* block) {
  const Number trace = s.aa[0] + s.aa[4] + s.aa[8];
  for (int i = 0; i < 3; ++i) {
    block[7 * i] += s.ww;
    block[7 * (3 + i)] += trace;
    for (int j = 0; j < 3; ++j) block[6 * (3 + i) + 3 + j] -= s.aa[3 * j + i];
  }
  for (int m = 0; m < 3; ++m) {
    const int p = (m + 1) % 3, q = (m + 2) % 3;
    block[6 * q + 3 + m] += s.wa[p];
    block[6 * p + 3 + m] -= s.wa[q];
    block[6 * (3 + m) + q] += s.aw[p];
    block[6 * (3 + m) + p] -= s.aw[q];
  }
}

// No fibers: what add_projected_tangent adds to a differential in the frame of the decomposition.
struct NoFibers {
  template <class Number>
  void operator()(const Number*, Number*) const {}
};

// The tangent at a quadrature point: u, v (9, row-major), hessian (6), same, cross (3), scaled by weight and volume;
// gradient: 3x8 row-major dN_n/dX; weight [8 k + n]; arm [3 n + i]. With a prestretch A, v is A V. add_fibers(hat, dp)
// adds what fibers give to dp.
template <class Number, class Gradient, class AddFibers = NoFibers>
void add_projected_tangent(const Number* u, const Number* v, const Number* hessian, const Number* same,
                           const Number* cross, const Gradient& gradient, const Number* weight, const Number* arm,
                           Number* blocks, const AddFibers& add_fibers = {}) {
  constexpr int kPairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  Number g[8][3], m[8][9];  // V^T g_k and M_k V
  for (int k = 0; k < 8; ++k) {
    Number flat[3], turned[9];
    for (int j = 0; j < 3; ++j) flat[j] = weight[8 * k] * Number(gradient[8 * j]);
    for (int i = 0; i < 3; ++i) {
      const Number share = weight[8 * k] * arm[i];
      for (int j = 0; j < 3; ++j) turned[3 * i + j] = share * Number(gradient[8 * j]);
    }
    for (int n = 1; n < 8; ++n) {
      const Number w = weight[8 * k + n];
      for (int j = 0; j < 3; ++j) flat[j] += w * Number(gradient[8 * j + n]);
      for (int i = 0; i < 3; ++i) {
        const Number share = w * arm[3 * n + i];
        for (int j = 0; j < 3; ++j) turned[3 * i + j] += share * Number(gradient[8 * j + n]);
      }
    }
    for (int j = 0; j < 3; ++j) {
      g[k][j] = flat[0] * v[j] + flat[1] * v[3 + j] + flat[2] * v[6 + j];
      for (int i = 0; i < 3; ++i)
        m[k][3 * i + j] = turned[3 * i] * v[j] + turned[3 * i + 1] * v[3 + j] + turned[3 * i + 2] * v[6 + j];
    }
  }
  for (int l = 0; l < 8; ++l)
    for (int column = 0; column < 6; ++column) {
      Number hat[9], dp[9], stress[9];
      const int axis = column % 3, p = (axis + 1) % 3, q = (axis + 2) % 3;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          if (column < 3)
            hat[3 * i + j] = u[3 * axis + i] * g[l][j];
          else
            hat[3 * i + j] = u[3 * q + i] * m[l][3 * p + j] - u[3 * p + i] * m[l][3 * q + j];
      dp[0] = hessian[0] * hat[0] + hessian[1] * hat[4] + hessian[2] * hat[8];
      dp[4] = hessian[1] * hat[0] + hessian[3] * hat[4] + hessian[4] * hat[8];
      dp[8] = hessian[2] * hat[0] + hessian[4] * hat[4] + hessian[5] * hat[8];
      for (int pair = 0; pair < 3; ++pair) {
        const int ij = 3 * kPairs[pair][0] + kPairs[pair][1], ji = 3 * kPairs[pair][1] + kPairs[pair][0];
        dp[ij] = same[pair] * hat[ij] + cross[pair] * hat[ji];
        dp[ji] = same[pair] * hat[ji] + cross[pair] * hat[ij];
      }
      add_fibers(hat, dp);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          stress[3 * i + j] = u[3 * i] * dp[j] + u[3 * i + 1] * dp[3 + j] + u[3 * i + 2] * dp[6 + j];
      for (int k = l; k < 8; ++k) {
        Number* entry = blocks + 36 * pair_of(k, l) + column;
        for (int i = 0; i < 3; ++i)
          entry[6 * i] += stress[3 * i] * g[k][0] + stress[3 * i + 1] * g[k][1] + stress[3 * i + 2] * g[k][2];
        for (int i = 0; i < 3; ++i) {
          const int a = 3 * ((i + 1) % 3), b = 3 * ((i + 2) % 3);
          entry[6 * (3 + i)] += m[k][a] * stress[b] + m[k][a + 1] * stress[b + 1] + m[k][a + 2] * stress[b + 2] -
                                m[k][b] * stress[a] - m[k][b + 1] * stress[a + 1] - m[k][b + 2] * stress[a + 2];
        }
      }
    }
}

// The stabilization of one-point quadrature: sum_m stiffness[m] |h_m . x|^2 / 2.
template <class Number>
void add_projected_hourglass(const Number (&stiffness)[4], const Number* weight, const Number* arm, Number* blocks) {
  Number w[4][8], a[4][8][3];
  for (int mode = 0; mode < 4; ++mode) {
    const auto& signs = kHourglassModes[mode];
    for (int k = 0; k < 8; ++k) {
      w[mode][k] = weight[8 * k] - weight[8 * k];
      for (int i = 0; i < 3; ++i) a[mode][k][i] = w[mode][k];
      for (int n = 0; n < 8; ++n)
        if (signs[n] > 0) {
          w[mode][k] += weight[8 * k + n];
          for (int i = 0; i < 3; ++i) a[mode][k][i] += weight[8 * k + n] * arm[3 * n + i];
        } else {
          w[mode][k] -= weight[8 * k + n];
          for (int i = 0; i < 3; ++i) a[mode][k][i] -= weight[8 * k + n] * arm[3 * n + i];
        }
    }
  }
  for (int l = 0; l < 8; ++l) {
    Number cw[4], ca[4][3];
    for (int mode = 0; mode < 4; ++mode) {
      cw[mode] = stiffness[mode] * w[mode][l];
      for (int i = 0; i < 3; ++i) ca[mode][i] = stiffness[mode] * a[mode][l][i];
    }
    for (int k = l; k < 8; ++k) {
      ModeMoments<Number> s;
      s.ww = w[0][k] * cw[0] + w[1][k] * cw[1] + w[2][k] * cw[2] + w[3][k] * cw[3];
      for (int i = 0; i < 3; ++i) {
        s.wa[i] = w[0][k] * ca[0][i] + w[1][k] * ca[1][i] + w[2][k] * ca[2][i] + w[3][k] * ca[3][i];
        s.aw[i] = a[0][k][i] * cw[0] + a[1][k][i] * cw[1] + a[2][k][i] * cw[2] + a[3][k][i] * cw[3];
        for (int j = 0; j < 3; ++j)
          s.aa[3 * i + j] =
              a[0][k][i] * ca[0][j] + a[1][k][i] * ca[1][j] + a[2][k][i] * ca[2][j] + a[3][k][i] * ca[3][j];
      }
      add_moments(s, blocks + 36 * pair_of(k, l));
    }
  }
}

// A symmetric scalar form Q (8x8) on the cell's nodes, times the identity.
template <class Number>
void add_projected_form(const Number* form, const Number* weight, const Number* arm, Number* blocks) {
  for (int l = 0; l < 8; ++l) {
    Number qw[8], qa[8][3];
    for (int n = 0; n < 8; ++n) {
      qw[n] = form[8 * n] * weight[8 * l];
      for (int i = 0; i < 3; ++i) qa[n][i] = qw[n] * arm[i];
      for (int b = 1; b < 8; ++b) {
        const Number share = form[8 * n + b] * weight[8 * l + b];
        qw[n] += share;
        for (int i = 0; i < 3; ++i) qa[n][i] += share * arm[3 * b + i];
      }
    }
    for (int k = l; k < 8; ++k) {
      const Number zero = weight[8 * k] - weight[8 * k];
      ModeMoments<Number> s{zero, {zero, zero, zero}, {zero, zero, zero}, {}};
      for (Number& entry : s.aa) entry = zero;
      for (int n = 0; n < 8; ++n) {
        const Number w = weight[8 * k + n];
        s.ww += w * qw[n];
        for (int i = 0; i < 3; ++i) {
          const Number share = w * arm[3 * n + i];
          s.wa[i] += w * qa[n][i];
          s.aw[i] += share * qw[n];
          for (int j = 0; j < 3; ++j) s.aa[3 * i + j] += share * qa[n][j];
        }
      }
      add_moments(s, blocks + 36 * pair_of(k, l));
    }
  }
}

// Cells that are projected in one call.
inline constexpr int kProjectionLanes = 16;

// Adds P^T K P of up to kProjectionLanes cells: slots [lane] (the last one repeated where there are fewer), weights
// [64][lane] (zero in lanes without a cell), arms [24][lane], blocks [kModePairSize][lane].
template <class Number, bool kOnePoint, bool kFibers, bool kPrestretched, bool kShares>
void project_cells(const ElasticArrays<typename NumberTraits<Number>::Scalar>& arrays, const std::int32_t* slots,
                   const typename NumberTraits<Number>::Scalar* weights,
                   const typename NumberTraits<Number>::Scalar* arms, typename NumberTraits<Number>::Scalar* blocks) {
  using Real = typename NumberTraits<Number>::Scalar;
  constexpr int w = kLanes<Number>;
  static_assert(kProjectionLanes % w == 0);
  const int points = kOnePoint ? 1 : arrays.points;
  alignas(64) Real buffer[64][w];
  Number weight[64], arm[24], out[kModePairSize];
  for (int first = 0; first < kProjectionLanes; first += w) {
    for (int i = 0; i < 64; ++i) weight[i] = load<Number>(weights + kProjectionLanes * i + first);
    for (int i = 0; i < 24; ++i) arm[i] = load<Number>(arms + kProjectionLanes * i + first);
    for (int i = 0; i < kModePairSize; ++i) out[i] = load<Number>(blocks + kProjectionLanes * i + first);
    // Collects `fields` numbers of each lane's cell, found at from + place * stride.
    const auto collect = [&](const Real* from, std::int64_t stride, int fields, Number* to) {
      for (int lane = 0; lane < w; ++lane) {
        const Real* record = from + slots[first + lane] / w * stride + slots[first + lane] % w;
        for (int k = 0; k < fields; ++k) buffer[k][lane] = record[k * w];
      }
      for (int k = 0; k < fields; ++k) to[k] = load<Number>(buffer[k]);
    };
    alignas(64) Real share[kShareFields][w];
    if constexpr (kShares)
      for (int lane = 0; lane < w; ++lane) {
        const std::int32_t slot = slots[first + lane];
        const Real* record = arrays.share_of(slot / w, w) + slot % w;
        for (int k = 0; k < kShareFields; ++k) share[k][lane] = record[k * w];
      }
    for (int q = 0; q < points; ++q) {
      Number tangent[kTangentFields], u[9], v[9], rotation[9];
      collect(arrays.tangent + q * kTangentFields * w, std::int64_t{points} * kTangentFields * w, kTangentFields,
              tangent);
      const Number quaternion_u[4] = {tangent[kU], tangent[kU + 1], tangent[kU + 2], tangent[kU + 3]};
      const Number quaternion_v[4] = {tangent[kV], tangent[kV + 1], tangent[kV + 2], tangent[kV + 3]};
      rotation_of_quaternion(quaternion_u, u);
      rotation_of_quaternion(quaternion_v, rotation);
      if constexpr (kPrestretched) {
        Number packed[6], stretch[9];
        collect(arrays.material + kPrestretch * w, arrays.material_stride, 6, packed);
        unpack_symmetric3(packed, stretch);
        multiply3(stretch, rotation, v);
      } else {
        for (int i = 0; i < 9; ++i) v[i] = rotation[i];
      }
      const PointGradients<Number, Real, kOnePoint, kShares> gradient(arrays, &share[0][0], q, w);
      if constexpr (kFibers) {
        Number material[kPrestretch], sigma[3], response[kFiberFields];
        collect(arrays.material, arrays.material_stride, kPrestretch, material);
        collect(arrays.sigma + q * 3 * w, std::int64_t{points} * 3 * w, 3, sigma);
        collect(arrays.fiber_tangent + q * kFiberFields * w, std::int64_t{points} * kFiberFields * w, kFiberFields,
                response);
        const FiberDifferential<Number> fiber(material, sigma, response, rotation);
        add_projected_tangent(u, v, tangent + kHessian, tangent + kSame, tangent + kCross, gradient, weight, arm, out,
                              fiber);
      } else {
        add_projected_tangent(u, v, tangent + kHessian, tangent + kSame, tangent + kCross, gradient, weight, arm, out);
      }
    }
    if constexpr (kOnePoint) {
      Number stabilization, stiffness[4];
      collect(arrays.stabilization, w, 1, &stabilization);
      hourglass_stiffness<Number, kShares>(stabilization, &share[0][0], w, stiffness);
      add_projected_hourglass(stiffness, weight, arm, out);
    }
    bool attached = false;
    for (int lane = 0; lane < w && arrays.quadratic_of != nullptr; ++lane)
      attached = attached || arrays.quadratic_of[slots[first + lane] / w] >= 0;
    if (attached) {
      Number form[64];
      int entry = 0;
      for (int a = 0; a < 8; ++a)
        for (int b = a; b < 8; ++b, ++entry) {
          for (int lane = 0; lane < w; ++lane) {
            const std::int32_t slot = slots[first + lane], index = arrays.quadratic_of[slot / w];
            buffer[0][lane] =
                index < 0 ? Real(0) : arrays.quadratics[(std::int64_t{index} * 36 + entry) * w + slot % w];
          }
          form[8 * a + b] = form[8 * b + a] = load<Number>(buffer[0]);
        }
      add_projected_form(form, weight, arm, out);
    }
    for (int i = 0; i < kModePairSize; ++i) store(out[i], blocks + kProjectionLanes * i + first);
  }
}

}  // namespace lappet
