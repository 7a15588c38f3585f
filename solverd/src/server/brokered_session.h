// One session behind the broker: its process, what of the client's messages it has not answered, and how long it takes.
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "lattice/refused.h"
#include "server/message.h"
#include "server/solver_process.h"

namespace lappet {

class BrokeredSession {
 public:
  using Clock = std::chrono::steady_clock;
  using Parts = std::vector<zmq::message_t>;  // header, arrays

  struct Reply {
    Parts parts;
    bool progress = false;
    std::optional<Header> shown;  // the header of what those who follow the session see too
  };

  BrokeredSession(zmq::context_t& context, const SolverProcessOptions& options, std::string user);

  SolverProcess& process() { return process_; }
  // The number that `opened` gave; nothing before and after.
  std::optional<std::uint64_t> number() const { return number_; }
  // Whether every user may follow it.
  bool shared = false;

  // Hands a message on. Throws RefusedError(kOutOfOrder) when too many, or too large ones, wait already.
  void forward(const Header& header, Parts message);
  // Cancels the epochs and solves that came before.
  void cancel();
  // The next reply for the client, if there is one. Throws RefusedError(kInternal) for what is no reply.
  std::optional<Reply> receive();
  // The process holds no session and has nothing to do: it may end.
  bool over() const { return !number_ && waiting_.empty(); }
  // The ids of the messages that were not answered.
  std::vector<std::uint64_t> unanswered() const;

  // Cancels what takes longer than a frame or an epoch may. True: it does not obey, so that the process must end.
  bool overdue(Clock::time_point now);
  // Why the process that has ended answers no more: a code and a sentence.
  std::pair<ErrorCode, std::string> epitaph();

 private:
  struct Waiting {
    std::uint64_t id;
    std::string type;
    std::uint64_t bytes;
  };

  std::optional<Reply> read(Header header, Parts parts);
  Reply out_of_time(const Header& header) const;

  const std::string user_;
  const SessionLimits limits_;
  const std::uint64_t max_message_bytes_;
  SolverProcess process_;
  std::deque<Waiting> waiting_;
  std::uint64_t waiting_bytes_ = 0;
  bool greeted_ = false;
  std::optional<std::uint64_t> number_;
  Clock::time_point busy_since_;                // the first that waits began then
  std::optional<Clock::time_point> cancelled_;  // it was cancelled then, because it took too long
  std::set<std::uint64_t> out_of_time_;         // what was cancelled then
};

}  // namespace lappet
