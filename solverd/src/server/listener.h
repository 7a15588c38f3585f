// TCP sockets of the daemon's own: listening on a network and connecting to a local socket.
#pragma once
#include <string>

#include "server/descriptor.h"

namespace lappet {

struct Listener {
  Descriptor socket;
  std::string endpoint;  // tcp://HOST:PORT, with its port
};

// Listens on tcp://HOST:PORT: HOST a number or a name of this machine, [IPv6], or * for all; PORT may be * or 0 for a
// free one. Throws RefusedError(kInvalidInput) where it cannot.
Listener listen_on(const std::string& address);

struct Accepted {
  Descriptor socket;   // not open: nobody waits
  std::string source;  // the peer's address without its port; of IPv6 the network, /64
  bool full = false;   // this process, or the machine, has no descriptor left
};
Accepted accept_from(const Descriptor& listener);

// Connects to the socket at `path`. Not open: nobody listens there.
Descriptor connect_locally(const std::string& path);

}  // namespace lappet
