// Messages of the wire (PROTOCOL.md) to and from the values of session/program.h. Indices into the epoch and into the
// procedure are checked here, so that no index out of range ever reaches the solver.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "lattice/refused.h"
#include "server/message.h"
#include "session/program.h"

namespace lappet {

// What the indices of a frame may refer to.
struct FrameLimits {
  std::int32_t triangles = 0;   // of the epoch's surface
  std::int32_t sutures = 0;     // in the procedure
  std::int32_t retractors = 0;  // in the procedure
  std::int32_t materials = 1;   // of the session
};

struct Hello {
  std::string token;
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

// Where a reply belongs: the request's id and the session, 0 for none.
struct ReplyTo {
  std::uint64_t id = 0;
  std::uint64_t session = 0;
};

std::vector<PartBytes> encode_welcome(ReplyTo to, int threads, std::uint64_t max_message_bytes);
std::vector<PartBytes> encode_opened(ReplyTo to);
std::vector<PartBytes> encode_lattice(ReplyTo to, const EpochReport& report);
std::vector<PartBytes> encode_accepted(ReplyTo to);
std::vector<PartBytes> encode_pong(ReplyTo to);
std::vector<PartBytes> encode_progress(ReplyTo to, const Progress& progress);
std::vector<PartBytes> encode_frame(ReplyTo to, const FrameOutput& frame);
std::vector<PartBytes> encode_error(ReplyTo to, ErrorCode code, const std::string& sentence);

std::string_view error_name(ErrorCode code);  // as in PROTOCOL.md

}  // namespace lappet
