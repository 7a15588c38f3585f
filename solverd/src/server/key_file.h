// A file of the keys folder: lines `name = value`, `#` comments. Only regular files are read, of the user's own and
// closed to others; no link is followed.
#pragma once
#include <sys/types.h>

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>

namespace lappet {

inline constexpr std::size_t kMaxKeyFileBytes = 4096;
inline constexpr std::size_t kKeyLength = 40;  // of a CURVE key in Z85

struct KeyEntry {
  std::string value;
  int line = 0;
};
using KeyEntries = std::map<std::string, KeyEntry, std::less<>>;

// What a sentence says of a place: "DIR/users/anna.pub, line 3".
std::string place_of(const std::string& path, int line);

// Reads `name` in the folder open as `folder`; `path` is what sentences call it. Throws RefusedError(kInvalidInput)
// where it is not a regular file of this user's or root's without the mode bits `forbidden`, is larger than
// kMaxKeyFileBytes, is not text, or has a line that is no `name = value` or names something else than `known`, or
// twice.
KeyEntries read_key_file(int folder, const std::string& name, const std::string& path, mode_t forbidden,
                         std::span<const std::string_view> known);

// The CURVE key of an entry that must be there. Throws RefusedError(kInvalidInput) for anything but a key in Z85.
std::string key_in(const KeyEntries& entries, std::string_view name, const std::string& path);

}  // namespace lappet
