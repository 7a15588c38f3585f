// Values of session/program.h to the replies of the wire (PROTOCOL.md).
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lattice/refused.h"
#include "server/message.h"
#include "session/program.h"

namespace lappet {

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
