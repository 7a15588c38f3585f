#include "server/roles.h"

#include <algorithm>
#include <string>

#include "server/fields.h"

namespace lappet {
namespace {

constexpr std::array<std::string_view, 3> kNames = {"follower", "author", "admin"};

}  // namespace

std::string_view role_name(Role role) { return kNames[static_cast<std::size_t>(role)]; }

std::optional<Role> role_of(std::string_view name) {
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Role>(found - kNames.begin());
}

const MessageRule& rule_of(std::string_view type) {
  const auto found = std::ranges::find(kMessageRules, type, &MessageRule::type);
  if (found == kMessageRules.end()) malformed("The message type " + in_quotes(type) + " is not known.");
  return *found;
}

}  // namespace lappet
