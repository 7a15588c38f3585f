// Vector operations with a fixed order of summation, whatever the number of threads; dot products in double.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "math/parallel.h"

namespace lappet {

// The sum over i of `count` numbers that body(i, sums) adds to its argument; eight interleaved sums a chunk, so that
// additions do not wait for each other.
template <std::size_t Count, class Body>
std::array<double, Count> reduce(std::size_t size, const Body& body) {
  constexpr std::size_t kLanes = 8;
  std::vector<std::array<double, Count>> partial((size + 3 * kChunk - 1) / (3 * kChunk));
  for_each_chunk(
      size,
      [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        double sums[Count][kLanes] = {};
        std::size_t i = begin;
        for (; i + kLanes <= end; i += kLanes)
          for (std::size_t lane = 0; lane < kLanes; ++lane) {
            double value[Count];
            body(i + lane, value);
            for (std::size_t k = 0; k < Count; ++k) sums[k][lane] += value[k];
          }
        for (; i < end; ++i) {
          double value[Count];
          body(i, value);
          for (std::size_t k = 0; k < Count; ++k) sums[k][0] += value[k];
        }
        for (std::size_t k = 0; k < Count; ++k) {
          double sum = 0.0;
          for (const double s : sums[k]) sum += s;
          partial[chunk][k] = sum;
        }
      },
      3 * kChunk);
  std::array<double, Count> total{};
  for (const auto& sum : partial)
    for (std::size_t k = 0; k < Count; ++k) total[k] += sum[k];
  return total;
}

template <class Real>
double dot(std::span<const Real> a, std::span<const Real> b) {
  return reduce<1>(a.size(), [a = a.data(), b = b.data()](std::size_t i, double* out) {
    out[0] = static_cast<double>(a[i]) * static_cast<double>(b[i]);
  })[0];
}

template <class Real>
void copy(std::span<const Real> from, std::span<Real> to) {
  for_each_chunk(from.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    std::copy(from.begin() + static_cast<std::ptrdiff_t>(begin), from.begin() + static_cast<std::ptrdiff_t>(end),
              to.begin() + static_cast<std::ptrdiff_t>(begin));
  });
}

template <class Real>
double largest(std::span<const Real> a) {
  std::vector<double> most((a.size() + 3 * kChunk - 1) / (3 * kChunk), 0.0);
  for_each_chunk(
      a.size(),
      [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
          most[chunk] = std::max(most[chunk], std::abs(static_cast<double>(a[i])));
      },
      3 * kChunk);
  return most.empty() ? 0.0 : *std::ranges::max_element(most);
}

template <class Real>
void set_zero(std::span<Real> a) {
  for_each_index(a.size(), [a = a.data()](std::size_t i) { a[i] = Real(0); });
}

// y += a x
template <class Real>
void add(Real a, std::span<const Real> x, std::span<Real> y) {
  for_each_index(y.size(), [a, x = x.data(), y = y.data()](std::size_t i) { y[i] += a * x[i]; });
}

// y = a y + b x
template <class Real>
void combine(Real a, Real b, std::span<const Real> x, std::span<Real> y) {
  for_each_index(y.size(), [a, b, x = x.data(), y = y.data()](std::size_t i) { y[i] = a * y[i] + b * x[i]; });
}

}  // namespace lappet
