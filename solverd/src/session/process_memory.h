// What the daemon's process takes of the machine's memory.
#pragma once

namespace lappet {

// The most that it ever took, in bytes.
double peak_bytes();

// Building a lattice takes twice what it leaves: what was freed goes back to the system before the solve takes its own.
void release_freed_memory();

}  // namespace lappet
