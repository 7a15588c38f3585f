// What a build of the daemon holds. The product holds everything and chooses by the scene; a build configured with
// -DLAPPET_LEAVE_OUT="contact;fibers" is without these for good. Its only use is as a yardstick: a scene that needs
// none of them must cost the product's hot loops the same instructions (`lappet report economy --yardstick`).
#pragma once
#include <string_view>

namespace lappet {

#ifndef LAPPET_LEFT_OUT
#define LAPPET_LEFT_OUT ""
#endif

// The names of what is left out, with commas between them.
inline constexpr std::string_view kLeftOut = LAPPET_LEFT_OUT;

consteval bool holds(std::string_view feature) {
  std::string_view rest = kLeftOut;
  while (!rest.empty()) {
    const auto comma = rest.find(',');
    if (rest.substr(0, comma) == feature) return false;
    rest = comma == std::string_view::npos ? std::string_view{} : rest.substr(comma + 1);
  }
  return true;
}

inline constexpr bool kHasContact = holds("contact"), kHasFibers = holds("fibers"), kHasMuscle = holds("muscle"),
                      kHasPrestretch = holds("prestretch"), kHasHeterogeneity = holds("heterogeneity"),
                      kHasMeshCells = holds("mesh_cells"), kHasLandmarks = holds("landmarks"),
                      kHasErrorEstimate = holds("error_estimate"), kHasStrain = holds("strain");

}  // namespace lappet
