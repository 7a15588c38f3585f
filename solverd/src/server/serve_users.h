// The daemon with --keys, from its start to its end. Where a system has no broker (serve_users_windows.cpp) it refuses.
#pragma once
#include <functional>
#include <string>

#include "server/broker_options.h"

namespace lappet {

// Serves the users of the folder of keys; `say_where` is told the address once it listens. Signals that ask a program
// to end do, and the log says why it ended. Where a connection that broke off would hold that up it ends the process
// with status 0. Throws RefusedError where it cannot start.
void serve_users(BrokerOptions options, const std::function<void(const std::string& endpoint)>& say_where);

}  // namespace lappet
