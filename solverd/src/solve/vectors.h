// Vector operations with a fixed order of summation, whatever the number of threads; dot products in double.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "math/parallel.h"

namespace lappet {

template <class Real>
double dot(std::span<const Real> a, std::span<const Real> b) {
  std::vector<double> partial((a.size() + kChunk - 1) / kChunk);
  for_each_chunk(a.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
    partial[chunk] = sum;
  });
  double total = 0.0;
  for (const double sum : partial) total += sum;
  return total;
}

template <class Real>
void copy(std::span<const Real> from, std::span<Real> to) {
  std::copy(from.begin(), from.end(), to.begin());
}

template <class Real>
void scale(Real factor, std::span<Real> y) {
  for_each_index(y.size(), [&](std::size_t i) { y[i] *= factor; });
}

template <class Real>
double largest(std::span<const Real> a) {
  double most = 0.0;
  for (const Real x : a) most = std::max(most, std::abs(static_cast<double>(x)));
  return most;
}

// y += a x
template <class Real>
void add(Real a, std::span<const Real> x, std::span<Real> y) {
  for_each_index(y.size(), [&](std::size_t i) { y[i] += a * x[i]; });
}

// y = a y + b x
template <class Real>
void combine(Real a, Real b, std::span<const Real> x, std::span<Real> y) {
  for_each_index(y.size(), [&](std::size_t i) { y[i] = a * y[i] + b * x[i]; });
}

}  // namespace lappet
