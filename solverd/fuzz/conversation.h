// The messages that one client sends, in order, as they lie in a file of tests/daemon/corpus: the number of messages;
// of each the number of its parts; of each the number of its bytes and these. Numbers have 4 bytes, little-endian.
#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "server/message.h"

namespace lappet {

using RawMessage = std::vector<PartBytes>;  // header, arrays
using Conversation = std::vector<RawMessage>;

// Any bytes are a conversation: what is cut off ends it.
Conversation read_conversation(std::span<const std::byte> bytes);
std::vector<std::byte> write_conversation(const Conversation& conversation);

struct NamedConversation {
  std::string name;
  Conversation messages;
};

// Of every file of a folder, or of one file. Throws std::runtime_error where there is none.
std::vector<NamedConversation> load_corpus(const std::filesystem::path& place);
void save(const std::filesystem::path& file, std::span<const std::byte> bytes);

}  // namespace lappet
