// What one session may take at most, whatever its client asks for.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "session/program.h"

namespace lappet {

struct SessionLimits {
  std::uint64_t memory = 0;  // bytes, 0: what the client says
  int threads = 0;           // 0: all of the machine
  double seconds = 0.0;      // of one frame, 0: no limit
};

// The settings within the limits.
inline SessionSettings within(SessionSettings settings, const SessionLimits& limits) {
  if (limits.memory != 0) settings.memory_budget = std::min<std::size_t>(settings.memory_budget, limits.memory);
  if (limits.threads != 0 && (settings.threads == 0 || settings.threads > limits.threads)) {
    settings.threads = limits.threads;
  }
  if (limits.seconds != 0.0 && (settings.time_budget == 0.0 || settings.time_budget > limits.seconds)) {
    settings.time_budget = limits.seconds;
  }
  return settings;
}

}  // namespace lappet
