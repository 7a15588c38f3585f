#include "server/brokered_session.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "server/encode.h"
#include "server/worker.h"

namespace lappet {
namespace {

constexpr std::uint64_t kOwnCancel = std::numeric_limits<std::uint64_t>::max();  // the id of a cancel of the broker's
constexpr std::uint64_t kMaxReplyBytes = std::uint64_t{1} << 50;
// A frame ends by itself when its time is over; the broker comes after that. Then it waits for the cancel.
constexpr std::chrono::milliseconds kGrace{500}, kPatience{3000};

std::uint64_t bytes_of(const BrokeredSession::Parts& parts) {
  std::uint64_t bytes = 0;
  for (const zmq::message_t& part : parts) bytes += part.size();
  return bytes;
}

BrokeredSession::Parts messages_of(const std::vector<PartBytes>& parts) {
  BrokeredSession::Parts messages;
  for (const PartBytes& part : parts) messages.emplace_back(part.data(), part.size());
  return messages;
}

}  // namespace

BrokeredSession::BrokeredSession(zmq::context_t& context, const SolverProcessOptions& options, std::string user)
    : user_(std::move(user)),
      limits_(options.limits),
      max_message_bytes_(options.max_message_bytes),
      process_(context, options) {}

void BrokeredSession::forward(const Header& header, Parts message) {
  const std::uint64_t bytes = bytes_of(message);
  if (waiting_.size() >= Worker::kMaxWaiting || (!waiting_.empty() && waiting_bytes_ + bytes > max_message_bytes_)) {
    throw RefusedError(ErrorCode::kOutOfOrder, std::to_string(waiting_.size()) + " messages of this client with " +
                                                   std::to_string(waiting_bytes_) +
                                                   " bytes wait already; read their replies before you send more.");
  }
  if (waiting_.empty()) busy_since_ = Clock::now();
  waiting_.push_back({header.id, header.type, bytes});
  waiting_bytes_ += bytes;
  for (std::size_t i = 0; i < message.size(); ++i) {
    const bool last = i + 1 == message.size();
    process_.socket().send(message[i],
                           (last ? zmq::send_flags::none : zmq::send_flags::sndmore) | zmq::send_flags::dontwait);
  }
}

void BrokeredSession::cancel() {
  process_.socket().send(zmq::buffer(MessageWriter("cancel", kOwnCancel).finish().front()), zmq::send_flags::dontwait);
}

std::optional<BrokeredSession::Reply> BrokeredSession::receive() {
  while (true) {
    Parts parts(1);
    if (!process_.socket().recv(parts.back(), zmq::recv_flags::dontwait)) return std::nullopt;
    while (parts.back().more()) {
      zmq::message_t part;
      if (!process_.socket().recv(part, zmq::recv_flags::none)) return std::nullopt;
      parts.push_back(std::move(part));
    }
    const zmq::message_t& first = parts.front();
    Header header = [&] {
      try {
        return decode_header({first.data<std::byte>(), first.size()}, kMaxReplyBytes);
      } catch (const RefusedError& error) {
        throw RefusedError(ErrorCode::kInternal, std::string("The solver's reply cannot be read: ") + error.what());
      }
    }();
    if (std::optional<Reply> reply = read(std::move(header), std::move(parts))) return reply;
  }
}

// What the client gets of a reply, if anything.
std::optional<BrokeredSession::Reply> BrokeredSession::read(Header header, Parts parts) {
  if (!greeted_ && header.type == "welcome") {
    greeted_ = true;
    return std::nullopt;
  }
  if (header.type == "progress") return Reply{std::move(parts), true, std::move(header)};
  if (header.id == kOwnCancel) return std::nullopt;
  const auto found = std::ranges::find(waiting_, header.id, &Waiting::id);
  if (found != waiting_.end()) {
    if (header.type == "opened") number_ = header.session;
    if (header.type == "accepted" && found->type == "close") number_.reset();
    if (found == waiting_.begin()) {
      busy_since_ = Clock::now();
      cancelled_.reset();
    }
    waiting_bytes_ -= found->bytes;
    waiting_.erase(found);
  }
  const bool late = out_of_time_.erase(header.id) > 0;
  if (late && header.type == "error" && header.fields.contains("code") &&
      header.fields.at("code") == Value(std::string(error_name(ErrorCode::kCancelled)))) {
    return out_of_time(header);
  }
  if (header.type == "frame" || header.type == "lattice") return Reply{std::move(parts), false, std::move(header)};
  return Reply{std::move(parts), false, std::nullopt};
}

BrokeredSession::Reply BrokeredSession::out_of_time(const Header& header) const {
  const std::string sentence = "It took longer than the " + shown(limits_.seconds) +
                               " s that this daemon gives a frame or an epoch of " + user_ + "'s.";
  return {messages_of(encode_error({header.id, header.session.value_or(0)}, ErrorCode::kTimeBudget, sentence)), false,
          std::nullopt};
}

std::vector<std::uint64_t> BrokeredSession::unanswered() const {
  std::vector<std::uint64_t> ids;
  for (const Waiting& waiting : waiting_) ids.push_back(waiting.id);
  return ids;
}

bool BrokeredSession::overdue(Clock::time_point now) {
  if (limits_.seconds == 0.0 || waiting_.empty()) return false;
  const std::chrono::duration<double> passed = now - busy_since_;
  if (passed < std::chrono::duration<double>(limits_.seconds) + kGrace) return false;
  if (cancelled_) return now - *cancelled_ > kPatience;
  cancelled_ = now;
  for (const Waiting& waiting : waiting_) out_of_time_.insert(waiting.id);
  cancel();
  return false;
}

std::pair<ErrorCode, std::string> BrokeredSession::epitaph() {
  const std::string again = "; the session is over, open another.";
  if (cancelled_) {
    return {ErrorCode::kTimeBudget, "The solver took longer than " + shown(limits_.seconds) +
                                        " s, did not obey a cancel and was ended" + again};
  }
  const ProcessEnd& end = process_.end();
  if (end.killed) {
    return {ErrorCode::kMemoryBudget, "The solver was killed, as the system does where memory is spent" + again};
  }
  return {ErrorCode::kInternal, "The solver of this session " + end.how + again};
}

}  // namespace lappet
