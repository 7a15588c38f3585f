#include "server/message.h"

#define MSGPACK_NO_BOOST
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <msgpack.hpp>

#include "lattice/refused.h"
#include "lattice/surface_box.h"

namespace lappet {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the wire is little-endian and arrays are copied as they are");

constexpr std::size_t kMaxDepth = 5;
constexpr std::size_t kMaxMapEntries = 64;
constexpr std::uint64_t kMaxElements = std::uint64_t{1} << 40;

Value to_value(const msgpack::object& object, std::size_t depth) {
  if (depth > kMaxDepth) malformed("The header is nested deeper than " + std::to_string(kMaxDepth) + " levels.");
  switch (object.type) {
    case msgpack::type::BOOLEAN:
      return object.via.boolean;
    case msgpack::type::POSITIVE_INTEGER:
      return object.via.u64;
    case msgpack::type::NEGATIVE_INTEGER:
      return object.via.i64;
    case msgpack::type::FLOAT32:
    case msgpack::type::FLOAT64:
      return object.via.f64;
    case msgpack::type::STR:
      return std::string(object.via.str.ptr, object.via.str.size);
    case msgpack::type::ARRAY: {
      std::vector<Value> list;
      list.reserve(object.via.array.size);
      for (std::uint32_t i = 0; i < object.via.array.size; ++i) {
        list.push_back(to_value(object.via.array.ptr[i], depth + 1));
      }
      return list;
    }
    case msgpack::type::MAP: {
      Fields fields;
      for (std::uint32_t i = 0; i < object.via.map.size; ++i) {
        const msgpack::object_kv& entry = object.via.map.ptr[i];
        if (entry.key.type != msgpack::type::STR) malformed("A key of the header is not a text.");
        std::string key(entry.key.via.str.ptr, entry.key.via.str.size);
        Value value = to_value(entry.val, depth + 1);
        if (!fields.emplace(key, std::move(value)).second) malformed("The header holds " + in_quotes(key) + " twice.");
      }
      return fields;
    }
    default:
      malformed("The header holds a value that is neither number, text, truth value, list nor map.");
  }
}

msgpack::object_handle unpack(std::span<const std::byte> part) {
  const msgpack::unpack_limit limit(kMaxMapEntries, kMaxMapEntries, kMaxTextBytes, kMaxTextBytes, kMaxTextBytes,
                                    kMaxDepth);
  std::size_t offset = 0;
  msgpack::object_handle handle =
      msgpack::unpack(reinterpret_cast<const char*>(part.data()), part.size(), offset, nullptr, nullptr, limit);
  if (offset != part.size()) {
    malformed("The header part holds " + std::to_string(part.size() - offset) + " bytes after its map.");
  }
  return handle;
}

std::optional<std::uint64_t> unsigned_of(const Value& value) {
  if (const auto* whole = std::get_if<std::uint64_t>(&value)) return *whole;
  if (const auto* whole = std::get_if<std::int64_t>(&value); whole != nullptr && *whole >= 0) {
    return static_cast<std::uint64_t>(*whole);
  }
  return std::nullopt;
}

std::uint64_t take_unsigned(Fields& fields, std::string_view name) {
  const auto found = fields.find(name);
  if (found == fields.end()) malformed("The header has no field '" + std::string(name) + "'.");
  const std::optional<std::uint64_t> whole = unsigned_of(found->second);
  if (!whole) {
    malformed("The header field '" + std::string(name) + "' is " + std::string(kind_name(found->second)) +
              "; it must be a whole number of 0 or more.");
  }
  fields.erase(found);
  return *whole;
}

ElementType element_of(const std::string& name, const std::string& array) {
  for (const ElementType type :
       {ElementType::kU1, ElementType::kI4, ElementType::kI8, ElementType::kF4, ElementType::kF8}) {
    if (name == element_name(type)) return type;
  }
  malformed("The array " + in_quotes(array) + " has the dtype " + in_quotes(name) + "; known are u1, i4, i8, f4, f8.");
}

ArrayDescription to_description(const Value& value) {
  const auto* map = std::get_if<Fields>(&value);
  if (map == nullptr) malformed("An entry of 'arrays' is " + std::string(kind_name(value)) + "; it must be a map.");
  ArrayDescription array;
  FieldReader reader(*map, "arrays");
  array.name = reader.text("name");
  array.type = element_of(reader.text("dtype"), array.name);
  const auto shape = map->find("shape");
  const std::vector<Value>* list = shape == map->end() ? nullptr : std::get_if<std::vector<Value>>(&shape->second);
  if (list == nullptr) malformed("The array " + in_quotes(array.name) + " has no shape; it must be a list of lengths.");
  if (map->size() != 3) malformed("The array " + in_quotes(array.name) + " has fields besides name, dtype and shape.");
  if (list->size() > kMaxDimensions) {
    malformed("The array " + in_quotes(array.name) + " has " + std::to_string(list->size()) + " dimensions; at most " +
              std::to_string(kMaxDimensions) + " are known.");
  }
  std::uint64_t elements = 1;
  for (const Value& entry : *list) {
    const std::optional<std::uint64_t> length = unsigned_of(entry);
    if (!length)
      malformed("The shape of " + in_quotes(array.name) + " holds something else than lengths of 0 or more.");
    if (*length > kMaxElements || __builtin_mul_overflow(elements, *length, &elements) || elements > kMaxElements) {
      malformed("The array " + in_quotes(array.name) + " is too large: its shape holds the length " +
                std::to_string(*length) + ".");
    }
    array.shape.push_back(*length);
  }
  array.bytes = elements * element_bytes(array.type);
  return array;
}

std::string shape_text(std::span<const std::uint64_t> shape) {
  std::string text = "(";
  for (std::size_t i = 0; i < shape.size(); ++i) text += (i == 0 ? "" : ", ") + std::to_string(shape[i]);
  return text + ")";
}

std::string expected_text(std::span<const std::int64_t> shape) {
  std::string text = "(";
  for (std::size_t i = 0; i < shape.size(); ++i) {
    text += (i == 0 ? "" : ", ") + (shape[i] == kAny ? std::string("any") : std::to_string(shape[i]));
  }
  return text + ")";
}

// Always as float 64: the library's own pack would write whole numbers as integers, and a field keeps its kind.
void pack_real(msgpack::sbuffer& buffer, double value) {
  std::array<char, 9> bytes{'\xcb'};
  const auto bits = std::bit_cast<std::uint64_t>(value);
  for (std::size_t i = 0; i < 8; ++i) bytes[1 + i] = static_cast<char>(bits >> (56 - 8 * i));
  buffer.write(bytes.data(), bytes.size());
}

void pack(msgpack::packer<msgpack::sbuffer>& packer, msgpack::sbuffer& buffer, const Value& value) {
  std::visit(
      [&](const auto& held) {
        using Held = std::decay_t<decltype(held)>;
        if constexpr (std::is_same_v<Held, std::vector<Value>>) {
          packer.pack_array(static_cast<std::uint32_t>(held.size()));
          for (const Value& entry : held) pack(packer, buffer, entry);
        } else if constexpr (std::is_same_v<Held, Fields>) {
          packer.pack_map(static_cast<std::uint32_t>(held.size()));
          for (const auto& [key, entry] : held) {
            packer.pack(key);
            pack(packer, buffer, entry);
          }
        } else if constexpr (std::is_same_v<Held, double>) {
          pack_real(buffer, held);
        } else {
          packer.pack(held);
        }
      },
      value);
}

}  // namespace

std::string_view element_name(ElementType type) {
  static constexpr std::array<std::string_view, 5> kNames = {"u1", "i4", "i8", "f4", "f8"};
  return kNames[static_cast<std::size_t>(type)];
}

std::size_t element_bytes(ElementType type) {
  static constexpr std::array<std::size_t, 5> kBytes = {1, 4, 8, 4, 8};
  return kBytes[static_cast<std::size_t>(type)];
}

std::uint64_t guess_id(std::span<const std::byte> part) noexcept {
  try {
    if (part.empty() || part.size() > kMaxHeaderBytes) return 0;
    const msgpack::object_handle handle = unpack(part);
    const msgpack::object& object = handle.get();
    if (object.type != msgpack::type::MAP) return 0;
    for (std::uint32_t i = 0; i < object.via.map.size; ++i) {
      const msgpack::object_kv& entry = object.via.map.ptr[i];
      if (entry.key.type == msgpack::type::STR &&
          std::string_view(entry.key.via.str.ptr, entry.key.via.str.size) == "id" &&
          entry.val.type == msgpack::type::POSITIVE_INTEGER) {
        return entry.val.via.u64;
      }
    }
  } catch (const std::exception&) {  // unreadable: no id
  }
  return 0;
}

Header decode_header(std::span<const std::byte> part, std::uint64_t max_message_bytes) {
  if (part.empty()) malformed("The header part is empty.");
  if (part.size() > kMaxHeaderBytes) {
    malformed("The header part has " + std::to_string(part.size()) + " bytes; at most " +
              std::to_string(kMaxHeaderBytes) + " are read.");
  }
  Value value;
  try {
    const msgpack::object_handle handle = unpack(part);
    value = to_value(handle.get(), 0);
  } catch (const msgpack::unpack_error&) {
    malformed("The header part is not a msgpack map.");
  }
  auto* fields = std::get_if<Fields>(&value);
  if (fields == nullptr) malformed("The header part is " + std::string(kind_name(value)) + "; it must be a map.");

  const std::uint64_t version = take_unsigned(*fields, "v");
  if (version != kProtocolVersion) {
    malformed("The message speaks version " + std::to_string(version) +
              " of the protocol; this daemon speaks version " + std::to_string(kProtocolVersion) +
              ": install client and daemon from the same release.");
  }
  Header header;
  header.id = take_unsigned(*fields, "id");
  header.type = FieldReader(*fields, "header").text("type");
  fields->erase("type");
  if (fields->contains("session")) header.session = take_unsigned(*fields, "session");

  const auto arrays = fields->find("arrays");
  const std::vector<Value>* list = arrays == fields->end() ? nullptr : std::get_if<std::vector<Value>>(&arrays->second);
  if (list == nullptr) malformed("The header has no list 'arrays' (an empty one if there are none).");
  if (list->size() > kMaxArrays) {
    malformed("The message has " + std::to_string(list->size()) + " arrays; at most " + std::to_string(kMaxArrays) +
              " are read.");
  }
  std::uint64_t total = part.size();
  for (const Value& entry : *list) {
    ArrayDescription array = to_description(entry);
    for (const ArrayDescription& other : header.arrays) {
      if (other.name == array.name) malformed("The message holds the array " + in_quotes(array.name) + " twice.");
    }
    total += array.bytes;  // no overflow: at most 32 arrays of 2^43 bytes
    if (total > max_message_bytes) {
      malformed("The message needs " + std::to_string(total) + " bytes or more up to its array " +
                in_quotes(array.name) + "; this daemon takes " + std::to_string(max_message_bytes) + ".");
    }
    header.arrays.push_back(std::move(array));
  }
  fields->erase("arrays");
  header.fields = std::move(*fields);
  return header;
}

ArrayReader::ArrayReader(const Header& header, std::span<const std::span<const std::byte>> parts)
    : header_(header), parts_(parts), read_(header.arrays.size(), false) {
  if (parts.size() != header.arrays.size()) {
    malformed("The header names " + std::to_string(header.arrays.size()) + " arrays and the message holds " +
              std::to_string(parts.size()) + " array parts.");
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const ArrayDescription& array = header.arrays[i];
    if (parts[i].size() != array.bytes) {
      malformed("The array " + in_quotes(array.name) + " has " + std::to_string(parts[i].size()) +
                " bytes; its shape " + shape_text(array.shape) + " of " + std::string(element_name(array.type)) +
                " asks for " + std::to_string(array.bytes) + ".");
    }
  }
}

bool ArrayReader::has(std::string_view name) const {
  return std::ranges::find(header_.arrays, name, &ArrayDescription::name) != header_.arrays.end();
}

std::span<const std::byte> ArrayReader::checked(std::string_view name, ElementType type,
                                                std::span<const std::int64_t> shape) {
  const auto found = std::ranges::find(header_.arrays, name, &ArrayDescription::name);
  if (found == header_.arrays.end()) malformed("'" + header_.type + "' has no array '" + std::string(name) + "'.");
  const auto index = static_cast<std::size_t>(found - header_.arrays.begin());
  if (found->type != type) {
    malformed("The array '" + found->name + "' of '" + header_.type + "' has the dtype " +
              std::string(element_name(found->type)) + "; it must be " + std::string(element_name(type)) + ".");
  }
  const bool fits = std::ranges::equal(found->shape, shape, [](std::uint64_t length, std::int64_t expected) {
    return expected == kAny || length == static_cast<std::uint64_t>(expected);
  });
  if (!fits) {
    malformed("The array '" + found->name + "' of '" + header_.type + "' has the shape " + shape_text(found->shape) +
              "; it must be " + expected_text(shape) + ".");
  }
  read_[index] = true;
  return parts_[index];
}

std::vector<double> ArrayReader::read_finite(std::string_view name, std::initializer_list<std::int64_t> shape) {
  std::vector<double> elements = read<double>(name, shape);
  const auto bad = std::ranges::find_if(elements, [](double element) { return !std::isfinite(element); });
  if (bad != elements.end()) {
    throw RefusedError(ErrorCode::kInvalidInput, "The array '" + std::string(name) + "' holds " + std::to_string(*bad) +
                                                     " at element " + std::to_string(bad - elements.begin()) +
                                                     "; every element must be finite.");
  }
  return elements;
}

std::vector<double> ArrayReader::read_coordinates(std::string_view name, std::initializer_list<std::int64_t> shape) {
  std::vector<double> elements = read_finite(name, shape);
  check_coordinates(elements, name);
  return elements;
}

void check_coordinates(std::span<const double> elements, std::string_view array) {
  const auto bad = std::ranges::find_if(elements, [](double element) { return std::abs(element) > kMaxCoordinate; });
  if (bad == elements.end()) return;
  throw RefusedError(ErrorCode::kInvalidInput, "'" + std::string(array) + "' holds " + shown(*bad) + " at element " +
                                                   std::to_string(bad - elements.begin()) + "; at most " +
                                                   shown(kMaxCoordinate) + " is taken.");
}

void ArrayReader::finish() const {
  for (std::size_t i = 0; i < read_.size(); ++i) {
    if (!read_[i]) {
      malformed("'" + header_.type + "' has the array " + in_quotes(header_.arrays[i].name) +
                ", which this version does not know.");
    }
  }
}

void ArrayReader::copy_bytes(std::span<const std::byte> bytes, void* target) {
  if (!bytes.empty()) std::memcpy(target, bytes.data(), bytes.size());
}

MessageWriter::MessageWriter(std::string type, std::uint64_t id, std::optional<std::uint64_t> session) {
  header_.type = std::move(type);
  header_.id = id;
  header_.session = session;
}

MessageWriter& MessageWriter::field(std::string name, Value value) {
  header_.fields.insert_or_assign(std::move(name), std::move(value));
  return *this;
}

void MessageWriter::add_array(std::string name, ElementType type, std::span<const std::byte> bytes,
                              std::vector<std::uint64_t> shape) {
  std::uint64_t expected = element_bytes(type);
  for (const std::uint64_t length : shape) expected *= length;
  if (expected != bytes.size()) {
    throw RefusedError(ErrorCode::kInternal, "The reply array '" + name + "' has " + std::to_string(bytes.size()) +
                                                 " bytes and the shape " + shape_text(shape) + ".");
  }
  header_.arrays.push_back({std::move(name), type, std::move(shape), expected});
  parts_.emplace_back(bytes.begin(), bytes.end());
}

PartBytes encode_header(const Header& header) {
  msgpack::sbuffer buffer;
  msgpack::packer<msgpack::sbuffer> packer(buffer);
  packer.pack_map(static_cast<std::uint32_t>(4 + (header.session ? 1 : 0) + header.fields.size()));
  packer.pack("v").pack(kProtocolVersion);
  packer.pack("type").pack(header.type);
  packer.pack("id").pack(header.id);
  if (header.session) packer.pack("session").pack(*header.session);
  packer.pack("arrays").pack_array(static_cast<std::uint32_t>(header.arrays.size()));
  for (const ArrayDescription& array : header.arrays) {
    packer.pack_map(3);
    packer.pack("name").pack(array.name);
    packer.pack("dtype").pack(std::string(element_name(array.type)));
    packer.pack("shape").pack(array.shape);
  }
  for (const auto& [name, value] : header.fields) {
    packer.pack(name);
    pack(packer, buffer, value);
  }
  const auto bytes = std::as_bytes(std::span(buffer.data(), buffer.size()));
  return {bytes.begin(), bytes.end()};
}

std::vector<PartBytes> MessageWriter::finish() {
  std::vector<PartBytes> parts;
  parts.reserve(1 + parts_.size());
  parts.push_back(encode_header(header_));
  std::ranges::move(parts_, std::back_inserter(parts));
  return parts;
}

}  // namespace lappet
