#include <algorithm>

#include "solve/system/system.h"

namespace lappet {

namespace {

CellMaterials materials_of(const CellMaterials& whole, std::span<const std::int32_t> cells) {
  CellMaterials restricted{whole.table};
  for (const std::int32_t cell : cells) {
    const auto c = static_cast<std::size_t>(cell);
    if (!whole.of_cell.empty()) restricted.of_cell.push_back(whole.of_cell[c]);
    if (!whole.normal_of_cell.empty()) restricted.normal_of_cell.push_back(whole.normal_of_cell[c]);
  }
  return restricted;
}

}  // namespace

template <class Real>
std::unique_ptr<System<Real>> System<Real>::restrict_to(const System& whole, const Lattice& subdomain,
                                                        std::span<const std::int32_t> cells,
                                                        std::span<const std::int32_t> nodes,
                                                        std::span<const std::uint8_t> moves, std::span<const Real> u) {
  std::vector<std::int32_t> place_of_cell(whole.lattice().cell_nodes.size(), -1), place_of_node(whole.nodes(), -1);
  for (std::size_t c = 0; c < cells.size(); ++c)
    place_of_cell[static_cast<std::size_t>(cells[c])] = static_cast<std::int32_t>(c);
  for (std::size_t n = 0; n < nodes.size(); ++n)
    place_of_node[static_cast<std::size_t>(nodes[n])] = static_cast<std::int32_t>(n);

  Attachments attachments;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const auto at = static_cast<std::size_t>(nodes[n]);
    const std::int32_t group = whole.attachments_.node_group[at];
    const bool carried = group >= 0 && !whole.free_[at];
    attachments.node_group.push_back(moves[n] ? kFree : carried ? group : kStillGroup);
  }
  const auto take = [&](const auto& from, auto& to) {
    for (auto face : from)
      if ((face.cell = place_of_cell[static_cast<std::size_t>(face.cell)]) >= 0) to.push_back(face);
  };
  take(whole.attachments_.face_constraints, attachments.face_constraints);
  take(whole.attachments_.resting, attachments.resting);
  auto result = std::make_unique<System>(subdomain, materials_of(whole.elastic_.materials(), cells),
                                         static_cast<int>(whole.elastic_.points()), std::move(attachments),
                                         static_cast<std::int32_t>(whole.retractor_active_.size()),
                                         whole.bed_stiffness_, Vec3::Zero());
  result->held_stiffness_ = whole.held_stiffness_;
  result->retractor_motion_ = whole.retractor_motion_;
  result->retractor_active_ = whole.retractor_active_;
  result->rebuild_constraints();
  result->elastic_.set_activation(whole.elastic_.activation());
  const auto take_nodes = [&](const std::vector<double>& from, std::vector<double>& to) {
    if (from.empty()) return;
    to.clear();
    for (const std::int32_t n : nodes)
      for (std::size_t i = 0; i < 3; ++i) to.push_back(from[3 * static_cast<std::size_t>(n) + i]);
  };
  take_nodes(whole.gravity_force_, result->gravity_force_);
  if (result->has_held_faces_) take_nodes(whole.held_multipliers_, result->held_multipliers_);
  if (whole.contact()) result->contact_ = std::make_unique<Contact>(*whole.contact(), subdomain, place_of_cell);

  std::vector<PointConstraint> constraints;
  for (const PointConstraint& constraint : whole.point_constraints_) {
    PointConstraint local = constraint;
    local.nodes.clear();
    local.weights.clear();
    bool moving = false;
    for (std::size_t k = 0; k < constraint.nodes.size(); ++k) {
      const auto n = static_cast<std::size_t>(constraint.nodes[k]);
      if (const std::int32_t at = place_of_node[n]; at >= 0) {
        local.nodes.push_back(at);
        local.weights.push_back(constraint.weights[k]);
        moving = moving || moves[static_cast<std::size_t>(at)];
      } else {
        local.offset += constraint.weights[k] * Vec3(double(u[3 * n]), double(u[3 * n + 1]), double(u[3 * n + 2]));
      }
    }
    if (moving) constraints.push_back(std::move(local));
  }
  result->set_point_constraints(std::move(constraints));
  return result;
}

template <class Real>
void System<Real>::take_multipliers(const System& subdomain, std::span<const std::int32_t> nodes) {
  std::vector<std::int32_t> place_of_node(free_.size(), -1);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const auto at = static_cast<std::size_t>(nodes[n]);
    place_of_node[at] = static_cast<std::int32_t>(n);
    if (!subdomain.held_multipliers_.empty())
      for (std::size_t i = 0; i < 3; ++i) held_multipliers_[3 * at + i] = subdomain.held_multipliers_[3 * n + i];
  }
  auto local = subdomain.point_constraints_.begin();
  for (PointConstraint& constraint : point_constraints_)
    if (std::ranges::any_of(constraint.nodes, [&](std::int32_t n) {
          const std::int32_t at = place_of_node[static_cast<std::size_t>(n)];
          return at >= 0 && subdomain.is_free(static_cast<std::size_t>(at));
        }))
      constraint.multiplier = (local++)->multiplier;
}

template void System<float>::take_multipliers(const System&, std::span<const std::int32_t>);
template void System<double>::take_multipliers(const System&, std::span<const std::int32_t>);
template std::unique_ptr<System<float>> System<float>::restrict_to(const System&, const Lattice&,
                                                                   std::span<const std::int32_t>,
                                                                   std::span<const std::int32_t>,
                                                                   std::span<const std::uint8_t>,
                                                                   std::span<const float>);
template std::unique_ptr<System<double>> System<double>::restrict_to(const System&, const Lattice&,
                                                                     std::span<const std::int32_t>,
                                                                     std::span<const std::int32_t>,
                                                                     std::span<const std::uint8_t>,
                                                                     std::span<const double>);

}  // namespace lappet
