// Instantiates the parts of the elastic kernels for float lanes `Number` (and the peak rate for double lanes `Double`).
// Included by one translation unit per instruction set; plain arrays only, so that no function of the standard library
// is compiled for a set that another processor lacks.
#pragma once
#include "cell_kernels.h"
#include "force/kernels/cell_corners.h"
#include "force/kernels/product_kernel.h"
#include "force/materials/neo_hookean.h"
#include "math/svd3.h"

namespace lappet {

// What all cells are made of: 50 kPa at a Poisson's ratio of 0.45.
inline constexpr float kBenchmarkMu = 17.24138f, kBenchmarkLambda = 155.1724f;

template <class Number>
struct CellParts {
  static constexpr int w = kLanes<Number>;
  static constexpr std::int64_t kNumbers = kBlockNodes * 3 * w;
  using In = const float* const*;
  using Out = float* const*;

  static Moduli<Number> moduli() { return {Number(kBenchmarkMu), Number(kBenchmarkLambda), Number(0.0f)}; }

  template <int n>
  static void read(const float* from, Number (&values)[n]) {
    for (int k = 0; k < n; ++k) values[k] = load<Number>(from + k * w);
  }
  template <int n>
  static void write(const Number (&values)[n], float* to) {
    for (int k = 0; k < n; ++k) store(values[k], to + k * w);
  }

  static void svd(In in, Out out, std::int64_t begin, std::int64_t end) {
    for (std::int64_t cell = begin * kBlockCells; cell < end * kBlockCells; ++cell) {
      Number f[9], u[9], s[3], v[9];
      read(in[0] + cell * 9 * w, f);
      svd3(f, u, s, v);
      write(u, out[0] + cell * 9 * w);
      write(s, out[1] + cell * 3 * w);
      write(v, out[2] + cell * 9 * w);
    }
  }

  static void stress(In in, Out out, std::int64_t begin, std::int64_t end) {
    for (std::int64_t cell = begin * kBlockCells; cell < end * kBlockCells; ++cell) {
      Number s[3], p[3];
      read(in[0] + cell * 3 * w, s);
      NeoHookean::p_hat(s, moduli(), p);
      write(p, out[0] + cell * 3 * w);
    }
  }

  // Decomposition, stress, its derivative made definite: everything the tangent needs, from F.
  static void state_update(In in, Out out, std::int64_t begin, std::int64_t end) {
    for (std::int64_t cell = begin * kBlockCells; cell < end * kBlockCells; ++cell) {
      Number f[9], u[9], s[3], v[9], p[3], q[4];
      read(in[0] + cell * 9 * w, f);
      svd3(f, u, s, v);
      NeoHookean::p_hat(s, moduli(), p);
      write(s, out[0] + cell * 3 * w);
      write(p, out[1] + cell * 3 * w);
      float* tangent = out[2] + cell * kTangentFields * w;
      quaternion_of_rotation(u, q);
      write(q, tangent + kU * w);
      quaternion_of_rotation(v, q);
      write(q, tangent + kV * w);
      TangentHat<Number> t;
      NeoHookean::dpdf_hat(s, moduli(), t);
      make_definite(t, Number(float(kDefiniteFloor)) * moduli().mu, PsdProjection::kClamp);
      write(t.hessian, tangent + kHessian * w);
      for (int k = 0; k < 3; ++k) {
        store(Number(0.5f) * (t.stretch[k] + t.rotation[k]), tangent + (kSame + k) * w);
        store(Number(0.5f) * (t.stretch[k] - t.rotation[k]), tangent + (kCross + k) * w);
      }
    }
  }

  static void quaternion_of(In in, Out out, std::int64_t begin, std::int64_t end) {
    for (std::int64_t cell = begin * kBlockCells; cell < end * kBlockCells; ++cell) {
      Number r[9], q[4];
      read(in[0] + cell * 9 * w, r);
      quaternion_of_rotation(r, q);
      write(q, out[0] + cell * 4 * w);
    }
  }
  static void rotation_of(In in, Out out, std::int64_t begin, std::int64_t end) {
    for (std::int64_t cell = begin * kBlockCells; cell < end * kBlockCells; ++cell) {
      Number q[4], r[9];
      read(in[0] + cell * 4 * w, q);
      rotation_of_quaternion(q, r);
      write(r, out[0] + cell * 9 * w);
    }
  }

  static void read_corners(const float* at, int place, Number (&corners)[3][8]) {
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < 8; ++c) corners[i][c] = load<Number>(at + (block_node(place, c) * 3 + i) * w);
  }

  // Calls body(group, place, result) for each place of each block and adds the results up as the passes do.
  template <class Body>
  static void on_blocks(float* sums, std::int64_t begin, std::int64_t end, const Body& body) {
    for (std::int64_t group = begin; group < end; ++group) {
      float* sum = sums + group * kNumbers;
      for (int n = 0; n < kBlockNodes * 3; ++n) store(Number(0.0f), sum + n * w);
      for (int place = 0; place < kBlockCells; ++place) {
        Number result[3][8];
        body(group, place, result);
        for (int i = 0; i < 3; ++i)
          for (int c = 0; c < 8; ++c) {
            float* to = sum + (block_node(place, c) * 3 + i) * w;
            store(load<Number>(to) + result[i][c], to);
          }
      }
    }
  }

  // f = U P_hat V^T grad N
  static void force(In in, Out out, std::int64_t begin, std::int64_t end) {
    on_blocks(out[0], begin, end, [&](std::int64_t group, int place, auto& result) {
      const std::int64_t cell = group * kBlockCells + place;
      Number u[9], v[9], p[3], turned[9], stress[9];
      load_rotation(in[0] + cell * 8 * w, 0, u);
      load_rotation(in[0] + cell * 8 * w, 4, v);
      read(in[1] + cell * 3 * w, p);
      for (int i = 0; i < 9; ++i) turned[i] = u[i] * p[i % 3];
      multiply3_transposed_right(turned, v, stress);
      const Number none[4] = {Number(0.0f), Number(0.0f), Number(0.0f), Number(0.0f)};
      for (int i = 0; i < 3; ++i)
        spread_to_corners(stress[3 * i], stress[3 * i + 1], stress[3 * i + 2], none, result[i]);
    });
  }

  static void force_differential(In in, Out out, std::int64_t begin, std::int64_t end) {
    on_blocks(out[0], begin, end, [&](std::int64_t group, int place, auto& result) {
      const std::int64_t cell = group * kBlockCells + place;
      Number corners[3][8];
      read_corners(in[0] + group * kNumbers, place, corners);
      Number df[9], modes[4];
      for (int i = 0; i < 3; ++i) corner_sums(corners[i], df[3 * i], df[3 * i + 1], df[3 * i + 2], modes);
      differential<false, false>(in[1] + cell * kTangentFields * w, static_cast<const float*>(nullptr),
                                 static_cast<const float*>(nullptr), static_cast<const float*>(nullptr), df);
      const Number none[4] = {Number(0.0f), Number(0.0f), Number(0.0f), Number(0.0f)};
      for (int i = 0; i < 3; ++i) spread_to_corners(df[3 * i], df[3 * i + 1], df[3 * i + 2], none, result[i]);
    });
  }

  static void stabilization(In in, Out out, std::int64_t begin, std::int64_t end) {
    on_blocks(out[0], begin, end, [&](std::int64_t group, int place, auto& result) {
      const std::int64_t cell = group * kBlockCells + place;
      Number corners[3][8];
      read_corners(in[0] + group * kNumbers, place, corners);
      const Number strength = load<Number>(in[1] + cell * w), half = Number(0.5f) * strength, zero(0.0f);
      for (int i = 0; i < 3; ++i) {
        Number x, y, z, modes[4];
        corner_sums(corners[i], x, y, z, modes);
        for (int m = 0; m < 3; ++m) modes[m] *= strength;
        modes[3] *= half;
        spread_to_corners(zero, zero, zero, modes, result[i]);
      }
    });
  }

  static void gather(const ElasticArrays<float>& arrays, std::int64_t begin, std::int64_t end, const float* field,
                     float* at) {
    for (std::int64_t group = begin; group < end; ++group)
      gather_block<Number>(nodes_of(arrays, group, w), field, at + group * kNumbers, [] {});
  }
  static void scatter(const ElasticArrays<float>& arrays, std::int64_t begin, std::int64_t end, const float* sum,
                      float* field) {
    for (std::int64_t group = begin; group < end; ++group)
      scatter_block<Number>(nodes_of(arrays, group, w), sum + group * kNumbers, field, [](int) {});
  }
};

// Twelve independent chains hide the latency of two units of four or five cycles.
template <class Number>
double multiply_add_rate(std::int64_t rounds, typename NumberTraits<Number>::Scalar* result) {
  using Scalar = typename NumberTraits<Number>::Scalar;
  constexpr int kChains = 12, kUnroll = 8;
  const Number factor(Scalar(0.999999)), term(Scalar(1e-6));
  Number chain[kChains];
  for (int i = 0; i < kChains; ++i) chain[i] = Number(Scalar(1 + i));
  for (std::int64_t round = 0; round < rounds; ++round)
    for (int k = 0; k < kUnroll; ++k)
      for (auto& c : chain) {
        c = c * factor + term;
#if defined(__x86_64__)
        // keeps compilers from making vectors of scalars; costs no instruction
        if constexpr (kLanes<Number> == 1 && std::is_floating_point_v<Number>) asm volatile("" : "+x"(c));
#elif defined(__aarch64__)
        if constexpr (kLanes<Number> == 1 && std::is_floating_point_v<Number>) asm volatile("" : "+w"(c));
#endif
      }
  Number sum(Scalar(0));
  for (const auto& c : chain) sum += c;
  alignas(64) Scalar lanes[kLanes<Number>];
  store(sum, lanes);
  *result = lanes[0];
  return 2.0 * kChains * kUnroll * kLanes<Number> * double(rounds);
}

template <class Number, class Double>
inline void fill_cell_kernels(CellKernels& k) {
  using C = Content;
  using Parts = CellParts<Number>;
  constexpr auto no = C::kNothing;
  k.lanes = kLanes<Number>;
  k.kernels[0] = {"svd", {C::kDeformation, no, no, no}, {C::kRotation, C::kSigma, C::kRotation, no}, &Parts::svd};
  k.kernels[1] = {"stress", {C::kSigma, no, no, no}, {C::kStress, no, no, no}, &Parts::stress};
  k.kernels[2] = {
      "state_update", {C::kDeformation, no, no, no}, {C::kSigma, C::kStress, C::kTangent, no}, &Parts::state_update};
  k.kernels[3] = {
      "quaternion_of_rotation", {C::kRotation, no, no, no}, {C::kQuaternion, no, no, no}, &Parts::quaternion_of};
  k.kernels[4] = {
      "rotation_of_quaternion", {C::kQuaternion, no, no, no}, {C::kRotation, no, no, no}, &Parts::rotation_of};
  k.kernels[5] = {"force", {C::kQuaternions, C::kStress, no, no}, {C::kBlockNodes, no, no, no}, &Parts::force};
  k.kernels[6] = {"force_differential",
                  {C::kBlockNodes, C::kTangent, no, no},
                  {C::kBlockNodes, no, no, no},
                  &Parts::force_differential};
  k.kernels[7] = {"stabilization",
                  {C::kBlockNodes, C::kStabilization, no, no},
                  {C::kBlockNodes, no, no, no},
                  &Parts::stabilization};
  k.multiply_add_float = &multiply_add_rate<Number>;
  k.multiply_add_double = &multiply_add_rate<Double>;
  k.gather = &Parts::gather;
  k.scatter = &Parts::scatter;
}

}  // namespace lappet
