#include "kernel_twins_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>

#include "force/kernels/elastic_arrays.h"
#include "force/materials/fiber.h"
#include "force/materials/material.h"
#include "kernel_twins_inputs.h"

namespace lappet {

namespace {

double distance(const double* a, const double* b, std::size_t count) {
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}
double largest(const double* from, std::size_t count) {
  double most = 0;
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, std::abs(from[i]));
  return most;
}
double determinant(const double* m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
}
// |M^T M - 1|, and -1 where M is a reflection
double rotation_error(const double* m) {
  double sum = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double dot = m[i] * m[j] + m[3 + i] * m[3 + j] + m[6 + i] * m[6 + j] - (i == j ? 1.0 : 0.0);
      sum += dot * dot;
    }
  return determinant(m) > 0.5 ? std::sqrt(sum) : std::numeric_limits<double>::infinity();
}

// error(input, got, expected): over the size of the kernel's terms.
using Error = std::function<double(const Values& in, const Values& got, const Values& expected)>;

template <class Real>
class Comparison {
 public:
  Comparison(const KernelTwins<Real>& twins, const KernelTwins<double>& reference)
      : lanes_(static_cast<std::size_t>(twins.lanes)), reference_lanes_(static_cast<std::size_t>(reference.lanes)) {}

  void compare(const std::string& kernel, typename KernelTwins<Real>::Function run,
               KernelTwins<double>::Function reference, std::vector<Values> samples, std::size_t outputs,
               const Error& error, double tolerance = kTwinTolerance<Real>) {
    for (auto& sample : samples)
      for (double& value : sample) value = double(Real(value));
    const auto got = results<Real>(run, lanes_, samples, outputs);
    const auto expected = results<double>(reference, reference_lanes_, samples, outputs);
    TwinResult result{kernel, tolerance, samples.size()};
    for (std::size_t k = 0; k < samples.size(); ++k) {
      double e = error(samples[k], got[k], expected[k]);
      if (!(e <= std::numeric_limits<double>::max())) e = std::numeric_limits<double>::infinity();  // NaN too
      if (e <= result.worst) continue;
      result.worst = e;
      result.where.clear();
      char text[32];
      for (const double value : samples[k]) {
        std::snprintf(text, sizeof text, "%.9g ", value);
        result.where += text;
      }
    }
    all.push_back(result);
  }

  std::vector<TwinResult> all;

 private:
  template <class T>
  static std::vector<Values> results(typename KernelTwins<T>::Function run, std::size_t lanes,
                                     const std::vector<Values>& samples, std::size_t outputs) {
    struct alignas(64) Line {
      T values[64 / sizeof(T)];
    };
    const std::size_t inputs = samples.at(0).size(), per_line = 64 / sizeof(T);
    std::vector<Line> in_lines(inputs * lanes / per_line + 1), out_lines(outputs * lanes / per_line + 1);
    T *in = in_lines[0].values, *out = out_lines[0].values;
    std::vector<Values> all(samples.size(), Values(outputs));
    for (std::size_t begin = 0; begin < samples.size(); begin += lanes) {
      for (std::size_t lane = 0; lane < lanes; ++lane)
        for (std::size_t i = 0; i < inputs; ++i)
          in[i * lanes + lane] = T(samples[std::min(begin + lane, samples.size() - 1)][i]);
      run(in, out);
      for (std::size_t lane = 0; lane < lanes && begin + lane < samples.size(); ++lane)
        for (std::size_t i = 0; i < outputs; ++i) all[begin + lane][i] = double(out[i * lanes + lane]);
    }
    return all;
  }

  std::size_t lanes_, reference_lanes_;
};

// Relative to the largest of `count` outputs from `first` on.
Error against_largest(std::size_t first, std::size_t count) {
  return [=](const Values&, const Values& got, const Values& expected) {
    return distance(&got[first], &expected[first], count) / std::max(norm(&expected[first], count), 1e-300);
  };
}

double svd_error(const Values& f, const Values& got, const Values& expected) {
  const double size = norm(f.data(), 9);
  const double *u = got.data(), *s = &got[9], *v = &got[12];
  double error = std::max(rotation_error(u), rotation_error(v));
  double rebuilt[9];
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      rebuilt[3 * i + j] = 0;
      for (std::size_t a = 0; a < 3; ++a) rebuilt[3 * i + j] += u[3 * i + a] * s[a] * v[3 * j + a];
    }
  if (size == 0.0) return std::max(error, norm(s, 3));
  error = std::max({error, distance(rebuilt, f.data(), 9) / size, distance(s, &expected[9], 3) / size});
  // order and sign: sigma[0] >= sigma[1] >= |sigma[2]|, the sign of the last that of the determinant
  error = std::max({error, (s[1] - s[0]) / size, (std::abs(s[2]) - s[1]) / size, -s[1] / size});
  const double least = std::abs(expected[11]);
  if (least > 1e-4 * size && (s[2] < 0) != (determinant(f.data()) < 0)) return 2;
  return error;
}

template <class Real>
void compare_matrices(Comparison<Real>& c, const KernelTwins<Real>& twins, const KernelTwins<double>& reference) {
  Random random;
  std::vector<Values> positive;
  for (int k = 0; k < 500; ++k) positive.push_back({random.log_uniform(1e-8, 1e8)});
  const auto relative = [](std::size_t i) {
    return
        [i](const Values&, const Values& got, const Values& expected) { return std::abs(got[i] / expected[i] - 1.0); };
  };
  // Of the rough ones 11 bits will do, further sweeps correct them.
  for (const std::size_t i : {0U, 1U})
    c.compare(i == 0 ? "rough 1/x" : "rough 1/sqrt(x)", twins.roots, reference.roots, positive, 3, relative(i),
              std::ldexp(1.0, -11));
  c.compare("1/sqrt(x)", twins.roots, reference.roots, positive, 3, relative(2));

  const auto gradients = deformation_gradients(random);
  c.compare("svd3", twins.svd, reference.svd, gradients, 21, svd_error);

  std::vector<Values> pairs, rotations;
  for (int k = 0; k < 500; ++k) pairs.push_back(random.normals(18));
  c.compare("products of matrices", twins.products, reference.products, pairs, 27,
            [](const Values& in, const Values& got, const Values& expected) {
              return distance(got.data(), expected.data(), 27) / (norm(in.data(), 9) * norm(&in[9], 9));
            });
  for (int k = 0; k < 1000; ++k) {
    const auto r = random.rotation();
    rotations.emplace_back(r.begin(), r.end());
  }
  for (int axis = 0; axis < 3; ++axis)  // half turns, and nearly
    for (const double angle : {0.0, 1e-4, 3.14159, 3.14159265358979}) {
      Values r(9, 0.0);
      const std::size_t i = axis, j = (i + 1) % 3, k = (i + 2) % 3;
      r[4 * i] = 1;
      r[4 * j] = r[4 * k] = std::cos(angle);
      r[3 * j + k] = -(r[3 * k + j] = std::sin(angle));
      rotations.push_back(r);
    }
  c.compare(
      "quaternions", twins.quaternion, reference.quaternion, rotations, 13,
      [](const Values& in, const Values& got, const Values& expected) {
        // q and -q are one rotation, and which of them comes out may turn on a rounding
        Values other(expected.begin(), expected.begin() + 4);
        for (double& value : other) value = -value;
        return std::max({std::min(distance(got.data(), expected.data(), 4), distance(got.data(), other.data(), 4)),
                         distance(&got[4], in.data(), 9), rotation_error(&got[4])});
      });

  const auto symmetric = symmetric_matrices(random);
  c.compare("symmetric_eigen3", twins.eigen, reference.eigen, symmetric, 12,
            [](const Values& in, const Values& got, const Values& expected) {
              const double size = std::max(norm(in.data(), 6), 1e-300);
              Values a(got.begin(), got.begin() + 3), b(expected.begin(), expected.begin() + 3);
              std::sort(a.begin(), a.end());
              std::sort(b.begin(), b.end());
              double rebuilt[6] = {};
              std::size_t entry = 0;
              for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t j = i; j < 3; ++j, ++entry)
                  for (std::size_t m = 0; m < 3; ++m)
                    rebuilt[entry] += got[3 + 3 * i + m] * got[m] * got[3 + 3 * j + m];
              return std::max({distance(a.data(), b.data(), 3) / size, distance(rebuilt, in.data(), 6) / size,
                               rotation_error(&got[3])});
            });
  for (const int how : {0, 1}) {
    auto with_floor = symmetric;
    for (auto& matrix : with_floor) matrix.push_back(kDefiniteFloor * norm(matrix.data(), 6));
    c.compare(how == 0 ? "make_definite3, clamp" : "make_definite3, absolute", twins.definite3[how],
              reference.definite3[how], with_floor, 6, [](const Values& in, const Values& got, const Values& expected) {
                return distance(got.data(), expected.data(), 6) / std::max(norm(in.data(), 6), 1e-300);
              });
  }
}

template <class Real>
void compare_materials(Comparison<Real>& c, const KernelTwins<Real>& twins, const KernelTwins<double>& reference) {
  Random random;
  std::vector<Values> states;
  for (int k = 0; k < 3000; ++k) {
    const auto s = random.stretches(k);
    const double mu = random.log_uniform(0.5, 50.0), poisson = k % 4 == 0 ? 0.499 : random.uniform(0.0, 0.49);
    states.push_back({s[0], s[1], s[2], mu, 2 * mu * poisson / (1 - 2 * poisson), random.uniform(0.0, 3.0)});
  }
  for (std::size_t model = 0; model < MaterialModels::kCount; ++model) {
    const std::string name(MaterialModels::kNames[model]);
    // The terms are as large as the tangent times the stretch; near rest they cancel.
    const auto scale = [](const Values& in, const Values& expected, int power) {
      return largest(&expected[4], 12) * std::pow(std::max(in[0], 1.0), power);
    };
    c.compare(name + ": energy", twins.model[model], reference.model[model], states, 16,
              [&](const Values& in, const Values& got, const Values& expected) {
                return std::abs(got[0] - expected[0]) / std::max(scale(in, expected, 2), expected[0]);
              });
    c.compare(name + ": p_hat", twins.model[model], reference.model[model], states, 16,
              [&](const Values& in, const Values& got, const Values& expected) {
                return distance(&got[1], &expected[1], 3) / std::max(scale(in, expected, 1), norm(&expected[1], 3));
              });
    c.compare(name + ": dpdf_hat", twins.model[model], reference.model[model], states, 16,
              [](const Values&, const Values& got, const Values& expected) {
                return distance(&got[4], &expected[4], 12) / norm(&expected[4], 12);
              });
    // what the tangent of the scalar double becomes
    std::vector<Values> tangents;
    for (const auto& state : states) {
      Values out(16);
      reference.model[model](state.data(), out.data());
      out.erase(out.begin(), out.begin() + 4);
      out.push_back(kDefiniteFloor * state[3]);
      tangents.push_back(out);
    }
    for (const int how : {0, 1})
      c.compare(name + (how == 0 ? ": definite, clamp" : ": definite, absolute"), twins.definite[how],
                reference.definite[how], tangents, 12, [](const Values& in, const Values& got, const Values& expected) {
                  return distance(got.data(), expected.data(), 12) / norm(in.data(), 12);
                });
  }
}

// Near the cap of its exponent the fibers' energy has a condition number of its own: a relative error of E grows by
// d ln stress / d ln E = 1 + 2 k2 E^2, at most 21, and E itself is a difference of squares: one rounding of I4 moves E
// by I4/E roundings. In terms of k2 the two together are 2 sqrt(10 k2), whatever the arithmetic; that much is allowed.
double fiber_condition(double k2) { return std::max(1.0, 2.0 * std::sqrt(fiber_detail::kMaxExponent * k2)); }

template <class Real>
void compare_fibers(Comparison<Real>& c, const KernelTwins<Real>& twins, const KernelTwins<double>& reference) {
  Random random;
  std::vector<Values> states;
  for (int k = 0; k < 6000; ++k) {
    const auto s = random.stretches(k);
    const auto v = random.rotation();
    const double i1 = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
    double i4 = 0;
    for (std::size_t i = 0; i < 3; ++i) i4 += s[i] * s[i] * v[i] * v[i];
    const bool fibers = k % 3 != 0, muscle = k % 3 != 1;
    const double k2 = k % 5 == 0 ? 0.0 : random.log_uniform(1e-3, 200.0);
    const double slack = k % 2 == 0 ? 1.0 : random.uniform(1.02, 1.4);
    states.push_back({i1, i4, fibers ? random.log_uniform(0.1, 300.0) : 0.0, fibers ? k2 : 0.0,
                      random.uniform(0.0, 1.0 / 3.0), muscle ? random.uniform(0.0, 300.0) : 0.0, s[0] * s[1] * s[2],
                      slack * slack - 1.0});
  }
  const auto scale = [](const Values& in, const Values& r) {
    // stiffness of the response on dF: the largest of what its parts give, and of the slack fiber and muscle; |C| <= I1
    const double stiffness =
        std::max({std::abs(r[1]), std::abs(r[2]), std::abs(r[3]) * (in[0] + r[7] * r[7] * in[0] * in[0]),
                  std::abs(r[4]) * std::max(in[1], 0.16), in[2], in[5], std::abs(r[5]) * std::sqrt(in[0]),
                  r[6] * in[0] * in[0]});
    return stiffness * fiber_condition(in[3]);
  };
  const auto tangent_error = [=](const Values& in, const Values& got, const Values& expected) {
    // the terms as they act: the curvature on B B, the muscle's on F a a, |F a|^2 = I4, the pressure on dC, |dC| <= 2
    // |F|
    double difference =
        std::max({std::abs(got[1] - expected[1]), std::abs(got[2] - expected[2]),
                  std::abs(got[5] - expected[5]) * std::sqrt(in[0]), std::abs(got[6] - expected[6]) * in[0] * in[0],
                  std::abs(got[7] - expected[7]) * std::abs(expected[3]) * in[0]});
    double measure, slope, curvature;
    fiber_detail::volume_measure(in[6], measure, slope, curvature);
    const double strain = in[4] * (in[0] - 3 + measure) + (1 - 3 * in[4]) * (in[1] - 1) - in[7];
    // of slack fibers, where the curvature steps
    const bool at_the_kink =
        in[7] == 0.0 && std::abs(strain) < 8 * kTwinTolerance<Real> * (in[0] + std::abs(measure) + 1);
    if (!at_the_kink) difference = std::max(difference, std::abs(got[3] - expected[3]) * in[0]);
    const double change = std::abs(std::sqrt(in[1]) - 1);
    if (std::abs(change - fiber_detail::kPeak) > 1e-5)
      difference = std::max(difference, std::abs(got[4] - expected[4]) * in[1]);
    return difference / scale(in, expected);
  };
  c.compare("fibers and muscle: energy", twins.fiber, reference.fiber, states, 8,
            [=](const Values& in, const Values& got, const Values& expected) {
              return std::abs(got[0] - expected[0]) / (scale(in, expected) * std::max(in[0], 1.0));
            });
  c.compare("fibers and muscle: response", twins.fiber, reference.fiber, states, 8, tangent_error);
  for (const int how : {0, 1})
    c.compare(how == 0 ? "fibers and muscle: definite, clamp" : "fibers and muscle: definite, absolute",
              twins.fiber_definite[how], reference.fiber_definite[how], states, 8, tangent_error);
}

template <class Real>
void compare_cells(Comparison<Real>& c, const KernelTwins<Real>& twins, const KernelTwins<double>& reference) {
  Random random;
  std::vector<Values> corners, quadratics;
  for (int k = 0; k < 500; ++k) {
    corners.push_back(random.normals(8));
    quadratics.push_back(random.normals(60));
  }
  c.compare("gradient, hourglass modes and their transposes", twins.corners, reference.corners, corners, 15,
            against_largest(0, 15));
  c.compare("quadratic terms", twins.quadratic, reference.quadratic, quadratics, 24, against_largest(0, 24));

  // What the stored tangent may hold: unit quaternions, a tangent of both signs, stretches of every kind.
  std::vector<Values> differentials;
  for (int k = 0; k < 2000; ++k) {
    Values in;
    for (int rotation = 0; rotation < 2; ++rotation) {
      Values q = random.normals(4);
      const double length = norm(q.data(), 4);
      for (const double value : q) in.push_back(value / length);
    }
    for (int i = 0; i < 12; ++i) in.push_back(10.0 * random.normal());
    for (const double s : random.stretches(k)) in.push_back(s);
    for (int i = 0; i < 4; ++i) in.push_back(10.0 * random.normal());
    Values material(kMaterialFields);
    material[kFiberDispersion] = random.uniform(0.0, 1.0 / 3.0);
    const auto direction = random.rotation();
    for (std::size_t i = 0; i < 3; ++i) material[kFiberDirection + i] = direction[i];
    for (const std::size_t i : {0U, 3U, 5U}) material[kPrestretch + i] = random.uniform(0.8, 1.2);
    for (const std::size_t i : {1U, 2U, 4U}) material[kPrestretch + i] = random.uniform(-0.1, 0.1);
    in.insert(in.end(), material.begin(), material.end());
    const Values df = random.normals(9);
    in.insert(in.end(), df.begin(), df.end());
    differentials.push_back(in);
  }
  // |T| |dF|: fibers act with along, and their curvatures times |F|^2 and |F + volume C|^2
  const auto scale = [](const Values& in, bool fibers) {
    double tangent = norm(&in[8], 12);
    const double stretch = in[20] * in[20] + in[21] * in[21] + in[22] * in[22];
    if (fibers)
      tangent += std::abs(in[23]) + std::abs(in[24]) * std::max(stretch + in[25] * in[25] * stretch * stretch, 1.0) +
                 std::abs(in[26]) * std::max(stretch, 1.0);
    return tangent;
  };
  for (const bool fibers : {false, true})
    for (const bool prestretched : {false, true}) {
      const std::string with = std::string(fibers ? ", fibers" : "") + (prestretched ? ", prestretch" : "");
      c.compare("differential" + with, twins.differential[fibers][prestretched],
                reference.differential[fibers][prestretched], differentials, 9,
                [=](const Values& in, const Values& got, const Values& expected) {
                  return distance(got.data(), expected.data(), 9) / (scale(in, fibers) * norm(&in[in.size() - 9], 9));
                });
      auto blocks = differentials;
      for (auto& in : blocks) in.resize(in.size() - 6);
      c.compare("diagonal block" + with, twins.corner_block[fibers][prestretched],
                reference.corner_block[fibers][prestretched], blocks, 6,
                [=](const Values& in, const Values& got, const Values& expected) {
                  const double g = norm(&in[in.size() - 3], 3);
                  return distance(got.data(), expected.data(), 6) / (scale(in, fibers) * g * g);
                });
    }
}

}  // namespace

template <class Real>
std::vector<TwinResult> compare_kernel_twins(const KernelTwins<Real>& twins, const KernelTwins<double>& reference) {
  Comparison<Real> c(twins, reference);
  compare_matrices(c, twins, reference);
  compare_materials(c, twins, reference);
  compare_fibers(c, twins, reference);
  compare_cells(c, twins, reference);
  for (auto& result : compare_node_kernels(twins)) c.all.push_back(std::move(result));
  return c.all;
}

template std::vector<TwinResult> compare_kernel_twins(const KernelTwins<float>&, const KernelTwins<double>&);
template std::vector<TwinResult> compare_kernel_twins(const KernelTwins<double>&, const KernelTwins<double>&);

}  // namespace lappet
