// What the kernels are tried on: random, near-singular, inverted, tiny, with repeated singular values; the same every
// time.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace lappet {

using Values = std::vector<double>;

inline double norm(const double* from, std::size_t count) {
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += from[i] * from[i];
  return std::sqrt(sum);
}

class Random {
 public:
  double uniform(double low, double high) { return low + (high - low) * unit_(engine_); }
  double normal() { return normal_(engine_); }
  Values normals(std::size_t count) {
    Values values(count);
    for (double& value : values) value = normal();
    return values;
  }
  std::array<double, 9> rotation() {
    double q[4];
    for (double& value : q) value = normal();
    const double length = norm(q, 4);
    for (double& value : q) value /= length;
    std::array<double, 9> r{};
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    r = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
         2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
         2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    return r;
  }
  // Singular values in the order of svd3: every kind that a cell may have.
  std::array<double, 3> stretches(int kind) {
    std::array<double, 3> s = {uniform(0.3, 2.0), uniform(0.3, 2.0), uniform(0.3, 2.0)};
    switch (kind % 12) {
      case 0:
        s = {1, 1, 1};
        break;
      case 1:
        s = {1 + 1e-3 * normal(), 1 + 1e-3 * normal(), 1 + 1e-3 * normal()};
        break;
      case 2:
        s[1] = s[0];
        break;
      case 3:
        s[2] = s[1];
        break;
      case 4:
        s[1] = s[2] = s[0];
        break;
      case 5:
        s[2] *= 1e-6 * normal();
        break;
      case 6:
        s[1] *= 1e-5, s[2] *= 1e-6;
        break;
      case 7:
        s[2] = 0;
        break;
      case 8:
        s[2] = -s[2];
        break;
      case 9:
        s[0] *= 4, s[2] *= -0.2;
        break;
      case 10:
        s = {s[0] * 1e-4, s[1] * 1e-4, s[2] * 1e-4};
        break;
      default:
        break;
    }
    std::sort(s.begin(), s.end(), [](double a, double b) { return std::abs(a) > std::abs(b); });
    const bool inverted = s[0] * s[1] * s[2] < 0;
    for (double& value : s) value = std::abs(value);
    if (inverted) s[2] = -s[2];
    return s;
  }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }

 private:
  std::mt19937 engine_{20240611};
  std::uniform_real_distribution<double> unit_{0.0, 1.0};
  std::normal_distribution<double> normal_;
};

inline std::vector<Values> deformation_gradients(Random& random) {
  std::vector<Values> all;
  for (int k = 0; k < 4000; ++k) {
    Values f(9);
    const auto u = random.rotation(), v = random.rotation();
    const auto s = random.stretches(k);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t a = 0; a < 3; ++a) f[3 * i + j] += u[3 * i + a] * s[a] * v[3 * j + a];
    if (k % 7 == 0) f = random.normals(9);
    if (k % 7 == 1)  // rank one
      for (std::size_t i = 0; i < 9; ++i) f[i] = u[i / 3] * v[i % 3];
    if (k % 7 == 2)  // axes of its own: zeros, and exactly repeated values
      for (std::size_t i = 0; i < 9; ++i) f[i] = i % 4 == 0 ? s[i / 4] : 0.0;
    if (k % 7 == 3)  // a shear that Jacobi rotations see late
      f = {1, random.normal() * 1e-4, random.normal() * 30, 0, 1, random.normal(), 0, 0, random.log_uniform(1e-6, 1)};
    if (k % 5 == 4) {  // tiny
      const double scale = random.log_uniform(1e-16, 1e-2);
      for (double& value : f) value *= scale;
    }
    all.push_back(f);
  }
  all.push_back(Values(9, 0.0));
  all.push_back({-1, 0, 0, 0, -1, 0, 0, 0, -1});
  all.push_back({0, 0, 1, 1, 0, 0, 0, 1, 0});
  all.push_back(Values(9, 1.0));
  return all;
}

inline std::vector<Values> symmetric_matrices(Random& random) {
  std::vector<Values> all;
  for (int k = 0; k < 3000; ++k) {
    Values a(6);
    const auto v = random.rotation();
    Values values = random.normals(3);
    if (k % 5 == 1) values[1] = values[0];
    if (k % 5 == 2) values[2] = values[1] = values[0];
    if (k % 5 == 3) values[0] *= 1e5;
    if (k % 5 == 4) values[2] *= 1e-6;
    if (k % 3 == 0)
      for (double& value : values) value *= random.log_uniform(1e-4, 1e6);
    std::size_t entry = 0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = i; j < 3; ++j, ++entry)
        for (std::size_t m = 0; m < 3; ++m) a[entry] += v[3 * i + m] * values[m] * v[3 * j + m];
    if (k % 11 == 0) a[1] = a[2] = a[4] = 0;
    all.push_back(a);
  }
  all.push_back(Values(6, 0.0));
  return all;
}

}  // namespace lappet
