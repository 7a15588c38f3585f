// Messages of the wire (PROTOCOL.md) to the values of session/program.h. Indices into the epoch and into the procedure
// are checked here, so that no index out of range ever reaches the solver.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "server/message.h"
#include "session/program.h"

namespace lappet {

// What the indices of a frame may refer to.
struct FrameLimits {
  std::int32_t triangles = 0;   // of the epoch's surface
  std::int32_t sutures = 0;     // in the procedure
  std::int32_t retractors = 0;  // in the procedure
  std::int32_t materials = 1;   // of the session
  std::int32_t bones = 0;       // of the session, that move
};

struct Hello {
  std::string token;  // empty where it has none: users have keys
  std::string client;
};

using ArrayParts = std::span<const std::span<const std::byte>>;

Hello decode_hello(const Header& header, ArrayParts parts);
SessionSettings decode_open(const Header& header, ArrayParts parts);
EpochInput decode_epoch(const Header& header, ArrayParts parts, std::int32_t retractors, std::int32_t materials);
SolverState decode_state(const Header& header, ArrayParts parts, std::int32_t sutures, std::int32_t materials);
FrameInput decode_solve(const Header& header, ArrayParts parts, const FrameLimits& limits);
// For messages without fields and arrays: refuses any.
void decode_bare(const Header& header, ArrayParts parts);

}  // namespace lappet
