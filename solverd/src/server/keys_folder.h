// The folder that says who may use this daemon (--keys): its own CURVE keys and a file for each user.
//
//   DIR/server.key      mode 0600: public = Z85, secret = Z85
//   DIR/users/NAME.pub  public = Z85, role = follower|author|admin, and quotas, each of which may be left out:
//                       memory_gib, threads, sessions, seconds
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <ctime>
#include <map>
#include <optional>
#include <string>

#include "server/descriptor.h"
#include "server/roles.h"

namespace lappet {

// What a user's file says of quotas; nothing: what the daemon's options say.
struct UserQuotas {
  std::optional<double> memory_gib;  // of each session
  std::optional<int> threads;        // of each session
  std::optional<int> sessions;       // at a time
  std::optional<double> seconds;     // of one frame or epoch
};

struct User {
  std::string name;
  std::string public_key;  // Z85
  Role role = Role::kFollower;
  UserQuotas quotas;
};

class KeysFolder {
 public:
  // Reads all of it. Throws RefusedError(kInvalidInput) with the file and the line of what is wrong: also a folder that
  // others may enter, keys that do not belong together, or one key of two users.
  explicit KeysFolder(std::string path);

  const std::string& secret_key() const { return secret_key_; }

  // Reads the users' files that changed since. A file that is wrong, or gone, is no user any more, and the log says so.
  void refresh();
  const User* with_key(const std::string& public_key) const;

 private:
  struct Stamp {
    ino_t inode = 0;
    off_t size = 0;
    timespec modified{}, changed{};
    bool operator==(const Stamp& other) const;
  };
  struct Entry {
    Stamp stamp;
    std::optional<User> user;  // none: the file is wrong, as it was said when it was read
  };

  void read_server_keys(int folder);
  void read_users(bool strict);
  User read_user(int folder, const std::string& name) const;
  void index_users(bool strict);

  std::string path_;
  std::string secret_key_;
  std::map<std::string, Entry> entries_;      // by the file's name
  std::map<std::string, const User*> users_;  // by public key: those that no other user has
};

}  // namespace lappet
