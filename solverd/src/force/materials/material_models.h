// The registry of the isotropic material models: their order here is the index by which kernels are chosen. Nothing
// else in the solver knows which models there are.
#pragma once
#include <array>
#include <string_view>

#include "force/materials/corotated.h"
#include "force/materials/mooney_rivlin.h"
#include "force/materials/neo_hookean.h"
#include "force/materials/stable_neo_hookean.h"

namespace lappet {

template <class... Models>
struct MaterialModelList {
  static constexpr int kCount = sizeof...(Models);
  static constexpr std::array<std::string_view, kCount> kNames{Models::kName...};

  // The index of the model of that name, -1 where there is none.
  static constexpr int index(std::string_view name) {
    int index = 0;
    return ((name == Models::kName || (++index, false)) || ...) ? index : -1;
  }
  // Calls body.template operator()<Model>() with the model at that index.
  template <class Body>
  static constexpr void with(int index, const Body& body) {
    int at = 0;
    ((index == at++ && (body.template operator()<Models>(), true)) || ...);
  }
  // Whether the model of that name describes J < 0.
  static constexpr bool inverts(std::string_view name) { return ((name == Models::kName && Models::kInverts) || ...); }
};

// One row a model.
using MaterialModels = MaterialModelList<Corotated,         //
                                         NeoHookean,        //
                                         StableNeoHookean,  //
                                         MooneyRivlin>;

inline constexpr std::string_view kDefaultMaterialModel = NeoHookean::kName;

}  // namespace lappet
