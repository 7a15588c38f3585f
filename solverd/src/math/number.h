// The scalar face of `Number`: what every kernel may call, for float and double. A SIMD type offers the same functions,
// so that a kernel is written once.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

namespace lappet {

template <class Number>
struct NumberTraits {
  using Scalar = Number;
  using Mask = bool;
};

template <class Number>
inline Number select(bool condition, Number yes, Number no) {
  return condition ? yes : no;
}

template <class Number>
constexpr typename NumberTraits<Number>::Scalar tiny_number() {
  return std::numeric_limits<typename NumberTraits<Number>::Scalar>::min() * 16;
}

}  // namespace lappet
