// The state of the cells at u: deformation gradients, their decomposition, energy and forces; and from it the tangent.
//   F = I + du grad N (times the prestretch A),   P = U P_hat(sigma) V^T (+ fibers, times A^T)
// The arithmetic may be wider than what is stored: a float session evaluates in double, so that the energy of the line
// search and the residual keep their digits, `width` lanes of the layout in several batches.
#pragma once
#include "force/kernels/array_access.h"
#include "force/kernels/cell_corners.h"
#include "force/kernels/product_kernel.h"
#include "force/materials/fiber.h"
#include "force/materials/material.h"
#include "math/svd3.h"

namespace lappet {

struct StateSums {
  double energy = 0.0;  // mN mm
  double minimum_j = std::numeric_limits<double>::infinity();
  std::int32_t inverted = 0;  // cells with J <= 0 at a point
};

// Loads what a cell is made of.
template <class Number, class Real>
inline Moduli<Number> load_moduli(const Real* material, int width) {
  return {load<Number>(material + kMu * width), load<Number>(material + kLambda * width),
          load<Number>(material + kMooney * width)};
}
template <class Number, class Real>
inline FiberParameters<Number> load_fiber(const Real* material, int width, bool active) {
  return {load<Number>(material + kFiberK1 * width),         load<Number>(material + kFiberK2 * width),
          load<Number>(material + kFiberDispersion * width), load<Number>(material + kFiberThreshold * width),
          load<Number>(material + kMuscle * width),          active};
}

// Invariants, cofactors and pushed-forward direction of the fibers at F = U diag(sigma) V^T, in that frame.
template <class Number>
struct FiberState {
  Number a[3], fa[3], c[3], i1, i4, j;
};
template <class Number, class Real>
inline FiberState<Number> fiber_state(const Real* material, int width, const Number (&s)[3], const Number (&v)[9]) {
  FiberState<Number> state;
  const Number d0 = load<Number>(material + kFiberDirection * width),
               d1 = load<Number>(material + (kFiberDirection + 1) * width),
               d2 = load<Number>(material + (kFiberDirection + 2) * width);
  for (int i = 0; i < 3; ++i) {
    state.a[i] = v[i] * d0 + v[3 + i] * d1 + v[6 + i] * d2;
    state.fa[i] = s[i] * state.a[i];
  }
  state.i1 = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
  state.i4 = state.fa[0] * state.fa[0] + state.fa[1] * state.fa[1] + state.fa[2] * state.fa[2];
  state.c[0] = s[1] * s[2];
  state.c[1] = s[0] * s[2];
  state.c[2] = s[0] * s[1];
  state.j = s[0] * state.c[0];
  return state;
}

// Adds the forces of the groups begin..end to `gradient` (3 per node) and the magnitudes of the cells' forces to
// `magnitude` (1 per node), and remembers decompositions. Number: the arithmetic; Real and width: the layout.
template <class Number, class Real, int width, class Model, bool kOnePoint, bool kFibers, bool kPrestretched,
          bool kShares>
[[gnu::flatten]] void evaluate_groups(const ElasticArrays<Real>& arrays, std::int64_t begin, std::int64_t end,
                                      const Real* u, double* gradient, double* magnitude, StateSums& sums) {
  using std::min;
  using std::sqrt;
  constexpr int b = kLanes<Number>;
  static_assert(width % b == 0);
  using Scalar = typename NumberTraits<Number>::Scalar;
  const int points = kOnePoint ? 1 : arrays.points;
  const Number to_gradient(Scalar(0.25 / arrays.spacing));
  alignas(64) Scalar at[kBlockNodes][3][b];
  alignas(64) Scalar sum[kBlockNodes][4][b];
  alignas(64) Scalar buffer[b];
  Number min_j(std::numeric_limits<Scalar>::max());
  double energy = 0.0;
  for (std::int64_t group = begin; group < end; ++group)
    for (int lane = 0; lane < width; lane += b) {
      const GroupNodes nodes = nodes_of(arrays, group, width);
      nodes.for_each([&](int n, const std::int32_t* row, std::ptrdiff_t shift) __attribute__((always_inline)) {
        for (int k = 0; k < b; ++k) {
          const Real* from = u + 3 * (row[lane + k] + shift);
          for (int i = 0; i < 3; ++i) at[n][i][k] = Scalar(from[i]);
        }
      });
      for (auto& node : sum)
        for (auto& row : node) store(Number(0), row);
      Number group_energy(0);
      for (int place = 0; place < kBlockCells; ++place) {
        const std::int64_t cell = group * kBlockCells + place;
        const Real* material = material_of(arrays, cell) + lane;
        const Moduli<Number> moduli = load_moduli<Number>(material, width);
        const Number volume = load<Number>(arrays.volume + cell * width + lane);
        const auto present = volume > Number(0);
        const Real* share = kShares ? arrays.share_of(cell, width) + lane : nullptr;
        Number corners[3][8], force[3][8];
        for (int i = 0; i < 3; ++i)
          for (int c = 0; c < 8; ++c) {
            corners[i][c] = load<Number>(at[block_node(place, c)][i]);
            force[i][c] = Number(0);
          }
        Number cell_j(std::numeric_limits<Scalar>::max());
        for (int q = 0; q < points; ++q) {
          Number f[9], modes[3][4];
          const PointGradients<Number, Real, kOnePoint, kShares> gradients(arrays, share, q, width);
          if constexpr (kOnePoint) {
            for (int i = 0; i < 3; ++i) corner_sums(corners[i], f[3 * i], f[3 * i + 1], f[3 * i + 2], modes[i]);
            if constexpr (kShares) {
              const auto at_point = share_point<Number>(arrays, share, q, width);
              for (int i = 0; i < 3; ++i) at_point.add_to_gradient(modes[i], f[3 * i], f[3 * i + 1], f[3 * i + 2]);
            }
          } else {
            for (int i = 0; i < 3; ++i)
              for (int j = 0; j < 3; ++j) {
                Number total(0);
                for (int c = 0; c < 8; ++c) total += corners[i][c] * gradients[8 * j + c];
                f[3 * i + j] = total;
              }
          }
          for (int i = 0; i < 9; ++i) f[i] = to_gradient * f[i] + Number(i % 4 == 0 ? 1 : 0);
          Number stretch[9];
          if constexpr (kPrestretched) {
            Number unstretched[9];
            load_symmetric3<Number>(material + kPrestretch * width, stretch, width);
            for (int i = 0; i < 9; ++i) unstretched[i] = f[i];
            multiply3(unstretched, stretch, f);
          }
          Number rotation_u[9], rotation_v[9], s[3], p_hat[3], p[9], rotated[9];
          svd3(f, rotation_u, s, rotation_v);
          Model::p_hat(s, moduli, p_hat);
          Number density = Model::energy(s, moduli);
          cell_j = min(cell_j, s[0] * s[1] * s[2]);
          for (int i = 0; i < 9; ++i) p[i] = i % 4 == 0 ? p_hat[i / 4] : Number(0);
          if constexpr (kFibers) {
            const auto fiber = fiber_state(material, width, s, rotation_v);
            const auto response =
                fiber_response(fiber.i1, fiber.i4, fiber.j, load_fiber<Number>(material, width, arrays.active));
            density += response.energy;
            for (int i = 0; i < 3; ++i) {
              p[4 * i] += response.shear * s[i] + response.pressure * fiber.c[i];
              for (int j = 0; j < 3; ++j) p[3 * i + j] += response.along * fiber.fa[i] * fiber.a[j];
            }
            multiply3(rotation_u, p, rotated);
          } else {
            for (int i = 0; i < 9; ++i) rotated[i] = rotation_u[i] * p_hat[i % 3];
          }
          multiply3_transposed_right(rotated, rotation_v, p);
          if constexpr (kPrestretched) {
            for (int i = 0; i < 9; ++i) rotated[i] = p[i];
            multiply3(rotated, stretch, p);
          }
          const std::int64_t point = cell * points + q;
          Number quaternion[4];
          Real* tangent = arrays.tangent + point * kTangentFields * width + lane;
          quaternion_of_rotation(rotation_u, quaternion);
          for (int k = 0; k < 4; ++k) store(quaternion[k], tangent + (kU + k) * width);
          quaternion_of_rotation(rotation_v, quaternion);
          for (int k = 0; k < 4; ++k) store(quaternion[k], tangent + (kV + k) * width);
          for (int i = 0; i < 3; ++i) store(s[i], arrays.sigma + (point * 3 + i) * width + lane);
          if constexpr (kOnePoint) {
            const Number scale = volume * to_gradient;
            Number hourglass[4];
            hourglass_stiffness<Number, kShares>(load<Number>(arrays.stabilization + cell * width + lane), share, width,
                                                 hourglass);
            for (int i = 0; i < 3; ++i) {
              Number pull[4];
              for (int m = 0; m < 4; ++m) {
                pull[m] = hourglass[m] * modes[i][m];
                group_energy += Number(0.5) * pull[m] * modes[i][m];
              }
              const Number px = scale * p[3 * i], py = scale * p[3 * i + 1], pz = scale * p[3 * i + 2];
              if constexpr (kShares) share_point<Number>(arrays, share, q, width).add_to_modes(px, py, pz, pull);
              spread_to_corners(px, py, pz, pull, force[i]);
            }
            group_energy += volume * density;
          } else {
            const Number part = volume * Number(Scalar(arrays.weights[q]));
            const Number scale = part * to_gradient;
            for (int i = 0; i < 3; ++i)
              for (int c = 0; c < 8; ++c)
                for (int j = 0; j < 3; ++j) force[i][c] += scale * p[3 * i + j] * gradients[8 * j + c];
            group_energy += part * density;
          }
        }
        cell_j = select(present, cell_j, Number(1));
        min_j = min(min_j, cell_j);
        store(cell_j, buffer);
        for (const Scalar j : buffer) sums.inverted += !(j > Scalar(0));
        for (int c = 0; c < 8; ++c) {
          auto& node = sum[block_node(place, c)];
          for (int i = 0; i < 3; ++i) store(load<Number>(node[i]) + force[i][c], node[i]);
          store(load<Number>(node[3]) +
                    sqrt(force[0][c] * force[0][c] + force[1][c] * force[1][c] + force[2][c] * force[2][c]),
                node[3]);
        }
      }
      store(group_energy, buffer);
      for (const Scalar e : buffer) energy += double(e);
      nodes.for_each([&](int n, const std::int32_t* row, std::ptrdiff_t shift) __attribute__((always_inline)) {
        for (int k = 0; k < b; ++k) {
          const std::ptrdiff_t node = row[lane + k] + shift;
          for (int i = 0; i < 3; ++i) gradient[3 * node + i] += double(sum[n][i][k]);
          magnitude[node] += double(sum[n][3][k]);
        }
      });
    }
  sums.energy += energy;
  store(min_j, buffer);
  for (const Scalar j : buffer) sums.minimum_j = std::min(sums.minimum_j, double(j));
}

// Computes the tangent of the groups begin..end from what evaluate_groups remembered.
template <class Number, class Model, bool kOnePoint, bool kFibers>
[[gnu::flatten]] void linearize_groups(const ElasticArrays<typename NumberTraits<Number>::Scalar>& arrays,
                                       std::int64_t begin, std::int64_t end, PsdProjection how) {
  using Real = typename NumberTraits<Number>::Scalar;
  constexpr int w = kLanes<Number>;
  const int points = kOnePoint ? 1 : arrays.points;
  const Number scale(Real(1.0 / (16.0 * arrays.spacing * arrays.spacing)));
  for (std::int64_t cell = begin * kBlockCells; cell < end * kBlockCells; ++cell) {
    const Real* material = material_of(arrays, cell);
    const Moduli<Number> moduli = load_moduli<Number>(material, w);
    const Number volume = load<Number>(arrays.volume + cell * w) * scale;
    for (int q = 0; q < points; ++q) {
      const std::int64_t point = cell * points + q;
      Number s[3];
      for (int i = 0; i < 3; ++i) s[i] = load<Number>(arrays.sigma + (point * 3 + i) * w);
      TangentHat<Number> t;
      Model::dpdf_hat(s, moduli, t);
      const Number weight = kOnePoint ? volume : volume * Number(Real(arrays.weights[q]));
      Real* tangent = arrays.tangent + point * kTangentFields * w;
      if constexpr (kFibers) {
        Number v[9];
        load_rotation(tangent, kV, v);
        const auto fiber = fiber_state(material, w, s, v);
        auto response = fiber_response(fiber.i1, fiber.i4, fiber.j, load_fiber<Number>(material, w, arrays.active));
        add_isotropic(response, s, t);
        if (kHasMuscle && arrays.active) make_definite(response, fiber.i4, how);
        Real* stored = arrays.fiber_tangent + point * kFiberFields * w;
        store(weight * response.along, stored + kAlong * w);
        store(weight * response.curvature, stored + kCurvature * w);
        store(response.volume, stored + kVolumeSlope * w);
        store(weight * response.muscle_curvature, stored + kMuscleCurvature * w);
      }
      make_definite(t, Number(Real(kDefiniteFloor)) * moduli.mu, how);
      for (int i = 0; i < 6; ++i) store(weight * t.hessian[i], tangent + (kHessian + i) * w);
      for (int k = 0; k < 3; ++k) {
        store(Number(0.5) * weight * (t.stretch[k] + t.rotation[k]), tangent + (kSame + k) * w);
        store(Number(0.5) * weight * (t.stretch[k] - t.rotation[k]), tangent + (kCross + k) * w);
      }
    }
  }
}

}  // namespace lappet
