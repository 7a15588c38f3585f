#include "force/constraints/contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "force/constraints/face_pieces.h"
#include "force/constraints/point_constraint.h"
#include "lattice/embedding.h"
#include "math/parallel.h"

namespace lappet {

namespace {

// What a penalty may leave, in spacings; a frame converges below it.
constexpr double kAllowedPenetration = 0.08;
constexpr double kMaxEdge = 1.5;  // of a triangle without proxies inside, spacings
constexpr double kMaxDepthOnTheWay = 2.0;
// Near the middle of a thin bone the distance is rounded, and its gradient, which pushes back, fades before it turns.
// A step ends where less of it than this is left, or less than half of what there was at its start.
constexpr double kPushesBack = 0.5;
constexpr int kBisections = 8;
// A step that takes a proxy farther than so many spacings of the bones' grid is cut there: violent loads ask for 1e30
// mm.
constexpr int kMaxStrides = 4096;

// A proxy on its way, told by the distances along it.
class WayIntoBone {
 public:
  WayIntoBone(const SignedDistance::Sample& start, double deepest)
      : side_(start.gradient.normalized()), floor_(std::max(deepest, -start.value)), inside_(start.value < 0.0) {
    if (start.value < 0.0) pushes_back_ = std::min(kPushesBack, 0.5 * start.gradient.norm());
  }

  // False where it would be too deep or be pushed to another side than the one it comes from.
  bool goes_on(const SignedDistance::Sample& at) {
    const bool outside = at.value >= 0.0;
    if (side_.isZero() && !outside) side_ = at.gradient.normalized();
    const double back = at.gradient.dot(side_);
    if (outside ? inside_ && back < 0.0 : -at.value > floor_ || back < pushes_back_) return false;
    inside_ = !outside;
    if (outside) {
      side_ = at.gradient.normalized();
      pushes_back_ = kPushesBack;
    }
    return true;
  }

 private:
  Vec3 side_;  // where bone pushes to
  double floor_, pushes_back_ = kPushesBack;
  bool inside_;
};

}  // namespace

Contact::Contact(BoneDistance bones, const Lattice& lattice, const Surface& surface,
                 std::span<const std::uint8_t> fixed, double stiffness, const Interrupt& interrupt)
    : bones_(std::move(bones)), lattice_(lattice), stiffness_(stiffness) {
  Embedder embedder(lattice, surface);
  std::vector<double> area_of_vertex(surface.points.size(), 0.0);
  std::vector<std::uint8_t> held(surface.points.size(), 0);
  std::vector<Proxy> inner;
  std::vector<Vec3> inner_rest;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& corners = surface.triangles[t];
    if (fixed[t]) {
      for (const Index p : corners) held[p] = 1;
      continue;
    }
    const std::array whole{surface.points[corners[0]], surface.points[corners[1]], surface.points[corners[2]]};
    for_each_piece(whole, kMaxEdge * lattice.settings.spacing, [&](const FacePiece& piece) {
      const int n = piece.n;
      const Vec3 a = piece.at[0], ab = piece.at[1] - a, ac = piece.at[2] - a;
      const double third = 0.5 * ab.cross(ac).norm() / (3.0 * n * n);
      // n^2 small triangles; each gives a third of its area to its corners.
      for (int i = 0; i <= n; ++i) {
        interrupt.check();
        for (int j = 0; j <= n - i; ++j) {
          const int k = n - i - j;
          const int at_end = (i == 0) + (j == 0) + (k == 0);
          if (const int corner = at_end == 2 ? piece.corner[k == n ? 0 : i == n ? 1 : 2] : -1; corner >= 0) {
            area_of_vertex[corners[corner]] += third;
            continue;
          }
          const Vec3 point = a + (i * ab + j * ac) / n;
          const Index triangle = to_index(t);
          inner.push_back({embedder.embed(point, {&triangle, 1}), (at_end == 2   ? 1.0
                                                                   : at_end == 1 ? 3.0
                                                                                 : 6.0) *
                                                                      third});
          inner_rest.push_back(point);
        }
      }
    });
  }
  for (std::size_t p = 0; p < surface.points.size(); ++p)
    if (!held[p] && area_of_vertex[p] > 0.0) {
      proxies_.push_back({lattice.surface_points[p], area_of_vertex[p]});
      rest_.push_back(surface.points[p]);
    }
  proxies_.insert(proxies_.end(), inner.begin(), inner.end());
  rest_.insert(rest_.end(), inner_rest.begin(), inner_rest.end());
  found_.resize((proxies_.size() + kChunk - 1) / kChunk);
}

Contact::Contact(const Contact& whole, const Lattice& lattice, std::span<const Index> place)
    : bones_(whole.bones_), lattice_(lattice), stiffness_(whole.stiffness_) {
  for (std::size_t p = 0; p < whole.proxies_.size(); ++p) {
    Proxy proxy = whole.proxies_[p];
    proxy.point.cell = place[proxy.point.cell];
    if (proxy.point.cell < 0) continue;
    proxies_.push_back(proxy);
    rest_.push_back(whole.rest_[p]);
  }
  found_.resize((proxies_.size() + kChunk - 1) / kChunk);
}

std::vector<double> Contact::restrict_pressures(std::span<const double> pressures, std::span<const Index> place) const {
  std::vector<double> restricted;
  for (std::size_t p = 0; p < pressures.size(); ++p)
    if (place[proxies_[p].point.cell] >= 0) restricted.push_back(pressures[p]);
  return restricted;
}

Contact::Depth Contact::deepest_at_rest() const {
  Depth result;
  for (const Vec3& point : rest_)
    if (const double depth = -bones_.at_rest(point).value; depth > result.depth) result = {depth, point};
  return result;
}

template <class Real>
void Contact::evaluate(std::span<const Real> u, std::span<const double> pressures, std::span<const std::uint8_t> free,
                       std::span<double> gradient, std::vector<ContactPenalty>& penalties, ContactState& state) const {
  std::vector<double> carried(found_.size(), 0.0);  // how deep
  for_each_chunk(proxies_.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    auto& found = found_[chunk];
    found.clear();
    for (std::size_t p = begin; p < end; ++p) {
      const auto sample = bones_.at(rest_[p] + displacement(lattice_, proxies_[p].point, u));
      const double squeezed = (pressures.empty() ? 0.0 : pressures[p] / stiffness_) - sample.value;
      if (!(squeezed > 0.0)) continue;
      const auto& nodes = lattice_.cell_nodes[proxies_[p].point.cell];
      bool moves = false;
      for (std::size_t k = 0; k < 8; ++k) moves = moves || (free[nodes[k]] && proxies_[p].point.weights[k] != 0.0);
      if (moves)
        found.push_back({std::uint32_t(p), -sample.value, squeezed, sample.gradient});
      else if (const double sunk = bones_.at_rest(rest_[p]).value - sample.value;
               sunk > kAllowedPenetration * lattice_.settings.spacing)
        carried[chunk] = std::max(carried[chunk], -sample.value);
    }
  });
  state.touching.clear();
  for (const auto& found : found_) state.touching.insert(state.touching.end(), found.begin(), found.end());

  double energy = 0.0;
  for (std::size_t p = 0; p < pressures.size(); ++p)
    energy -= 0.5 * pressures[p] * pressures[p] / stiffness_ * proxies_[p].area;
  double penetration = 0.0;
  for (const double depth : carried) penetration = std::max(penetration, depth);
  state.force.setZero();
  for (const ContactState::Touching& active : state.touching) {
    const Proxy& proxy = proxies_[active.proxy];
    const double stiffness = stiffness_ * proxy.area;
    energy += 0.5 * stiffness * active.squeezed * active.squeezed;
    const Vec3 force = stiffness * active.squeezed * active.normal;
    const auto& nodes = lattice_.cell_nodes[proxy.point.cell];
    for (std::size_t k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i) gradient[offset_of(3, nodes[k]) + i] -= proxy.point.weights[k] * force[i];
    penalties.push_back({proxy.point.cell, proxy.point.weights, active.normal, stiffness});
    penetration = std::max(penetration, active.depth);
    state.force += force;
  }
  state.energy = energy;
  state.largest_penetration = penetration;
  state.excess = std::max(0.0, penetration - kAllowedPenetration * lattice_.settings.spacing);
}

void Contact::update_pressures(const ContactState& at, std::vector<double>& pressures) const {
  if (!(at.excess > 0.0)) return;
  pressures.assign(proxies_.size(), 0.0);
  for (const ContactState::Touching& active : at.touching) pressures[active.proxy] = stiffness_ * active.squeezed;
}

template <class Real>
double Contact::largest_step(std::span<const Real> u, std::span<const Real> step, double max_part) const {
  const double deepest = kMaxDepthOnTheWay * lattice_.settings.spacing, stride = bones_.spacing();
  std::vector<double> part_of_chunk(found_.size(), max_part);
  for_each_chunk(proxies_.size(), [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    double& most = part_of_chunk[chunk];
    for (std::size_t p = begin; p < end; ++p) {
      const Vec3 move = displacement(lattice_, proxies_[p].point, step);
      const double length = move.norm();
      const Vec3 from = rest_[p] + displacement(lattice_, proxies_[p].point, u);
      const auto start = bones_.at(from);
      if (most * length <= std::min(start.value, stride)) continue;
      WayIntoBone way(start, deepest);
      double clear = 0.0;
      for (int strides = 0; clear < most; ++strides) {
        if (strides == kMaxStrides) {
          most = clear;
          break;
        }
        double part = std::min(most, clear + stride / length);
        if (way.goes_on(bones_.at(from + part * move))) {
          clear = part;
          continue;
        }
        for (int k = 0; k < kBisections; ++k) {
          const double middle = 0.5 * (clear + part);
          (way.goes_on(bones_.at(from + middle * move)) ? clear : part) = middle;
        }
        most = std::max(clear, part - clear);  // some way at least
        break;
      }
    }
  });
  for (const double part : part_of_chunk) max_part = std::min(max_part, part);
  return max_part;
}

template void Contact::evaluate<float>(std::span<const float>, std::span<const double>, std::span<const std::uint8_t>,
                                       std::span<double>, std::vector<ContactPenalty>&, ContactState&) const;
template void Contact::evaluate<double>(std::span<const double>, std::span<const double>, std::span<const std::uint8_t>,
                                        std::span<double>, std::vector<ContactPenalty>&, ContactState&) const;
template double Contact::largest_step<float>(std::span<const float>, std::span<const float>, double) const;
template double Contact::largest_step<double>(std::span<const double>, std::span<const double>, double) const;

}  // namespace lappet
