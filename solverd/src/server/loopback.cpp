#include "server/loopback.h"

#include <arpa/inet.h>

#include <algorithm>
#include <string_view>

#include "lattice/refused.h"
#include "server/fields.h"

namespace lappet {
namespace {

bool is_loopback_host(const std::string& host) {
  in_addr v4{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return (ntohl(v4.s_addr) >> 24) == 127;
  return host == "[::1]";
}

bool is_port(std::string_view port) {
  if (port == "*") return true;
  return !port.empty() && port.size() <= 5 && std::ranges::all_of(port, [](char c) { return c >= '0' && c <= '9'; }) &&
         std::stoi(std::string(port)) <= 65535;
}

}  // namespace

void require_loopback(const std::string& address) {
  constexpr std::string_view kScheme = "tcp://";
  const std::size_t colon = address.rfind(':');
  if (address.starts_with(kScheme) && colon > kScheme.size() && colon != std::string::npos) {
    const std::string host = address.substr(kScheme.size(), colon - kScheme.size());
    if (is_loopback_host(host) && is_port(std::string_view(address).substr(colon + 1))) return;
  }
  throw RefusedError(ErrorCode::kInvalidInput, "The daemon does not listen on " + in_quotes(address) +
                                                   ": only loopback is served; use tcp://127.0.0.1:* or "
                                                   "tcp://127.0.0.1:PORT.");
}

}  // namespace lappet
