// A field on the nodes of a lattice, three numbers a node, read as vectors in double.
#pragma once
#include <cstddef>
#include <span>

#include "lattice/surface.h"

namespace lappet {

template <class Real>
class NodeField {
 public:
  explicit NodeField(std::span<const Real> values) : values_(values) {}
  std::size_t nodes() const { return values_.size() / 3; }
  Vec3 operator[](std::size_t node) const {
    const Real* v = &values_[3 * node];
    return {double(v[0]), double(v[1]), double(v[2])};
  }

 private:
  std::span<const Real> values_;
};

template <class Real>
NodeField(std::span<Real>) -> NodeField<std::remove_const_t<Real>>;

}  // namespace lappet
