// The release that this daemon belongs to; the build sets LAPPET_VERSION from the project's version.
#pragma once
#include <string_view>

#ifndef LAPPET_VERSION
#define LAPPET_VERSION "0.0.0+unknown"
#endif

#if defined(__clang__)
#define LAPPET_COMPILED_BY "clang " __clang_version__
#elif defined(__GNUC__)
#define LAPPET_COMPILED_BY "g++ " __VERSION__
#else
#define LAPPET_COMPILED_BY "unknown"
#endif

namespace lappet {
inline constexpr std::string_view kVersion = LAPPET_VERSION, kCompiler = LAPPET_COMPILED_BY;
}
