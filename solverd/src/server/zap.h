// Who may connect: ZeroMQ asks for every handshake (ZAP, https://rfc.zeromq.org/spec/27) and waits for the answer.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <zmq.hpp>

namespace lappet {

class ZapHandler {
 public:
  // Says who the owner of a public key (Z85) is at a socket with that ZAP domain; nothing: the handshake fails.
  using Decide = std::function<std::optional<std::string>(const std::string& domain, const std::string& public_key)>;

  // Handshakes at sockets of this context are refused until `answer` is called.
  ZapHandler(zmq::context_t& context, Decide decide);
  zmq::socket_t& socket() { return socket_; }
  // Answers every request that waits.
  void answer();

 private:
  zmq::socket_t socket_;
  Decide decide_;
};

}  // namespace lappet
