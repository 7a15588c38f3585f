// Loads on faces. A traction is a force on the nodes that does not change: it has the energy -f . u.
//
// A pressure pushes on the area as it is now. Over faces that are closed, or whose border stays or slides in its plane,
// it has an energy, p times the volume that they have swept; over others it has none. So what is counted is its work on
// the straight way from where the tangent was taken, besides what it was there: that is the energy where there is one,
// and along any step of a search its derivative is the force. The tangent has its symmetric part where it is exact:
// all of it where there is an energy.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "lattice/node_field.h"
#include "math/parallel.h"
#include "solve/system/system.h"
#include "solve/system/vectors.h"

namespace lappet {

namespace {

// Of a tangent, as a share of it: less is what the samples of faces off the lattice planes leave (chosen).
constexpr double kOdd = 1e-3;

template <class Real>
FaceMotion motion_of(const Lattice& lattice, const LoadedFaces& faces, const LoadedFaces::Sample& sample,
                     std::span<const Real> u) {
  const LoadedFaces::Directions& rest = faces.directions(sample);
  const auto weights = sample.weights();
  const auto first = sample.slopes(rest.first, lattice.settings.spacing);
  const auto second = sample.slopes(rest.second, lattice.settings.spacing);
  FaceMotion motion;
  for (std::size_t k = 0; k < 8; ++k) {
    const Vec3 moved =
        NodeField(u)[static_cast<std::size_t>(lattice.cell_nodes[static_cast<std::size_t>(sample.cell)][k])];
    motion.middle += weights[k] * moved;
    motion.first += first[k] * moved;
    motion.second += second[k] * moved;
  }
  return motion;
}

// The directions as they are after a motion.
LoadedFaces::Directions moved(const LoadedFaces::Directions& rest, const FaceMotion& motion) {
  return {rest.first + motion.first, rest.second + motion.second};
}

template <class Real, class Field>
void add_at(const std::array<Index, 8>& nodes, const Field& force_of_node, std::span<Real> to) {
  for (std::size_t k = 0; k < 8; ++k) {
    const Vec3 force = force_of_node(k);
    for (std::size_t i = 0; i < 3; ++i)
      to[3 * static_cast<std::size_t>(nodes[k]) + i] += static_cast<Real>(force[static_cast<int>(i)]);
  }
}

}  // namespace

template <class Real>
void System<Real>::set_loads(std::vector<FaceLoad> loads, std::span<const Real> u) {
  loads_ = std::move(loads);
  traction_force_.clear();
  for (const FaceLoad& load : loads_) {
    if (load.traction.isZero(0.0)) continue;
    traction_force_.resize(3 * free_.size(), 0.0);
    for (const auto& sample : load.faces->samples())
      add_at<double>(
          lattice().cell_nodes[static_cast<std::size_t>(sample.cell)],
          [&, weights = sample.weights()](std::size_t k) -> Vec3 { return weights[k] * sample.area * load.traction; },
          traction_force_);
  }
  pressure_tangent_.clear();
  pressure_energy_from_ = 0.0;
  pressed_from_ = pressed_motions(u);
  std::size_t at = 0;
  for (const FaceLoad& load : loads_)
    for (std::size_t k = 0; load.pressure != 0.0 && k < load.faces->samples().size(); ++k, ++at) {
      const auto& sample = load.faces->samples()[k];
      pressure_energy_from_ +=
          load.pressure * sample.area * swept_volume(load.faces->directions(sample), pressed_from_[at]);
    }
}

template <class Real>
std::vector<FaceMotion> System<Real>::pressed_motions(std::span<const Real> u) const {
  std::vector<FaceMotion> motions;
  for (const FaceLoad& load : loads_) {
    if (load.pressure == 0.0) continue;
    const auto& samples = load.faces->samples();
    const std::size_t first = motions.size();
    motions.resize(first + samples.size());
    for_each_row(samples.size(),
                 [&](std::size_t k) { motions[first + k] = motion_of(lattice(), *load.faces, samples[k], u); });
  }
  return motions;
}

template <class Real>
void System<Real>::add_loads(std::span<const Real> u, Evaluation& result) const {
  if (!traction_force_.empty())
    result.energy -= reduce<1>(traction_force_.size(), [&, g = result.gradient.data()](std::size_t i, double* out) {
      out[0] = traction_force_[i] * static_cast<double>(u[i]);
      g[i] -= traction_force_[i];
    })[0];
  result.pressure_energy = 0.0;
  result.pressed.clear();
  if (!pressed_from_.empty()) add_pressures(u, result);
}

template <class Real>
void System<Real>::add_pressures(std::span<const Real> u, Evaluation& result) const {
  struct Found {
    std::array<Vec3, 8> forces;
    double work = 0.0;
  };
  result.pressed = pressed_motions(u);
  result.pressure_energy = pressure_energy_from_;
  std::size_t at = 0;
  for (const FaceLoad& load : loads_) {
    if (load.pressure == 0.0) continue;
    const auto& samples = load.faces->samples();
    const auto& begins = load.faces->cell_begins();
    std::vector<Found> found(begins.size() - 1);
    for_each_row(found.size(), [&](std::size_t c) {
      found[c].forces.fill(Vec3::Zero());
      for (std::size_t k = begins[c]; k < begins[c + 1]; ++k) {
        const FaceMotion &from = pressed_from_[at + k], &now = result.pressed[at + k];
        found[c].work +=
            load.pressure * samples[k].area * swept_volume(moved(load.faces->directions(samples[k]), from), now - from);
        const Vec3 push = load.pressure * load.faces->area_now(samples[k], now);
        const auto weights = samples[k].weights();
        for (std::size_t n = 0; n < 8; ++n) found[c].forces[n] += weights[n] * push;
      }
    });
    for (std::size_t c = 0; c < found.size(); ++c) {
      result.pressure_energy += found[c].work;
      const auto cell = static_cast<std::size_t>(samples[begins[c]].cell);
      add_at<double>(
          lattice().cell_nodes[cell], [&](std::size_t n) -> const Vec3& { return found[c].forces[n]; },
          std::span<double>(result.gradient));
    }
    at += samples.size();
  }
  result.energy += result.pressure_energy;
}

template <class Real>
void System<Real>::linearize_pressures() {
  std::size_t at = 0;
  for (const FaceLoad& load : loads_) {
    if (load.pressure == 0.0) continue;
    const auto& samples = load.faces->samples();
    const auto& begins = load.faces->cell_begins();
    const std::size_t first = pressure_tangent_.size();
    pressure_tangent_.resize(first + begins.size() - 1);
    for_each_row(begins.size() - 1, [&](std::size_t c) {
      NodePairs& pairs = pressure_tangent_[first + c];
      pairs.fill(Vec3::Zero());
      for (std::size_t k = begins[c]; k < begins[c + 1]; ++k) {
        const LoadedFaces::Directions& rest = load.faces->directions(samples[k]);
        add_symmetric_change(samples[k], rest, moved(rest, pressed_from_[at + k]), lattice().settings.spacing, pairs);
      }
      for (Vec3& pair : pairs) pair *= load.pressure;
    });
    at += samples.size();
  }
}

template <class Real>
void System<Real>::multiply_pressure(std::span<const Real> x, std::span<Real> y) const {
  const NodePairs* pairs = pressure_tangent_.data();
  for (const FaceLoad& load : loads_) {
    if (load.pressure == 0.0) continue;
    const auto& begins = load.faces->cell_begins();
    for (std::size_t c = 0; c + 1 < begins.size(); ++c, ++pairs) {
      const auto& nodes = lattice().cell_nodes[static_cast<std::size_t>(load.faces->samples()[begins[c]].cell)];
      std::array<Vec3, 8> from, forces;
      for (std::size_t k = 0; k < 8; ++k) {
        from[k] = NodeField(x)[static_cast<std::size_t>(nodes[k])];
        forces[k].setZero();
      }
      const Vec3* pair = pairs->data();
      for (std::size_t a = 0; a < 8; ++a)
        for (std::size_t b = a + 1; b < 8; ++b, ++pair) {
          forces[a] += pair->cross(from[b]);
          forces[b] -= pair->cross(from[a]);
        }
      add_at<Real>(nodes, [&](std::size_t k) -> const Vec3& { return forces[k]; }, y);
    }
  }
}

// Takes off what is not free, or leaves the planes of rollers.
template <class Real>
void System<Real>::leave_on_rollers(std::span<Real> x) const {
  for (std::size_t n = 0; n < free_.size(); ++n)
    if (!free_[n]) x[3 * n] = x[3 * n + 1] = x[3 * n + 2] = Real(0);
  for (const RollerRow& row : attachments_.rollers) {
    if (!acts(row)) continue;
    double squared = 0.0;
    for (const double weight : row.weights) squared += weight * weight;
    const double away = off(row, x) / squared;
    for (std::size_t k = 0; k < 8; ++k) {
      const auto n = static_cast<std::size_t>(lattice().cell_nodes[static_cast<std::size_t>(row.cell)][k]);
      for (std::size_t i = 0; row.weights[k] != 0.0 && i < 3; ++i)
        x[3 * n + i] -= static_cast<Real>(away * row.weights[k] * row.normal[static_cast<int>(i)]);
    }
  }
}

template <class Real>
bool System<Real>::pressures_have_energy(std::span<const Real> u) const {
  if (pressed_from_.empty()) return true;
  std::vector<Real> noise(u.size()), odd(u.size()), all(u.size());  // odd: what the tangent has that is not symmetric
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<Real>(std::sin(12.9898 * double(i)));
  leave_on_rollers(noise);
  const std::vector<FaceMotion> motions = pressed_motions(noise), now = pressed_motions(u);
  std::size_t at = 0;
  for (const FaceLoad& load : loads_)
    for (std::size_t k = 0; load.pressure != 0.0 && k < load.faces->samples().size(); ++k, ++at) {
      const auto& sample = load.faces->samples()[k];
      const LoadedFaces::Directions& rest = load.faces->directions(sample);
      const LoadedFaces::Directions here = moved(rest, now[at]);
      const Vec3 whole =
          load.pressure * sample.area * (here.first.cross(motions[at].second) + motions[at].first.cross(here.second));
      NodePairs even{};
      even.fill(Vec3::Zero());
      add_symmetric_change(sample, rest, here, lattice().settings.spacing, even);
      const auto& nodes = lattice().cell_nodes[static_cast<std::size_t>(sample.cell)];
      const auto weights = sample.weights();
      std::array<Vec3, 8> apart;
      for (std::size_t n = 0; n < 8; ++n) apart[n] = weights[n] * whole;
      const Vec3* pair = even.data();
      for (std::size_t a = 0; a < 8; ++a)
        for (std::size_t b = a + 1; b < 8; ++b, ++pair) {
          apart[a] -= load.pressure * pair->cross(NodeField<Real>(noise)[static_cast<std::size_t>(nodes[b])]);
          apart[b] += load.pressure * pair->cross(NodeField<Real>(noise)[static_cast<std::size_t>(nodes[a])]);
        }
      add_at<Real>(nodes, [&](std::size_t n) -> Vec3 { return weights[n] * whole; }, std::span<Real>(all));
      add_at<Real>(nodes, [&](std::size_t n) -> const Vec3& { return apart[n]; }, std::span<Real>(odd));
    }
  leave_on_rollers(odd);
  leave_on_rollers(all);
  return dot<Real>(odd, odd) <= kOdd * kOdd * dot<Real>(all, all);
}

// motions: of the samples under its pressure.
template <class Real>
Vec3 System<Real>::load_force(const FaceLoad& load, std::span<const FaceMotion> motions) const {
  Vec3 force = load.faces->area() * load.traction;
  for (std::size_t k = 0; k < motions.size(); ++k)
    force -= load.pressure * load.faces->area_now(load.faces->samples()[k], motions[k]);
  return force;
}

template void System<float>::leave_on_rollers(std::span<float>) const;
template bool System<float>::pressures_have_energy(std::span<const float>) const;
template void System<double>::leave_on_rollers(std::span<double>) const;
template bool System<double>::pressures_have_energy(std::span<const double>) const;
template void System<float>::set_loads(std::vector<FaceLoad>, std::span<const float>);
template std::vector<FaceMotion> System<float>::pressed_motions(std::span<const float>) const;
template void System<float>::add_loads(std::span<const float>, Evaluation&) const;
template void System<float>::add_pressures(std::span<const float>, Evaluation&) const;
template void System<float>::linearize_pressures();
template void System<double>::linearize_pressures();
template void System<float>::multiply_pressure(std::span<const float>, std::span<float>) const;
template Vec3 System<float>::load_force(const FaceLoad&, std::span<const FaceMotion>) const;
template void System<double>::set_loads(std::vector<FaceLoad>, std::span<const double>);
template std::vector<FaceMotion> System<double>::pressed_motions(std::span<const double>) const;
template void System<double>::add_loads(std::span<const double>, Evaluation&) const;
template void System<double>::add_pressures(std::span<const double>, Evaluation&) const;
template void System<double>::multiply_pressure(std::span<const double>, std::span<double>) const;
template Vec3 System<double>::load_force(const FaceLoad&, std::span<const FaceMotion>) const;

}  // namespace lappet
