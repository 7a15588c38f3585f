// What the tests of messages share: the arrays of a message, and refusals as values.
#pragma once
#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "lattice/refused.h"
#include "server/encode.h"
#include "server/message.h"

namespace lappet {

using Views = std::vector<std::span<const std::byte>>;

inline Views array_views(const std::vector<PartBytes>& parts) { return {parts.begin() + 1, parts.end()}; }

template <class Action>
RefusedError refusal_of(Action action) {
  try {
    action();
  } catch (const RefusedError& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was refused";
  return {ErrorCode::kInternal, ""};
}

inline testing::AssertionResult says(const RefusedError& error, ErrorCode code, const std::string& part) {
  if (error.code() == code && std::string(error.what()).find(part) != std::string::npos) {
    return testing::AssertionSuccess();
  }
  return testing::AssertionFailure() << error_name(error.code()) << ": " << error.what();
}

}  // namespace lappet
