#include "conversation.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <utility>

namespace lappet {
namespace {

constexpr std::uint32_t kMaxMessages = 4096, kMaxParts = 4096;

class Cursor {
 public:
  explicit Cursor(std::span<const std::byte> bytes) : rest_(bytes) {}
  std::optional<std::uint32_t> number() {
    std::uint32_t value = 0;
    if (rest_.size() < sizeof value) return std::nullopt;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_ = rest_.subspan(sizeof value);
    return value;
  }
  PartBytes bytes(std::size_t count) {
    const auto taken = rest_.first(std::min(count, rest_.size()));
    rest_ = rest_.subspan(taken.size());
    return {taken.begin(), taken.end()};
  }

 private:
  std::span<const std::byte> rest_;
};

void append_number(std::vector<std::byte>& to, std::size_t count) {
  const auto value = static_cast<std::uint32_t>(count);
  const auto bytes = std::as_bytes(std::span(&value, 1));
  to.insert(to.end(), bytes.begin(), bytes.end());
}

std::vector<std::byte> bytes_of_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

Conversation read_conversation(std::span<const std::byte> bytes) {
  Cursor cursor(bytes);
  Conversation result;
  const std::uint32_t messages = std::min(cursor.number().value_or(0), kMaxMessages);
  for (std::uint32_t m = 0; m < messages; ++m) {
    const auto parts = cursor.number();
    if (!parts) break;
    RawMessage message;
    for (std::uint32_t p = 0; p < std::min(*parts, kMaxParts); ++p) {
      const auto length = cursor.number();
      if (!length) break;
      message.push_back(cursor.bytes(*length));
    }
    result.push_back(std::move(message));
  }
  return result;
}

std::vector<std::byte> write_conversation(const Conversation& conversation) {
  std::vector<std::byte> result;
  append_number(result, conversation.size());
  for (const RawMessage& message : conversation) {
    append_number(result, message.size());
    for (const PartBytes& part : message) {
      append_number(result, part.size());
      result.insert(result.end(), part.begin(), part.end());
    }
  }
  return result;
}

std::vector<NamedConversation> load_corpus(const std::filesystem::path& place) {
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_directory(place)) {
    for (const auto& entry : std::filesystem::directory_iterator(place))
      if (entry.path().extension() == ".messages") files.push_back(entry.path());
  } else {
    files.push_back(place);
  }
  if (files.empty()) throw std::runtime_error("there is no .messages file in " + place.string());
  std::ranges::sort(files);  // a seed means the same everywhere
  std::vector<NamedConversation> result;
  for (const auto& file : files) result.push_back({file.stem().string(), read_conversation(bytes_of_file(file))});
  return result;
}

void save(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  std::ofstream stream(file, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!stream) throw std::runtime_error("cannot write " + file.string());
}

}  // namespace lappet
