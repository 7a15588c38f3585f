#include "loose_message.h"

#define MSGPACK_NO_BOOST
#include <algorithm>
#include <msgpack.hpp>
#include <stdexcept>
#include <utility>

namespace lappet {
namespace {

constexpr std::size_t kMaxEntries = 1024;

Value to_value(const msgpack::object& object) {
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
      for (std::uint32_t i = 0; i < object.via.array.size; ++i) list.push_back(to_value(object.via.array.ptr[i]));
      return list;
    }
    case msgpack::type::MAP: {
      Fields fields;
      for (std::uint32_t i = 0; i < object.via.map.size; ++i) {
        const msgpack::object_kv& entry = object.via.map.ptr[i];
        fields.insert_or_assign(entry.key.as<std::string>(), to_value(entry.val));
      }
      return fields;
    }
    default:
      throw std::invalid_argument("a kind of value that the protocol does not use");
  }
}

void write_value(msgpack::packer<msgpack::sbuffer>& packer, const Value& value) {
  std::visit(
      [&]<class Held>(const Held& held) {
        if constexpr (std::is_same_v<Held, std::vector<Value>>) {
          packer.pack_array(static_cast<std::uint32_t>(held.size()));
          for (const Value& entry : held) write_value(packer, entry);
        } else if constexpr (std::is_same_v<Held, Fields>) {
          packer.pack_map(static_cast<std::uint32_t>(held.size()));
          for (const auto& [key, entry] : held) {
            packer.pack(key);
            write_value(packer, entry);
          }
        } else {
          packer.pack(held);
        }
      },
      value);
}

std::optional<ElementType> type_named(const Value* name) {
  const auto* text = name == nullptr ? nullptr : std::get_if<std::string>(name);
  for (const ElementType type :
       {ElementType::kU1, ElementType::kI4, ElementType::kI8, ElementType::kF4, ElementType::kF8})
    if (text != nullptr && *text == element_name(type)) return type;
  return std::nullopt;
}

Value* find(Fields& fields, std::string_view name) {
  const auto found = fields.find(name);
  return found == fields.end() ? nullptr : &found->second;
}

// Fills in rows where the shape says what the part holds.
void measure(LooseArray& array) {
  std::uint64_t in_row = element_bytes(array.type);
  for (std::size_t d = 1; d < array.shape->size(); ++d) {
    const auto* length = std::get_if<std::uint64_t>(&(*array.shape)[d]);
    if (length == nullptr || *length > 4096) return;
    in_row *= *length;
  }
  const auto* rows = array.shape->empty() ? nullptr : std::get_if<std::uint64_t>(&array.shape->front());
  if (rows == nullptr || in_row == 0 || array.part->size() % in_row != 0 || array.part->size() / in_row != *rows)
    return;
  array.rows = *rows;
  array.row_bytes = in_row;
}

}  // namespace

std::optional<LooseMessage> read_loosely(const RawMessage& message) {
  if (message.empty()) return std::nullopt;
  try {
    const PartBytes& header = message.front();
    const msgpack::unpack_limit limit(kMaxEntries, kMaxEntries, kMaxHeaderBytes, kMaxHeaderBytes, kMaxHeaderBytes, 32);
    const auto handle =
        msgpack::unpack(reinterpret_cast<const char*>(header.data()), header.size(), nullptr, nullptr, limit);
    Value value = to_value(handle.get());
    auto* fields = std::get_if<Fields>(&value);
    if (fields == nullptr) return std::nullopt;
    return LooseMessage{std::move(*fields), {message.begin() + 1, message.end()}};
  } catch (const std::exception&) {  // no map that can be read
    return std::nullopt;
  }
}

RawMessage write_loosely(const LooseMessage& message) {
  msgpack::sbuffer buffer;
  msgpack::packer<msgpack::sbuffer> packer(buffer);
  write_value(packer, message.header);
  const auto header = std::as_bytes(std::span(buffer.data(), buffer.size()));
  RawMessage result{PartBytes(header.begin(), header.end())};
  result.insert(result.end(), message.parts.begin(), message.parts.end());
  return result;
}

std::vector<LooseArray> arrays_of(LooseMessage& message) {
  std::vector<LooseArray> result;
  Value* listed = find(message.header, "arrays");
  auto* list = listed == nullptr ? nullptr : std::get_if<std::vector<Value>>(listed);
  if (list == nullptr) return result;
  for (std::size_t i = 0; i < std::min(list->size(), message.parts.size()); ++i) {
    LooseArray array;
    array.entry = std::get_if<Fields>(&(*list)[i]);
    if (array.entry == nullptr) continue;
    Value* shape = find(*array.entry, "shape");
    array.shape = shape == nullptr ? nullptr : std::get_if<std::vector<Value>>(shape);
    array.part = &message.parts[i];
    const auto type = type_named(find(*array.entry, "dtype"));
    if (array.shape == nullptr || !type) continue;
    array.type = *type;
    measure(array);
    result.push_back(array);
  }
  return result;
}

}  // namespace lappet
