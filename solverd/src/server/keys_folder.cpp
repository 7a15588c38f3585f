#include "server/keys_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <zmq.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <memory>
#include <set>
#include <string_view>
#include <utility>

#include "lattice/refused.h"
#include "server/fields.h"
#include "server/key_file.h"

namespace lappet {
namespace {

constexpr std::size_t kMaxUsers = 4096;
constexpr std::size_t kMaxNameLength = 64;
constexpr std::string_view kUserEnding = ".pub";
constexpr std::array<std::string_view, 2> kServerNames = {"public", "secret"};
constexpr std::array<std::string_view, 6> kUserNames = {"public",  "role",     "memory_gib",
                                                        "threads", "sessions", "seconds"};

bool is_user_name(std::string_view name) {
  return !name.empty() && name.size() <= kMaxNameLength && name.front() != '.' && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
  });
}

// The folder, when it is this user's own, no link, and has none of the mode bits `forbidden`.
Descriptor open_folder(int above, const std::string& name, const std::string& path, mode_t forbidden) {
  Descriptor folder(::openat(above, name.c_str(), O_RDONLY | O_CLOEXEC | O_DIRECTORY | O_NOFOLLOW));
  if (!folder.open()) refuse("The folder '" + path + "' cannot be opened: " + std::strerror(errno) + ".");
  struct stat found{};
  if (::fstat(folder.get(), &found) != 0 || found.st_uid != ::geteuid() || (found.st_mode & forbidden) != 0) {
    refuse("The folder '" + path + "' must belong to the daemon's user and be closed to others; use chmod 700.");
  }
  return folder;
}

template <class Number>
Number number_in(const KeyEntry& entry, std::string_view name, const std::string& path, Number low, Number high) {
  Number number{};
  const char* const end = entry.value.data() + entry.value.size();
  const auto [rest, error] = std::from_chars(entry.value.data(), end, number);
  const bool finite = [&] {
    if constexpr (std::is_floating_point_v<Number>) return std::isfinite(number);
    return true;
  }();
  if (error != std::errc{} || rest != end || !finite || number < low || number > high) {
    refuse(place_of(path, entry.line) + ": '" + std::string(name) + "' is " + in_quotes(entry.value) + "; it must be " +
           shown(static_cast<double>(low)) + " to " + shown(static_cast<double>(high)) + ".");
  }
  return number;
}

std::string public_key_of(const std::string& secret) {
  std::array<char, kKeyLength + 1> key{};
  if (zmq_curve_public(key.data(), secret.c_str()) != 0) return {};
  return key.data();
}

}  // namespace

bool KeysFolder::Stamp::operator==(const Stamp& other) const {
  const auto same = [](const timespec& a, const timespec& b) { return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec; };
  return inode == other.inode && size == other.size && same(modified, other.modified) && same(changed, other.changed);
}

KeysFolder::KeysFolder(std::string path) : path_(std::move(path)) {
  while (path_.size() > 1 && path_.ends_with('/')) path_.pop_back();
  if (zmq_has("curve") != 1) refuse("This daemon's ZeroMQ has no CURVE, so it cannot use keys.");
  const Descriptor folder = open_folder(AT_FDCWD, path_, path_, S_IRWXG | S_IRWXO);
  read_server_keys(folder.get());
  read_users(true);
  if (users_.empty()) spdlog::warn("'{}/users' names nobody who may use this daemon yet", path_);
}

void KeysFolder::read_server_keys(int folder) {
  const std::string path = path_ + "/server.key";
  const KeyEntries entries = read_key_file(folder, "server.key", path, S_IRWXG | S_IRWXO, kServerNames);
  const std::string public_key = key_in(entries, "public", path);
  secret_key_ = key_in(entries, "secret", path);
  if (public_key_of(secret_key_) != public_key) refuse("The two keys in '" + path + "' do not belong together.");
}

void KeysFolder::refresh() {
  try {
    read_users(false);
  } catch (const RefusedError& error) {  // nobody is known while the folder cannot be read
    if (!entries_.empty()) spdlog::error("{}", error.what());
    users_.clear();
    entries_.clear();
  }
}

void KeysFolder::read_users(bool strict) {
  const std::string path = path_ + "/users";
  const Descriptor above = open_folder(AT_FDCWD, path_, path_, S_IRWXG | S_IRWXO);
  Descriptor folder = open_folder(above.get(), "users", path, S_IWGRP | S_IWOTH);
  const int number = folder.get();
  const std::unique_ptr<DIR, int (*)(DIR*)> listing(::fdopendir(number), ::closedir);
  if (!listing) refuse("The folder '" + path + "' cannot be read: " + std::strerror(errno) + ".");
  static_cast<void>(folder.release());  // closed with the listing
  std::set<std::string> seen;
  while (const dirent* entry = ::readdir(listing.get())) {
    const std::string file = entry->d_name;
    if (!file.ends_with(kUserEnding) || file.starts_with('.')) continue;  // as editors leave them
    if (seen.size() >= kMaxUsers) refuse("'" + path + "' has more than " + std::to_string(kMaxUsers) + " users.");
    struct stat found{};
    if (::fstatat(number, file.c_str(), &found, AT_SYMLINK_NOFOLLOW) != 0) continue;  // it went away meanwhile
    seen.insert(file);
#ifdef __APPLE__
    const Stamp stamp{found.st_ino, found.st_size, found.st_mtimespec, found.st_ctimespec};
#else
    const Stamp stamp{found.st_ino, found.st_size, found.st_mtim, found.st_ctim};
#endif
    const auto known = entries_.find(file);
    if (known != entries_.end() && known->second.stamp == stamp) continue;
    Entry now{stamp, std::nullopt};
    try {
      now.user = read_user(number, file);
    } catch (const RefusedError& error) {
      if (strict) throw;
      spdlog::error("{}", error.what());
    }
    entries_.insert_or_assign(file, std::move(now));
  }
  std::erase_if(entries_, [&](const auto& entry) { return !seen.contains(entry.first); });
  index_users(strict);
}

User KeysFolder::read_user(int folder, const std::string& name) const {
  const std::string path = path_ + "/users/" + name;
  User user;
  user.name = name.substr(0, name.size() - kUserEnding.size());
  if (!is_user_name(user.name))
    refuse("'" + path + "' names no user: a name is 1 to 64 of a-z, 0-9, '.', '_' and '-'.");
  const KeyEntries entries = read_key_file(folder, name, path, S_IWGRP | S_IWOTH, kUserNames);
  user.public_key = key_in(entries, "public", path);
  const auto role = entries.find("role");
  if (role == entries.end()) refuse("'" + path + "' has no line 'role = …'.");
  const std::optional<Role> known = role_of(role->second.value);
  if (!known) {
    refuse(place_of(path, role->second.line) + ": the role " + in_quotes(role->second.value) +
           " is not known; there are follower, author and admin.");
  }
  user.role = *known;
  const auto quota = [&](std::string_view quota_name, auto low, auto high) -> std::optional<decltype(low)> {
    const auto found = entries.find(quota_name);
    if (found == entries.end()) return std::nullopt;
    return number_in(found->second, quota_name, path, low, high);
  };
  user.quotas = {quota("memory_gib", 0.01, 65536.0), quota("threads", 1, 1024), quota("sessions", 0, 1024),
                 quota("seconds", 0.01, 1e6)};
  return user;
}

void KeysFolder::index_users(bool strict) {
  users_.clear();
  std::set<std::string> twice;
  for (const auto& [file, entry] : entries_) {
    if (!entry.user) continue;
    const auto [place, fresh] = users_.emplace(entry.user->public_key, &*entry.user);
    if (fresh || !twice.insert(entry.user->public_key).second) continue;
    const std::string sentence =
        "'" + path_ + "/users' has one key twice: of " + place->second->name + " and of " + entry.user->name + ".";
    if (strict) refuse(sentence);
    spdlog::error("{}", sentence);
  }
  for (const std::string& key : twice) users_.erase(key);
}

const User* KeysFolder::with_key(const std::string& public_key) const {
  const auto found = users_.find(public_key);
  return found == users_.end() ? nullptr : found->second;
}

}  // namespace lappet
