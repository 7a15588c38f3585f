#include "session/bones.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "lattice/refused.h"
#include "session/bone_bodies.h"

namespace lappet {

namespace {

// The penalty of contact, in Young's moduli per spacing; multipliers act where it is not enough.
constexpr double kContactPenalty = 10.0;
// The nodes of the bones' distance field, and how deep it knows distances, in spacings.
constexpr double kBoneSpacing = 0.5, kBoneDepth = 3.0;
constexpr double kMaxRestPenetration = 0.5;  // in spacings

}  // namespace

std::optional<BoneDistance> distance_to_bones(const SessionSettings& settings, const Interrupt& interrupt) {
  if (settings.bones.triangles.empty()) return std::nullopt;
  std::vector<std::shared_ptr<const SignedDistance>> fields;
  std::size_t left = settings.memory_budget;
  for (const Surface& body : bone_bodies(settings)) {
    fields.push_back(std::make_shared<const SignedDistance>(body, kBoneSpacing * settings.spacing,
                                                            kBoneDepth * settings.spacing, left, interrupt));
    left -= std::min(left, fields.back()->bytes());
  }
  return BoneDistance(std::move(fields));
}

std::unique_ptr<Contact> contact_with_bones(const BoneDistance& bones, const Lattice& lattice, const EpochInput& epoch,
                                            const SessionSettings& settings, const Interrupt& interrupt) {
  const double stiffness = kContactPenalty * settings.materials[0].youngs_modulus / settings.spacing;
  auto contact = std::make_unique<Contact>(bones, lattice, epoch.surface, epoch.fixed, stiffness, interrupt);
  auto [depth, where] = contact->deepest_at_rest();
  // Bone that tissue encloses touches none of its surface. The middles of full cells are tissue.
  for (std::size_t c = 0; c < lattice.cell_nodes.size(); ++c) {
    if (c % 4096 == 0) interrupt.check();
    if (lattice.cell_fill[c] < 1.0F) continue;
    const Vec3 middle =
        lattice.node_rest[static_cast<std::size_t>(lattice.cell_nodes[c][0])] + Vec3::Constant(0.5 * settings.spacing);
    if (const double inside = -bones.at_rest(middle).value; inside > depth) depth = inside, where = middle;
  }
  if (depth > kMaxRestPenetration * settings.spacing)
    throw RefusedError(
        ErrorCode::kInvalidInput,
        fmt::format("the tissue of epoch {} lies {}{:.3g} mm deep in bone near ({:.4g}, {:.4g}, {:.4g}) mm before "
                    "anything moves it; move the bone or the tissue apart (up to {:g} mm, half the spacing, is pushed "
                    "out)",
                    epoch.index, depth < bones.depth() * (1 - 1e-6) ? "" : "at least ", depth, where[0], where[1],
                    where[2], kMaxRestPenetration * settings.spacing));
  return contact;
}

}  // namespace lappet
