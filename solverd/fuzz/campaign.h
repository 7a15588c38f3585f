// Mutated messages in numbered blocks. A block is the same for the same corpus, seed and number, whoever plays it.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "conversation.h"

namespace lappet {

inline constexpr std::size_t kBlock = 64;  // mutated messages in a block

// What a block has played until now; called before each message, so that what ends the program is known.
using Recorder = std::function<void(const RawMessage&)>;

// One block in `session_every` is a session: a conversation of the corpus, mutated messages, and the conversation
// again, which must be answered as before, bit for bit. The others decode mutated messages without solving, which costs
// a hundredth of it. Throws Finding.
void play_block(const std::vector<NamedConversation>& corpus, std::uint64_t seed, std::uint64_t block,
                std::uint64_t session_every, const Recorder& record);

}  // namespace lappet
