#include "solve/newton/step_to_contact.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <vector>

#include "solve/system/vectors.h"

namespace lappet {

namespace {

constexpr double kFreeEnough = 0.7;  // share of a step that is enough
constexpr int kRounds = 4;
constexpr int kMaxIterations = 60;
constexpr double kStepCap = 8.0;  // spacings a node may move, as in the line search

}  // namespace

template <class Real>
StepToContact find_step_to_contact(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<const Real> u,
                                   const StepEquations<Real>& equations, LinearVectors<Real>& work,
                                   std::span<Real> step, const std::function<bool()>& stop) {
  StepToContact outcome;
  SelfContact& contact = *system.self_contact();
  const std::vector<TouchingPair>& touching = equations.at.self_contact.pairs;
  std::map<std::array<Index, 4>, TouchingPair> springs;  // by their vertices
  std::vector<Real> whole(step.size());
  std::vector<double> pull(step.size());
  while (outcome.rounds < kRounds && !stop()) {
    copy<Real>(step, whole);
    if (!equations.carried.empty()) add<Real>(Real(1), equations.carried, whole);
    const double most =
        std::min(1.0, kStepCap * system.lattice().settings.spacing / std::max(largest<Real>(whole), 1e-300));
    if (system.largest_step(u, whole, most) >= kFreeEnough * most) break;
    const std::size_t before = springs.size();
    for (const TouchingPair& pair : contact.template met<Real>(u, whole, most))
      springs.insert_or_assign(pair.vertices, pair);
    if (springs.size() == before && outcome.rounds > 0) break;
    std::vector<TouchingPair> pairs = touching;
    for (const auto& [vertices, pair] : springs) pairs.push_back(pair);
    system.set_self_contact_rows(pairs);
    preconditioner.refresh(u);
    equations.set_right_hand_side();
    std::ranges::fill(pull, 0.0);
    contact.add_gradient(std::span<const TouchingPair>(pairs).subspan(touching.size()), pull);
    for_each_index(system.nodes(), [&](std::size_t n) {
      for (std::size_t i = 3 * n; system.is_free(n) && i < 3 * n + 3; ++i) work.r[i] -= static_cast<Real>(pull[i]);
    });
    const LinearOutcome linear =
        conjugate_gradients<Real>(system, preconditioner, work, step, equations.tolerance, kMaxIterations, stop);
    outcome.pcg_iterations += linear.iterations;
    ++outcome.rounds;
    if (linear.indefinite) break;
  }
  if (outcome.rounds > 0) {
    system.set_self_contact_rows(touching);
    spdlog::debug("  {} springs for what the step meets: {} rounds, {} pcg", springs.size(), outcome.rounds,
                  outcome.pcg_iterations);
  }
  return outcome;
}

template StepToContact find_step_to_contact(System<float>&, TwoLevel<float>&, std::span<const float>,
                                            const StepEquations<float>&, LinearVectors<float>&, std::span<float>,
                                            const std::function<bool()>&);
template StepToContact find_step_to_contact(System<double>&, TwoLevel<double>&, std::span<const double>,
                                            const StepEquations<double>&, LinearVectors<double>&, std::span<double>,
                                            const std::function<bool()>&);

}  // namespace lappet
