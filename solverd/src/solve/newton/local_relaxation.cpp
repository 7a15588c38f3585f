#include "solve/newton/local_relaxation.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "math/disjoint_sets.h"
#include "solve/newton/equilibrium.h"
#include "solve/subdomain/subdomain.h"

namespace lappet {

namespace {

constexpr int kDegree = 4;           // of the smoother
constexpr int kRings = 2;            // of cells around the nodes that are off
constexpr double kOff = 0.1;         // nodes with this part of the largest force are off ...
constexpr double kOffShare = 0.5;    // ... and have at least this much of the squared residual
constexpr double kMaxMoving = 0.05;  // of the free nodes
constexpr double kReduction = 0.1;   // of the residual
// Likewise where tissue presses on tissue: closed wounds touch all along, and what is left there holds up the whole.
constexpr double kMaxMovingTouching = 0.3, kReductionTouching = 0.01;
constexpr double kTighter = 0.3;  // than the tolerance need nothing be
constexpr int kMaxNewton = 40;    // for each cluster

// The pairs that press on each other, as far as subdomains know of them.
template <class Real>
std::span<const TouchingPair> known_pairs(const System<Real>& system, const Evaluation& now) {
  if (!system.self_contact() || !system.self_contact()->acts_in_subdomains()) return {};
  return now.self_contact.pairs;
}

// The nodes that each pair hangs on, which move.
template <class Real, class Body>
void for_each_touching(const System<Real>& system, std::span<const TouchingPair> pairs, const Body& body) {
  if (pairs.empty()) return;
  const ContactSurface& surface = system.self_contact()->surface();
  std::vector<Index> nodes;
  for (const TouchingPair& pair : pairs) {
    nodes.clear();
    for (std::size_t k = 0; k < 4 && pair.vertices[k] >= 0; ++k)
      if (const Index cell = surface.embedded(pair.vertices[k]).cell; cell >= 0 && pair.weights[k] != 0.0)
        nodes.insert(nodes.end(), surface.lattice().cell_nodes[cell].begin(), surface.lattice().cell_nodes[cell].end());
    body(nodes);
  }
}

// The free nodes whose forces are the largest, and some rings of cells around them; empty where they are too many, or
// where what is left of the residual is elsewhere.
template <class Real>
std::vector<std::uint8_t> around_what_is_off(const System<Real>& system, const Evaluation& now,
                                             std::span<const TouchingPair> touching) {
  const std::size_t size = system.nodes();
  const auto squared = [&](std::size_t n) {
    const double* g = &now.gradient[3 * n];
    return g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
  };
  double largest = 0.0, share = 0.0;
  for (std::size_t n = 0; n < size; ++n) largest = std::max(largest, squared(n));
  std::vector<std::uint8_t> moving(size, 0);
  for (std::size_t n = 0; n < size; ++n)
    if (system.is_free(n) && squared(n) >= kOff * kOff * largest) {
      moving[n] = 1;
      share += squared(n);
    }
  if (share < kOffShare * now.residual * now.residual) return {};
  for (int ring = 0; ring < kRings; ++ring) {
    std::vector<std::uint8_t> grown = moving;
    const auto grow = [&](const auto& nodes) {
      if (std::ranges::any_of(nodes, [&](std::int32_t n) { return moving[static_cast<std::size_t>(n)] != 0; }))
        for (const std::int32_t n : nodes)
          grown[static_cast<std::size_t>(n)] = system.is_free(static_cast<std::size_t>(n));
    };
    for (const auto& corners : system.lattice().cell_nodes) grow(corners);
    if (ring == 0) {  // a suture moves both its ends, and what presses what it presses on
      for (const PointConstraint& constraint : system.point_constraints()) grow(constraint.nodes());
      for_each_touching(system, touching, grow);
    }
    moving = std::move(grown);
  }
  const auto count = static_cast<double>(std::ranges::count(moving, std::uint8_t{1}));
  const double most = touching.empty() ? kMaxMoving : kMaxMovingTouching;
  if (count > most * static_cast<double>(system.free_nodes())) return {};
  return moving;
}

// Which of the moving nodes hang together, by cells, by point constraints or by what presses: numbers from 1 on, 0
// where a node does not move.
template <class Real>
std::vector<std::int32_t> clusters(const System<Real>& system, std::span<const TouchingPair> pairs,
                                   std::span<const std::uint8_t> moving, int& count) {
  DisjointSets sets(moving.size());
  const auto join = [&](const auto& nodes) {
    Index first = -1;
    for (const Index n : nodes) {
      if (!moving[n]) continue;
      if (first >= 0) sets.unite(first, n);
      first = n;
    }
  };
  for (const auto& corners : system.lattice().cell_nodes) join(corners);
  for (const PointConstraint& constraint : system.point_constraints()) join(constraint.nodes());
  for_each_touching(system, pairs, join);
  std::vector<std::int32_t> number(moving.size(), 0);
  count = 0;
  for (std::size_t n = 0; n < moving.size(); ++n) {
    if (!moving[n]) continue;
    auto& of_root = number[sets.find(to_index(n))];
    if (of_root == 0) of_root = ++count;
    number[n] = of_root;
  }
  return number;
}

struct RelaxedCluster {
  int newton_iterations = 0;
  bool moved = false;
};
// Takes a cluster to its own equilibrium; `moved` where that lowers the energy.
template <class Real>
RelaxedCluster relax_cluster(Subdomain<Real>& cluster, double target, bool inverts, const std::function<bool()>& stop) {
  auto& [lattice, cells, nodes, moves, u, multipliers, system] = cluster;
  TwoLevel<Real> preconditioner(*system, kDegree);
  const EvaluationSummary start = system->evaluate(u, multipliers);
  EquilibriumOptions options;
  options.tolerance = target / start.force_scale;
  options.gap_tolerance = std::numeric_limits<double>::infinity();  // multipliers are the whole's
  options.max_newton = kMaxNewton;
  options.inverts = inverts;
  options.accuracy = Accuracy::kRelaxation;
  const EquilibriumOutcome outcome =
      find_equilibrium<Real>(*system, preconditioner, u, multipliers, options, {[](int, double, double) {}, stop});
  return {outcome.newton_iterations, outcome.energy < start.energy};
}

}  // namespace

template <class Real>
LocalRelaxation relax_locally(const System<Real>& system, std::span<Real> u, const Multipliers& multipliers,
                              const Evaluation& now, double tolerance, bool inverts,
                              const std::function<bool()>& stop) {
  LocalRelaxation result;
  const std::span<const TouchingPair> touching = known_pairs(system, now);
  const auto moving = around_what_is_off(system, now, touching);
  if (moving.empty()) return result;
  // First all together, so that each cluster is cut out of something small.
  Subdomain<Real> all = restrict_to<Real>(moving, system, u, multipliers);
  int count = 0;
  const auto cluster_of = clusters(*all.system, touching, all.moves, count);
  const double reduction = touching.empty() ? kReduction : kReductionTouching;
  const double target = std::max(reduction * now.residual, kTighter * tolerance * now.residual / now.relative_residual);
  for (int k = 1; k <= count && !stop(); ++k) {
    std::vector<std::uint8_t> own(all.moves.size());
    for (std::size_t n = 0; n < own.size(); ++n) own[n] = cluster_of[n] == k;
    std::optional<Subdomain<Real>> part;
    if (count > 1) part = restrict_to<Real>(own, *all.system, all.u, all.multipliers);
    const RelaxedCluster cluster = relax_cluster<Real>(part ? *part : all, target, inverts, stop);
    if (!cluster.moved) continue;
    if (part) part->write_back(all.u);
    ++result.clusters;
    result.newton_iterations += cluster.newton_iterations;
    result.nodes += static_cast<std::size_t>(std::ranges::count(own, std::uint8_t{1}));
  }
  if (result.nodes > 0) all.write_back(u);
  return result;
}

template LocalRelaxation relax_locally<float>(const System<float>&, std::span<float>, const Multipliers&,
                                              const Evaluation&, double, bool, const std::function<bool()>&);
template LocalRelaxation relax_locally<double>(const System<double>&, std::span<double>, const Multipliers&,
                                               const Evaluation&, double, bool, const std::function<bool()>&);

}  // namespace lappet
