#include "server/zap.h"

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "server/key_file.h"

namespace lappet {
namespace {

constexpr const char* kEndpoint = "inproc://zeromq.zap.01";
// The parts of a request.
enum Part : std::size_t { kVersion, kRequest, kDomain, kAddress, kIdentity, kMechanism, kPublicKey, kParts };
constexpr std::size_t kBinaryKeyBytes = 32;

std::optional<std::string> key_of(const std::vector<zmq::message_t>& parts) {
  if (parts.size() != kParts || parts[kVersion].to_string_view() != "1.0") return std::nullopt;
  if (parts[kMechanism].to_string_view() != "CURVE" || parts[kPublicKey].size() != kBinaryKeyBytes) return std::nullopt;
  std::array<char, kKeyLength + 1> key{};
  zmq_z85_encode(key.data(), parts[kPublicKey].data<std::uint8_t>(), kBinaryKeyBytes);
  return key.data();
}

}  // namespace

ZapHandler::ZapHandler(zmq::context_t& context, Decide decide)
    : socket_(context, zmq::socket_type::rep), decide_(std::move(decide)) {
  socket_.set(zmq::sockopt::linger, 0);
  socket_.bind(kEndpoint);
}

void ZapHandler::answer() {
  while (true) {
    std::vector<zmq::message_t> parts(1);
    if (!socket_.recv(parts.back(), zmq::recv_flags::dontwait)) return;
    while (parts.back().more()) {
      zmq::message_t part;
      if (!socket_.recv(part, zmq::recv_flags::none)) return;
      parts.push_back(std::move(part));
    }
    const std::optional<std::string> key = key_of(parts);
    const std::optional<std::string> user = key ? decide_(parts[kDomain].to_string(), *key) : std::nullopt;
    const std::string request = parts.size() > kRequest ? parts[kRequest].to_string() : std::string();
    const std::array<std::string, 6> reply = {
        "1.0", request, user ? "200" : "400", user ? "" : "not known", user.value_or(""), std::string()};
    for (std::size_t i = 0; i < reply.size(); ++i) {
      const bool last = i + 1 == reply.size();
      socket_.send(zmq::buffer(reply[i]), last ? zmq::send_flags::none : zmq::send_flags::sndmore);
    }
  }
}

}  // namespace lappet
