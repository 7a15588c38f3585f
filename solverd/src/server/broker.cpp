#include "server/broker.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <utility>

#include "server/encode.h"

namespace lappet {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTick{250}, kHurry{10};
constexpr milliseconds kRefresh{500};     // of the users' folder
constexpr milliseconds kLastWords{2000};  // of a connection whose user is none any more
constexpr milliseconds kFarewell{200};    // for replies on their way when the daemon ends
constexpr int kMessagesPerTurn = 16;
constexpr int kIoThreads = 1, kMaxSockets = 4096;

}  // namespace

Broker::Broker(BrokerOptions options)
    : options_(std::move(options)),
      keys_(options_.keys),
      context_(kIoThreads, kMaxSockets),
      zap_(context_, [this](const std::string& domain, const std::string& key) { return decide(domain, key); }),
      gate_(options_.address, options_.gate),
      heard_(Clock::now()),
      refreshed_(heard_) {}

Broker::~Broker() {
  for (auto& [number, peer] : peers_) end_session(*peer);
  peers_.clear();
  ending_.clear();  // waits for the processes
}

std::string Broker::run() {
  heard_ = Clock::now();
  while (end_reason_.empty()) wait_and_serve();
  const auto end = Clock::now() + kFarewell;
  while (Clock::now() < end) {
    hurry_ = true;
    wait_and_serve();
  }
  return end_reason_;
}

void Broker::wait_and_serve() {
  std::vector<zmq::pollitem_t> items = {{zap_.socket().handle(), 0, ZMQ_POLLIN, 0},
                                        {nullptr, options_.signals, ZMQ_POLLIN, 0},
                                        {nullptr, options_.serves_one ? options_.input : -1, ZMQ_POLLIN, 0}};
  const std::size_t own = items.size();
  gate_.add_items(items);
  const std::size_t gates = items.size() - own;
  for (auto& [number, peer] : peers_) {
    const bool throttled = !peer->user.empty() && is_throttled(*peer);
    const bool reads = !peer->user.empty() && !throttled;
    hurry_ = hurry_ || throttled;
    const int events = (reads ? ZMQ_POLLIN : 0) | (peer->has_unsent() ? ZMQ_POLLOUT : 0);
    items.push_back({peer->socket().handle(), 0, static_cast<short>(events), 0});
    if (!peer->session) continue;
    items.push_back({peer->session->process().socket().handle(), 0, ZMQ_POLLIN, 0});
    items.push_back({nullptr, peer->session->process().life(), ZMQ_POLLIN, 0});
  }
  try {
    zmq::poll(items, hurry_ || !ending_.empty() ? kHurry : kTick);
  } catch (const zmq::error_t& error) {
    if (error.num() != EINTR) throw;
    return;
  }
  hurry_ = false;
  zap_.answer();
  if (items[1].revents != 0 && end_reason_.empty()) end_reason_ = "it was told to by a signal";
  if (items[2].revents != 0 && end_reason_.empty()) {
    std::array<char, 256> ignored{};
    const ssize_t count = ::read(options_.input, ignored.data(), ignored.size());
    if (count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN)) end_reason_ = "its standard input closed";
  }
  gate_.serve(std::span(items).subspan(own, gates));
  welcome_arrived();
  drop_gone();
  serve_peers();
  serve_sessions();
  look_after_users();
  look_after_peers();
  look_after_itself();
  reap();
}

// Says whose a handshake is. The domain is the number of its connection.
std::optional<std::string> Broker::decide(const std::string& domain, const std::string& public_key) {
  Number number = 0;
  std::from_chars(domain.data(), domain.data() + domain.size(), number);
  const auto peer = peers_.find(number);
  if (peer == peers_.end() || !end_reason_.empty()) return std::nullopt;
  refresh_users();
  const User* const user = keys_.with_key(public_key);
  if (user == nullptr) {
    spdlog::info("a peer with an unknown key is refused");
    return std::nullopt;
  }
  const auto theirs =
      std::ranges::count_if(peers_, [&](const auto& entry) { return entry.second->user == user->name; });
  if (static_cast<std::size_t>(theirs) >= options_.connections_per_user ||
      !gate_.admit(number, kBytesBeforeHello + kEnvelopeBytes)) {
    spdlog::warn("{} has {} connections already; another one is refused", user->name, theirs);
    return std::nullopt;
  }
  peer->second->user = user->name;
  peer->second->public_key = public_key;
  peer->second->heard = Clock::now();
  return user->name;
}

void Broker::welcome_arrived() {
  for (const Number number : gate_.take_arrived()) {
    const std::string path = folder_.path() + "/c" + std::to_string(number);
    try {
      auto peer = std::make_unique<BrokerPeer>(context_, path, keys_.secret_key(), std::to_string(number),
                                               options_.max_message_bytes);
      if (gate_.join(number, path)) {
        peers_.emplace(number, std::move(peer));
      } else {
        gate_.close(number);
      }
    } catch (const zmq::error_t& error) {  // no descriptor or no memory is left
      spdlog::error("A connection is refused: {}.", error.what());
      gate_.close(number);
    }
    ::unlink(path.c_str());  // nobody else comes this way
  }
}

void Broker::drop_gone() {
  for (const Number number : gate_.take_gone()) drop(number, "");
}

void Broker::drop(Number number, const std::string& why) {
  gate_.close(number);
  const auto found = peers_.find(number);
  if (found == peers_.end()) return;
  BrokerPeer& peer = *found->second;
  if (!why.empty()) spdlog::warn("A connection of {} is closed: {}.", peer.user, why);
  end_session(peer);
  peers_.erase(found);
}

void Broker::serve_peers() {
  for (auto& [number, peer] : peers_) {
    if (peer->user.empty()) continue;
    if (peer->has_unsent()) peer->flush();
    for (int i = 0; i < kMessagesPerTurn && end_reason_.empty() && !is_throttled(*peer); ++i) {
      std::optional<BrokerPeer::Incoming> message = peer->receive(message_bytes(*peer));
      if (!message) break;
      gate_.count_message(number);
      messages_.find(peer->user)->second.take(Clock::now());
      handle(number, *peer, std::move(*message));
    }
  }
  for (const Number number : std::exchange(to_drop_, {})) drop(number, "it does not read what it is sent");
}

void Broker::serve_sessions() {
  for (auto& [number, peer] : peers_) {
    if (peer->session) serve_session(number, *peer);
  }
  for (const Number number : std::exchange(to_drop_, {})) drop(number, "it does not read what it is sent");
}

void Broker::serve_session(Number number, BrokerPeer& peer) {
  BrokeredSession& session = *peer.session;
  try {
    const bool ended = !session.process().lives() && session.process().reaped();  // then nothing more will come
    while (std::optional<BrokeredSession::Reply> reply = session.receive()) {
      if (reply->shown && session.number()) show(*session.number(), *reply);
      if (reply->progress && peer.has_unsent()) continue;
      if (peer.send(std::move(reply->parts), options_.max_unread_bytes)) continue;
      to_drop_.push_back(number);
      return;
    }
    if (ended || session.overdue(Clock::now())) {
      const auto [code, sentence] = session.epitaph();
      end_session(number, peer, code, sentence);
      return;
    }
    hurry_ = hurry_ || !session.process().lives();
  } catch (const RefusedError& error) {
    end_session(number, peer, error.code(), error.what());
    return;
  }
  if (session.over()) end_session(peer);
}

void Broker::end_session(BrokerPeer& peer) {
  if (!peer.session) return;
  const std::optional<std::uint64_t> number = peer.session->number();
  peer.session->process().kill();
  ending_.push_back(std::move(peer.session));
  if (number) tell_the_end(*number);
}

// Says so to whoever waits for an answer.
void Broker::end_session(Number number, BrokerPeer& peer, ErrorCode code, const std::string& sentence) {
  if (!peer.session) return;
  spdlog::warn("A session of {} ends: {}", peer.user, sentence);
  for (const std::uint64_t id : peer.session->unanswered()) send(number, peer, encode_error({id, 0}, code, sentence));
  end_session(peer);
}

void Broker::refresh_users() {
  keys_.refresh();
  refreshed_ = Clock::now();
}

void Broker::look_after_users() {
  if (Clock::now() - refreshed_ < kRefresh) return;
  refresh_users();
  for (auto& [number, peer] : peers_) {
    if (peer->user.empty() || peer->refused) continue;
    try {
      user_of(*peer);
    } catch (const RefusedError& error) {
      end_session(number, *peer, error.code(), error.what());
    }
  }
}

void Broker::look_after_peers() {
  const auto now = Clock::now();
  std::vector<std::pair<Number, std::string>> over;
  for (auto& [number, peer] : peers_) {
    if (peer->user.empty()) continue;  // the gate looks after them
    const auto silent = now - peer->heard;
    if (peer->refused && now - *peer->refused > kLastWords) {
      over.emplace_back(number, "its user is not known any more");
    } else if (silent > (peer->greeted ? options_.silence : options_.hello)) {
      over.emplace_back(number, peer->greeted ? "it was silent for too long" : "it did not say hello");
    } else if (gate_.is_flooding(number, now) && !is_throttled(*peer) &&
               (peer->socket().get(zmq::sockopt::events) & ZMQ_POLLIN) == 0) {
      over.emplace_back(number, "it sends a message that does not end");
    }
  }
  for (const auto& [number, why] : over) drop(number, why);
}

void Broker::look_after_itself() {
  if (!options_.serves_one || !end_reason_.empty()) return;
  if (Clock::now() - heard_ > options_.silence) {
    end_reason_ = "it heard nothing for " + std::to_string(options_.silence.count() / 1000) + " s";
  } else if (options_.parent != 0 && ::kill(options_.parent, 0) != 0 && errno == ESRCH) {
    end_reason_ = "its parent process " + std::to_string(options_.parent) + " ended";
  }
}

void Broker::reap() {
  std::erase_if(ending_, [](const auto& session) { return session->process().reaped(); });
}

}  // namespace lappet
