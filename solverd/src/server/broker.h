// The daemon for several people (--keys). It knows its users by their CURVE keys, and starts a process of its own for
// each session, so that a crash or a spent budget ends one session. One thread, which never solves: it lets peers in
// (gate.h, zap.h), says who may do what (roles.h, keys_folder.h), and hands messages on (brokered_session.h).
#pragma once
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "server/broker_options.h"
#include "server/broker_peer.h"
#include "server/gate.h"
#include "server/keys_folder.h"
#include "server/private_folder.h"
#include "server/token_bucket.h"
#include "server/zap.h"

namespace lappet {

inline constexpr std::uint64_t kBytesBeforeHello = kMaxHeaderBytes;  // in a message
// What a message with as many parts as it may have takes on the wire besides their bytes.
inline constexpr std::uint64_t kEnvelopeBytes = std::uint64_t{64} << 10;

class Broker {
 public:
  // Reads the keys and listens. Throws RefusedError where it cannot.
  explicit Broker(BrokerOptions options);
  ~Broker();
  Broker(const Broker&) = delete;
  Broker& operator=(const Broker&) = delete;

  const std::string& endpoint() const { return gate_.endpoint(); }
  // Serves until it is shut down; says why it ended.
  std::string run();

 private:
  using Clock = std::chrono::steady_clock;
  using Number = Gate::Number;
  using Peers = std::map<Number, std::unique_ptr<BrokerPeer>>;

  // The loop (broker.cpp).
  void wait_and_serve();
  std::optional<std::string> decide(const std::string& domain, const std::string& public_key);
  void welcome_arrived();
  void drop_gone();
  void serve_peers();
  void serve_sessions();
  void serve_session(Number number, BrokerPeer& peer);
  void look_after_peers();
  void refresh_users();
  void look_after_users();
  void look_after_itself();
  void reap();
  void drop(Number number, const std::string& why);
  void end_session(BrokerPeer& peer);
  void end_session(Number number, BrokerPeer& peer, ErrorCode code, const std::string& sentence);

  // Following (broker_followers.cpp).
  void follow(BrokerPeer& peer, const Header& header);
  void share(BrokerPeer& peer);
  void show(std::uint64_t session, const BrokeredSession::Reply& reply);
  void tell_the_end(std::uint64_t session);

  // Messages (broker_messages.cpp).
  void handle(Number number, BrokerPeer& peer, BrokerPeer::Incoming message);
  void dispatch(Number number, BrokerPeer& peer, BrokerPeer::Incoming message);
  void greet(Number number, BrokerPeer& peer, const User& user, const Header& header, const BrokerPeer::Parts& arrays);
  void work(Number number, BrokerPeer& peer, const User& user, const Header& header, BrokerPeer::Parts message);
  void start_session(BrokerPeer& peer, const User& user);
  void answer(Number number, BrokerPeer& peer, const User& user, const Header& header, bool has_arrays);
  const User& user_of(BrokerPeer& peer);
  void send(Number number, BrokerPeer& peer, const std::vector<PartBytes>& parts);
  SessionLimits limits_of(const User& user) const;
  std::uint64_t message_bytes(const BrokerPeer& peer) const;
  bool is_throttled(const BrokerPeer& peer);
  std::size_t sessions_of(const std::string* user) const;

  const BrokerOptions options_;
  KeysFolder keys_;
  zmq::context_t context_;
  PrivateFolder folder_;  // of the sockets; gone before the context ends, which may take long
  ZapHandler zap_;
  Gate gate_;
  Peers peers_;
  std::vector<std::unique_ptr<BrokeredSession>> ending_;  // their processes were killed
  std::map<std::string, TokenBucket> messages_;           // by user
  std::vector<Number> to_drop_;
  std::uint64_t next_session_ = 1;
  Clock::time_point heard_, refreshed_;
  bool hurry_ = false;  // something is due before the next tick
  std::string end_reason_;
};

}  // namespace lappet
