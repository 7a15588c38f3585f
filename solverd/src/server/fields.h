// The values of a message header and the reading of them by name and kind. What does not fit is
// RefusedError(kMalformed) with a sentence that names the field, what it holds and what is expected.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace lappet {

// A header value: only the kinds that the protocol uses.
struct Value;
using Fields = std::map<std::string, Value, std::less<>>;
struct Value : std::variant<std::int64_t, std::uint64_t, double, bool, std::string, std::vector<Value>, Fields> {
  using variant::variant;
};

std::string_view kind_name(const Value& value);  // "a text"

[[noreturn]] void malformed(const std::string& sentence);
// Client text for a sentence: quoted, printable, at most 60 characters.
std::string in_quotes(std::string_view text);

// Reads the fields of one map by name and kind. `finish` refuses those that nobody asked for, so that a misspelt field
// is never ignored. `where` names the map in the sentences ("solve", "settings").
class FieldReader {
 public:
  FieldReader(const Fields& fields, std::string where) : fields_(fields), where_(std::move(where)) {}

  double number(std::string_view name);                    // finite; whole numbers count
  double number(std::string_view name, double otherwise);  // for a field that may be left out
  std::int64_t integer(std::string_view name, std::int64_t low, std::int64_t high);
  std::string text(std::string_view name);
  std::array<double, 3> vector3(std::string_view name);
  const Fields& map(std::string_view name);
  std::vector<double> numbers(std::string_view name, std::size_t count);
  // A list of maps, each of which `read` gets with a reader that is finished afterwards.
  void maps(std::string_view name, const std::function<void(FieldReader&)>& read);
  bool has(std::string_view name) const { return fields_.contains(name); }
  void finish() const;

 private:
  const Value& take(std::string_view name);
  const Fields& fields_;
  std::string where_;
  std::vector<std::string> taken_;
};

}  // namespace lappet
