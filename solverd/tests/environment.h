// Environment variables of this process, in tests.
#pragma once
#include <cstdlib>

namespace lappet {

// null: the variable is removed.
inline void set_variable(const char* name, const char* value) {
#ifdef _WIN32
  ::_putenv_s(name, value != nullptr ? value : "");
#else
  if (value != nullptr)
    ::setenv(name, value, 1);
  else
    ::unsetenv(name);
#endif
}

}  // namespace lappet
