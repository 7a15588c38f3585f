// The functions of kernel_twins.h on one Number. Included by one translation unit per instruction set; everything is a
// template on the batch (see math/simd_number.h).
#pragma once
#include "force/kernels/diagonal_kernel.h"
#include "force/kernels/node_lanes_kernel.h"
#include "force/kernels/product_kernel.h"
#include "force/materials/fiber.h"
#include "force/materials/material_models.h"
#include "kernel_twins.h"
#include "math/matrix3.h"
#include "math/svd3.h"

namespace lappet {

template <class Number>
struct TwinInstance {
  using Real = typename NumberTraits<Number>::Scalar;
  static constexpr int w = kLanes<Number>;

  template <int n>
  static void take(const Real*& in, Number (&values)[n]) {
    for (int i = 0; i < n; ++i, in += w) values[i] = load<Number>(in);
  }
  static Number take(const Real*& in) {
    const Number value = load<Number>(in);
    in += w;
    return value;
  }
  template <int n>
  static void give(Real*& out, const Number (&values)[n]) {
    for (int i = 0; i < n; ++i, out += w) store(values[i], out);
  }
  static void give(Real*& out, const Number& value) {
    store(value, out);
    out += w;
  }

  static void roots(const Real* in, Real* out) {
    const Number x = take(in);
    give(out, rough_reciprocal(x));
    give(out, rough_reciprocal_sqrt(x));
    give(out, reciprocal_sqrt(x));
  }
  static void svd(const Real* in, Real* out) {
    Number f[9], u[9], s[3], v[9];
    take(in, f);
    svd3(f, u, s, v);
    give(out, u);
    give(out, s);
    give(out, v);
  }
  static void products(const Real* in, Real* out) {
    Number a[9], b[9], c[9];
    take(in, a);
    take(in, b);
    multiply3(a, b, c);
    give(out, c);
    multiply3_transposed_left(a, b, c);
    give(out, c);
    multiply3_transposed_right(a, b, c);
    give(out, c);
  }
  static void quaternion(const Real* in, Real* out) {
    Number r[9], q[4];
    take(in, r);
    quaternion_of_rotation(r, q);
    give(out, q);
    rotation_of_quaternion(q, r);
    give(out, r);
  }
  static void eigen(const Real* in, Real* out) {
    Number a[6], values[3], v[9];
    take(in, a);
    symmetric_eigen3(a, values, v);
    give(out, values);
    give(out, v);
  }
  template <bool kAbsolute>
  static void definite3(const Real* in, Real* out) {
    Number a[6];
    take(in, a);
    make_definite3(a, take(in), kAbsolute);
    give(out, a);
  }
  static void give_tangent(Real*& out, const TangentHat<Number>& t) {
    give(out, t.hessian);
    give(out, t.stretch);
    give(out, t.rotation);
  }
  template <class Model>
  static void model(const Real* in, Real* out) {
    Number s[3], p[3];
    take(in, s);
    Moduli<Number> m;
    m.mu = take(in);
    m.lambda = take(in);
    m.mooney = take(in);
    give(out, Model::energy(s, m));
    Model::p_hat(s, m, p);
    give(out, p);
    TangentHat<Number> t;
    Model::dpdf_hat(s, m, t);
    give_tangent(out, t);
  }
  template <PsdProjection kHow>
  static void definite(const Real* in, Real* out) {
    TangentHat<Number> t;
    take(in, t.hessian);
    take(in, t.stretch);
    take(in, t.rotation);
    make_definite(t, take(in), kHow);
    give_tangent(out, t);
  }
  template <PsdProjection kHow>
  static void fiber(const Real* in, Real* out) {
    Number x[8];
    take(in, x);
    auto r = fiber_response(x[0], x[1], x[6], FiberParameters<Number>{x[2], x[3], x[4], x[7], x[5]});
    make_definite(r, x[1], kHow);
    const Number values[8] = {r.energy,           r.shear,    r.along, r.curvature,
                              r.muscle_curvature, r.pressure, r.bulk,  r.volume};
    give(out, values);
  }
  static void corners(const Real* in, Real* out) {
    Number c[8], sums[3], modes[4];
    take(in, c);
    corner_sums(c, sums[0], sums[1], sums[2], modes);
    give(out, sums);
    give(out, modes);
    spread_to_corners(sums[0], sums[1], sums[2], modes, c);
    give(out, c);
  }
  template <bool kFibers, bool kPrestretched>
  static void differential_of(const Real* in, Real* out) {
    const Real *tangent = in, *sigma = tangent + kTangentFields * w, *fiber = sigma + 3 * w,
               *material = fiber + kFiberFields * w, *last = material + kMaterialFields * w;
    Number df[9];
    take(last, df);
    differential<kFibers, kPrestretched>(tangent, sigma, fiber, material, df);
    give(out, df);
  }
  template <bool kFibers, bool kPrestretched>
  static void corner_block(const Real* in, Real* out) {
    const Real *tangent = in, *sigma = tangent + kTangentFields * w, *fiber = sigma + 3 * w,
               *material = fiber + kFiberFields * w, *last = material + kMaterialFields * w;
    Number g[3], u[9], v[9], block[6];
    take(last, g);
    load_rotation(tangent, kU, u);
    load_rotation(tangent, kV, v);
    for (auto& value : block) value = Number(0);
    add_corner_block<kFibers, kPrestretched>(tangent, sigma, fiber, material, u, v, g, block);
    give(out, block);
  }
  static void quadratic(const Real* in, Real* out) {
    const Real* matrix = in;
    in += 36 * w;
    Number x[3][8], y[3][8];
    for (auto& row : x) take(in, row);
    for (auto& row : y)
      for (auto& value : row) value = Number(0);
    for (int i = 0; i < 3; ++i) add_quadratic(matrix, x[i], y[i]);
    for (const auto& row : y) give(out, row);
  }

  static void gather(const GroupNodes& nodes, const Real* field, Real* at) {
    gather_block<Number>(nodes, field, at, [] {});
  }
  static int scatter(const GroupNodes& nodes, const Real* sum, Real* field) {
    int steps = 0;
    scatter_block<Number>(nodes, sum, field, [&](int lanes) { steps += lanes; });
    return steps;
  }

  static void fill(KernelTwins<Real>& twins) {
    twins.lanes = w;
    twins.roots = &roots;
    twins.svd = &svd;
    twins.products = &products;
    twins.quaternion = &quaternion;
    twins.eigen = &eigen;
    twins.definite3[0] = &definite3<false>;
    twins.definite3[1] = &definite3<true>;
    for (int k = 0; k < MaterialModels::kCount; ++k)
      MaterialModels::with(k, [&]<class Model>() { twins.model[k] = &TwinInstance::model<Model>; });
    twins.definite[0] = &definite<PsdProjection::kClamp>;
    twins.definite[1] = &definite<PsdProjection::kAbsolute>;
    twins.fiber = &fiber<PsdProjection::kExact>;
    twins.fiber_definite[0] = &fiber<PsdProjection::kClamp>;
    twins.fiber_definite[1] = &fiber<PsdProjection::kAbsolute>;
    twins.corners = &corners;
    twins.differential[0][0] = &differential_of<false, false>;
    twins.differential[0][1] = &differential_of<false, true>;
    twins.differential[1][0] = &differential_of<true, false>;
    twins.differential[1][1] = &differential_of<true, true>;
    twins.corner_block[0][0] = &corner_block<false, false>;
    twins.corner_block[0][1] = &corner_block<false, true>;
    twins.corner_block[1][0] = &corner_block<true, false>;
    twins.corner_block[1][1] = &corner_block<true, true>;
    twins.quadratic = &quadratic;
    twins.gather = &NodeLanes<Number>::gather;
    twins.scatter_add = &NodeLanes<Number>::scatter_add;
    twins.gather_block = &gather;
    twins.scatter_block = &scatter;
  }
};

}  // namespace lappet
