// A folder for sockets that only this user may enter. It goes with its owner; where that was killed, with the next one.
#pragma once
#include <string>

#include "server/descriptor.h"

namespace lappet {

class PrivateFolder {
 public:
  // Makes one below TMPDIR, or /tmp, and removes those of owners that are gone. Throws RefusedError(kInvalidInput)
  // where it cannot.
  PrivateFolder();
  ~PrivateFolder();
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
  Descriptor lock_;  // on a file in it, as long as the owner lives
};

}  // namespace lappet
