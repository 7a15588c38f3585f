// One connection of a user to the broker. It has a ZeroMQ socket of its own, so nothing that the peer says of itself
// tells it from others: what arrives here was sent by the user who made the handshake, and what is sent goes there.
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "server/brokered_session.h"
#include "server/message.h"

namespace lappet {

class BrokerPeer {
 public:
  using Clock = std::chrono::steady_clock;
  using Parts = std::vector<zmq::message_t>;
  struct Incoming {
    Parts parts;        // header, arrays
    std::string fault;  // set when it was too large to keep
  };

  // Listens at ipc://`path` for the one connection, with the server's secret key and the ZAP domain `domain`.
  BrokerPeer(zmq::context_t& context, const std::string& path, const std::string& secret_key, const std::string& domain,
             std::uint64_t max_message_bytes);

  zmq::socket_t& socket() { return socket_; }

  // The next whole message, if there is one.
  std::optional<Incoming> receive(std::uint64_t limit);
  // Sends as soon as the peer takes it. False: more than `most` bytes wait for it already.
  bool send(Parts parts, std::uint64_t most);
  bool send(const std::vector<PartBytes>& parts, std::uint64_t most);
  bool has_unsent() const { return !unsent_.empty(); }
  void flush();

  std::string user;        // empty: not known yet
  std::string public_key;  // of the user, Z85
  std::string name;        // what it calls itself
  bool greeted = false;
  Clock::time_point heard = Clock::now();    // or known since, until it says hello
  std::optional<Clock::time_point> refused;  // its user is none any more
  std::unique_ptr<BrokeredSession> session;

  struct Following {
    std::uint64_t session;  // its number
    std::uint64_t id;       // of the message `follow`
  };
  std::optional<Following> following;

 private:
  zmq::socket_t socket_;
  std::deque<Parts> unsent_;
  std::uint64_t unsent_bytes_ = 0;
};

}  // namespace lappet
