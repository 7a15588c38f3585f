// Why a search for the equilibrium ended without one: a code that programs compare, and a sentence for people.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace lappet {

enum class FailureCode : std::uint8_t {
  kNone,         // it did not fail
  kStopped,      // the observer stopped it
  kNotFinite,    // the residual is not a finite number
  kIterations,   // no equilibrium after the allowed Newton iterations
  kNoDescent,    // no direction or no step lowers the energy
  kTooStiff,     // a stiffness is so large that the equations cannot be solved
  kInverted,     // cells are inverted where the material does not allow it
  kInBone,       // tissue is pressed into bone
  kGap,          // what must hold exactly keeps a gap
  kUnreachable,  // a target is too far away
  kBlocked,      // tissue is in the way of what retractors carry
};

// On the wire, in the order of the codes.
inline constexpr std::array<std::string_view, 11> kFailureNames = {
    "",         "stopped", "not_finite", "iterations",  "no_descent", "too_stiff",
    "inverted", "in_bone", "gap",        "unreachable", "blocked"};

struct Failure {
  FailureCode code = FailureCode::kNone;
  std::string message;

  std::string_view name() const { return kFailureNames[static_cast<std::size_t>(code)]; }
};

}  // namespace lappet
