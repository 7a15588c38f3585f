// The daemon with --keys, from its start to its end. Where a system has no broker (serve_users_windows.cpp) it refuses.
#pragma once
#include <functional>
#include <string>

#include "server/broker_options.h"

namespace lappet {

// Serves the users of the folder of keys; `say_where` is told the address once it listens. Returns why it ended.
// Signals that ask a program to end do. Throws RefusedError where it cannot start.
std::string serve_users(BrokerOptions options, const std::function<void(const std::string& endpoint)>& say_where);

}  // namespace lappet
