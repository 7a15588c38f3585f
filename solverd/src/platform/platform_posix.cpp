// Linux, macOS and other systems of their kind.
#include <arpa/inet.h>
#include <dlfcn.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>

#include "platform/platform.h"
#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

namespace lappet {

double peak_bytes() {
  // Where there is /proc: what getrusage counts begins with the size of the process that started this one.
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (double kibibytes = 0.0; word == "VmHWM:" && status >> kibibytes) return 1024.0 * kibibytes;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
#if defined(__APPLE__)
  return static_cast<double>(usage.ru_maxrss);
#else
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
#endif
}

void return_large_blocks() {
#if defined(__GLIBC__)
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

void release_freed_memory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

void* loaded_function(const char* name) {
  if (void* const found = ::dlsym(RTLD_DEFAULT, name)) return found;
  const std::string prefixed = std::string("scipy_") + name;  // as the BLAS of PyPI's wheels calls its own
  return ::dlsym(RTLD_DEFAULT, prefixed.c_str());
}

std::string take_variable(const char* name) {
  const char* const value = std::getenv(name);
  std::string taken = value != nullptr ? value : "";
  ::unsetenv(name);
  return taken;
}

void survive_closed_pipes() { std::signal(SIGPIPE, SIG_IGN); }

ProcessWatch::ProcessWatch(int process) : process_(process) {}

bool ProcessWatch::ended() const { return process_ != 0 && ::kill(process_, 0) != 0 && errno == ESRCH; }

InputWatch::InputWatch(int descriptor) : descriptor_(descriptor) {}

int InputWatch::pollable() const { return descriptor_; }

bool InputWatch::ended() {
  if (descriptor_ < 0) return false;
  std::array<char, 256> ignored{};
  const ssize_t count = ::read(descriptor_, ignored.data(), ignored.size());
  return count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN);
}

bool is_loopback_number(const std::string& host) {
  in_addr v4{};
  return ::inet_pton(AF_INET, host.c_str(), &v4) == 1 && (ntohl(v4.s_addr) >> 24) == 127;
}

bool is_users_alone(const std::string& folder) {
  struct stat found{};
  return !folder.empty() && ::lstat(folder.c_str(), &found) == 0 && S_ISDIR(found.st_mode) &&
         found.st_uid == ::geteuid() && (found.st_mode & (S_IRWXG | S_IRWXO)) == 0;
}

void remove_socket_at(const std::string& path, const std::string& folder) {
  ::unlink(path.c_str());
  ::rmdir(folder.c_str());
}

}  // namespace lappet
