// What the broker answers to each message (PROTOCOL.md), and who may send it.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <new>
#include <thread>
#include <utility>

#include "server/broker.h"
#include "server/decode.h"
#include "server/encode.h"

namespace lappet {
namespace {

constexpr std::chrono::milliseconds kBetweenHellos{50};  // a folder of many users takes some milliseconds to read
constexpr double kGiB = 1024.0 * 1024.0 * 1024.0;
constexpr std::size_t kEndingForEach = 2;  // processes that are killed but not gone yet, for each session

std::span<const std::byte> bytes_of(const zmq::message_t& part) {
  return {static_cast<const std::byte*>(part.data()), part.size()};
}

}  // namespace

void Broker::handle(Number number, BrokerPeer& peer, BrokerPeer::Incoming message) {
  const std::uint64_t id = message.parts.empty() ? 0 : guess_id(bytes_of(message.parts.front()));
  const auto refuse_it = [&](ErrorCode code, const std::string& sentence) {
    spdlog::info("{}: message {}: {}: {}", peer.user, id, error_name(code), sentence);
    send(number, peer, encode_error({id, 0}, code, sentence));
  };
  try {
    dispatch(number, peer, std::move(message));
  } catch (const RefusedError& error) {
    refuse_it(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    refuse_it(ErrorCode::kMemoryBudget, "The machine's memory is spent.");
  } catch (const zmq::error_t& error) {
    refuse_it(ErrorCode::kInternal, std::string("The daemon has no place left: ") + error.what() + ".");
  } catch (const std::exception& error) {
    refuse_it(ErrorCode::kInternal, std::string("A fault of the daemon: ") + error.what() + ".");
  }
}

void Broker::dispatch(Number number, BrokerPeer& peer, BrokerPeer::Incoming message) {
  user_of(peer);  // whoever is none any more is told so, whatever they send
  if (!message.fault.empty() || message.parts.empty()) throw RefusedError(ErrorCode::kMalformed, message.fault);
  const Header header = decode_header(bytes_of(message.parts.front()), message_bytes(peer));
  const MessageRule& rule = rule_of(header.type);
  if (header.type == "hello" && Clock::now() - refreshed_ > kBetweenHellos) refresh_users();
  const User& user = user_of(peer);
  peer.heard = heard_ = Clock::now();
  if (header.type == "hello") {
    message.parts.erase(message.parts.begin());
    greet(number, peer, user, header, message.parts);
    return;
  }
  if (!peer.greeted) {
    throw RefusedError(ErrorCode::kOutOfOrder, "'" + header.type + "' needs a greeted client; send 'hello' first.");
  }
  if (user.role < rule.least) {
    throw RefusedError(ErrorCode::kUnauthorized, "'" + header.type + "' needs the role " +
                                                     std::string(role_name(rule.least)) + "; " + user.name + " is " +
                                                     (user.role == Role::kFollower ? "a " : "an ") +
                                                     std::string(role_name(user.role)) + ".");
  }
  if (rule.work) {
    work(number, peer, user, header, std::move(message.parts));
  } else {
    answer(number, peer, user, header, message.parts.size() > 1);
  }
}

// The user as the folder has it now. Throws RefusedError(kUnauthorized) where it has none with this key any more.
const User& Broker::user_of(BrokerPeer& peer) {
  const User* const user = keys_.with_key(peer.public_key);
  if (user != nullptr && user->name == peer.user && !peer.refused) return *user;
  if (!peer.refused) peer.refused = Clock::now();
  throw RefusedError(ErrorCode::kUnauthorized, "The key of '" + peer.user + "' is not known here any more.");
}

void Broker::greet(Number number, BrokerPeer& peer, const User& user, const Header& header,
                   const BrokerPeer::Parts& arrays) {
  std::vector<std::span<const std::byte>> parts;
  for (const zmq::message_t& array : arrays) parts.push_back(bytes_of(array));
  const Hello hello = decode_hello(header, parts);
  peer.name = hello.client;
  peer.greeted = true;
  gate_.allow(number, message_bytes(peer) + kEnvelopeBytes);
  spdlog::info("{} says hello as {}", user.name, in_quotes(hello.client));
  send(number, peer, encode_welcome({header.id, 0}, limits_of(user).threads, message_bytes(peer)));
}

void Broker::work(Number number, BrokerPeer& peer, const User& user, const Header& header, BrokerPeer::Parts message) {
  if (!peer.session && header.type != "open") {
    throw RefusedError(ErrorCode::kOutOfOrder, "'" + header.type + "' needs a session; send 'open' first.");
  }
  if (!peer.session) start_session(peer, user);
  try {
    peer.session->forward(header, std::move(message));
  } catch (const zmq::error_t& error) {
    end_session(number, peer, ErrorCode::kInternal, std::string("The solver cannot be reached: ") + error.what() + ".");
    throw;
  }
}

void Broker::start_session(BrokerPeer& peer, const User& user) {
  const std::size_t theirs = sessions_of(&user.name), all = sessions_of(nullptr);
  const auto allowed =
      user.quotas.sessions ? static_cast<std::size_t>(*user.quotas.sessions) : options_.sessions_per_user;
  if (theirs >= allowed) {
    throw RefusedError(ErrorCode::kOutOfOrder, "There are " + std::to_string(theirs) + " sessions of " + user.name +
                                                   " already, as many as they may have; close one.");
  }
  if (all >= options_.max_sessions || ending_.size() >= kEndingForEach * options_.max_sessions) {
    throw RefusedError(ErrorCode::kOutOfOrder, "The daemon has " + std::to_string(all) +
                                                   " sessions already, as many as it may; try again later.");
  }
  const std::uint64_t session = next_session_++;
  SolverProcessOptions process;
  process.folder = folder_.path() + "/s" + std::to_string(session);
  process.limits = limits_of(user);
  process.max_message_bytes = message_bytes(peer);
  process.session = session;
  process.verbose = options_.verbose;
  peer.session = std::make_unique<BrokeredSession>(context_, process, user.name);
  spdlog::info("session {} of {} is process {}", session, user.name, peer.session->process().pid());
}

// The messages that no solver has to do with.
void Broker::answer(Number number, BrokerPeer& peer, const User& user, const Header& header, bool has_arrays) {
  if (has_arrays) {
    throw RefusedError(ErrorCode::kMalformed, "'" + header.type + "' has array parts; it takes none.");
  }
  decode_bare(header, {});
  if (header.type == "ping") {
    send(number, peer, encode_pong({header.id, 0}));
    return;
  }
  if (header.type == "follow") {
    follow(peer, header);
  } else if (header.type == "share") {
    share(peer);
  } else if (header.type == "cancel") {
    if (peer.session) peer.session->cancel();
  } else if (header.type == "bye") {
    end_session(peer);
    peer.greeted = false;
    peer.following.reset();
    gate_.allow(number, kBytesBeforeHello + kEnvelopeBytes);
  } else {
    end_reason_ = user.name + " shut it down";
  }
  send(number, peer, encode_accepted({header.id, 0}));
}

void Broker::send(Number number, BrokerPeer& peer, const std::vector<PartBytes>& parts) {
  if (!peer.send(parts, options_.max_unread_bytes)) to_drop_.push_back(number);
}

SessionLimits Broker::limits_of(const User& user) const {
  SessionLimits limits = options_.limits;
  if (user.quotas.memory_gib) limits.memory = static_cast<std::uint64_t>(*user.quotas.memory_gib * kGiB);
  if (user.quotas.threads) limits.threads = *user.quotas.threads;
  if (user.quotas.seconds) limits.seconds = *user.quotas.seconds;
  const int processors = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  limits.threads = limits.threads == 0 ? processors : std::min(limits.threads, processors);
  return limits;
}

std::uint64_t Broker::message_bytes(const BrokerPeer& peer) const {
  const User* const user = peer.greeted ? keys_.with_key(peer.public_key) : nullptr;
  return user == nullptr || user->role == Role::kFollower ? kBytesBeforeHello : options_.max_message_bytes;
}

bool Broker::is_throttled(const BrokerPeer& peer) {
  const double rate = options_.messages_per_second;
  return messages_.try_emplace(peer.user, rate, rate, Clock::now()).first->second.empty(Clock::now());
}

// Of one user, or of all.
std::size_t Broker::sessions_of(const std::string* user) const {
  return static_cast<std::size_t>(std::ranges::count_if(peers_, [&](const auto& entry) {
    return entry.second->session && (user == nullptr || entry.second->user == *user);
  }));
}

}  // namespace lappet
