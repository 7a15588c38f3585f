#include "server/broker_peer.h"

#include <utility>

namespace lappet {
namespace {

constexpr int kHandshake = 2000, kHeartbeat = 10000;  // ms
// A closed socket of ZeroMQ's keeps what it has not sent until the connection has ended, which the gate does at once.
// At 0 it may throw away the rest of a message of which it has sent a part, and then aborts the process
// (session_base.cpp, clean_pipes).
constexpr int kLinger = 30000;  // ms

std::uint64_t bytes_of(const BrokerPeer::Parts& parts) {
  std::uint64_t bytes = 0;
  for (const zmq::message_t& part : parts) bytes += part.size();
  return bytes;
}

}  // namespace

BrokerPeer::BrokerPeer(zmq::context_t& context, const std::string& path, const std::string& secret_key,
                       const std::string& domain, std::uint64_t max_message_bytes)
    : socket_(context, zmq::socket_type::dealer) {
  socket_.set(zmq::sockopt::linger, kLinger);
  socket_.set(zmq::sockopt::rcvhwm,
              2);  // ZeroMQ 4.3.4 delivers nothing at 1; what waits is counted in bytes by the gate
  socket_.set(zmq::sockopt::sndhwm, 1);
  socket_.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(max_message_bytes));
  socket_.set(zmq::sockopt::handshake_ivl, kHandshake);
  socket_.set(zmq::sockopt::heartbeat_ivl, kHeartbeat);
  socket_.set(zmq::sockopt::heartbeat_timeout, 3 * kHeartbeat);
  socket_.set(zmq::sockopt::curve_server, 1);
  socket_.set(zmq::sockopt::curve_secretkey, secret_key);
  socket_.set(zmq::sockopt::zap_domain, domain);
  socket_.bind("ipc://" + path);
}

std::optional<BrokerPeer::Incoming> BrokerPeer::receive(std::uint64_t limit) {
  Incoming message;
  std::uint64_t bytes = 0;
  bool more = true;
  for (bool first = true; more; first = false) {
    zmq::message_t part;
    if (!socket_.recv(part, first ? zmq::recv_flags::dontwait : zmq::recv_flags::none)) return std::nullopt;
    more = part.more();
    bytes += part.size();
    if (bytes > limit) {
      message.fault = "The message has more than " + std::to_string(limit) + " bytes, the most that is taken here.";
    } else if (message.parts.size() > kMaxArrays) {
      message.fault = "The message has more than " + std::to_string(kMaxArrays) + " array parts.";
    } else {
      message.parts.push_back(std::move(part));
    }
  }
  return message;
}

bool BrokerPeer::send(Parts parts, std::uint64_t most) {
  const std::uint64_t bytes = bytes_of(parts);
  flush();
  if (!unsent_.empty() && unsent_bytes_ + bytes > most) return false;
  unsent_.push_back(std::move(parts));
  unsent_bytes_ += bytes;
  flush();
  return true;
}

bool BrokerPeer::send(const std::vector<PartBytes>& parts, std::uint64_t most) {
  Parts messages;
  for (const PartBytes& part : parts) messages.emplace_back(part.data(), part.size());
  return send(std::move(messages), most);
}

void BrokerPeer::flush() {
  while (!unsent_.empty()) {
    Parts& parts = unsent_.front();
    const std::uint64_t bytes = bytes_of(parts);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const auto flags = i + 1 < parts.size() ? zmq::send_flags::sndmore : zmq::send_flags::none;
      if (!socket_.send(parts[i], flags | zmq::send_flags::dontwait)) {
        if (i == 0) return;  // ZeroMQ takes a message whole or not at all
        break;
      }
    }
    unsent_bytes_ -= bytes;
    unsent_.pop_front();
  }
}

}  // namespace lappet
