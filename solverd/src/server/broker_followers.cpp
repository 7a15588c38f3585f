// Sessions that others follow: what their solver answers to `epoch` and `solve`, they see too.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "server/broker.h"
#include "server/encode.h"

namespace lappet {

// Throws RefusedError(kOutOfOrder) for a session that is not there and for one that this user may not follow alike.
void Broker::follow(BrokerPeer& peer, const Header& header) {
  if (!header.session) throw RefusedError(ErrorCode::kMalformed, "'follow' names no session.");
  const auto found = std::ranges::find_if(peers_, [&](const auto& entry) {
    const BrokerPeer& other = *entry.second;
    return other.session && other.session->number() == header.session &&
           (other.user == peer.user || other.session->shared);
  });
  if (found == peers_.end()) {
    throw RefusedError(ErrorCode::kOutOfOrder, "There is no session " + std::to_string(*header.session) + " that " +
                                                   peer.user + " may follow.");
  }
  peer.following = BrokerPeer::Following{*header.session, header.id};
  spdlog::info("{} follows session {}", peer.user, *header.session);
}

void Broker::share(BrokerPeer& peer) {
  if (!peer.session || !peer.session->number()) {
    throw RefusedError(ErrorCode::kOutOfOrder, "'share' needs a session; send 'open' first.");
  }
  peer.session->shared = true;
}

// Each gets it with the id of their `follow`. Progress is left out for those who have not read the last.
void Broker::show(std::uint64_t session, const BrokeredSession::Reply& reply) {
  for (auto& [number, peer] : peers_) {
    if (!peer->following || peer->following->session != session || (reply.progress && peer->has_unsent())) continue;
    Header header = *reply.shown;
    header.id = peer->following->id;
    const PartBytes first = encode_header(header);
    BrokerPeer::Parts parts;
    parts.emplace_back(first.data(), first.size());
    for (std::size_t i = 1; i < reply.parts.size(); ++i) {
      zmq::message_t part;
      part.copy(const_cast<zmq::message_t&>(reply.parts[i]));  // shares the bytes
      parts.push_back(std::move(part));
    }
    if (!peer->send(std::move(parts), options_.max_unread_bytes)) to_drop_.push_back(number);
  }
}

void Broker::tell_the_end(std::uint64_t session) {
  for (auto& [number, peer] : peers_) {
    if (!peer->following || peer->following->session != session) continue;
    const std::uint64_t id = std::exchange(peer->following, std::nullopt)->id;
    send(number, *peer,
         encode_error({id, session}, ErrorCode::kCancelled, "Session " + std::to_string(session) + " is over."));
  }
}

}  // namespace lappet
