// Only loopback addresses: whoever can reach the daemon can use this machine's processors and memory.
#pragma once
#include <string>

namespace lappet {

// Throws RefusedError(kInvalidInput) unless `address` is tcp://127.x.y.z:PORT or tcp://[::1]:PORT (PORT may be *).
void require_loopback(const std::string& address);

}  // namespace lappet
