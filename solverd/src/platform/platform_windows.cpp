// Windows.
#include <windows.h>
// what needs it
#include <io.h>
#include <malloc.h>
#include <psapi.h>
#include <winsock2.h>
#include <ws2tcpip.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <thread>
#include <vector>

#include "platform/platform.h"

namespace lappet {

double peak_bytes() {
  PROCESS_MEMORY_COUNTERS counters{};
  if (::K32GetProcessMemoryInfo(::GetCurrentProcess(), &counters, sizeof counters) == 0) return 0.0;
  return static_cast<double>(counters.PeakWorkingSetSize);
}

void return_large_blocks() {}  // the heap of Windows gives them back as they are freed

void release_freed_memory() { ::_heapmin(); }

void* loaded_function(const char* name) {
  std::vector<HMODULE> modules(256);
  DWORD bytes = 0;
  const auto room = [&] { return static_cast<DWORD>(modules.size() * sizeof(HMODULE)); };
  while (::K32EnumProcessModules(::GetCurrentProcess(), modules.data(), room(), &bytes) != 0 && bytes > room()) {
    modules.resize(bytes / sizeof(HMODULE));
  }
  modules.resize(bytes / sizeof(HMODULE));
  const std::string prefixed = std::string("scipy_") + name;  // as the BLAS of PyPI's wheels calls its own
  for (const HMODULE module : modules) {
    for (const char* const called : {name, prefixed.c_str()}) {
      if (const FARPROC found = ::GetProcAddress(module, called)) return reinterpret_cast<void*>(found);
    }
  }
  return nullptr;
}

std::string take_variable(const char* name) {
  const char* const value = std::getenv(name);
  std::string taken = value != nullptr ? value : "";
  ::_putenv_s(name, "");
  return taken;
}

void survive_closed_pipes() {}  // Windows has no such signal

// The number may be given to another process later; a handle keeps to this one.
ProcessWatch::ProcessWatch(int process) : process_(process) {
  if (process == 0) return;
  const HANDLE handle = ::OpenProcess(SYNCHRONIZE, FALSE, static_cast<DWORD>(process));
  if (handle != nullptr) {
    handle_.reset(handle, ::CloseHandle);
  } else if (::GetLastError() != ERROR_INVALID_PARAMETER) {
    process_ = 0;  // it runs, and may not be watched
  }
}

bool ProcessWatch::ended() const {
  if (process_ == 0) return false;
  return handle_ == nullptr || ::WaitForSingleObject(handle_.get(), 0) == WAIT_OBJECT_0;
}

// A pipe cannot be polled: a thread reads it, and is left where it waits when the program ends.
struct InputWatch::Reader {
  std::atomic<bool> ended = false;
};

InputWatch::InputWatch(int descriptor) : descriptor_(descriptor) {
  if (descriptor < 0) return;
  reader_ = std::make_shared<Reader>();
  const auto input = reinterpret_cast<HANDLE>(::_get_osfhandle(descriptor));
  std::thread([input, reader = reader_] {
    std::array<char, 256> ignored{};
    DWORD count = 0;
    while (::ReadFile(input, ignored.data(), static_cast<DWORD>(ignored.size()), &count, nullptr) != 0 && count != 0) {
    }
    reader->ended = true;
  }).detach();
}

int InputWatch::pollable() const { return -1; }

bool InputWatch::ended() { return reader_ != nullptr && reader_->ended; }

bool is_loopback_number(const std::string& host) {
  in_addr v4{};
  return ::inet_pton(AF_INET, host.c_str(), &v4) == 1 && (ntohl(v4.s_addr) >> 24) == 127;
}

bool is_users_alone(const std::string&) { return false; }  // this daemon's ZeroMQ has no sockets in folders

void remove_socket_at(const std::string&, const std::string&) {}

}  // namespace lappet
