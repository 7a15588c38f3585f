#include "server/private_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "lattice/refused.h"

namespace lappet {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "lappet-broker-", kLock = "/lock";

std::string temporary_folder() {
  const char* const place = std::getenv("TMPDIR");
  return place != nullptr && *place != '\0' ? place : "/tmp";
}

// Our own, closed to others, with a lock that nobody holds.
bool is_abandoned(const std::string& folder) {
  struct stat found{};
  if (::lstat(folder.c_str(), &found) != 0 || !S_ISDIR(found.st_mode) || found.st_uid != ::geteuid()) return false;
  if ((found.st_mode & (S_IRWXG | S_IRWXO)) != 0) return false;
  const Descriptor lock(::open((folder + std::string(kLock)).c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW));
  return lock.open() && ::flock(lock.get(), LOCK_EX | LOCK_NB) == 0;
}

void remove_abandoned(const std::string& place) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(place, ignored)) {
    if (!entry.path().filename().string().starts_with(kPrefix) || !is_abandoned(entry.path().string())) continue;
    fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace

PrivateFolder::PrivateFolder() {
  constexpr std::size_t kLongest = 60;  // a socket's path has 104 bytes at most
  const std::string place = temporary_folder();
  path_ = place + "/" + std::string(kPrefix) + "XXXXXX";
  if (path_.size() > kLongest) refuse("The folder TMPDIR has too long a name; set another one.");
  remove_abandoned(place);
  if (::mkdtemp(path_.data()) == nullptr) refuse("No folder for sockets can be made at '" + path_ + "'.");
  // Locked under another name first, so that nobody sees it without.
  const std::string made = path_ + "/new";
  lock_ = Descriptor(::open(made.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (!lock_.open() || ::flock(lock_.get(), LOCK_EX | LOCK_NB) != 0 ||
      ::rename(made.c_str(), (path_ + std::string(kLock)).c_str()) != 0) {
    refuse("The folder '" + path_ + "' cannot be locked.");
  }
}

PrivateFolder::~PrivateFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace lappet
