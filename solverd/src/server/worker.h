// The thread that owns one client's session. It takes the client's requests in order and hands every reply, as a
// multipart message [client identity, header, arrays...], to the server's loop through an inproc socket.
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>
#include <zmq.hpp>

#include "server/message.h"
#include "server/solver_port.h"

namespace lappet {

struct Request {
  Header header;
  std::vector<zmq::message_t> arrays;
  std::uint64_t new_session = 0;  // the number that an `open` gives its session
  std::shared_ptr<std::atomic<bool>> cancelled = std::make_shared<std::atomic<bool>>(false);
};

class Worker {
 public:
  static constexpr std::size_t kMaxWaiting = 16;

  // `replies` is the inproc endpoint that the loop is bound to. `max_waiting_bytes` bounds the arrays of the requests
  // that wait.
  Worker(zmq::context_t& context, std::string replies, std::string identity, SolverFactory factory,
         std::uint64_t max_waiting_bytes);
  ~Worker();  // waits for the thread
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  // Queues a request. Throws RefusedError(kOutOfOrder) when too many, or too large ones, wait already.
  void submit(Request request);
  // Cancels the epochs and solves that came before, the running one and those that wait.
  void cancel();
  // Cancels, drops what waits and lets the thread end after what it does now.
  void stop();
  bool finished() const { return finished_.load(); }

 private:
  void run();
  void serve(const Request& request, zmq::socket_t& replies);
  std::vector<PartBytes> answer(const Request& request, zmq::socket_t& replies);
  FrameOutput solve(const Request& request, std::span<const std::span<const std::byte>> arrays, zmq::socket_t& replies);
  void send(zmq::socket_t& replies, const std::vector<PartBytes>& parts) const;
  SolverPort& session_for(const Request& request) const;

  zmq::context_t& context_;
  const std::string replies_;
  const std::string identity_;
  const SolverFactory factory_;
  const std::uint64_t max_waiting_bytes_;

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Request> waiting_;
  std::shared_ptr<std::atomic<bool>> running_;  // the cancel flag of the request that is served
  std::uint64_t waiting_bytes_ = 0;
  bool stopping_ = false;
  std::atomic<bool> finished_ = false;

  // The thread's own.
  std::unique_ptr<SolverPort> session_;
  std::uint64_t session_number_ = 0;
  SessionSettings settings_;
  std::optional<std::int32_t> epoch_triangles_;

  std::thread thread_;
};

}  // namespace lappet
