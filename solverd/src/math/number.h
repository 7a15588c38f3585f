// `Number`: what a kernel computes with. A kernel is written once on Number, for float and double (here) and for SIMD
// batches of both (math/simd_number.h), which offer the same functions. A batch holds kLanes independent values.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

namespace lappet {

template <class Number>
struct NumberTraits {
  using Scalar = Number;
  using Mask = bool;
  static constexpr int kLanes = 1;
  // From and to kLanes consecutive values of any floating type.
  template <class From>
  static Number load(const From* from) {
    return Number(*from);
  }
  template <class To>
  static void store(Number value, To* to) {
    *to = static_cast<To>(value);
  }
  static Number rough_reciprocal(Number x) { return Number(1) / x; }
  static Number rough_reciprocal_sqrt(Number x) { return Number(1) / std::sqrt(x); }
  static Number reciprocal_sqrt(Number x) { return Number(1) / std::sqrt(x); }
};

template <class Number>
inline constexpr int kLanes = NumberTraits<Number>::kLanes;

template <class Number, class From>
inline Number load(const From* from) {
  return NumberTraits<Number>::load(from);
}
template <class Number, class To>
inline void store(const Number& value, To* to) {
  NumberTraits<Number>::store(value, to);
}

template <class Number>
inline Number select(bool condition, Number yes, Number no) {
  return condition ? yes : no;
}

// 1/x to a few digits, for iterations that correct it; 1/sqrt(x) to rounding, x > 0.
template <class Number>
inline Number rough_reciprocal(Number x) {
  return NumberTraits<Number>::rough_reciprocal(x);
}
template <class Number>
inline Number rough_reciprocal_sqrt(Number x) {
  return NumberTraits<Number>::rough_reciprocal_sqrt(x);
}
template <class Number>
inline Number reciprocal_sqrt(Number x) {
  return NumberTraits<Number>::reciprocal_sqrt(x);
}

template <class Number>
constexpr typename NumberTraits<Number>::Scalar tiny_number() {
  return std::numeric_limits<typename NumberTraits<Number>::Scalar>::min() * 16;
}

}  // namespace lappet
