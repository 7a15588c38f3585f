#include "server/key_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "lattice/refused.h"
#include "server/descriptor.h"
#include "server/fields.h"

namespace lappet {
namespace {

std::string text_of(int folder, const std::string& name, const std::string& path, mode_t forbidden) {
  const Descriptor file(::openat(folder, name.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY));
  if (!file.open()) refuse("'" + path + "' cannot be read: " + std::strerror(errno) + ".");
  struct stat found{};
  if (::fstat(file.get(), &found) != 0 || !S_ISREG(found.st_mode)) refuse("'" + path + "' is not a regular file.");
  if (found.st_uid != ::geteuid() && found.st_uid != 0) {  // who keeps the users may be root
    refuse("'" + path + "' belongs to another user; give it to the daemon's.");
  }
  if ((found.st_mode & forbidden) != 0) {
    refuse("Others may " + std::string((forbidden & S_IROTH) != 0 ? "read" : "change") + " '" + path +
           "'; close it to them with chmod " + ((forbidden & S_IROTH) != 0 ? "600." : "644."));
  }
  std::string text(kMaxKeyFileBytes + 1, '\0');
  std::size_t length = 0;
  while (length < text.size()) {
    const ssize_t count = ::read(file.get(), text.data() + length, text.size() - length);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    length += static_cast<std::size_t>(count);
  }
  if (length > kMaxKeyFileBytes) refuse("'" + path + "' has more than " + std::to_string(kMaxKeyFileBytes) + " bytes.");
  text.resize(length);
  if (text.find('\0') != std::string::npos) refuse("'" + path + "' is no text.");
  return text;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

}  // namespace

std::string place_of(const std::string& path, int line) { return "'" + path + "', line " + std::to_string(line); }

KeyEntries read_key_file(int folder, const std::string& name, const std::string& path, mode_t forbidden,
                         std::span<const std::string_view> known) {
  const std::string text = text_of(folder, name, path, forbidden);
  KeyEntries entries;
  std::string_view rest = text;
  for (int line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view here = trimmed(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (here.empty() || here.front() == '#') continue;  // only there: a key may hold '#' and '='
    const std::size_t equals = here.find('=');
    if (equals == std::string_view::npos) refuse(place_of(path, line) + ": there is no '='; write 'name = value'.");
    const std::string key(trimmed(here.substr(0, equals)));
    if (std::ranges::find(known, key) == known.end()) {
      refuse(place_of(path, line) + ": " + in_quotes(key) + " is not known here.");
    }
    if (!entries.emplace(key, KeyEntry{std::string(trimmed(here.substr(equals + 1))), line}).second) {
      refuse(place_of(path, line) + ": '" + key + "' is there twice.");
    }
  }
  return entries;
}

std::string key_in(const KeyEntries& entries, std::string_view name, const std::string& path) {
  const auto found = entries.find(name);
  if (found == entries.end()) refuse("'" + path + "' has no line '" + std::string(name) + " = …'.");
  std::array<std::uint8_t, 32> bytes{};
  const std::string& key = found->second.value;
  if (key.size() != kKeyLength || zmq_z85_decode(bytes.data(), key.c_str()) == nullptr) {
    refuse(place_of(path, found->second.line) + ": '" + std::string(name) +
           "' is no key; a key has 40 characters of Z85.");
  }
  return key;
}

}  // namespace lappet
