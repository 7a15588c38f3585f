#include "server/solver_process.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <random>
#include <string_view>
#include <utility>
#include <vector>

#include "lattice/refused.h"
#include "server/child_limits.h"
#include "server/message.h"
#include "server/private_address.h"
#include "server/program_path.h"

extern char** environ;

namespace lappet {
namespace {

constexpr int kReconnect = 5;  // ms, until its socket is there
constexpr int kLinger = 1000;  // ms

[[noreturn]] void fail(const std::string& what) {
  throw RefusedError(ErrorCode::kInternal,
                     "A solver's process cannot be started: " + what + ": " + std::strerror(errno) + ".");
}

struct Pipe {
  Descriptor read, write;
};

Pipe make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) fail("a pipe");
  for (const int end : ends) ::fcntl(end, F_SETFD, FD_CLOEXEC);
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

std::string random_token() {
  std::random_device source;
  std::string token;
  for (int i = 0; i < 4; ++i) {
    std::array<char, 9> digits{};
    std::to_chars(digits.data(), digits.data() + digits.size(), source() | 0x10000000U, 16);
    token += digits.data();
  }
  return token;
}

std::vector<std::string> arguments_of(const SolverProcessOptions& options) {
  const SessionLimits& limits = options.limits;
  std::vector<std::string> arguments = {
      "lappet-solverd",
      "--address",
      "ipc://" + options.folder + "/socket",
      "--parent",
      std::to_string(::getpid()),
      "--max-clients",
      "1",
      "--silence",
      "1000000",
      "--max-message-bytes",
      std::to_string(options.max_message_bytes),
      "--first-session",
      std::to_string(options.session),
      "--memory-bytes",
      std::to_string(limits.memory),
      "--threads",
      std::to_string(limits.threads),
      "--seconds",
      std::to_string(limits.seconds),
      "--process-memory",
      std::to_string(process_memory(limits.memory, options.max_message_bytes, limits.threads))};
  if (options.verbose) arguments.emplace_back("--verbose");
  return arguments;
}

// Everything but the token, which is the child's own.
std::vector<std::string> environment_with(const std::string& token) {
  constexpr std::string_view kToken = "LAPPET_TOKEN=";
  std::vector<std::string> environment;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!std::string_view(*entry).starts_with(kToken)) environment.emplace_back(*entry);
  }
  environment.push_back(std::string(kToken) + token);
  return environment;
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

// In the child, between fork and exec: nothing but calls that a signal handler may make.
[[noreturn]] void become(const char* program, char* const* arguments, char* const* environment, int input, int output) {
  if (::dup2(input, STDIN_FILENO) < 0 || ::dup2(output, STDOUT_FILENO) < 0) ::_exit(126);
  sigset_t none;
  sigemptyset(&none);  // a macro on macOS
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::execve(program, arguments, environment);
  ::_exit(127);
}

}  // namespace

SolverProcess::SolverProcess(zmq::context_t& context, const SolverProcessOptions& options)
    : folder_(options.folder), socket_(context, zmq::socket_type::dealer) {
  if (::mkdir(folder_.c_str(), S_IRWXU) != 0) fail("its folder");
  const std::string token = random_token();
  socket_.set(zmq::sockopt::linger, kLinger);  // not 0, as in broker_peer.cpp
  socket_.set(zmq::sockopt::reconnect_ivl, kReconnect);
  socket_.set(zmq::sockopt::maxmsgsize, std::int64_t{-1});  // it is our own
  start(options, token);
  socket_.connect("ipc://" + folder_ + "/socket");
  const std::vector<PartBytes> hello =
      MessageWriter("hello", 0).field("token", token).field("client", std::string("broker")).finish();
  socket_.send(zmq::buffer(hello.front()), zmq::send_flags::dontwait);
}

SolverProcess::~SolverProcess() {
  kill();
  while (!reaped()) ::usleep(2000);
}

void SolverProcess::start(const SolverProcessOptions& options, const std::string& token) {
  Pipe input = make_pipe();
  Pipe output = make_pipe();
  std::vector<std::string> arguments = arguments_of(options);
  std::vector<std::string> environment = environment_with(token);
  const std::vector<char*> argument_pointers = pointers_to(arguments);
  const std::vector<char*> environment_pointers = pointers_to(environment);
  const std::string program = program_path();
  pid_ = ::fork();
  if (pid_ == 0) {
    become(program.c_str(), argument_pointers.data(), environment_pointers.data(), input.read.get(),
           output.write.get());
  }
  if (pid_ < 0) {
    gone_ = true;
    ::rmdir(folder_.c_str());
    fail("fork");
  }
  input_ = std::move(input.write);
  life_ = std::move(output.read);
  ::fcntl(life_.get(), F_SETFL, O_NONBLOCK);
}

bool SolverProcess::lives() {
  std::array<char, 256> ignored{};  // "listening ..."
  while (life_.open()) {
    const ssize_t count = ::read(life_.get(), ignored.data(), ignored.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return true;
    if (count <= 0) life_.close();
  }
  return false;
}

void SolverProcess::kill() {
  if (!gone_) ::kill(pid_, SIGKILL);
}

bool SolverProcess::reaped() {
  if (gone_) return true;
  int status = 0;
  const pid_t found = ::waitpid(pid_, &status, WNOHANG);
  if (found == 0 || (found < 0 && errno == EINTR)) return false;
  gone_ = true;
  remove_socket("ipc://" + folder_ + "/socket");
  if (found < 0) {
    end_.how = "ended";
  } else if (WIFSIGNALED(status)) {
    end_.killed = WTERMSIG(status) == SIGKILL;
    end_.how = "was ended by signal " + std::to_string(WTERMSIG(status)) + " (" + ::strsignal(WTERMSIG(status)) + ")";
  } else {
    end_.how = "ended with status " + std::to_string(WEXITSTATUS(status));
  }
  return true;
}

}  // namespace lappet
