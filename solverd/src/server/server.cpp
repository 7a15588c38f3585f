#include "server/server.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cerrno>
#include <thread>
#include <utility>

#include "server/decode.h"
#include "server/encode.h"
#include "server/private_address.h"
#include "server/roles.h"

namespace lappet {
namespace {

using PollDescriptor = decltype(zmq::pollitem_t::fd);

constexpr std::chrono::milliseconds kTick{250};
constexpr int kMessagesPerTurn = 64;  // then replies get their turn
constexpr std::chrono::milliseconds kLinger{500};
// A connection that has not greeted as ZeroMQ does by then, or no longer answers, is closed.
constexpr std::chrono::milliseconds kHandshake{2000}, kHeartbeat{10000};
constexpr std::uint64_t kBytesBeforeHello = kMaxHeaderBytes;

std::span<const std::byte> bytes_of(const zmq::message_t& part) {
  return {static_cast<const std::byte*>(part.data()), part.size()};
}

// Takes the same time wherever the texts differ.
bool same_secret(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0U : 1U;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i % b.size()]);
  }
  return difference == 0;
}

}  // namespace

Server::Server(ServerOptions options, SolverFactory factory)
    : options_(std::move(options)),
      factory_(std::move(factory)),
      parent_(options_.parent),
      input_(options_.input),
      router_(context_, zmq::socket_type::router),
      replies_(context_, zmq::socket_type::pull),
      replies_endpoint_("inproc://replies"),
      next_session_(options_.first_session),
      heard_(Clock::now()) {
  require_private(options_.address);
  if (options_.token.empty()) {
    throw RefusedError(
        ErrorCode::kInvalidInput,
        "The environment variable LAPPET_TOKEN is not set; set it to a secret that clients send in 'hello'.");
  }
  replies_.set(zmq::sockopt::rcvhwm, 0);
  replies_.bind(replies_endpoint_);
  router_.set(zmq::sockopt::linger, static_cast<int>(kLinger.count()));
  router_.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(options_.max_message_bytes));
  router_.set(zmq::sockopt::handshake_ivl, static_cast<int>(kHandshake.count()));
  router_.set(zmq::sockopt::heartbeat_ivl, static_cast<int>(kHeartbeat.count()));
  router_.set(zmq::sockopt::heartbeat_timeout, static_cast<int>(3 * kHeartbeat.count()));
  router_.set(zmq::sockopt::ipv6, options_.address.find('[') != std::string::npos);
  try {
    router_.bind(options_.address);
  } catch (const zmq::error_t& error) {
    throw RefusedError(ErrorCode::kInvalidInput,
                       "The daemon cannot listen on '" + options_.address + "': " + error.what() + ".");
  }
  endpoint_ = router_.get(zmq::sockopt::last_endpoint);
}

Server::~Server() = default;

std::string Server::run() {
  std::vector<zmq::pollitem_t> items = {{router_.handle(), 0, ZMQ_POLLIN, 0}, {replies_.handle(), 0, ZMQ_POLLIN, 0}};
  const bool polls_input = input_.pollable() >= 0;
  if (polls_input) items.push_back({nullptr, PollDescriptor(input_.pollable()), ZMQ_POLLIN | ZMQ_POLLERR, 0});
  heard_ = Clock::now();
  while (end_reason_.empty()) {
    try {
      zmq::poll(items, kTick);
    } catch (const zmq::error_t& error) {
      if (error.num() == EINTR) continue;
      throw;
    }
    forward_replies();
    for (int i = 0; i < kMessagesPerTurn && end_reason_.empty(); ++i) {
      std::optional<Incoming> message = receive();
      if (!message) break;
      handle(std::move(*message));
    }
    if ((!polls_input || items[2].revents != 0) && input_.ended()) end_reason_ = "its standard input closed";
    drop_idle_clients();
  }
  return end_reason_;
}

bool Server::stop_workers(std::chrono::milliseconds patience) {
  for (auto& [identity, client] : clients_) retire(std::move(client));
  clients_.clear();
  const auto end = Clock::now() + patience;
  const auto busy = [this] { return std::ranges::any_of(retired_, [](const auto& w) { return !w->finished(); }); };
  while (busy() && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return !busy();
}

std::optional<Server::Incoming> Server::receive() {
  zmq::message_t identity;
  if (!router_.recv(identity, zmq::recv_flags::dontwait)) return std::nullopt;
  Incoming message{identity.to_string(), {}, {}};
  // What is too large for this client is read to its end and dropped.
  const std::uint64_t limit = clients_.contains(message.identity) ? options_.max_message_bytes : kBytesBeforeHello;
  std::uint64_t bytes = 0;
  bool more = identity.more();
  while (more) {
    zmq::message_t part;
    if (!router_.recv(part, zmq::recv_flags::none)) break;
    more = part.more();
    bytes += part.size();
    if (bytes > limit) {
      message.fault = "The message has more than " + std::to_string(limit) + " bytes, the most this daemon takes" +
                      (limit == kBytesBeforeHello ? " before 'hello'." : ".");
    } else if (message.parts.size() > kMaxArrays) {
      message.fault = "The message has more than " + std::to_string(kMaxArrays) + " array parts.";
    } else {
      message.parts.push_back(std::move(part));
    }
  }
  return message;
}

void Server::handle(Incoming message) {
  std::uint64_t id = 0;
  try {
    if (message.parts.empty()) throw RefusedError(ErrorCode::kMalformed, "The message has no header part.");
    const std::span<const std::byte> header_part = bytes_of(message.parts.front());
    id = guess_id(header_part);
    if (!message.fault.empty()) throw RefusedError(ErrorCode::kMalformed, message.fault);
    Header header = decode_header(header_part, options_.max_message_bytes);
    message.parts.erase(message.parts.begin());
    dispatch(message.identity, std::move(header), std::move(message.parts));
  } catch (const RefusedError& error) {
    spdlog::info("message {}: {}: {}", id, error_name(error.code()), error.what());
    send(message.identity, encode_error({id, 0}, error.code(), error.what()));
  } catch (const zmq::error_t&) {
    throw;
  } catch (const std::bad_alloc&) {
    send(message.identity, encode_error({id, 0}, ErrorCode::kMemoryBudget, "The machine's memory is spent."));
  } catch (const std::exception& error) {
    spdlog::error("message {}: {}", id, error.what());
    send(message.identity,
         encode_error({id, 0}, ErrorCode::kInternal, std::string("A fault of the daemon: ") + error.what()));
  }
}

void Server::dispatch(const std::string& identity, Header header, std::vector<zmq::message_t> arrays) {
  const bool work = rule_of(header.type).work;
  if (header.type == "hello") {
    std::vector<std::span<const std::byte>> parts;
    for (const zmq::message_t& array : arrays) parts.push_back(bytes_of(array));
    greet(identity, decode_hello(header, parts));
    send(identity, encode_welcome({header.id, 0}, static_cast<int>(std::thread::hardware_concurrency()),
                                  options_.max_message_bytes));
    return;
  }
  const auto found = clients_.find(identity);
  if (found == clients_.end()) {
    throw RefusedError(ErrorCode::kOutOfOrder, "'" + header.type + "' needs a greeted client; send 'hello' first.");
  }
  Client& client = found->second;
  client.heard = heard_ = Clock::now();
  if (work) {
    Request request{std::move(header), std::move(arrays)};
    if (request.header.type == "open") request.new_session = next_session_++;
    client.worker->submit(std::move(request));
    return;
  }
  if (!arrays.empty()) {
    throw RefusedError(ErrorCode::kMalformed, "'" + header.type + "' has array parts; it takes none.");
  }
  decode_bare(header, {});
  if (header.type == "ping") {
    send(identity, encode_pong({header.id, 0}));
    return;
  }
  if (header.type == "cancel") {
    client.worker->cancel();
  } else if (header.type == "bye") {
    retire(std::move(client));
    clients_.erase(found);
  } else if (header.type == "shutdown") {
    end_reason_ = in_quotes(client.name) + " shut it down";
  } else {
    throw RefusedError(ErrorCode::kOutOfOrder, "'" + header.type + "' needs a daemon that knows its users (--keys).");
  }
  send(identity, encode_accepted({header.id, 0}));
}

void Server::greet(const std::string& identity, const Hello& hello) {
  if (!same_secret(hello.token, options_.token)) {
    throw RefusedError(ErrorCode::kUnauthorized,
                       "The token is wrong; start the daemon and the client with the same token.");
  }
  heard_ = Clock::now();
  if (const auto found = clients_.find(identity); found != clients_.end()) {
    found->second.heard = heard_;
    return;
  }
  if (clients_.size() + retired_.size() >= options_.max_clients && !make_room()) {
    throw RefusedError(ErrorCode::kOutOfOrder, "The daemon serves " + std::to_string(options_.max_clients) +
                                                   " clients already; close one, or start another daemon.");
  }
  auto worker = std::make_unique<Worker>(context_, replies_endpoint_, identity, factory_, options_.max_message_bytes);
  clients_.emplace(identity, Client{hello.client, std::move(worker), heard_});
  spdlog::info("{} says hello", in_quotes(hello.client));
}

void Server::send(const std::string& identity, const std::vector<PartBytes>& parts) {
  if (!router_.send(zmq::buffer(identity), zmq::send_flags::sndmore | zmq::send_flags::dontwait)) return;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool last = i + 1 == parts.size();
    router_.send(zmq::buffer(parts[i]), last ? zmq::send_flags::none : zmq::send_flags::sndmore);
  }
}

void Server::forward_replies() {
  while (true) {
    zmq::message_t identity;
    if (!replies_.recv(identity, zmq::recv_flags::dontwait)) return;
    bool more = identity.more();
    // Replies to a client that is gone are dropped by the ROUTER.
    router_.send(identity, more ? zmq::send_flags::sndmore : zmq::send_flags::none);
    while (more) {
      zmq::message_t part;
      if (!replies_.recv(part, zmq::recv_flags::none)) return;
      more = part.more();
      router_.send(part, more ? zmq::send_flags::sndmore : zmq::send_flags::none);
    }
  }
}

void Server::drop_idle_clients() {
  std::erase_if(retired_, [](const auto& worker) { return worker->finished(); });
  const auto now = Clock::now();
  for (auto client = clients_.begin(); client != clients_.end();) {
    if (now - client->second.heard > options_.silence) {
      spdlog::warn("{} was silent for too long and is dropped", in_quotes(client->second.name));
      retire(std::move(client->second));
      client = clients_.erase(client);
    } else {
      ++client;
    }
  }
  if (!end_reason_.empty()) return;
  if (now - heard_ > options_.silence) {
    end_reason_ = "it heard nothing for " + std::to_string(options_.silence.count() / 1000) + " s";
  } else if (parent_.ended()) {
    end_reason_ = "its parent process " + std::to_string(options_.parent) + " ended";
  }
}

// Drops the client that was silent longest, if that is longer than one that lives is.
bool Server::make_room() {
  const auto longest = std::ranges::min_element(clients_, {}, [](const auto& client) { return client.second.heard; });
  if (longest == clients_.end() || Clock::now() - longest->second.heard <= options_.silence_where_full) return false;
  spdlog::warn("{} was silent for too long and makes room", in_quotes(longest->second.name));
  retire(std::move(longest->second));
  clients_.erase(longest);
  return true;
}

void Server::retire(Client client) {
  client.worker->stop();
  retired_.push_back(std::move(client.worker));
}

}  // namespace lappet
