#include "server/fields.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "lattice/refused.h"

namespace lappet {

void malformed(const std::string& sentence) { throw RefusedError(ErrorCode::kMalformed, sentence); }

std::string in_quotes(std::string_view text) {
  std::string result = "'";
  for (const char c : text.substr(0, 60)) {
    const auto byte = static_cast<unsigned char>(c);
    result += (byte < 0x20 || byte > 0x7e) ? '?' : c;
  }
  return result + (text.size() > 60 ? "...'" : "'");
}

std::string_view kind_name(const Value& value) {
  static constexpr std::array<std::string_view, 7> kNames = {
      "a whole number", "a whole number", "a number", "a truth value", "a text", "a list", "a map"};
  return kNames[value.index()];
}

const Value& FieldReader::take(std::string_view name) {
  const auto found = fields_.find(name);
  if (found == fields_.end()) malformed("'" + where_ + "' has no field '" + std::string(name) + "'.");
  taken_.emplace_back(name);
  return found->second;
}

double FieldReader::number(std::string_view name) {
  const Value& value = take(name);
  double result = std::numeric_limits<double>::quiet_NaN();
  if (const auto* real = std::get_if<double>(&value)) {
    result = *real;
  } else if (const auto* natural = std::get_if<std::uint64_t>(&value)) {
    result = static_cast<double>(*natural);
  } else if (const auto* whole = std::get_if<std::int64_t>(&value)) {
    result = static_cast<double>(*whole);
  } else {
    malformed("The field '" + std::string(name) + "' of '" + where_ + "' is " + std::string(kind_name(value)) +
              "; it must be a number.");
  }
  if (!std::isfinite(result)) {
    throw RefusedError(ErrorCode::kInvalidInput, "The field '" + std::string(name) + "' of '" + where_ + "' is " +
                                                     std::to_string(result) + "; it must be finite.");
  }
  return result;
}

std::int64_t FieldReader::integer(std::string_view name, std::int64_t low, std::int64_t high) {
  const Value& value = take(name);
  const auto* whole = std::get_if<std::int64_t>(&value);
  const auto* natural = std::get_if<std::uint64_t>(&value);
  if (whole == nullptr && natural == nullptr) {
    malformed("The field '" + std::string(name) + "' of '" + where_ + "' is " + std::string(kind_name(value)) +
              "; it must be a whole number.");
  }
  const bool fits =
      natural != nullptr ? *natural <= static_cast<std::uint64_t>(std::max<std::int64_t>(high, 0)) : *whole <= high;
  const std::int64_t result = whole != nullptr ? *whole : fits ? static_cast<std::int64_t>(*natural) : high;
  if (!fits || result < low) {
    throw RefusedError(ErrorCode::kInvalidInput,
                       "The field '" + std::string(name) + "' of '" + where_ + "' is " +
                           (whole != nullptr ? std::to_string(*whole) : std::to_string(*natural)) +
                           "; it must lie between " + std::to_string(low) + " and " + std::to_string(high) + ".");
  }
  return result;
}

std::string FieldReader::text(std::string_view name) {
  const Value& value = take(name);
  const auto* text = std::get_if<std::string>(&value);
  if (text == nullptr) {
    malformed("The field '" + std::string(name) + "' of '" + where_ + "' is " + std::string(kind_name(value)) +
              "; it must be a text.");
  }
  return *text;
}

double FieldReader::number(std::string_view name, double otherwise) { return has(name) ? number(name) : otherwise; }

std::vector<double> FieldReader::numbers(std::string_view name, std::size_t count) {
  const Value& value = take(name);
  const auto* list = std::get_if<std::vector<Value>>(&value);
  if (list == nullptr || list->size() != count) {
    malformed("The field '" + std::string(name) + "' of '" + where_ + "' must be a list of " +
              (count == 2   ? "two"
               : count == 3 ? "three"
                            : std::to_string(count)) +
              " numbers.");
  }
  std::vector<double> result;
  for (const Value& element : *list) {
    const Fields entry = {{std::string(name), element}};
    result.push_back(FieldReader(entry, where_).number(name));
  }
  return result;
}

std::array<double, 3> FieldReader::vector3(std::string_view name) {
  const std::vector<double> found = numbers(name, 3);
  return {found[0], found[1], found[2]};
}

void FieldReader::maps(std::string_view name, const std::function<void(FieldReader&)>& read) {
  const Value& value = take(name);
  const auto* list = std::get_if<std::vector<Value>>(&value);
  if (list == nullptr) {
    malformed("The field '" + std::string(name) + "' of '" + where_ + "' is " + std::string(kind_name(value)) +
              "; it must be a list of maps.");
  }
  for (std::size_t i = 0; i < list->size(); ++i) {
    const auto* map = std::get_if<Fields>(&(*list)[i]);
    if (map == nullptr) {
      malformed("The entry " + std::to_string(i) + " of '" + std::string(name) + "' is " +
                std::string(kind_name((*list)[i])) + "; it must be a map.");
    }
    FieldReader reader(*map, std::string(name) + "[" + std::to_string(i) + "]");
    read(reader);
    reader.finish();
  }
}

const Fields& FieldReader::map(std::string_view name) {
  const Value& value = take(name);
  const auto* map = std::get_if<Fields>(&value);
  if (map == nullptr) {
    malformed("The field '" + std::string(name) + "' of '" + where_ + "' is " + std::string(kind_name(value)) +
              "; it must be a map.");
  }
  return *map;
}

void FieldReader::finish() const {
  for (const auto& [name, value] : fields_) {
    if (std::ranges::find(taken_, name) == taken_.end()) {
      malformed("'" + where_ + "' has the field " + in_quotes(name) + ", which this version does not know.");
    }
  }
}

}  // namespace lappet
