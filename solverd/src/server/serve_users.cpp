#include "server/serve_users.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <future>
#include <memory>

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

// ZeroMQ waits for a connection that broke off with a message half sent and others unread, up to its next heartbeat
// (BrokerPeer's linger). Whoever it was has gone: nobody waits for that.
void end(std::unique_ptr<Broker> daemon) {
  constexpr std::chrono::seconds kPatience{2};
  const std::future<void> ended = std::async(std::launch::async, [&daemon] { daemon.reset(); });
  if (ended.wait_for(kPatience) == std::future_status::ready) return;
  spdlog::info("A connection that broke off is not waited for.");
  std::_Exit(0);
}

}  // namespace

void serve_users(BrokerOptions options, const std::function<void(const std::string& endpoint)>& say_where) {
  options.signals = catch_signals();
  share_descriptors(options.gate);
  auto daemon = std::make_unique<Broker>(options);
  say_where(daemon->endpoint());
  const std::string reason = daemon->run();
  spdlog::warn("The daemon ends: {}.", reason);
  end(std::move(daemon));
}

}  // namespace lappet
