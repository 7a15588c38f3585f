#include "server/listener.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string_view>

#include "lattice/refused.h"
#include "server/fields.h"

namespace lappet {
namespace {

constexpr int kBacklog = 512;

// Never inherited by a child, never waits.
void prepare(int socket) {
  ::fcntl(socket, F_SETFD, FD_CLOEXEC);
  ::fcntl(socket, F_SETFL, ::fcntl(socket, F_GETFL) | O_NONBLOCK);
}

void set_option(int socket, int level, int option) {
  const int on = 1;
  ::setsockopt(socket, level, option, &on, sizeof on);
}

// Of an IPv6 address: whoever has one has the other 2^64 of its network too.
void keep_network(in6_addr& address) {
  constexpr std::size_t kNetworkBytes = 8;
  if (IN6_IS_ADDR_V4MAPPED(&address)) return;
  std::memset(address.s6_addr + kNetworkBytes, 0, sizeof address.s6_addr - kNetworkBytes);
}

std::string numeric(const sockaddr_storage& address, socklen_t length, std::string* port) {
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> service{};
  if (::getnameinfo(reinterpret_cast<const sockaddr*>(&address), length, host.data(), host.size(), service.data(),
                    service.size(), NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return {};
  }
  if (port != nullptr) *port = service.data();
  return host.data();
}

}  // namespace

Listener listen_on(const std::string& address) {
  constexpr std::string_view kScheme = "tcp://";
  const auto fail = [&](const std::string& why) {
    refuse("The daemon cannot listen on " + in_quotes(address) + ": " + why + ".");
  };
  const std::size_t colon = address.rfind(':');
  if (!address.starts_with(kScheme) || colon == std::string::npos || colon <= kScheme.size()) {
    fail("give tcp://HOST:PORT");
  }
  std::string host = address.substr(kScheme.size(), colon - kScheme.size());
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  const std::string port = address.substr(colon + 1) == "*" ? "0" : address.substr(colon + 1);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  if (host == "*") hints.ai_family = AF_INET;
  addrinfo* list = nullptr;
  if (const int error = ::getaddrinfo(host == "*" ? nullptr : host.c_str(), port.c_str(), &hints, &list); error != 0) {
    fail(::gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> found(list, ::freeaddrinfo);
  Descriptor socket(::socket(found->ai_family, SOCK_STREAM, 0));
  if (!socket.open()) fail(std::strerror(errno));
  prepare(socket.get());
  set_option(socket.get(), SOL_SOCKET, SO_REUSEADDR);
  if (::bind(socket.get(), found->ai_addr, found->ai_addrlen) != 0 || ::listen(socket.get(), kBacklog) != 0) {
    fail(std::strerror(errno));
  }
  sockaddr_storage bound{};
  socklen_t length = sizeof bound;
  std::string bound_port;
  if (::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&bound), &length) != 0) fail(std::strerror(errno));
  const std::string bound_host = numeric(bound, length, &bound_port);
  const bool v6 = bound.ss_family == AF_INET6;
  return {std::move(socket), std::string(kScheme) + (v6 ? "[" + bound_host + "]" : bound_host) + ":" + bound_port};
}

Accepted accept_from(const Descriptor& listener) {
  sockaddr_storage peer{};
  socklen_t length = sizeof peer;
  Accepted accepted;
  accepted.socket = Descriptor(::accept(listener.get(), reinterpret_cast<sockaddr*>(&peer), &length));
  if (!accepted.socket.open()) {
    accepted.full = errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM;
    return accepted;
  }
  prepare(accepted.socket.get());
  set_option(accepted.socket.get(), IPPROTO_TCP, TCP_NODELAY);
  set_option(accepted.socket.get(), SOL_SOCKET, SO_KEEPALIVE);
  if (peer.ss_family == AF_INET6) keep_network(reinterpret_cast<sockaddr_in6&>(peer).sin6_addr);
  accepted.source = numeric(peer, length, nullptr);
  return accepted;
}

Descriptor connect_locally(const std::string& path) {
  sockaddr_un address{};
  if (path.size() >= sizeof address.sun_path) return Descriptor();
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.c_str(), path.size());
  Descriptor socket(::socket(AF_UNIX, SOCK_STREAM, 0));
  if (!socket.open()) return socket;
  prepare(socket.get());
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) socket.close();
  return socket;
}

}  // namespace lappet
