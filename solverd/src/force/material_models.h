// The isotropic material models: the one place that lists them.
#pragma once
#include <string_view>

#include "force/material.h"
#include "force/mooney_rivlin.h"
#include "force/stable_neo_hookean.h"

namespace lappet {

template <class... Models>
struct MaterialModelList {
  // Calls body.template operator()<Model>() with the model of that name; false where there is none.
  template <class Body>
  static bool with(std::string_view name, const Body& body) {
    return ((name == Models::kName && (body.template operator()<Models>(), true)) || ...);
  }
};

using MaterialModels = MaterialModelList<Corotated, NeoHookean, StableNeoHookean, MooneyRivlin>;

}  // namespace lappet
