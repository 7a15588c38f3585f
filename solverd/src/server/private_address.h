// Addresses that others do not reach: whoever can reach the daemon can use this machine's processors and memory.
#pragma once
#include <string>

namespace lappet {

// Throws RefusedError(kInvalidInput) unless `address` is tcp://127.x.y.z:PORT or tcp://[::1]:PORT (PORT may be *), or
// ipc://FOLDER/NAME with a folder that only this user may enter: its own, of mode 0700, and no link.
void require_private(const std::string& address);

// Removes the socket of an ipc address, and its folder where nothing else is in it; does nothing for others.
void remove_socket(const std::string& address);

}  // namespace lappet
