#include "server/gate.h"

#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace lappet {
namespace {

constexpr int kAcceptsPerTurn = 64;
constexpr std::size_t kBytesPerTurn = std::size_t{1} << 20;
constexpr std::size_t kScratchBytes = std::size_t{128} << 10;
constexpr std::size_t kMaxSources = 4096;  // whose handshakes are counted each for itself
constexpr double kSourcesAtOnce = 4.0;
constexpr std::chrono::milliseconds kDeliveryTime{1000};  // for a message's way through ZeroMQ
#ifdef MSG_NOSIGNAL
constexpr int kSendFlags = MSG_NOSIGNAL;
#else
constexpr int kSendFlags = 0;  // main ignores SIGPIPE
#endif

bool waits() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

// Writes what it can; the number of bytes, or nothing where the socket is broken.
std::optional<std::size_t> write_to(int socket, const char* bytes, std::size_t count) {
  std::size_t done = 0;
  while (done < count) {
    const ssize_t now = ::send(socket, bytes + done, count - done, kSendFlags);
    if (now < 0 && errno == EINTR) continue;
    if (now < 0 && waits()) break;
    if (now <= 0) return std::nullopt;
    done += static_cast<std::size_t>(now);
  }
  return done;
}

enum class Moved { kAll, kStuck, kEnded, kBroken };  // nothing more to read; to write; ever to read; a socket broke

// Moves at most `most` bytes and adds their number to `moved`.
template <class Flow>
Moved move_bytes(int from, int to, Flow& flow, std::vector<char>& scratch, std::uint64_t most, std::uint64_t& moved) {
  if (!flow.empty()) {
    const auto done = write_to(to, flow.bytes.data() + flow.begin, flow.bytes.size() - flow.begin);
    if (!done) return Moved::kBroken;
    flow.begin += *done;
    if (!flow.empty()) return Moved::kStuck;
    flow = {};
  }
  for (std::uint64_t count = 0; count < most;) {
    const ssize_t now = ::recv(from, scratch.data(), std::min<std::uint64_t>(scratch.size(), most - count), 0);
    if (now == 0) return Moved::kEnded;
    if (now < 0 && errno == EINTR) continue;
    if (now < 0) return waits() ? Moved::kAll : Moved::kEnded;
    const auto size = static_cast<std::size_t>(now);
    count += size;
    moved += size;
    const auto done = write_to(to, scratch.data(), size);
    if (!done) return Moved::kBroken;
    if (*done < size) {
      flow.bytes.assign(scratch.data() + *done, scratch.data() + size);
      flow.begin = 0;
      return Moved::kStuck;
    }
  }
  return Moved::kAll;
}

}  // namespace

Gate::Gate(const std::string& address, const GateLimits& limits)
    : limits_(limits),
      listener_(listen_on(address)),
      all_handshakes_(kSourcesAtOnce * limits.handshakes_per_second, kSourcesAtOnce * limits.handshakes_per_second,
                      Clock::now()),
      scratch_(kScratchBytes) {}

void Gate::add_items(std::vector<zmq::pollitem_t>& items) {
  items.push_back({nullptr, listener_.socket.get(), static_cast<short>(without_descriptors_ ? 0 : ZMQ_POLLIN), 0});
  without_descriptors_ = false;
  polled_.clear();
  const auto events = [](bool in, bool out) {
    return static_cast<short>((in ? ZMQ_POLLIN : 0) | (out ? ZMQ_POLLOUT : 0));
  };
  for (const auto& [number, connection] : connections_) {
    polled_.push_back(number);
    const bool reads = connection.inward.empty() && connection.received < connection.limit;
    const bool begins = !connection.arrived;
    const bool joined = connection.inner.open();
    items.push_back(
        {nullptr, connection.outer.get(), events(begins || (joined && reads), !connection.outward.empty()), 0});
    // An entry without a descriptor is not waited for, also not for its end.
    const short wanted = events(connection.outward.empty(), !connection.inward.empty());
    const bool waits_for = joined && !connection.inner_ended && wanted != 0;
    items.push_back({nullptr, waits_for ? connection.inner.get() : -1, wanted, 0});
  }
}

void Gate::serve(std::span<const zmq::pollitem_t> items) {
  const auto now = Clock::now();
  for (std::size_t i = 0; i < polled_.size(); ++i) {
    const auto found = connections_.find(polled_[i]);
    if (found == connections_.end()) continue;
    serve_connection(found->first, found->second, items[1 + 2 * i].revents, items[2 + 2 * i].revents);
  }
  for (auto next = connections_.begin(); next != connections_.end();) {
    const auto here = next++;
    if (!here->second.known && now - here->second.since > limits_.handshake) drop(here);
  }
  if ((items[0].revents & ZMQ_POLLIN) != 0) accept();
}

void Gate::serve_connection(Number number, Connection& connection, short outer, short inner) {
  const auto now = Clock::now();
  if (!connection.arrived) {
    if (outer == 0) return;
    char first = 0;
    if (::recv(connection.outer.get(), &first, 1, MSG_PEEK) <= 0 || !may_shake_hands(connection.source, now)) {
      drop(connections_.find(number));
      return;
    }
    connection.arrived = true;
    arrived_.push_back(number);
    return;
  }
  if (!connection.inner.open()) return;  // it is joined after this turn
  const bool broken = ((outer & ZMQ_POLLERR) != 0 && (outer & ZMQ_POLLIN) == 0) ||
                      ((outer & ZMQ_POLLIN) != 0 && !relay_inward(connection)) ||
                      ((inner & ZMQ_POLLOUT) != 0 && !relay_inward(connection)) ||
                      ((inner & (ZMQ_POLLIN | ZMQ_POLLERR)) != 0 && !relay_outward(connection)) ||
                      ((outer & ZMQ_POLLOUT) != 0 && !relay_outward(connection));
  if (broken) drop(connections_.find(number));
}

// False: the connection is over.
bool Gate::relay_inward(Connection& connection) {
  const std::uint64_t left = connection.limit - std::min(connection.limit, connection.received);
  const std::uint64_t most = std::min<std::uint64_t>(kBytesPerTurn, left);
  const Moved moved = move_bytes(connection.outer.get(), connection.inner.get(), connection.inward, scratch_, most,
                                 connection.received);
  if (moved == Moved::kEnded || moved == Moved::kBroken) return false;
  if (connection.received < connection.limit) return true;
  if (!connection.full_since) connection.full_since = Clock::now();
  return connection.known;  // a handshake never has so many
}

bool Gate::relay_outward(Connection& connection) {
  std::uint64_t ignored = 0;
  const std::uint64_t most = connection.inner_ended ? 0 : kBytesPerTurn;
  const Moved moved =
      move_bytes(connection.inner.get(), connection.outer.get(), connection.outward, scratch_, most, ignored);
  if (moved == Moved::kBroken) return false;
  if (moved == Moved::kEnded) connection.inner_ended = true;
  return !connection.inner_ended || !connection.outward.empty();
}

void Gate::accept() {
  for (int i = 0; i < kAcceptsPerTurn; ++i) {
    Accepted accepted = accept_from(listener_.socket);
    if (accepted.full) {
      without_descriptors_ = true;
      evict();
    }
    if (!accepted.socket.open()) return;
    if (unknown() >= limits_.unknown) evict();
    Connection connection;
    connection.outer = std::move(accepted.socket);
    connection.source = std::move(accepted.source);
    connection.since = Clock::now();
    connection.limit = limits_.bytes_before_known;
    connections_.emplace(next_++, std::move(connection));
  }
}

// Closes the oldest of those whose address has most connections that are not known.
void Gate::evict() {
  std::map<std::string_view, std::size_t> count;
  for (const auto& [number, connection] : connections_) {
    if (!connection.known) ++count[connection.source];
  }
  if (count.empty()) return;
  const auto most = std::ranges::max_element(count, {}, [](const auto& entry) { return entry.second; });
  const auto oldest = std::ranges::find_if(
      connections_, [&](const auto& entry) { return !entry.second.known && entry.second.source == most->first; });
  drop(oldest);
}

bool Gate::may_shake_hands(const std::string& source, Clock::time_point now) {
  if (handshakes_.size() >= kMaxSources) {
    std::erase_if(handshakes_, [&](const auto& entry) { return entry.second.full(now); });
    if (handshakes_.size() >= kMaxSources) return all_handshakes_.take(now);
  }
  const double rate = limits_.handshakes_per_second;
  const auto found = handshakes_.try_emplace(source, rate, rate, now).first;
  return found->second.take(now) && all_handshakes_.take(now);
}

bool Gate::join(Number number, const std::string& path) {
  const auto found = connections_.find(number);
  if (found == connections_.end()) return false;
  found->second.inner = connect_locally(path);
  return found->second.inner.open();
}

bool Gate::admit(Number number, std::uint64_t bytes) {
  const auto found = connections_.find(number);
  if (found == connections_.end() || found->second.known || known_ >= limits_.known) return false;
  found->second.known = true;
  found->second.received = 0;
  found->second.limit = bytes;
  ++known_;
  return true;
}

void Gate::allow(Number number, std::uint64_t bytes) {
  const auto found = connections_.find(number);
  if (found != connections_.end()) found->second.limit = bytes;
}

void Gate::count_message(Number number) {
  const auto found = connections_.find(number);
  if (found == connections_.end()) return;
  found->second.received = 0;
  found->second.full_since.reset();
}

bool Gate::is_flooding(Number number, Clock::time_point now) const {
  const auto found = connections_.find(number);
  return found != connections_.end() && found->second.full_since && now - *found->second.full_since > kDeliveryTime;
}

void Gate::close(Number number) {
  const auto found = connections_.find(number);
  if (found != connections_.end()) drop(found);
}

void Gate::drop(Connections::iterator connection) {
  if (connection->second.known) --known_;
  gone_.push_back(connection->first);
  connections_.erase(connection);
}

}  // namespace lappet
