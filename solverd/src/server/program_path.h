// Where this program is, to be started once more.
#pragma once
#include <string>
#ifdef __APPLE__
#include <mach-o/dyld.h>

#include <cstdint>
#endif

namespace lappet {

inline std::string program_path() {
#ifdef __APPLE__
  std::string path(4096, '\0');
  auto size = static_cast<std::uint32_t>(path.size());
  return ::_NSGetExecutablePath(path.data(), &size) == 0 ? std::string(path.c_str()) : std::string();
#else
  return "/proc/self/exe";  // also when the file was replaced meanwhile
#endif
}

}  // namespace lappet
