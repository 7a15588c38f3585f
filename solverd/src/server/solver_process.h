// The process that solves one session: this program once more, on a socket in a private folder, with a token of its
// own. It ends with this object, with the broker, or by itself.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <string>
#include <zmq.hpp>

#include "server/descriptor.h"
#include "server/session_limits.h"

namespace lappet {

struct SolverProcessOptions {
  std::string folder;  // a new one of mode 0700; removed with the process
  SessionLimits limits;
  std::uint64_t max_message_bytes = 0;
  std::uint64_t session = 1;  // the number that its first `open` gives
  bool verbose = false;
};

// How a process ended, as a sentence goes on after "it".
struct ProcessEnd {
  bool killed = false;  // by SIGKILL, as the system does where memory is spent
  std::string how;
};

class SolverProcess {
 public:
  // Starts it and says hello. Throws RefusedError(kInternal) where it cannot.
  SolverProcess(zmq::context_t& context, const SolverProcessOptions& options);
  ~SolverProcess();  // kills it
  SolverProcess(const SolverProcess&) = delete;
  SolverProcess& operator=(const SolverProcess&) = delete;

  zmq::socket_t& socket() { return socket_; }  // DEALER; its first reply is the `welcome`
  int life() const { return life_.get(); }     // readable when the process says something, or has ended
  pid_t pid() const { return pid_; }

  // Reads what it says. False: it has ended.
  bool lives();
  void kill();
  // Whether it is gone and its end known; `end` says how.
  bool reaped();
  const ProcessEnd& end() const { return end_; }

 private:
  void start(const SolverProcessOptions& options, const std::string& token);

  const std::string folder_;
  zmq::socket_t socket_;
  Descriptor life_, input_;  // its standard output, and the end of its standard input that is kept open
  pid_t pid_ = 0;
  bool gone_ = false;
  ProcessEnd end_;
};

}  // namespace lappet
