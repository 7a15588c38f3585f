// Windows: no broker yet, which starts processes and hands them sockets as POSIX has them. So no process of this
// program is a broker's child either.
#include "lattice/refused.h"
#include "server/child_limits.h"
#include "server/serve_users.h"

namespace lappet {

void serve_users(BrokerOptions, const std::function<void(const std::string& endpoint)>&) {
  throw RefusedError(ErrorCode::kInvalidInput,
                     "The daemon for Windows serves its own user only; leave out --keys, or start a daemon for several "
                     "users on Linux.");
}

void become_child_of(int, std::uint64_t) {
  throw RefusedError(ErrorCode::kInvalidInput, "The daemon for Windows has no broker; leave out --process-memory.");
}

}  // namespace lappet
