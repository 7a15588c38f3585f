// One message of the wire (PROTOCOL.md): a msgpack header part and one raw little-endian part per array, both ways.
//
// Everything that comes from a client is checked here, before anything is allocated for it: what cannot be read is
// RefusedError(kMalformed) with a sentence that names the field, its value and what is expected.
#pragma once
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/fields.h"

namespace lappet {

inline constexpr std::uint64_t kProtocolVersion = 1;
inline constexpr std::size_t kMaxHeaderBytes = 64 * 1024;
inline constexpr std::size_t kMaxArrays = 32;
inline constexpr std::size_t kMaxDimensions = 4;
inline constexpr std::size_t kMaxTextBytes = 4096;
inline constexpr std::uint64_t kDefaultMaxMessageBytes = std::uint64_t{1} << 30;

enum class ElementType { kU1, kI4, kI8, kF4, kF8 };
std::string_view element_name(ElementType type);
std::size_t element_bytes(ElementType type);

template <class T>
inline constexpr ElementType kElementOf = [] {
  static_assert(std::is_same_v<T, std::uint8_t> || std::is_same_v<T, std::int32_t> || std::is_same_v<T, std::int64_t> ||
                    std::is_same_v<T, float> || std::is_same_v<T, double>,
                "not an element type of the protocol");
  if constexpr (std::is_same_v<T, std::uint8_t>) return ElementType::kU1;
  if constexpr (std::is_same_v<T, std::int32_t>) return ElementType::kI4;
  if constexpr (std::is_same_v<T, std::int64_t>) return ElementType::kI8;
  if constexpr (std::is_same_v<T, float>) return ElementType::kF4;
  return ElementType::kF8;
}();

struct ArrayDescription {
  std::string name;
  ElementType type = ElementType::kF8;
  std::vector<std::uint64_t> shape;
  std::uint64_t bytes = 0;  // elements times element size, overflow excluded
};

struct Header {
  std::string type;
  std::uint64_t id = 0;
  std::optional<std::uint64_t> session;
  std::vector<ArrayDescription> arrays;
  Fields fields;  // all others
};

// The id of a header that may be unreadable otherwise, so that the error reply reaches its request; 0 if there is none.
std::uint64_t guess_id(std::span<const std::byte> part) noexcept;

// Reads a header part. `max_message_bytes` bounds what its arrays may take together.
Header decode_header(std::span<const std::byte> part, std::uint64_t max_message_bytes = kDefaultMaxMessageBytes);

inline constexpr std::int64_t kAny = -1;  // a free dimension in an expected shape

// The arrays of one message by name, checked against the dtype and the shape that the message type asks for.
class ArrayReader {
 public:
  // Checks that there is one part per described array and that each has the described length.
  ArrayReader(const Header& header, std::span<const std::span<const std::byte>> parts);

  // Whether there is such an array; for those that may be left out.
  bool has(std::string_view name) const;
  // A copy of the elements in C order. In `shape`, kAny stands for any length.
  template <class T>
  std::vector<T> read(std::string_view name, std::initializer_list<std::int64_t> shape) {
    const std::span<const std::byte> bytes = checked(name, kElementOf<T>, shape);
    std::vector<T> elements(bytes.size() / sizeof(T));
    copy_bytes(bytes, elements.data());
    return elements;
  }
  // The same for floating-point arrays, refusing (kInvalidInput) what is not finite.
  std::vector<double> read_finite(std::string_view name, std::initializer_list<std::int64_t> shape);
  // The same for coordinates in mm, refusing also those beyond kMaxCoordinate.
  std::vector<double> read_coordinates(std::string_view name, std::initializer_list<std::int64_t> shape);
  // Refuses arrays that nobody read.
  void finish() const;

 private:
  std::span<const std::byte> checked(std::string_view name, ElementType type, std::span<const std::int64_t> shape);
  std::span<const std::byte> checked(std::string_view name, ElementType type,
                                     std::initializer_list<std::int64_t> shape) {
    return checked(name, type, std::span<const std::int64_t>(shape.begin(), shape.size()));
  }
  static void copy_bytes(std::span<const std::byte> bytes, void* target);

  const Header& header_;
  std::span<const std::span<const std::byte>> parts_;
  std::vector<bool> read_;
};

// Refuses (kInvalidInput) what lies beyond kMaxCoordinate (lattice/surface_box.h); NaN passes.
void check_coordinates(std::span<const double> elements, std::string_view array);

using PartBytes = std::vector<std::byte>;

// A header's part, as `decode_header` reads it.
PartBytes encode_header(const Header& header);

// Builds a message: header fields and arrays in any order, then `finish` for its parts, the header first.
class MessageWriter {
 public:
  MessageWriter(std::string type, std::uint64_t id, std::optional<std::uint64_t> session = std::nullopt);

  MessageWriter& field(std::string name, Value value);
  template <class T>
  MessageWriter& array(std::string name, std::span<const T> elements, std::vector<std::uint64_t> shape) {
    add_array(std::move(name), kElementOf<T>, std::as_bytes(elements), std::move(shape));
    return *this;
  }
  std::vector<PartBytes> finish();  // once: the arrays are moved out

 private:
  void add_array(std::string name, ElementType type, std::span<const std::byte> bytes,
                 std::vector<std::uint64_t> shape);

  Header header_;
  std::vector<PartBytes> parts_;
};

}  // namespace lappet
