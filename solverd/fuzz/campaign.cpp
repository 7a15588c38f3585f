#include "campaign.h"

#include <string>
#include <utility>

#include "lattice/refused.h"
#include "mutation.h"
#include "replay.h"
#include "server/encode.h"

namespace lappet {
namespace {

using Replies = std::vector<std::vector<PartBytes>>;

const RawMessage& any_message(const std::vector<NamedConversation>& corpus, Mutation& mutation) {
  while (true) {
    const Conversation& messages = corpus[mutation.below(corpus.size())].messages;
    if (!messages.empty()) return messages[mutation.below(messages.size())];
  }
}

Replies play_all(Replay& replay, const Conversation& conversation, const Recorder& record) {
  Replies replies;
  for (const RawMessage& message : conversation) {
    record(message);
    replies.push_back(replay.play(message));
  }
  return replies;
}

// Time is the only thing by which the same messages may end in another way.
bool ran_out_of_time(const Replies& replies) {
  for (const auto& reply : replies) {
    const Header header = decode_header(reply.front());
    if (header.type == "error" && std::get<std::string>(header.fields.at("code")) == "time_budget") return true;
  }
  return false;
}

void require_same(const Replies& before, const Replies& after) {
  if (ran_out_of_time(before) || ran_out_of_time(after)) return;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const std::string was = decode_header(before[i].front()).type, is = decode_header(after[i].front()).type;
    if (was != is)
      throw Finding("message " + std::to_string(i) + " was answered by '" + was + "', in a new session by '" + is +
                    "'");
    for (std::size_t k = 1; k < before[i].size(); ++k)
      if (before[i][k] != after[i][k])
        throw Finding("message " + std::to_string(i) + " was answered with other numbers in a new session");
  }
}

void play_session(const std::vector<NamedConversation>& corpus, Mutation& mutation, const Recorder& record) {
  const Conversation& base = corpus[mutation.below(corpus.size())].messages;
  Replay replay;
  const Replies before = play_all(replay, base, record);
  for (std::size_t i = 0; i < kBlock; ++i) {
    const bool own = !base.empty() && !mutation.once_in(4);
    const RawMessage& message = own ? base[mutation.below(base.size())] : any_message(corpus, mutation);
    const RawMessage spoilt = mutation(message, any_message(corpus, mutation));
    record(spoilt);
    replay.play(spoilt);
  }
  const RawMessage close = MessageWriter("close", 1).finish();
  record(close);
  replay.play(close);
  require_same(before, play_all(replay, base, record));
}

}  // namespace

void play_block(const std::vector<NamedConversation>& corpus, std::uint64_t seed, std::uint64_t block,
                std::uint64_t session_every, const Recorder& record) {
  std::seed_seq mixed{seed, seed >> 32, block, block >> 32};
  std::mt19937_64 start(mixed);
  Mutation mutation(start());
  if (block % session_every == 0) return play_session(corpus, mutation, record);
  for (std::size_t i = 0; i < kBlock; ++i) {
    const RawMessage spoilt = mutation(any_message(corpus, mutation), any_message(corpus, mutation));
    record(spoilt);
    decode_alone(spoilt);
  }
}

}  // namespace lappet
