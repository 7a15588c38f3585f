// lappet-solverd: the daemon. Options, logging and the exit status; everything else is in server.h.
#include <spdlog/cfg/env.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <string>

#include "math/instruction_set.h"
#include "server/private_address.h"
#include "server/server.h"
#include "server/version.h"
#include "session/process_memory.h"
#include "session/session.h"

namespace lappet {
namespace {

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

int serve(ServerOptions options) {
  choose_instruction_set();  // a wrong LAPPET_ISA is refused before anybody waits
  Server server(std::move(options), [](const SessionSettings& settings) -> std::unique_ptr<SolverPort> {
    return std::make_unique<SessionPort>(settings);
  });
  std::printf("listening %s\n", server.endpoint().c_str());
  std::fflush(stdout);
  const std::string reason = server.run();
  spdlog::warn("The daemon ends: {}.", reason);
  if (!server.stop_workers(std::chrono::seconds(2))) {
    spdlog::warn("A solve did not end within 2 s of being cancelled; the daemon ends without it.");
    remove_socket(server.endpoint());
    std::_Exit(0);
  }
  remove_socket(server.endpoint());
  return 0;
}

}  // namespace
}  // namespace lappet

int main(int argc, char** argv) {
  lappet::return_large_blocks();
  CLI::App app("Solves the tissue mechanics of Lappet procedures for clients on this machine (PROTOCOL.md).",
               "lappet-solverd");
  lappet::ServerOptions options;
  double silence = 60.0;
  bool verbose = false;
  app.add_option("--address", options.address,
                 "Where to listen: loopback, or ipc://FOLDER/NAME in a folder of mode 0700, removed when empty")
      ->capture_default_str();
  app.add_option("--parent", options.parent, "End when the process with this id ends")->check(CLI::NonNegativeNumber);
  app.add_option("--silence", silence, "End after hearing nothing for so many seconds")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 1e6));
  app.add_option("--max-message-bytes", options.max_message_bytes, "Largest message that is read")
      ->capture_default_str()
      ->check(CLI::Range(std::uint64_t{1} << 16, std::uint64_t{1} << 40));
  app.add_option("--max-clients", options.max_clients, "Clients served at a time")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{1}, std::size_t{64}));
  app.add_flag("--verbose", verbose, "Log every refused message");
  app.set_version_flag("--version", std::string(lappet::kVersion));
  app.footer(
      "The token that clients must send is read from the environment variable LAPPET_TOKEN. The daemon ends when\n"
      "its standard input closes. Exit status: 0 done, 1 refused to start or failed, 2 usage.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  std::signal(SIGPIPE, SIG_IGN);  // a client that ends with our log pipe is seen on standard input
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("lappet-solverd", std::make_shared<spdlog::sinks::stderr_sink_mt>()));
  spdlog::set_pattern("%n: %l: %v");
  spdlog::set_level(verbose ? spdlog::level::info : spdlog::level::warn);
  spdlog::cfg::load_env_levels();  // SPDLOG_LEVEL=debug traces every Newton iteration
  spdlog::flush_on(spdlog::level::info);

  try {
    if (const char* token = std::getenv("LAPPET_TOKEN")) options.token = token;
    ::unsetenv("LAPPET_TOKEN");
    options.input = STDIN_FILENO;
    options.silence = std::chrono::milliseconds(static_cast<std::int64_t>(silence * 1000.0));
    return lappet::serve(std::move(options));
  } catch (const std::exception& error) {
    spdlog::critical("{}", error.what());
  }
  return 1;
}
