#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "lattice/node_field.h"
#include "solve/system/system.h"

namespace lappet {

namespace {

// Directions that rows demand nothing of have at most this share of the stiffest one's weight.
constexpr double kLoose = 1e-6;

}  // namespace

// Of the penalty, mN/mm: that of a held face over the side of a cell; the multipliers do the rest.
template <class Real>
double System<Real>::roller_stiffness() const {
  return held_stiffness() * lattice().settings.spacing * lattice().settings.spacing;
}

// What is prescribed is held already.
template <class Real>
bool System<Real>::acts(const RollerRow& row) const {
  for (std::size_t k = 0; k < 8; ++k)
    if (row.weights[k] != 0.0 && free_[static_cast<std::size_t>(lattice().cell_nodes[row.cell][k])]) return true;
  return false;
}

// How far what a row holds is off its plane, mm.
template <class Real>
double System<Real>::off(const RollerRow& row, std::span<const Real> u) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < 8; ++k)
    if (row.weights[k] != 0.0) sum += row.weights[k] * row.normal.dot(NodeField(u)[lattice().cell_nodes[row.cell][k]]);
  return sum;
}

template <class Real>
void System<Real>::add_rollers(std::span<const Real> u, const Multipliers& multipliers, Evaluation& result) const {
  const double stiffness = roller_stiffness();
  for (std::size_t r = 0; r < attachments_.rollers.size(); ++r) {
    const RollerRow& row = attachments_.rollers[r];
    if (!acts(row)) continue;
    const double away = off(row, u),
                 multiplier = multipliers.of_roller_row.empty() ? 0.0 : multipliers.of_roller_row[r];
    const double push = multiplier + stiffness * away;
    result.contact_penalties.push_back({row.cell, row.weights, row.normal, stiffness});
    result.energy += (multiplier + 0.5 * stiffness * away) * away;
    for (std::size_t k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i)
        result
            .gradient[3 * static_cast<std::size_t>(lattice().cell_nodes[row.cell][k]) + static_cast<std::size_t>(i)] +=
            push * row.weights[k] * row.normal[i];
  }
}

// Fragments whose rollers leave them no rigid motion; one that slides or turns on them still floats.
template <class Real>
void System<Real>::mark_rolling_fragments(std::vector<std::uint8_t>& held) const {
  struct Rolling {
    std::vector<std::pair<Vec3, Vec3>> rows;  // where, normal
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  };
  std::map<std::size_t, Rolling> fragments;
  for (const RollerRow& row : attachments_.rollers) {
    if (!acts(row)) continue;
    const auto k = static_cast<std::size_t>(
        std::ranges::max_element(row.weights, {}, [](double w) { return std::abs(w); }) - row.weights.begin());
    const auto node = static_cast<std::size_t>(lattice().cell_nodes[row.cell][k]);
    Rolling& own = fragments[fragment(node)];
    const Vec3 at = lattice().node_rest[node];
    own.rows.emplace_back(at, row.normal);
    own.low = own.low.cwiseMin(at);
    own.high = own.high.cwiseMax(at);
  }
  for (const auto& [fragment, own] : fragments) {
    const Vec3 center = 0.5 * (own.low + own.high);
    const double size = std::max((own.high - own.low).norm(), lattice().settings.spacing);
    Eigen::Matrix<double, 6, 6> demand = Eigen::Matrix<double, 6, 6>::Zero();
    for (const auto& [at, normal] : own.rows) {
      Eigen::Matrix<double, 6, 1> row;
      row << normal, (at - center).cross(normal) / size;
      demand += row * row.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> motions(demand, Eigen::EigenvaluesOnly);
    if (motions.eigenvalues()[0] > kLoose * motions.eigenvalues()[5]) held[fragment] = 1;
  }
}

template double System<float>::roller_stiffness() const;
template bool System<float>::acts(const RollerRow&) const;
template double System<float>::off(const RollerRow&, std::span<const float>) const;
template void System<float>::add_rollers(std::span<const float>, const Multipliers&, Evaluation&) const;
template void System<float>::mark_rolling_fragments(std::vector<std::uint8_t>&) const;
template double System<double>::roller_stiffness() const;
template bool System<double>::acts(const RollerRow&) const;
template double System<double>::off(const RollerRow&, std::span<const double>) const;
template void System<double>::add_rollers(std::span<const double>, const Multipliers&, Evaluation&) const;
template void System<double>::mark_rolling_fragments(std::vector<std::uint8_t>&) const;

}  // namespace lappet
