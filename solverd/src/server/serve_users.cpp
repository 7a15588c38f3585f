#include "server/serve_users.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>

#include "server/broker.h"

namespace lappet {
namespace {

std::array<int, 2> signal_pipe = {-1, -1};

void on_signal(int) {
  const int error = errno;
  const char byte = 0;
  static_cast<void>(!::write(signal_pipe[1], &byte, 1));
  errno = error;
}

// A descriptor that can be read when somebody wants the program to end.
int catch_signals() {
  if (::pipe(signal_pipe.data()) != 0) return -1;
  for (const int end : signal_pipe) {
    ::fcntl(end, F_SETFD, FD_CLOEXEC);
    ::fcntl(end, F_SETFL, O_NONBLOCK);
  }
  struct sigaction action{};
  action.sa_handler = on_signal;
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) ::sigaction(signal, &action, nullptr);
  return signal_pipe[0];
}

// As many descriptors as the connections can take, and no more connections than there are descriptors for: a third of
// them for peers that are not known.
void share_descriptors(GateLimits& gate) {
  constexpr rlim_t kWanted = 8192, kOwn = 64, kOfConnection = 6;  // and of its session
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  if (limit.rlim_cur < kWanted) {
    limit.rlim_cur = std::min(kWanted, limit.rlim_max);
    ::setrlimit(RLIMIT_NOFILE, &limit);
  }
  const rlim_t connections = std::max<rlim_t>(limit.rlim_cur, 2 * kOwn) / kOfConnection - kOwn / kOfConnection;
  gate.unknown = std::min<rlim_t>(gate.unknown, connections / 3);
  gate.known = std::min<rlim_t>(gate.known, connections - gate.unknown);
}

}  // namespace

std::string serve_users(BrokerOptions options, const std::function<void(const std::string& endpoint)>& say_where) {
  options.signals = catch_signals();
  share_descriptors(options.gate);
  Broker daemon(options);
  say_where(daemon.endpoint());
  return daemon.run();
}

}  // namespace lappet
