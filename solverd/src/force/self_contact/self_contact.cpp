#include "force/self_contact/self_contact.h"

#include <algorithm>
#include <cmath>

#include "force/self_contact/continuous_collision.h"
#include "force/self_contact/contour_shortening.h"
#include "force/self_contact/separation.h"
#include "force/self_contact/untangling.h"

namespace lappet {

namespace {

// From how many spacings on surfaces keep apart, up to a spacing of 1 mm. Beyond, this share grows with the spacing:
// what two lattices make of walls that fit each other differs by the square of it, and where the reach is less than
// that a few points bear all of the pressure.
constexpr double kReach = 0.05, kFullSpacing = 1.0;  // mm
// By how many spacings the surface may move before pairs are looked for again.
constexpr double kSlack = 0.05;
// Of the barrier, in Young's moduli: surfaces at half of the reach press on each other with 1.2 of them. Softer, a
// corner bears its load at a thousandth of the reach only, where a Newton step leads nowhere.
constexpr double kStiffness = 1.0;
// Spacings by which what holds creeps at most.
constexpr double kSlide = 2e-3;
// Rounds without less of what goes through itself, after which it stays as it is: of vertices that lie behind
// something, and of contours that are shortened, of which those of more places are deep.
constexpr int kRoundsInVain = 5, kRounds = 20;
constexpr std::size_t kMaxPlaces = 4000;
// Which share of the places where contours are shortened may stay as it is while the others are taken apart. Where more
// does, surfaces lie deep in each other, and half of the way out leads nowhere.
constexpr double kMaxLeft = 0.05;

double reach_at(double spacing) { return kReach * spacing * std::max(spacing / kFullSpacing, 1.0); }

constexpr std::size_t kPairsPerChunk = 128;

// Whether the direction in which a candidate was found tells that it stays so far out of its reach, on such a share of
// the way, that the way does not end there.
template <int kFirst, class Pair>
bool stays_out_of_reach(const std::array<Vec3, 4>& from, const std::array<Vec3, 4>& way, double share,
                        const Pair& pair) {
  const Vec3 direction = pair.direction.template cast<double>();
  const double enough = kWayEnds * pair.reach;
  return apart_along<kFirst>(from, direction) > enough &&
         share_apart_along<kFirst>(from, way, direction, enough, share) >= share;
}

// The least of the shares that body(k, most) finds for each pair, given what is left of the step so far.
template <class Body>
double least_share(std::size_t count, double most, const Body& body) {
  std::vector<double> of_chunk((count + kPairsPerChunk - 1) / kPairsPerChunk, most);
  for_each_chunk(
      count,
      [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) of_chunk[chunk] = std::min(of_chunk[chunk], body(k, of_chunk[chunk]));
      },
      kPairsPerChunk);
  for (const double share : of_chunk) most = std::min(most, share);
  return most;
}

}  // namespace

SelfContact::SelfContact(const Lattice& lattice, const Surface& surface, double modulus, double friction,
                         const Interrupt& interrupt)
    : surface_(lattice, surface, reach_at(lattice.settings.spacing), interrupt),
      candidates_(surface_, kSlack * lattice.settings.spacing),
      stiffness_(kStiffness * modulus),
      friction_(friction, kSlide * lattice.settings.spacing) {}

template <class Real>
std::size_t SelfContact::count_piercings(std::span<const Real> u) {
  surface_.positions(u, places_);
  return candidates_.piercings(places_).size();
}

template <class Real>
std::size_t SelfContact::begin(std::span<const Real> u) {
  surface_.positions(u, places_);
  if (friction_.acts()) friction_.begin(places_);
  const std::vector<Piercing>& piercings = candidates_.piercings(places_);
  return piercings.size() + candidates_.leave_out(piercings, places_);
}

template <class Real>
std::size_t SelfContact::untangle(std::span<Real> u, const std::function<bool(Index)>& moves) {
  const std::size_t places = count_piercings<Real>(u);
  if (places == 0 || places_ == in_vain_at_) return 0;
  const std::vector<Vec3> start = places_;
  Untangling behind(surface_, moves);
  std::size_t left = take_apart(u, kRoundsInVain, 0, [&](std::span<const Piercing> piercings, std::span<double> to) {
    return behind.push(places_, piercings, to);
  });
  if (left > 0 && places <= kMaxPlaces) {
    const std::vector<double> from(u.begin(), u.end());
    ContourShortening contours(surface_, moves, from);
    const auto enough = static_cast<std::size_t>(kMaxLeft * static_cast<double>(places));
    left = take_apart(u, kRounds, enough, [&](std::span<const Piercing> piercings, std::span<double> to) {
      return contours.push(places_, piercings, to);
    });
  }
  if (left == places) in_vain_at_ = start;
  return places - left;
}

// Rounds until nothing goes through anything, or there were so many without less of it. Where more than `enough` is
// left, u stays. Returns how much goes through something at u.
template <class Real>
std::size_t SelfContact::take_apart(std::span<Real> u, int most_in_vain, std::size_t enough, const Round& round) {
  std::vector<double> moved(u.begin(), u.end());
  std::vector<Real> best;
  const std::size_t places = count_piercings<Real>(u);
  std::size_t fewest = places;
  for (int in_vain = 0; fewest > 0 && in_vain < most_in_vain; ++in_vain) {
    surface_.positions<double>(moved, places_);
    if (!round(candidates_.piercings(places_), moved)) break;
    std::vector<Real> rounded(moved.begin(), moved.end());
    const std::size_t left = count_piercings<Real>(rounded);
    if (left >= fewest) continue;
    in_vain = 0;
    fewest = left;
    best = std::move(rounded);
  }
  if (fewest >= places || fewest > enough) return places;
  std::ranges::copy(best, u.begin());
  return fewest;
}

template <class Real>
bool SelfContact::is_apart(std::span<const Real> u) {
  if (begin(u) > 0) return false;
  candidates_.cover(places_);
  return touching_pairs(surface_, candidates_, places_, stiffness_).empty();
}

template <class Real>
void SelfContact::evaluate(std::span<const Real> u, std::span<double> gradient, SelfContactState& state) {
  surface_.positions(u, places_);
  candidates_.cover(places_);
  state.pairs = touching_pairs(surface_, candidates_, places_, stiffness_);
  state.energy = 0.0;
  for (const TouchingPair& pair : state.pairs) state.energy += pair.energy;
  add_gradient(state.pairs, gradient);
  state.sliding.clear();
  if (!friction_.acts()) return;
  state.sliding = friction_.sliding(places_);
  for (const SlidingPair& pair : state.sliding) {
    state.energy += pair.energy;
    for (std::size_t k = 0; k < 4 && pair.vertices[k] >= 0; ++k)
      add_force(pair.vertices[k], pair.weights[k] * pair.slope, gradient);
  }
}

bool SelfContact::look_for_friction(const SelfContactState& state) {
  if (friction_.acts()) friction_.look(state.pairs);
  return friction_.acts();
}

void SelfContact::add_gradient(std::span<const TouchingPair> pairs, std::span<double> gradient) const {
  for (const TouchingPair& pair : pairs)
    for (std::size_t k = 0; k < 4 && pair.vertices[k] >= 0; ++k)
      add_force(pair.vertices[k], pair.gradient(k), gradient);
}

void SelfContact::add_force(Index vertex, const Vec3& force, std::span<double> gradient) const {
  const EmbeddedPoint& point = surface_.embedded(vertex);
  if (point.cell < 0) return;
  const auto& nodes = surface_.lattice().cell_nodes[point.cell];
  for (std::size_t n = 0; n < 8; ++n)
    for (int i = 0; i < 3; ++i) gradient[offset_of(3, nodes[n]) + i] += point.weights[n] * force[i];
}

SparseRows SelfContact::rows(const SelfContactState& state) const {
  const auto& pairs = state.pairs;
  std::vector<std::vector<TangentRow>> of_pair(pairs.size());
  for_each_row(pairs.size(), [&](std::size_t p) { of_pair[p] = definite_rows(pairs[p]); });
  SparseRows result;
  for (std::size_t p = 0; p < pairs.size(); ++p) add_row(pairs[p].vertices, of_pair[p].front(), result);
  for (std::size_t p = 0; p < pairs.size(); ++p)
    for (std::size_t k = 1; k < of_pair[p].size(); ++k) add_row(pairs[p].vertices, of_pair[p][k], result);
  for (const SlidingPair& pair : state.sliding)
    for (const TangentRow& row : rows_of(pair)) add_row(pair.vertices, row, result);
  return result;
}

SparseRows SelfContact::negative_rows(std::span<const TouchingPair> pairs) const {
  std::vector<std::vector<TangentRow>> of_pair(pairs.size());
  for_each_row(pairs.size(), [&](std::size_t p) { of_pair[p] = lappet::negative_rows(pairs[p]); });
  SparseRows result;
  for (std::size_t p = 0; p < pairs.size(); ++p)
    for (const TangentRow& row : of_pair[p]) add_row(pairs[p].vertices, row, result);
  return result;
}

void SelfContact::add_row(const std::array<Index, 4>& vertices, const TangentRow& row, SparseRows& to) const {
  const auto first = static_cast<std::ptrdiff_t>(to.nodes.size());
  for (std::size_t k = 0; k < 4 && vertices[k] >= 0; ++k) {
    if (row[k].isZero(0.0)) continue;
    const EmbeddedPoint& point = surface_.embedded(vertices[k]);
    if (point.cell < 0) continue;
    for (std::size_t n = 0; n < 8; ++n) {
      if (point.weights[n] == 0.0) continue;
      const Vec3 factor = point.weights[n] * row[k];
      const Index node = surface_.lattice().cell_nodes[point.cell][n];
      const auto known = std::find(to.nodes.begin() + first, to.nodes.end(), node);
      if (known != to.nodes.end()) {
        to.factors[known - to.nodes.begin()] += factor;
      } else {
        to.nodes.push_back(node);
        to.factors.push_back(factor);
      }
    }
  }
  to.start.push_back(static_cast<std::uint32_t>(to.nodes.size()));
}

std::vector<SelfContact::Place> SelfContact::places(std::span<const TouchingPair> pairs) const {
  std::vector<Place> result;
  for (const TouchingPair& pair : pairs) {
    Place& place = result.emplace_back();
    place.normal = pair.normal;
    double most = 0.0, other_most = 0.0;
    for (std::size_t k = 0; k < 4 && pair.vertices[k] >= 0; ++k) {
      const double weight = pair.weights[k];
      const Index cell = surface_.embedded(pair.vertices[k]).cell;
      if (weight > 0.0) place.at += weight * surface_.rest(pair.vertices[k]);
      if (weight > most) {
        most = weight;
        place.cell = cell;
      }
      if (-weight > other_most) {
        other_most = -weight;
        place.other_cell = cell;
      }
    }
  }
  return result;
}

template <class Real>
void SelfContact::cover(std::span<const Real> u, std::span<const Real> step, double most) {
  surface_.positions(u, places_);
  surface_.displacements(step, ways_);
  for_each_index(ways_.size(), [&](std::size_t v) { ways_[v] *= most; });
  candidates_.cover(places_, ways_);
}

template <class Real>
double SelfContact::largest_step(std::span<const Real> u, std::span<const Real> step, double most) {
  cover(u, step, most);
  const auto& faces = candidates_.vertex_faces();
  const double share = least_share(faces.size(), 1.0, [&](std::size_t k, double so_far) {
    const auto corners = surface_.corners_of(faces[k].vertex, faces[k].face);
    const std::array<Vec3, 4> from = at(places_, corners), way = at(ways_, corners);
    if (stays_out_of_reach<1>(from, way, so_far, faces[k])) return so_far;
    return point_triangle_way(from, way, so_far, faces[k].reach);
  });
  const auto& edges = candidates_.edges();
  return most * least_share(edges.size(), share, [&](std::size_t k, double so_far) {
           const auto ends = surface_.ends_of(edges[k].first, edges[k].second);
           const std::array<Vec3, 4> from = at(places_, ends), way = at(ways_, ends);
           if (stays_out_of_reach<2>(from, way, so_far, edges[k])) return so_far;
           return segments_way(from, way, so_far, edges[k].reach);
         });
}

template std::size_t SelfContact::count_piercings(std::span<const float>);
template std::size_t SelfContact::count_piercings(std::span<const double>);
template std::size_t SelfContact::begin(std::span<const float>);
template std::size_t SelfContact::begin(std::span<const double>);
template std::size_t SelfContact::untangle(std::span<float>, const std::function<bool(Index)>&);
template std::size_t SelfContact::untangle(std::span<double>, const std::function<bool(Index)>&);
template bool SelfContact::is_apart(std::span<const float>);
template bool SelfContact::is_apart(std::span<const double>);
template void SelfContact::evaluate(std::span<const float>, std::span<double>, SelfContactState&);
template void SelfContact::evaluate(std::span<const double>, std::span<double>, SelfContactState&);
template double SelfContact::largest_step(std::span<const float>, std::span<const float>, double);
template double SelfContact::largest_step(std::span<const double>, std::span<const double>, double);

}  // namespace lappet
