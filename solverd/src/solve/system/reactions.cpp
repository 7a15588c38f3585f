#include <map>

#include "lattice/node_field.h"
#include "solve/system/system.h"

namespace lappet {

namespace {

Vec3 sum_of(std::span<const double> forces) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < forces.size(); k += 3) sum += Vec3::Map(&forces[k]);
  return sum;
}

Holder holder_of(Index group, std::span<const Index> parts, std::size_t at) {
  if (group == kBedGroup) return {Holder::Kind::kBed, 0};
  if (group >= 0) return {Holder::Kind::kRetractor, group};
  return {Holder::Kind::kFixed, parts.empty() ? 0 : parts[at]};
}

}  // namespace

template <class Real>
std::vector<Reaction> System<Real>::reactions(std::span<const Real> u, const Multipliers& multipliers,
                                              const Evaluation& at) const {
  std::map<Holder, Vec3> forces;
  const auto on = [&](const Holder& holder) -> Vec3& { return forces.try_emplace(holder, Vec3::Zero()).first->second; };
  for (std::size_t k = 0; k < prescribed_nodes_.size(); ++k) {
    const auto n = static_cast<std::size_t>(prescribed_nodes_[k]);
    on(holder_of(attachments_.node_group[n], attachments_.part_of_node, n)) += Vec3::Map(&at.holding[3 * k]);
  }
  for (std::size_t f = 0; f < attachments_.face_constraints.size(); ++f) {
    const FaceConstraint& face = attachments_.face_constraints[f];
    if (!acts(face)) continue;
    std::array<double, 25> found{};
    evaluate_face_constraint(face, u, multipliers, found);
    on(holder_of(face.group, attachments_.part_of_face_constraint, f)) -= sum_of(std::span(found).first(24));
  }
  if (!attachments_.attached.empty() || !attachments_.resting.empty()) {
    Evaluation bed;
    bed.gradient.assign(3 * free_.size(), 0.0);
    add_bed_faces(u, bed);
    add_resting_faces(u, bed);
    on({Holder::Kind::kBed, 0}) -= sum_of(bed.gradient);
  }
  if (contact()) on({Holder::Kind::kBone, 0}) += at.contact.force;
  if (!floating_cells_.empty()) {
    Evaluation drift;
    drift.gradient.assign(3 * free_.size(), 0.0);
    add_drift(u, drift);
    on({Holder::Kind::kWeakBed, 0}) -= sum_of(drift.gradient);
  }
  for (std::size_t r = 0; r < attachments_.rollers.size(); ++r) {
    const RollerRow& row = attachments_.rollers[r];
    const double push = multipliers.of_roller_row[r] + roller_stiffness() * off(row, u);
    double whole = 0.0;
    for (const double weight : row.weights) whole += weight;
    Vec3& force = on({Holder::Kind::kRoller, row.roller});
    if (acts(row)) force -= push * whole * row.normal;
  }
  std::size_t sample = 0;
  for (const FaceLoad& load : loads_) {
    const std::size_t count = load.pressure != 0.0 ? load.faces->samples().size() : 0;
    on({Holder::Kind::kLoad, load.index}) += load_force(load, std::span(at.pressed).subspan(sample, count));
    sample += count;
  }
  std::vector<Reaction> result;
  for (const auto& [holder, force] : forces) result.push_back({holder, force});
  return result;
}

template std::vector<Reaction> System<float>::reactions(std::span<const float>, const Multipliers&,
                                                        const Evaluation&) const;
template std::vector<Reaction> System<double>::reactions(std::span<const double>, const Multipliers&,
                                                         const Evaluation&) const;

}  // namespace lappet
