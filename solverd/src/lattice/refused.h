// Work that is refused: a small code for programs and a sentence for people. It ends at the daemon's boundary.
#pragma once
#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <utility>

namespace lappet {

enum class ErrorCode {
  kMalformed,     // the message could not be read
  kOutOfOrder,    // valid, but not now (no session, no epoch)
  kUnauthorized,  // wrong token
  kInvalidInput,  // values that make no sense
  kMemoryBudget,  // would exceed the session's memory
  kTimeBudget,    // ran out of its time
  kCancelled,
  kInternal,
};

class RefusedError : public std::runtime_error {
 public:
  RefusedError(ErrorCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

[[noreturn]] inline void refuse(const std::string& sentence) { throw RefusedError(ErrorCode::kInvalidInput, sentence); }

// A number as a sentence shows it.
inline std::string shown(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

}  // namespace lappet
