// What the daemon's process takes of the machine's memory.
#pragma once

namespace lappet {

// The most that it ever took, in bytes.
double peak_bytes();

// From now on blocks of 1 MiB and more go back to the system as soon as they are freed. The C library would keep more
// and more of them for later, in holes that what comes next does not fit.
void return_large_blocks();

// Building a lattice takes twice what it leaves: what was freed goes back to the system before the solve takes its own.
void release_freed_memory();

}  // namespace lappet
