#include "solve/newton/local_relaxation.h"

#include <algorithm>
#include <limits>

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
constexpr double kTighter = 0.3;     // than the tolerance need nothing be
constexpr int kMaxNewton = 40;       // for each cluster

// The free nodes whose forces are the largest, and some rings of cells around them; empty where they are too many, or
// where what is left of the residual is elsewhere.
template <class Real>
std::vector<std::uint8_t> around_what_is_off(const System<Real>& system, double residual) {
  const auto gradient = system.gradient();
  const std::size_t size = system.nodes();
  const auto squared = [&](std::size_t n) {
    const double* g = &gradient[3 * n];
    return g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
  };
  double most = 0.0, share = 0.0;
  for (std::size_t n = 0; n < size; ++n) most = std::max(most, squared(n));
  std::vector<std::uint8_t> moving(size, 0);
  for (std::size_t n = 0; n < size; ++n)
    if (system.is_free(n) && squared(n) >= kOff * kOff * most) {
      moving[n] = 1;
      share += squared(n);
    }
  if (share < kOffShare * residual * residual) return {};
  for (int ring = 0; ring < kRings; ++ring) {
    std::vector<std::uint8_t> grown = moving;
    const auto grow = [&](const auto& nodes) {
      if (std::ranges::any_of(nodes, [&](std::int32_t n) { return moving[static_cast<std::size_t>(n)] != 0; }))
        for (const std::int32_t n : nodes)
          grown[static_cast<std::size_t>(n)] = system.is_free(static_cast<std::size_t>(n));
    };
    for (const auto& corners : system.lattice().cell_nodes) grow(corners);
    if (ring == 0)  // a suture moves both its ends
      for (const PointConstraint& constraint : system.point_constraints()) grow(constraint.nodes);
    moving = std::move(grown);
  }
  const auto count = static_cast<double>(std::ranges::count(moving, std::uint8_t{1}));
  if (count > kMaxMoving * static_cast<double>(system.free_nodes())) return {};
  return moving;
}

// Which of the moving nodes hang together, by cells or by point constraints: numbers from 1 on, 0 where a node does not
// move.
template <class Real>
std::vector<std::int32_t> clusters(const System<Real>& system, std::span<const std::uint8_t> moving, int& count) {
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
  for (const PointConstraint& constraint : system.point_constraints()) join(constraint.nodes);
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

}  // namespace

template <class Real>
LocalRelaxation relax_locally(const System<Real>& system, std::span<Real> u, const Evaluation& now, double tolerance,
                              bool inverts, const std::function<bool()>& stop) {
  LocalRelaxation result;
  const auto moving = around_what_is_off(system, now.residual);
  if (moving.empty()) return result;
  // First all together, so that each cluster is cut out of something small.
  Subdomain<Real> all(system, moving, u);
  int count = 0;
  const auto cluster_of = clusters(*all.system, all.moves, count);
  const double target = std::max(kReduction * now.residual, kTighter * tolerance * now.force_scale);
  for (int cluster = 1; cluster <= count && !stop(); ++cluster) {
    std::vector<std::uint8_t> own(all.moves.size());
    for (std::size_t n = 0; n < own.size(); ++n) own[n] = cluster_of[n] == cluster;
    Subdomain<Real> subdomain(*all.system, own, all.u);
    TwoLevel<Real> preconditioner(*subdomain.system, kDegree);
    const Evaluation start = subdomain.system->evaluate(subdomain.u);
    EquilibriumOptions options;
    options.tolerance = target / start.force_scale;
    options.gap_tolerance = std::numeric_limits<double>::infinity();  // multipliers are the whole's
    options.max_newton = kMaxNewton;
    options.inverts = inverts;
    options.relaxes = false;
    const EquilibriumOutcome outcome = find_equilibrium<Real>(*subdomain.system, preconditioner, subdomain.u, options,
                                                              {[](int, double, double) {}, stop});
    if (!(outcome.energy < start.energy)) continue;
    subdomain.write_back(all.u);
    ++result.clusters;
    result.newton_iterations += outcome.newton_iterations;
    result.nodes += static_cast<std::size_t>(std::ranges::count(own, std::uint8_t{1}));
  }
  if (result.nodes > 0) all.write_back(u);
  return result;
}

template LocalRelaxation relax_locally<float>(const System<float>&, std::span<float>, const Evaluation&, double, bool,
                                              const std::function<bool()>&);
template LocalRelaxation relax_locally<double>(const System<double>&, std::span<double>, const Evaluation&, double,
                                               bool, const std::function<bool()>&);

}  // namespace lappet
