#include "server/worker.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <exception>
#include <new>
#include <utility>

#include "server/decode.h"
#include "server/encode.h"

namespace lappet {
namespace {

constexpr std::chrono::milliseconds kProgressInterval{40};

void refuse_if_cancelled(const Request& request) {
  if (request.cancelled->load())
    throw RefusedError(ErrorCode::kCancelled, "The " + request.header.type + " was cancelled before it began.");
}

std::uint64_t bytes_of(const Request& request) {
  std::uint64_t total = 0;
  for (const zmq::message_t& array : request.arrays) total += array.size();
  return total;
}

}  // namespace

Worker::Worker(zmq::context_t& context, std::string replies, std::string identity, SolverFactory factory,
               std::uint64_t max_waiting_bytes)
    : context_(context),
      replies_(std::move(replies)),
      identity_(std::move(identity)),
      factory_(std::move(factory)),
      max_waiting_bytes_(max_waiting_bytes),
      thread_([this] { run(); }) {}

Worker::~Worker() {
  stop();
  thread_.join();
}

void Worker::submit(Request request) {
  const std::lock_guard lock(mutex_);
  const std::uint64_t bytes = bytes_of(request);
  if (waiting_.size() >= kMaxWaiting || (!waiting_.empty() && waiting_bytes_ + bytes > max_waiting_bytes_)) {
    throw RefusedError(ErrorCode::kOutOfOrder, std::to_string(waiting_.size()) + " messages of this client with " +
                                                   std::to_string(waiting_bytes_) +
                                                   " bytes wait already; read their replies before you send more.");
  }
  waiting_bytes_ += bytes;
  waiting_.push_back(std::move(request));
  wake_.notify_one();
}

void Worker::cancel() {
  const std::lock_guard lock(mutex_);
  if (running_) running_->store(true);
  for (const Request& request : waiting_) request.cancelled->store(true);
}

void Worker::stop() {
  const std::lock_guard lock(mutex_);
  if (running_) running_->store(true);
  waiting_.clear();
  waiting_bytes_ = 0;
  stopping_ = true;
  wake_.notify_one();
}

void Worker::run() {
  try {
    zmq::socket_t replies(context_, zmq::socket_type::push);
    replies.set(zmq::sockopt::linger, 0);
    replies.set(zmq::sockopt::sndhwm, 0);  // bounded by the requests that wait and by kProgressInterval
    replies.connect(replies_);
    while (true) {
      std::unique_lock lock(mutex_);
      running_.reset();
      wake_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
      if (stopping_) break;
      const Request request = std::move(waiting_.front());
      waiting_.pop_front();
      waiting_bytes_ -= bytes_of(request);
      running_ = request.cancelled;
      lock.unlock();
      serve(request, replies);
    }
    session_.reset();
  } catch (const std::exception& error) {  // the sockets are gone: the daemon ends
    spdlog::error("A worker ends: {}", error.what());
  }
  finished_.store(true);
}

void Worker::serve(const Request& request, zmq::socket_t& replies) {
  const auto refuse = [&](ErrorCode code, const std::string& sentence) {
    spdlog::info("{} {}: {}: {}", request.header.type, request.header.id, error_name(code), sentence);
    send(replies, encode_error({request.header.id, session_number_}, code, sentence));
  };
  try {
    send(replies, answer(request, replies));
  } catch (const RefusedError& error) {
    refuse(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    refuse(ErrorCode::kMemoryBudget,
           "The machine's memory is spent; solve with a larger spacing or close other programs.");
  } catch (const zmq::error_t&) {
    throw;
  } catch (const std::exception& error) {
    refuse(ErrorCode::kInternal, "A fault of the daemon in '" + request.header.type + "': " + error.what());
  } catch (...) {
    refuse(ErrorCode::kInternal, "A fault of the daemon in '" + request.header.type + "' that it cannot name.");
  }
}

std::vector<PartBytes> Worker::answer(const Request& request, zmq::socket_t& replies) {
  std::vector<std::span<const std::byte>> arrays;
  arrays.reserve(request.arrays.size());
  for (const zmq::message_t& array : request.arrays) {
    arrays.emplace_back(static_cast<const std::byte*>(array.data()), array.size());
  }
  const Header& header = request.header;
  if (header.type == "open") {
    const SessionSettings settings = decode_open(header, arrays);
    if (session_) {
      throw RefusedError(ErrorCode::kOutOfOrder, "Session " + std::to_string(session_number_) +
                                                     " is open; send 'close' before another 'open'.");
    }
    session_ = factory_(settings);
    settings_ = settings;
    session_number_ = request.new_session;
    epoch_triangles_.reset();
    return encode_opened({header.id, session_number_});
  }
  SolverPort& session = session_for(request);
  const auto materials = static_cast<std::int32_t>(settings_.materials.size());
  const ReplyTo to{header.id, session_number_};
  if (header.type == "epoch") {
    const EpochInput epoch = decode_epoch(header, arrays, settings_.retractors, materials);
    refuse_if_cancelled(request);
    const EpochReport report = session.set_epoch(epoch, *request.cancelled);  // where it throws the epoch before stays
    epoch_triangles_ = static_cast<std::int32_t>(epoch.surface.triangles.size());
    return encode_lattice(to, report);
  }
  if (header.type == "close") {
    decode_bare(header, arrays);
    session_.reset();
    session_number_ = 0;
    return encode_accepted(to);
  }
  if (!epoch_triangles_) {
    throw RefusedError(ErrorCode::kOutOfOrder, "'" + header.type + "' needs an epoch; send 'epoch' first.");
  }
  if (header.type == "state") {
    session.set_state(decode_state(header, arrays, settings_.sutures, materials));
    return encode_accepted(to);
  }
  return encode_frame(to, solve(request, arrays, replies));
}

FrameOutput Worker::solve(const Request& request, std::span<const std::span<const std::byte>> arrays,
                          zmq::socket_t& replies) {
  const FrameInput frame =
      decode_solve(request.header, arrays,
                   {*epoch_triangles_, settings_.sutures, settings_.retractors,
                    static_cast<std::int32_t>(settings_.materials.size()), settings_.moving_bones()});
  refuse_if_cancelled(request);
  std::chrono::steady_clock::time_point last{};
  const auto report = [&](const Progress& progress) {
    const auto now = std::chrono::steady_clock::now();
    if (now - last < kProgressInterval) return;
    last = now;
    send(replies, encode_progress({request.header.id, session_number_}, progress));
  };
  return session_->solve(frame, report, *request.cancelled);
}

SolverPort& Worker::session_for(const Request& request) const {
  if (!session_) {
    throw RefusedError(ErrorCode::kOutOfOrder, "'" + request.header.type + "' needs a session; send 'open' first.");
  }
  if (request.header.session && *request.header.session != session_number_) {
    throw RefusedError(ErrorCode::kOutOfOrder, "The session " + std::to_string(*request.header.session) +
                                                   " is not open; this client's session is " +
                                                   std::to_string(session_number_) + ".");
  }
  return *session_;
}

void Worker::send(zmq::socket_t& replies, const std::vector<PartBytes>& parts) const {
  replies.send(zmq::buffer(identity_), zmq::send_flags::sndmore);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    replies.send(zmq::buffer(parts[i]), i + 1 < parts.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
  }
}

}  // namespace lappet
