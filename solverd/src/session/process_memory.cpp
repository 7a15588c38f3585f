#include "session/process_memory.h"

#include <sys/resource.h>

#include <fstream>
#include <string>
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

}  // namespace lappet
