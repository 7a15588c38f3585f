// The settings of a daemon for several people (broker.h).
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "server/gate_limits.h"
#include "server/message.h"
#include "server/session_limits.h"

namespace lappet {

struct BrokerOptions {
  std::string address = "tcp://127.0.0.1:*";
  std::string keys;                                        // the folder
  SessionLimits limits{std::uint64_t{8} << 30, 0, 600.0};  // of a session, where the user's file says nothing else
  std::size_t max_sessions = 8;                            // of all users
  std::size_t sessions_per_user = 2;                       // likewise
  std::size_t connections_per_user = 8;
  std::uint64_t max_message_bytes = kDefaultMaxMessageBytes;
  std::uint64_t max_unread_bytes = std::uint64_t{64} << 20;  // of one connection, beyond one reply
  double messages_per_second = 200.0;                        // of one user
  GateLimits gate;
  std::chrono::milliseconds hello{5'000};  // from the handshake
  std::chrono::milliseconds silence{60'000};
  bool serves_one = false;  // a client's own: it ends with its standard input, its parent, or in silence
  int input = -1;           // a descriptor whose end of file ends a client's own
  int parent = 0;           // likewise
  int signals = -1;         // a descriptor that is readable when the daemon shall end
  bool verbose = false;
};

}  // namespace lappet
