// What the daemon does with the messages of one client, without sockets and threads: every message is decoded, answered
// by a session, and its reply written. It must be a reply of PROTOCOL.md that a client can read: what is not is a
// `Finding`.
#pragma once
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "conversation.h"
#include "session/session.h"

namespace lappet {

// A fault of the daemon; the sentence says which. Faults that sanitizers and assertions see end the program.
class Finding : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Replay {
 public:
  // The parts of the reply. Throws Finding.
  std::vector<PartBytes> play(const RawMessage& message);

 private:
  std::vector<PartBytes> answer(const RawMessage& message);
  std::vector<PartBytes> answer_bare(const Header& header, std::span<const std::span<const std::byte>> arrays);
  std::vector<PartBytes> work(const Header& header, std::span<const std::span<const std::byte>> arrays);

  std::unique_ptr<Session> session_;
  SessionSettings settings_;
  std::optional<std::int32_t> epoch_triangles_;
};

// Decodes a message, and checks what it says, against a session that has everything; solves nothing. Throws Finding.
void decode_alone(const RawMessage& message);

}  // namespace lappet
