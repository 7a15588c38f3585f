#include <algorithm>

#include "solve/system/system.h"

namespace lappet {

namespace {

CellMaterials materials_of(const CellMaterials& whole, std::span<const std::int32_t> cells) {
  CellMaterials restricted{whole.table};
  for (Index place = 0; place < std::ssize(cells); ++place) {
    const auto c = static_cast<std::size_t>(cells[place]);
    if (!whole.of_cell.empty()) restricted.of_cell.push_back(whole.of_cell[c]);
    if (!whole.normal_of_cell.empty()) restricted.normal_of_cell.push_back(whole.normal_of_cell[c]);
    if (!whole.direction_of_cell.empty()) restricted.direction_of_cell.push_back(whole.direction_of_cell[c]);
    if (!whole.stretch_of_cell.empty()) restricted.stretch_of_cell.push_back(whole.stretch_of_cell[c]);
    for (MaterialShare share : whole.shares_of(c)) {
      share.cell = place;
      restricted.shares.push_back(share);
    }
  }
  return restricted;
}

// Per cell or node of the whole: its index in the subdomain, or -1.
std::vector<std::int32_t> inverse(std::span<const std::int32_t> indices, std::size_t size) {
  std::vector<std::int32_t> place(size, -1);
  for (std::size_t i = 0; i < indices.size(); ++i)
    place[static_cast<std::size_t>(indices[i])] = static_cast<std::int32_t>(i);
  return place;
}

// Three numbers per node of the whole; those of the nodes of the subdomain.
std::vector<double> of_nodes(const std::vector<double>& whole, std::span<const std::int32_t> nodes) {
  std::vector<double> restricted;
  if (whole.empty()) return restricted;
  restricted.reserve(3 * nodes.size());
  for (const std::int32_t n : nodes)
    for (std::size_t i = 0; i < 3; ++i) restricted.push_back(whole[3 * static_cast<std::size_t>(n) + i]);
  return restricted;
}

}  // namespace

template <class Real>
Attachments System<Real>::restricted_attachments(const Place& place,
                                                 std::span<const std::int32_t> place_of_cell) const {
  Attachments restricted;
  for (std::size_t n = 0; n < place.nodes.size(); ++n) {
    const auto at = static_cast<std::size_t>(place.nodes[n]);
    const std::int32_t group = attachments_.node_group[at];
    const bool carried = group >= 0 && !free_[at];
    restricted.node_group.push_back(place.moves[n] ? kFree : carried ? group : kStillGroup);
  }
  const auto take = [&](const auto& from, auto& to) {
    for (auto face : from)
      if ((face.cell = place_of_cell[static_cast<std::size_t>(face.cell)]) >= 0) to.push_back(face);
  };
  take(attachments_.face_constraints, restricted.face_constraints);
  take(attachments_.attached, restricted.attached);
  take(attachments_.resting, restricted.resting);
  take(attachments_.rollers, restricted.rollers);
  restricted.ground = attachments_.ground;
  return restricted;
}

// Those that hold a node that moves; what they hold elsewhere goes into the offset.
template <class Real>
std::vector<PointConstraint> System<Real>::restricted_point_constraints(const Place& place,
                                                                        std::span<const Real> u) const {
  const auto place_of_node = inverse(place.nodes, nodes());
  std::vector<PointConstraint> restricted;
  for (const PointConstraint& constraint : point_constraints_) {
    PointConstraint local = constraint;
    bool moving = false;
    for (std::size_t j = 0; j < local.pieces.size(); ++j) {
      const Piece& piece = constraint.pieces[j];
      Piece& own = local.pieces[j];
      own.nodes.clear();
      own.weights.clear();
      for (std::size_t k = 0; k < piece.nodes.size(); ++k) {
        const auto n = static_cast<std::size_t>(piece.nodes[k]);
        if (const std::int32_t at = place_of_node[n]; at >= 0) {
          own.nodes.push_back(at);
          own.weights.push_back(piece.weights[k]);
          moving = moving || place.moves[static_cast<std::size_t>(at)];
        } else {
          own.offset += piece.weights[k] * Vec3(double(u[3 * n]), double(u[3 * n + 1]), double(u[3 * n + 2]));
        }
      }
    }
    if (moving) restricted.push_back(std::move(local));
  }
  return restricted;
}

template <class Real>
std::unique_ptr<System<Real>> System<Real>::restricted(const Lattice& subdomain, const Place& place,
                                                       std::span<const Real> u) const {
  const auto place_of_cell = inverse(place.cells, lattice().cell_nodes.size());
  auto result =
      std::make_unique<System>(subdomain, materials_of(elastic_.materials(), place.cells),
                               static_cast<int>(elastic_.points()), restricted_attachments(place, place_of_cell),
                               static_cast<std::int32_t>(retractor_active_.size()), bed_, Vec3::Zero());
  result->held_stiffness_ = held_stiffness_;
  result->retractor_motion_ = retractor_motion_;
  result->retractor_active_ = retractor_active_;
  result->rebuild_constraints();
  result->elastic_.set_activation(elastic_.activation());
  result->gravity_force_ = of_nodes(gravity_force_, place.nodes);
  std::vector<FaceLoad> pressures;
  for (const FaceLoad& load : loads_)
    if (load.pressure != 0.0)
      pressures.push_back(
          {load.index, std::make_shared<const LoadedFaces>(*load.faces, place_of_cell), Vec3::Zero(), load.pressure});
  std::vector<Real> own_u;
  for (const std::int32_t n : place.nodes)
    for (std::size_t i = 0; i < 3; ++i) own_u.push_back(u[3 * static_cast<std::size_t>(n) + i]);
  result->set_loads(std::move(pressures), own_u);
  result->traction_force_ = of_nodes(traction_force_, place.nodes);
  if (contact()) result->contact_ = std::make_unique<Contact>(*contact(), subdomain, place_of_cell);
  if (self_contact() && self_contact()->acts_in_subdomains())
    result->self_contact_ = std::make_unique<SelfContact>(*self_contact(), subdomain, place_of_cell, u);
  result->set_point_constraints(restricted_point_constraints(place, u));
  if ((result->held_growth_ = held_growth_) != 1.0) result->set_quadratics();
  return result;
}

template <class Real>
Multipliers System<Real>::restricted(const Multipliers& multipliers, const System& subdomain,
                                     const Place& place) const {
  Multipliers result;
  result.of_constraint = multipliers.of_constraint;
  if (subdomain.has_held_faces_) result.of_held_node = of_nodes(multipliers.of_held_node, place.nodes);
  subdomain.fit(result);
  if (contact())
    result.of_contact_proxy =
        contact()->restrict_pressures(multipliers.of_contact_proxy, inverse(place.cells, lattice().cell_nodes.size()));
  if (attachments_.rollers.empty()) return result;
  const auto place_of_cell = inverse(place.cells, lattice().cell_nodes.size());
  result.of_roller_row.clear();
  for (std::size_t r = 0; r < multipliers.of_roller_row.size(); ++r)
    if (place_of_cell[static_cast<std::size_t>(attachments_.rollers[r].cell)] >= 0)
      result.of_roller_row.push_back(multipliers.of_roller_row[r]);
  subdomain.fit(result);
  return result;
}

template Attachments System<float>::restricted_attachments(const Place&, std::span<const std::int32_t>) const;
template Attachments System<double>::restricted_attachments(const Place&, std::span<const std::int32_t>) const;
template std::vector<PointConstraint> System<float>::restricted_point_constraints(const Place&,
                                                                                  std::span<const float>) const;
template std::vector<PointConstraint> System<double>::restricted_point_constraints(const Place&,
                                                                                   std::span<const double>) const;
template std::unique_ptr<System<float>> System<float>::restricted(const Lattice&, const Place&,
                                                                  std::span<const float>) const;
template std::unique_ptr<System<double>> System<double>::restricted(const Lattice&, const Place&,
                                                                    std::span<const double>) const;
template Multipliers System<float>::restricted(const Multipliers&, const System&, const Place&) const;
template Multipliers System<double>::restricted(const Multipliers&, const System&, const Place&) const;

}  // namespace lappet
