// A `Number` that counts what is done with it: a kernel instantiated on it says how many operations it takes.
// Additions, multiplications, divisions, square roots, logarithms, minima and comparisons count 1 each; signs, choices
// and memory nothing. A fused multiply-add is two.
#pragma once
#include <cmath>
#include <cstdint>

#include "math/number.h"

namespace lappet {

template <class T>
struct Counted {
  static inline thread_local std::int64_t operations = 0;

  T value{};

  Counted() = default;
  template <class From>
    requires std::is_arithmetic_v<From>
  Counted(From from) : value(T(from)) {}

  friend Counted operator-(Counted a) { return -a.value; }
  friend Counted operator+(Counted a, Counted b) { return count(a.value + b.value); }
  friend Counted operator-(Counted a, Counted b) { return count(a.value - b.value); }
  friend Counted operator*(Counted a, Counted b) { return count(a.value * b.value); }
  friend Counted operator/(Counted a, Counted b) { return count(a.value / b.value); }
  friend Counted& operator+=(Counted& a, Counted b) { return a = a + b; }
  friend Counted& operator-=(Counted& a, Counted b) { return a = a - b; }
  friend Counted& operator*=(Counted& a, Counted b) { return a = a * b; }
  friend bool operator<(Counted a, Counted b) { return ++operations, a.value < b.value; }
  friend bool operator>(Counted a, Counted b) { return ++operations, a.value > b.value; }
  friend bool operator<=(Counted a, Counted b) { return ++operations, a.value <= b.value; }
  friend bool operator>=(Counted a, Counted b) { return ++operations, a.value >= b.value; }
  friend Counted sqrt(Counted a) { return count(std::sqrt(a.value)); }
  friend Counted log(Counted a) { return count(std::log(a.value)); }
  friend Counted exp(Counted a) { return count(std::exp(a.value)); }
  friend Counted abs(Counted a) { return std::abs(a.value); }
  friend Counted min(Counted a, Counted b) { return count(std::min(a.value, b.value)); }
  friend Counted max(Counted a, Counted b) { return count(std::max(a.value, b.value)); }

 private:
  static Counted count(T result) {
    ++operations;
    return result;
  }
};

template <class T>
struct NumberTraits<Counted<T>> {
  using Scalar = T;
  using Mask = bool;
  static constexpr int kLanes = 1;
  template <class From>
  static Counted<T> load(const From* from) {
    return T(*from);
  }
  template <class To>
  static void store(Counted<T> value, To* to) {
    *to = To(value.value);
  }
  static Counted<T> rough_reciprocal(Counted<T> x) { return Counted<T>(1) / x; }
  static Counted<T> rough_reciprocal_sqrt(Counted<T> x) { return Counted<T>(1) / sqrt(x); }
  static Counted<T> reciprocal_sqrt(Counted<T> x) { return Counted<T>(1) / sqrt(x); }
};

}  // namespace lappet
