// lappet-solverd: the daemon. Options, logging and the exit status. Without keys it serves its own user (server.h),
// with keys several (serve_users.h).
#include <spdlog/cfg/env.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <string>

#include "math/instruction_set.h"
#include "platform/platform.h"
#include "server/broker_options.h"
#include "server/child_limits.h"
#include "server/private_address.h"
#include "server/serve_users.h"
#include "server/server.h"
#include "server/session_limits.h"
#include "server/version.h"
#include "session/session.h"

namespace lappet {
namespace {

constexpr double kGiB = 1024.0 * 1024.0 * 1024.0;

struct Options {
  ServerOptions server;
  BrokerOptions broker;
  double silence = 60.0;
  double memory_gib = 0.0;
  std::uint64_t memory_bytes = 0;    // the same for a session's process, to the byte
  std::uint64_t process_memory = 0;  // not 0: a broker started this process
  int threads = 0;
  double seconds = 0.0;
  bool verbose = false;
};

class SessionPort final : public SolverPort {
 public:
  explicit SessionPort(const SessionSettings& settings) : session_(settings) {}
  EpochReport set_epoch(const EpochInput& epoch, const std::atomic<bool>& cancel) override {
    return session_.set_epoch(epoch, cancel);
  }
  void set_state(const SolverState& state) override { session_.set_state(state); }
  FrameOutput solve(const FrameInput& frame, const ProgressCallback& progress,
                    const std::atomic<bool>& cancel) override {
    return session_.solve(frame, progress, cancel);
  }

 private:
  Session session_;
};

void say_where(const std::string& endpoint) {
  std::printf("listening %s\n", endpoint.c_str());
  std::fflush(stdout);
}

int serve(const Options& options) {
  const SessionLimits limits{options.memory_bytes, options.threads, options.seconds};
  Server server(options.server, [limits](const SessionSettings& settings) -> std::unique_ptr<SolverPort> {
    return std::make_unique<SessionPort>(within(settings, limits));
  });
  say_where(server.endpoint());
  const std::string reason = server.run();
  if (options.process_memory == 0) spdlog::warn("The daemon ends: {}.", reason);
  if (!server.stop_workers(std::chrono::seconds(2))) {
    spdlog::warn("A solve did not end within 2 s of being cancelled; the daemon ends without it.");
    remove_socket(server.endpoint());
    std::_Exit(0);
  }
  remove_socket(server.endpoint());
  return 0;
}

int serve_users_with(Options& options) {
  BrokerOptions& broker = options.broker;
  broker.address = options.server.address;
  if (options.memory_gib > 0.0) broker.limits.memory = options.memory_bytes;
  if (options.threads > 0) broker.limits.threads = options.threads;
  if (options.seconds > 0.0) broker.limits.seconds = options.seconds;
  broker.max_message_bytes = options.server.max_message_bytes;
  broker.silence = options.server.silence;
  broker.parent = options.server.parent;
  broker.serves_one = broker.parent != 0;
  broker.input = kStandardInput;
  broker.verbose = options.verbose;
  serve_users(broker, say_where);
  return 0;
}

void add_limits(CLI::App& app, Options& options) {
  app.add_option("--memory-gib", options.memory_gib, "Most memory of a session (with --keys 8, unless given)")
      ->check(CLI::Range(0.01, 65536.0));
  app.add_option("--threads", options.threads, "Most threads of a session (0: all)")->check(CLI::Range(0, 1024));
  app.add_option("--seconds", options.seconds,
                 "Most seconds of a frame; with --keys also of an epoch, and 600 unless given")
      ->check(CLI::Range(0.0, 1e6));
  // What a broker gives the processes that it starts.
  app.add_option("--memory-bytes", options.memory_bytes)->group("");
  app.add_option("--process-memory", options.process_memory)->group("");
  app.add_option("--first-session", options.server.first_session)->group("");
}

void add_broker_options(CLI::App& app, BrokerOptions& broker) {
  const std::string group = "With --keys";
  app.add_option("--keys", broker.keys, "The folder of the daemon's keys and its users'")->group(group);
  app.add_option("--max-sessions", broker.max_sessions, "Sessions at a time")
      ->capture_default_str()
      ->group(group)
      ->check(CLI::Range(std::size_t{1}, std::size_t{256}));
  app.add_option("--sessions", broker.sessions_per_user, "Sessions of one user at a time")
      ->capture_default_str()
      ->group(group)
      ->check(CLI::Range(std::size_t{0}, std::size_t{256}));
  app.add_option("--max-unread-bytes", broker.max_unread_bytes, "Unread replies of a client, beyond one")
      ->capture_default_str()
      ->group(group)
      ->check(CLI::Range(std::uint64_t{1} << 16, std::uint64_t{1} << 40));
  app.add_option("--messages-per-second", broker.messages_per_second, "Messages of one user that are read")
      ->capture_default_str()
      ->group(group)
      ->check(CLI::Range(1.0, 1e6));
  app.add_option("--handshakes-per-second", broker.gate.handshakes_per_second, "Handshakes with one address")
      ->capture_default_str()
      ->group(group)
      ->check(CLI::Range(1.0, 1e6));
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("--address,--listen", options.server.address,
                 "Where to listen: loopback, or ipc://FOLDER/NAME in a folder of mode 0700, removed when empty; with "
                 "--keys tcp://HOST:PORT")
      ->capture_default_str();
  app.add_option("--parent", options.server.parent, "End when the process with this id ends")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--silence", options.silence, "End after hearing nothing for so many seconds")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 1e6));
  app.add_option("--max-message-bytes", options.server.max_message_bytes, "Largest message that is read")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{1} << 16, std::uint64_t{1} << 40));
  app.add_option("--max-clients", options.server.max_clients, "Clients served at a time")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{1}, std::size_t{64}));
  add_limits(app, options);
  add_broker_options(app, options.broker);
  app.add_flag("--verbose", options.verbose, "Log every refused message");
  app.set_version_flag("--version", std::string(kVersion));
  app.footer(
      "Without --keys the token that clients must send is read from the environment variable LAPPET_TOKEN, and the\n"
      "daemon ends when its standard input closes; with --keys only where it has a --parent. Exit status: 0 done, 1\n"
      "refused to start or failed, 2 usage.");
}

void start_log(bool verbose) {
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("lappet-solverd", std::make_shared<spdlog::sinks::stderr_sink_mt>()));
  spdlog::set_pattern("%n: %l: %v");
  spdlog::set_level(verbose ? spdlog::level::info : spdlog::level::warn);
  spdlog::cfg::load_env_levels();  // SPDLOG_LEVEL=debug traces every Newton iteration
  spdlog::flush_on(spdlog::level::info);
}

}  // namespace
}  // namespace lappet

int main(int argc, char** argv) {
  lappet::return_large_blocks();
  CLI::App app("Solves the tissue mechanics of Lappet procedures for clients (PROTOCOL.md).", "lappet-solverd");
  lappet::Options options;
  lappet::add_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  lappet::survive_closed_pipes();  // a client that ends with our log pipe is seen on standard input
  lappet::start_log(options.verbose);
  try {
    lappet::ServerOptions& server = options.server;
    server.token = lappet::take_variable("LAPPET_TOKEN");
    server.input = lappet::kStandardInput;
    server.silence = std::chrono::milliseconds(static_cast<std::int64_t>(options.silence * 1000.0));
    if (options.memory_gib > 0.0) options.memory_bytes = static_cast<std::uint64_t>(options.memory_gib * lappet::kGiB);
    if (options.process_memory != 0) lappet::become_child_of(server.parent, options.process_memory);
    lappet::choose_instruction_set();  // a wrong LAPPET_ISA is refused before anybody waits
    return options.broker.keys.empty() ? lappet::serve(options) : lappet::serve_users_with(options);
  } catch (const std::exception& error) {
    spdlog::critical("{}", error.what());
  }
  return 1;
}
