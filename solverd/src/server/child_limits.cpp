#include "server/child_limits.h"

#include <sys/resource.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>

#include <csignal>
#include <fstream>
#endif

#include "lattice/refused.h"

namespace lappet {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitized = true;  // the sanitizer takes more than any limit
#else
constexpr bool kSanitized = false;
#endif
constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::uint64_t kProcess = 1024 * kMiB, kThread = 80 * kMiB;  // a stack, and what malloc keeps for it

}  // namespace

void become_child_of(int parent, std::uint64_t bytes) {
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);                  // elsewhere the end of standard input does it
  std::ofstream("/proc/self/oom_score_adj") << "500";  // where the machine's memory is spent, a session ends, no broker
  constexpr int kResource = RLIMIT_DATA;  // private memory that can be written, with stacks; not what is reserved only
#else
  constexpr int kResource = RLIMIT_AS;
#endif
  if (parent != 0 && ::getppid() != parent) {
    throw RefusedError(ErrorCode::kInternal, "The broker that started this daemon has ended.");
  }
  rlimit limit{};
  if (bytes == 0 || kSanitized || ::getrlimit(kResource, &limit) != 0) return;
  if (limit.rlim_max == RLIM_INFINITY || limit.rlim_max > bytes) limit.rlim_max = bytes;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(kResource, &limit);
}

std::uint64_t process_memory(std::uint64_t budget, std::uint64_t max_message_bytes, int threads) {
  return budget + 2 * max_message_bytes + kProcess + static_cast<std::uint64_t>(threads) * kThread;
}

}  // namespace lappet
