// What a user may send. Where the daemon knows its users (--keys) each has a role, and every message type has a least
// one; PROTOCOL.md, "Roles", shows the same table.
#pragma once
#include <array>
#include <optional>
#include <string_view>

namespace lappet {

enum class Role { kFollower, kAuthor, kAdmin };  // each may what those before it may

std::string_view role_name(Role role);
std::optional<Role> role_of(std::string_view name);

struct MessageRule {
  std::string_view type;
  Role least;
  bool work;  // for the session's solver; everything else is answered at once
};

// Every message type that a client may send.
inline constexpr std::array<MessageRule, 12> kMessageRules = {{
    {"hello", Role::kFollower, false},
    {"ping", Role::kFollower, false},
    {"bye", Role::kFollower, false},
    {"follow", Role::kFollower, false},
    {"open", Role::kAuthor, true},
    {"epoch", Role::kAuthor, true},
    {"state", Role::kAuthor, true},
    {"solve", Role::kAuthor, true},
    {"close", Role::kAuthor, true},
    {"cancel", Role::kAuthor, false},
    {"share", Role::kAuthor, false},
    {"shutdown", Role::kAdmin, false},
}};

// The rule of a message type. Throws RefusedError(kMalformed) for a type that nobody knows.
const MessageRule& rule_of(std::string_view type);

}  // namespace lappet
