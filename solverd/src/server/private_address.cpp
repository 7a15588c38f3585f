#include "server/private_address.h"

#include <algorithm>
#include <string_view>

#include "lattice/refused.h"
#include "platform/platform.h"
#include "server/fields.h"

namespace lappet {
namespace {

bool is_loopback_host(const std::string& host) { return is_loopback_number(host) || host == "[::1]"; }

bool is_port(std::string_view port) {
  if (port == "*") return true;
  return !port.empty() && port.size() <= 5 && std::ranges::all_of(port, [](char c) { return c >= '0' && c <= '9'; }) &&
         std::stoi(std::string(port)) <= 65535;
}

// The folder that holds the socket of an ipc address; empty for other addresses.
std::string folder_of(const std::string& address) {
  constexpr std::string_view kScheme = "ipc://";
  const std::size_t slash = address.rfind('/');
  if (!address.starts_with(kScheme) || slash <= kScheme.size() || slash + 1 == address.size()) return {};
  return address.substr(kScheme.size(), slash - kScheme.size());
}

}  // namespace

void remove_socket(const std::string& address) {
  const std::string folder = folder_of(address);
  if (folder.empty()) return;
  remove_socket_at(folder + address.substr(address.rfind('/')), folder);
}

void require_private(const std::string& address) {
  if (is_users_alone(folder_of(address))) return;
  constexpr std::string_view kScheme = "tcp://";
  const std::size_t colon = address.rfind(':');
  if (address.starts_with(kScheme) && colon > kScheme.size() && colon != std::string::npos) {
    const std::string host = address.substr(kScheme.size(), colon - kScheme.size());
    if (is_loopback_host(host) && is_port(std::string_view(address).substr(colon + 1))) return;
  }
  throw RefusedError(ErrorCode::kInvalidInput, "The daemon does not listen on " + in_quotes(address) +
                                                   ": only loopback is served, and sockets in a folder of your own "
                                                   "with mode 0700; use tcp://127.0.0.1:* or ipc://FOLDER/NAME.");
}

}  // namespace lappet
