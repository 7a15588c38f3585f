// The daemon's gate to a network: it accepts connections, keeps down what a peer can cost before it is known, and
// passes the bytes of each to a socket of this process and back.
//
// ZeroMQ bounds the parts of a message, not a message, not what is read before the handshake's end, and not the number
// of connections. The gate reads 4 KiB of a peer that is not known, for 2 s; of one that is, no more than one message
// may have. Connections whose peer is not known have places of their own: where they are taken, the oldest of whoever
// has most of them is closed. So they never shut out who is known, nor, for longer than a handshake takes, who will be.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
#include <zmq.hpp>

#include "server/descriptor.h"
#include "server/gate_limits.h"
#include "server/listener.h"
#include "server/token_bucket.h"

namespace lappet {

class Gate {
 public:
  using Number = std::uint64_t;  // of a connection; never used twice
  using Clock = std::chrono::steady_clock;

  // Listens. Throws RefusedError(kInvalidInput) where it cannot.
  Gate(const std::string& address, const GateLimits& limits);
  const std::string& endpoint() const { return listener_.endpoint; }

  // Appends what the gate waits for; `serve` takes the same items after the poll, then closes who took too long.
  void add_items(std::vector<zmq::pollitem_t>& items);
  void serve(std::span<const zmq::pollitem_t> items);

  // Those that began to speak, and those that ended, since the last call.
  std::vector<Number> take_arrived() { return std::exchange(arrived_, {}); }
  std::vector<Number> take_gone() { return std::exchange(gone_, {}); }

  // Passes the bytes of a connection that began to speak to the socket at `path`. False: nobody listens there.
  bool join(Number number, const std::string& path);
  // The peer is known now and may send `bytes` before its first whole message. False: all places are taken.
  bool admit(Number number, std::uint64_t bytes);
  // From now on a message may have so many bytes on the wire.
  void allow(Number number, std::uint64_t bytes);
  // A whole message of the connection was read.
  void count_message(Number number);
  // It has sent more than a message may have, and this for so long that no message can still be on its way to us.
  bool is_flooding(Number number, Clock::time_point now) const;
  void close(Number number);

  std::size_t unknown() const { return connections_.size() - known_; }
  std::size_t known() const { return known_; }

 private:
  struct Flow {  // bytes that were read and could not be written yet
    std::vector<char> bytes;
    std::size_t begin = 0;
    bool empty() const { return begin == bytes.size(); }
  };
  struct Connection {
    Descriptor outer, inner;
    std::string source;
    Clock::time_point since;
    Flow inward, outward;
    std::uint64_t received = 0, limit = 0;  // since the last whole message
    std::optional<Clock::time_point> full_since;
    bool known = false, arrived = false, inner_ended = false;
  };
  using Connections = std::map<Number, Connection>;

  void accept();
  void evict();
  void serve_connection(Number number, Connection& connection, short outer, short inner);
  bool relay_inward(Connection& connection);
  bool relay_outward(Connection& connection);
  bool may_shake_hands(const std::string& source, Clock::time_point now);
  void drop(Connections::iterator connection);

  const GateLimits limits_;
  Listener listener_;
  Connections connections_;  // in the order of their age
  std::size_t known_ = 0;
  Number next_ = 1;
  bool without_descriptors_ = false;  // accepts again at the next turn
  std::vector<Number> polled_, arrived_, gone_;
  std::map<std::string, TokenBucket> handshakes_;  // by source
  TokenBucket all_handshakes_;
  std::vector<char> scratch_;
};

}  // namespace lappet
