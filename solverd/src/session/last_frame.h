// The frame solved last, for the next one: where neither constraints nor tissue moved, all that it said holds on.
#pragma once
#include <optional>

#include "session/program.h"
#include "solve/newton/equilibrium.h"

namespace lappet {

class LastFrame {
 public:
  // What it left is no longer the state that the next frame starts from.
  void clear() { fields_.reset(); }
  void keep(const FrameInput& frame, const FrameFields& fields, const Arrival& arrival) {
    frame_ = frame;
    fields_ = fields;
    arrival_ = arrival;
  }
  // What it said, if `frame` asks for the same; else null.
  const FrameFields* of(FrameInput frame) const {
    frame.time = frame_.time;
    return fields_ && frame == frame_ ? &*fields_ : nullptr;
  }
  // Where its search ended, likewise.
  std::optional<Arrival> arrival_of(const FrameInput& frame) const {
    return of(frame) ? std::optional(arrival_) : std::nullopt;
  }

 private:
  FrameInput frame_;
  std::optional<FrameFields> fields_;
  Arrival arrival_;
};

}  // namespace lappet
