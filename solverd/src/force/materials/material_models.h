// The isotropic material models: the one place that lists them.
#pragma once
#include <string_view>

#include "force/materials/material.h"
#include "force/materials/mooney_rivlin.h"
#include "force/materials/stable_neo_hookean.h"

namespace lappet {

template <class... Models>
struct MaterialModelList {
  // The place of the model of that name in the list, -1 where there is none.
  static int index(std::string_view name) {
    int place = 0;
    return ((name == Models::kName || (++place, false)) || ...) ? place : -1;
  }
  // Calls body.template operator()<Model>() with the model at that place.
  template <class Body>
  static void with(int index, const Body& body) {
    int place = 0;
    ((index == place++ && (body.template operator()<Models>(), true)) || ...);
  }
};

using MaterialModels = MaterialModelList<Corotated, NeoHookean, StableNeoHookean, MooneyRivlin>;

}  // namespace lappet
