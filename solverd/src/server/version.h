// The release that this daemon belongs to; the build sets LAPPET_VERSION from the project's version.
#pragma once
#include <string_view>

#ifndef LAPPET_VERSION
#define LAPPET_VERSION "0.0.0+unknown"
#endif

namespace lappet {
inline constexpr std::string_view kVersion = LAPPET_VERSION;
}
