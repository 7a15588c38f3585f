// What a daemon does that a broker started for one session: it never outlives the broker, and its memory is bounded.
#pragma once
#include <cstdint>

namespace lappet {

// Ends this process when `parent` ends, and bounds the memory that it may take to `bytes`. Throws
// RefusedError(kInternal) where the parent has ended already.
void become_child_of(int parent, std::uint64_t bytes);

// The memory that a session's process may take: its budget, two messages of the largest kind, and what every process
// of this program has besides.
std::uint64_t process_memory(std::uint64_t budget, std::uint64_t max_message_bytes, int threads);

}  // namespace lappet
