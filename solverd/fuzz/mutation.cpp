#include "mutation.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <utility>

namespace lappet {
namespace {

using Reals = std::numeric_limits<double>;

constexpr std::array kReals = {0.0,
                               -0.0,
                               1.0,
                               -1.0,
                               0.5,
                               1e-3,
                               1e-12,
                               1e-160,
                               1e-300,
                               Reals::denorm_min(),
                               Reals::min(),
                               1e3,
                               1e8,
                               1.0000001e8,
                               1e9,
                               1e15,
                               1e20,
                               3.4e38,
                               3.5e38,
                               1e155,
                               1e300,
                               Reals::max(),
                               Reals::infinity(),
                               Reals::quiet_NaN()};
constexpr std::array<std::int64_t, 24> kWholes = {0,
                                                  1,
                                                  2,
                                                  3,
                                                  4,
                                                  8,
                                                  12,
                                                  -1,
                                                  -2,
                                                  5,
                                                  31,
                                                  32,
                                                  33,
                                                  64,
                                                  65,
                                                  255,
                                                  256,
                                                  65536,
                                                  1000000,
                                                  std::numeric_limits<std::int32_t>::max(),
                                                  std::numeric_limits<std::int32_t>::min(),
                                                  std::int64_t{1} << 40,
                                                  std::numeric_limits<std::int64_t>::max(),
                                                  std::numeric_limits<std::int64_t>::min()};
constexpr std::array<const char*, 12> kTexts = {"",          "float",    "double",          "neoHookean",
                                                "corotated", "twoLevel", "whole",           "chebyshev",
                                                "f8",        "i4",       "\x1b[2J\x00\xff", "solve"};

Value whole_value(std::int64_t whole) {
  if (whole < 0) return whole;
  return static_cast<std::uint64_t>(whole);
}

void erase_row(const LooseArray& array, std::size_t row) {
  const auto first = array.part->begin() + static_cast<std::ptrdiff_t>(row * array.row_bytes);
  array.part->erase(first, first + static_cast<std::ptrdiff_t>(array.row_bytes));
  array.shape->front() = static_cast<std::uint64_t>(array.rows - 1);
}

void repeat_row(const LooseArray& array, std::size_t row) {
  const auto first = array.part->begin() + static_cast<std::ptrdiff_t>(row * array.row_bytes);
  const PartBytes copy(first, first + static_cast<std::ptrdiff_t>(array.row_bytes));
  array.part->insert(array.part->end(), copy.begin(), copy.end());
  array.shape->front() = static_cast<std::uint64_t>(array.rows + 1);
}

void swap_rows(const LooseArray& array, std::size_t a, std::size_t b) {
  std::byte* bytes = array.part->data();
  if (a != b)
    std::swap_ranges(bytes + a * array.row_bytes, bytes + (a + 1) * array.row_bytes, bytes + b * array.row_bytes);
}

// Calls change(element by reference) with the type of the array's elements.
template <class Change>
void with_element(const LooseArray& array, std::size_t index, Change&& change) {
  const auto apply = [&]<class T>(T element) {
    std::byte* place = array.part->data() + index * sizeof(T);
    std::memcpy(&element, place, sizeof(T));
    change(element);
    std::memcpy(place, &element, sizeof(T));
  };
  if (array.type == ElementType::kU1) apply(std::uint8_t{});
  if (array.type == ElementType::kI4) apply(std::int32_t{});
  if (array.type == ElementType::kI8) apply(std::int64_t{});
  if (array.type == ElementType::kF4) apply(float{});
  if (array.type == ElementType::kF8) apply(double{});
}

std::size_t elements(const LooseArray& array) { return array.part->size() / element_bytes(array.type); }

}  // namespace

double Mutation::any_real(double near) {
  const double chosen = kReals[below(kReals.size())];
  switch (below(6)) {
    case 0:
      return -chosen;
    case 1:
      return near * (1.0 + 1e-6 * static_cast<double>(below(2000)) - 1e-3);
    case 2:
      return near + static_cast<double>(below(9)) - 4.0;
    case 3:
      return near * chosen;
    default:
      return chosen;
  }
}

std::int64_t Mutation::any_whole(std::int64_t near) {
  if (once_in(2)) return static_cast<std::int64_t>(static_cast<std::uint64_t>(near) + below(5) - 2);
  return kWholes[below(kWholes.size())];
}

Value Mutation::any_value() {
  switch (below(7)) {
    case 0:
      return once_in(2);
    case 1:
      return std::string(kTexts[below(kTexts.size())]);
    case 2:
      return std::string(below(6000), 'x');
    case 3:
      return std::vector<Value>(below(70), Value(1.0));
    case 4:
      return Fields{{"name", std::string("points")}, {"material", std::uint64_t{0}}};
    case 5:
      return any_real(1.0);
    default:
      return whole_value(any_whole(1));
  }
}

void Mutation::change_value(Value& value, std::size_t depth) {
  if (once_in(8)) {
    value = any_value();
  } else if (auto* fields = std::get_if<Fields>(&value); fields != nullptr && !fields->empty() && depth < 6) {
    const auto entry = std::next(fields->begin(), static_cast<std::ptrdiff_t>(below(fields->size())));
    if (once_in(12)) {
      fields->erase(entry);
    } else if (once_in(20)) {
      Value moved = std::move(entry->second);
      fields->erase(entry);
      fields->insert_or_assign(kTexts[below(kTexts.size())], std::move(moved));
    } else {
      change_value(entry->second, depth + 1);
    }
  } else if (auto* list = std::get_if<std::vector<Value>>(&value); list != nullptr && !list->empty() && depth < 6) {
    const std::size_t at = below(list->size());
    if (once_in(8)) {
      list->erase(list->begin() + static_cast<std::ptrdiff_t>(at));
    } else if (once_in(8)) {
      Value copy = (*list)[at];
      list->resize(list->size() + 1 + (once_in(4) ? 64 : 0), copy);
    } else {
      change_value((*list)[at], depth + 1);
    }
  } else if (const auto* real = std::get_if<double>(&value)) {
    value = any_real(*real);
  } else if (const auto* natural = std::get_if<std::uint64_t>(&value)) {
    value = once_in(6) ? Value(any_real(static_cast<double>(*natural)))
                       : whole_value(any_whole(static_cast<std::int64_t>(*natural)));
  } else if (std::holds_alternative<std::string>(value) && once_in(2)) {
    value = std::string(kTexts[below(kTexts.size())]);
  } else {
    value = any_value();
  }
}

void Mutation::change_header(LooseMessage& message) {
  static constexpr std::array<const char*, 10> kTypes = {"open", "epoch",  "state", "solve", "close",
                                                         "ping", "cancel", "bye",   "hello", "shutdown"};
  switch (below(8)) {
    case 0:
      message.header.insert_or_assign("type", std::string(kTypes[below(kTypes.size())]));
      break;
    case 1:
      message.header.insert_or_assign("session", whole_value(any_whole(1)));
      break;
    case 2:
      message.header.insert_or_assign("id", whole_value(any_whole(1)));
      break;
    default: {
      Value whole(message.header);
      change_value(whole, 0);
      if (auto* fields = std::get_if<Fields>(&whole)) message.header = std::move(*fields);
    }
  }
}

void Mutation::change_shape(LooseMessage& message) {
  auto arrays = arrays_of(message);
  if (arrays.empty()) return;
  LooseArray& array = arrays[below(arrays.size())];
  std::vector<Value>& shape = *array.shape;
  switch (below(4)) {
    case 0:
      shape.insert(shape.begin() + static_cast<std::ptrdiff_t>(below(shape.size() + 1)), whole_value(any_whole(1)));
      break;
    case 1:
      std::ranges::reverse(shape);
      break;
    case 2:
      array.entry->insert_or_assign("dtype", std::string(std::array{"u1", "i4", "i8", "f4", "f8"}[below(5)]));
      break;
    default:
      if (!shape.empty()) change_value(shape[below(shape.size())], 6);
  }
  if (!once_in(3)) return;  // else the part takes the length that the shape asks for, where that is short
  std::uint64_t bytes = element_bytes(array.type);
  for (const Value& length : shape) {
    const auto* natural = std::get_if<std::uint64_t>(&length);
    if (natural == nullptr || *natural > 4096 || (bytes *= *natural) > (1U << 20)) return;
  }
  array.part->resize(bytes);
}

void Mutation::change_bytes(PartBytes& bytes) {
  if (bytes.empty()) {
    bytes.resize(1 + below(64));
    return;
  }
  const std::size_t at = below(bytes.size());
  switch (below(4)) {
    case 0:
      bytes.resize(at);
      break;
    case 1:
      bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), 1 + below(16), static_cast<std::byte>(below(256)));
      break;
    case 2:
      bytes[at] = static_cast<std::byte>(below(256));
      break;
    default:
      bytes[at] ^= static_cast<std::byte>(1U << below(8));
  }
}

void Mutation::change_part(LooseMessage& message) {
  if (message.parts.empty() || once_in(6)) {
    message.parts.insert(message.parts.end(), 1 + (once_in(8) ? 40 : 0), PartBytes(below(64)));
    return;
  }
  const std::size_t at = below(message.parts.size());
  if (once_in(4))
    message.parts.erase(message.parts.begin() + static_cast<std::ptrdiff_t>(at));
  else
    change_bytes(message.parts[at]);
}

// The same rows of all arrays with as many, so that they still fit each other.
void Mutation::change_rows(LooseMessage& message) {
  auto arrays = arrays_of(message);
  std::erase_if(arrays, [](const LooseArray& array) { return array.rows == 0; });
  if (arrays.empty()) return;
  const std::size_t rows = arrays[below(arrays.size())].rows, row = below(rows), other = below(rows), way = below(3);
  const bool all = !once_in(4);
  const std::size_t only = below(arrays.size());
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    if (arrays[i].rows != rows || (!all && i != only)) continue;
    if (way == 0) erase_row(arrays[i], row);
    if (way == 1) repeat_row(arrays[i], row);
    if (way == 2) swap_rows(arrays[i], row, other);
  }
}

void Mutation::change_number(LooseMessage& message) {
  auto arrays = arrays_of(message);
  std::erase_if(arrays, [](const LooseArray& array) { return elements(array) == 0; });
  if (arrays.empty()) return;
  const LooseArray& array = arrays[below(arrays.size())];
  const std::size_t count = elements(array), at = below(count);
  if (once_in(5)) {  // another element of the same array
    const std::size_t size = element_bytes(array.type), from = below(count);
    std::memmove(array.part->data() + at * size, array.part->data() + from * size, size);
    return;
  }
  const std::size_t run = once_in(8) ? count - at : 1;
  for (std::size_t i = at; i < at + run; ++i)
    with_element(array, i, [&]<class T>(T& element) {
      if constexpr (std::is_same_v<T, float>) {
        const double real = any_real(static_cast<double>(element));
        element = std::abs(real) <= static_cast<double>(std::numeric_limits<float>::max())
                      ? static_cast<float>(real)
                      : std::numeric_limits<float>::infinity();
      } else if constexpr (std::is_same_v<T, double>) {
        element = any_real(element);
      } else {
        element = static_cast<T>(any_whole(static_cast<std::int64_t>(element)));
      }
    });
}

// Numbers that stay plausible: what they make is solved.
void Mutation::nudge_numbers(LooseMessage& message) {
  auto arrays = arrays_of(message);
  std::erase_if(arrays, [](const LooseArray& a) { return a.type != ElementType::kF8 || elements(a) == 0; });
  if (arrays.empty()) return;
  const LooseArray& array = arrays[below(arrays.size())];
  const double by = (static_cast<double>(below(2001)) / 1000.0 - 1.0) * std::array{1e-6, 1e-3, 0.1, 1.0, 4.0}[below(5)];
  const bool scale = once_in(2), every = once_in(2);
  const std::size_t only = below(elements(array));
  for (std::size_t i = 0; i < elements(array); ++i)
    if (every || i == only)
      with_element(array, i, [&]<class T>(T& element) {
        element = static_cast<T>(scale ? static_cast<double>(element) * (1.0 + by) : static_cast<double>(element) + by);
      });
}

void Mutation::take_over(LooseMessage& message, LooseMessage& donor) {
  auto theirs = arrays_of(donor), own = arrays_of(message);
  if (theirs.empty() || own.empty() || once_in(3)) {
    for (auto& [name, value] : donor.header)
      if (once_in(3)) message.header.insert_or_assign(name, value);
    return;
  }
  const LooseArray& from = theirs[below(theirs.size())];
  const LooseArray& to = own[below(own.size())];
  Value name = (*to.entry)["name"];
  *to.part = *from.part;
  *to.entry = *from.entry;
  if (!once_in(4)) (*to.entry)["name"] = std::move(name);
}

void Mutation::change(LooseMessage& message, LooseMessage donor) {
  switch (below(12)) {
    case 0:
    case 1:
    case 2:
      return change_header(message);
    case 3:
      return change_shape(message);
    case 4:
      return change_part(message);
    case 5:
    case 6:
      return change_rows(message);
    case 7:
      return take_over(message, donor);
    case 8:
    case 9:
      return nudge_numbers(message);
    default:
      return change_number(message);
  }
}

RawMessage Mutation::operator()(const RawMessage& message, const RawMessage& donor) {
  auto loose = read_loosely(message);
  const auto other = read_loosely(donor);
  if (!loose || once_in(16)) {  // the bytes of the header
    RawMessage spoilt = message;
    if (spoilt.empty()) spoilt.emplace_back();
    for (std::size_t i = 0; i <= below(3); ++i) change_bytes(spoilt.front());
    return spoilt;
  }
  for (std::size_t i = 0; i <= below(4); ++i) change(*loose, other.value_or(*loose));
  return write_loosely(*loose);
}

}  // namespace lappet
