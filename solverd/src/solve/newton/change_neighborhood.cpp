#include "solve/newton/change_neighborhood.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "solve/subdomain/subdomain.h"

namespace lappet {

namespace {

constexpr int kDegree = 4;  // of the smoother
// Of the cells: a larger neighborhood saves less than it may cost, and a smaller one may as well be larger.
constexpr double kMaxShare = 0.4, kMinShare = 0.2;
// Spacings by which a node is displaced, or one cell would be by the force on its node, that make it a part of the
// neighborhood.
constexpr double kDisplaced = 1e-2;
// Decay lengths around that; where nothing is displaced yet it shows least how far the changes reach: the most.
constexpr double kMinReach = 1.0, kMaxReach = 4.0;
constexpr double kShareOfTolerance =
    0.5;                        // for the residual of the neighborhood; the reactions at its rim take the rest
constexpr int kMaxNewton = 20;  // what takes more is for the whole

template <class Real>
double length(std::span<const Real> v, std::size_t n) {
  return Vec3(double(v[3 * n]), double(v[3 * n + 1]), double(v[3 * n + 2])).norm();
}

struct SheetOnBed {
  double thickness = 0.0, decay = 0.0;  // mm; 0 without an attached bed
};
template <class Real>
SheetOnBed sheet_on_bed(const System<Real>& system) {
  const Lattice& lattice = system.lattice();
  double area = 0.0, volume = 0.0, stiffest = 0.0;
  for (const FaceConstraint& face : system.attachments().face_constraints)
    area += face.group == kBedGroup ? face.area : 0.0;
  if (!(area > 0.0) || !(system.bed().shear > 0.0)) return {};
  for (const RestingFace& face : system.attachments().resting) area += face.area;
  for (const float fill : lattice.cell_fill) volume += double(fill) * std::pow(lattice.settings.spacing, 3);
  for (const auto& material : system.elastic().materials().table)
    stiffest = std::max(stiffest, material.youngs_modulus);
  return {volume / area, std::sqrt(stiffest * volume / area / system.bed().shear)};
}

// Per node: whether it belongs to the neighborhood whatever is around it.
template <class Real>
std::vector<std::uint8_t> affected(const System<Real>& system, std::span<const Real> u, const Evaluation& now) {
  const Lattice& lattice = system.lattice();
  const double displaced = kDisplaced * lattice.settings.spacing;
  const double force = displaced * system.elastic().materials().table[0].youngs_modulus * lattice.settings.spacing;
  std::vector<Real> increment(u.size());
  const bool carries = system.prescribed_increment(u, increment);
  std::vector<std::uint8_t> result(system.nodes());
  for_each_index(result.size(), [&](std::size_t n) {
    result[n] = length<Real>(u, n) > displaced || length<double>(now.gradient, n) > force ||
                (carries && length<Real>(increment, n) > 0.0);
  });
  const auto add = [&](const auto& nodes) {
    for (const std::int32_t n : nodes) result[static_cast<std::size_t>(n)] = 1;
  };
  for (const PointConstraint& constraint : system.point_constraints()) add(constraint.nodes());
  for (const RestingFace& face : system.attachments().resting)
    add(lattice.cell_nodes[static_cast<std::size_t>(face.cell)]);
  return result;
}

// Per node: whether it lies in the neighborhood; empty where that is large.
template <class Real>
std::vector<std::uint8_t> neighborhood(const System<Real>& system, const CoarseLattice& tiles, std::span<const Real> u,
                                       const Evaluation& now) {
  const auto& cell_nodes = system.lattice().cell_nodes;
  const double decay = sheet_on_bed(system).decay;
  if (!(decay > 0.0)) return {};
  std::vector<std::uint8_t> nodes = affected(system, u, now);
  const auto all_nodes = static_cast<double>(nodes.size()), all_cells = static_cast<double>(cell_nodes.size());
  if (static_cast<double>(std::ranges::count(nodes, std::uint8_t{1})) > kMaxShare * all_nodes) return {};

  const auto is_in = [](const auto& marked) {
    return [&](std::int32_t n) { return marked[static_cast<std::size_t>(n)] != 0; };
  };
  const auto cells_of = [&](std::size_t tile) { return tiles.cells[tile]; };
  const auto corners_of = [&](std::int32_t cell) -> const auto& { return cell_nodes[static_cast<std::size_t>(cell)]; };
  std::vector<std::uint8_t> taken(tiles.cell_nodes.size()), corners(tiles.nodes);
  for (std::size_t t = 0; t < taken.size(); ++t)
    taken[t] = std::ranges::any_of(
        cells_of(t), [&](std::int32_t cell) { return std::ranges::any_of(corners_of(cell), is_in(nodes)); });
  double count = 0;
  const double tile = tiles.ratio * system.lattice().settings.spacing;
  const double least =
      decay * (largest<Real>(u) > kDisplaced * system.lattice().settings.spacing ? kMinReach : kMaxReach);
  for (double reach = 0.0; reach < kMaxReach * decay + tile; reach += tile) {
    if (reach >= least + tile && count > kMinShare * all_cells) break;
    count = 0;
    for (std::size_t t = 0; t < taken.size(); ++t) {
      taken[t] = taken[t] || std::ranges::any_of(tiles.cell_nodes[t], is_in(corners));
      if (taken[t]) count += static_cast<double>(cells_of(t).size());
    }
    if (count > kMaxShare * all_cells) return {};
    for (std::size_t t = 0; t < taken.size(); ++t)
      if (taken[t])
        for (const std::int32_t corner : tiles.cell_nodes[t]) corners[static_cast<std::size_t>(corner)] = 1;
  }
  for (std::size_t t = 0; t < taken.size(); ++t)
    if (taken[t])
      for (const std::int32_t cell : cells_of(t))
        for (const std::int32_t n : corners_of(cell)) nodes[static_cast<std::size_t>(n)] = 1;
  return nodes;
}

}  // namespace

template <class Real>
NeighborhoodOutcome solve_change_neighborhood(const System<Real>& system, const CoarseLattice& tiles, std::span<Real> u,
                                              Multipliers& multipliers, const Evaluation& now,
                                              const EquilibriumOptions& options, const SolveObserver& observer) {
  if (system.contact() || now.self_contact.touches()) return {};
  auto moving = neighborhood<Real>(system, tiles, u, now);
  if (moving.empty()) return {};
  Subdomain<Real> subdomain = restrict_to<Real>(moving, system, u, multipliers);
  TwoLevel<Real> preconditioner(*subdomain.system, kDegree);
  EquilibriumOptions own = options;
  own.tolerance *= kShareOfTolerance;
  own.max_newton = std::min(own.max_newton, kMaxNewton);
  own.neighborhood_first = own.keeps_step = false;
  own.known.reset();
  own.motion = {};
  own.motions = {};
  NeighborhoodOutcome outcome;
  static_cast<EquilibriumOutcome&>(outcome) =
      find_equilibrium<Real>(*subdomain.system, preconditioner, subdomain.u, subdomain.multipliers, own, observer);
  outcome.active_cells = static_cast<std::int64_t>(subdomain.cells.size());
  if (outcome.converged) subdomain.write_back(u, multipliers);
  outcome.moved = std::move(moving);
  const auto [thickness, decay] = sheet_on_bed(system);
  const double h = system.lattice().settings.spacing;
  outcome.rim_compliance = (thickness / h + 1.0) / (2.0 * h * system.bed().shear * decay);
  return outcome;
}

template NeighborhoodOutcome solve_change_neighborhood<float>(const System<float>&, const CoarseLattice&,
                                                              std::span<float>, Multipliers&, const Evaluation&,
                                                              const EquilibriumOptions&, const SolveObserver&);
template NeighborhoodOutcome solve_change_neighborhood<double>(const System<double>&, const CoarseLattice&,
                                                               std::span<double>, Multipliers&, const Evaluation&,
                                                               const EquilibriumOptions&, const SolveObserver&);

}  // namespace lappet
