// What a process asks of its system: memory, its parent, its standard input, who else may come in. One file for each
// kind of system: platform_posix.cpp and platform_windows.cpp.
#pragma once
#include <memory>
#include <string>

namespace lappet {

// The most memory that this process ever took, in bytes.
double peak_bytes();

// From now on blocks of 1 MiB and more go back to the system as soon as they are freed. The C library would keep more
// and more of them for later, in holes that what comes next does not fit.
void return_large_blocks();

// Building a lattice takes twice what it leaves: what was freed goes back to the system before the solve takes its own.
void release_freed_memory();

// The address of a function by its name in C, in whichever library this program has loaded; null where none has it.
void* loaded_function(const char* name);

// The value of an environment variable, which children of this process do not get any more; empty where it is not set.
std::string take_variable(const char* name);

// A pipe whose reader has ended is an error of the call that writes to it, not the end of this process.
void survive_closed_pipes();

// Whether another process has ended.
class ProcessWatch {
 public:
  explicit ProcessWatch(int process);  // its number; 0: none, which never ends
  bool ended() const;

 private:
  int process_;
  std::shared_ptr<void> handle_;
};

// Whether whoever writes to a descriptor of this process has closed it. What was written is dropped.
class InputWatch {
 public:
  explicit InputWatch(int descriptor);  // -1: none, which never ends
  // What a poll can wait for before `ended` is asked; -1: nothing, so it is asked every now and then.
  int pollable() const;
  bool ended();

 private:
  struct Reader;
  int descriptor_;
  std::shared_ptr<Reader> reader_;
};

inline constexpr int kStandardInput = 0;  // its descriptor

// Whether `host` is an address 127.x.y.z.
bool is_loopback_number(const std::string& host);

// Whether `folder` can hold sockets that only this user reaches: its own, closed to others, and no link.
bool is_users_alone(const std::string& folder);

// Removes the socket at `path` and its folder `folder`, where nothing else is in it.
void remove_socket_at(const std::string& path, const std::string& folder);

}  // namespace lappet
