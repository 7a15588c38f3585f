// Contact of the tissue with rigid bones, without friction (GRIDiron 4.2).
//
// Proxies x_p on the tissue's surface each stand for an area a_p; d is the signed distance of the bones. The energy is
// sum a_p (k/2 f^2 - m^2 / 2k) with f = max(0, m/k - d(x_p)): a penalty k per area with the pressures m >= 0 as
// multipliers (augmented Lagrangian), so a proxy is pushed by a_p k f along grad d and by nothing where it is clear of
// bone. The pressures start from zero in every frame, so that no state is carried, and move only where a proxy is
// deeper in bone than allowed. The tangent keeps a_p k grad d grad d^T and leaves out the bone's curvature, which may
// be negative.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "force/constraints/bone_distance.h"
#include "force/constraints/contact_penalty.h"
#include "lattice/lattice.h"

namespace lappet {

// What the bones do to the tissue in a state of displacements.
struct ContactState {
  struct Touching {
    std::uint32_t proxy;
    double depth;     // -d
    double squeezed;  // f
    Vec3 normal;      // grad d
  };
  std::vector<Touching> touching;  // the proxies that are pushed, in their order
  double energy = 0.0;
  double largest_penetration = 0.0;  // of the deepest proxy, mm
  double excess = 0.0;        // by how much that exceeds what a penalty may leave (a fraction of the spacing), mm
  Vec3 force = Vec3::Zero();  // what the bones push with, mN

  std::int32_t count() const { return static_cast<std::int32_t>(touching.size()); }
};

class Contact {
 public:
  // Proxies at the surface's vertices and, where a triangle is larger than a cell, inside it. Fixed triangles (1)
  // cannot be pushed and carry none. stiffness: k, kPa/mm.
  Contact(BoneDistance bones, const Lattice& lattice, const Surface& surface, std::span<const std::uint8_t> fixed,
          double stiffness, const Interrupt& interrupt = {});

  // The proxies of some cells of a lattice as those of another lattice; place: per cell, its index there or -1.
  Contact(const Contact& whole, const Lattice& lattice, std::span<const Index> place);
  // Those of the pressures of all proxies here that belong to the proxies of those cells.
  std::vector<double> restrict_pressures(std::span<const double> pressures, std::span<const Index> place) const;

  // Moves the bones, as BoneDistance::place.
  void place_bones(std::span<const Eigen::Matrix4d> motions) { bones_.place(motions); }

  // How deep the tissue lies in bone at rest, and where; mm.
  struct Depth {
    double depth = 0.0;
    Vec3 where = Vec3::Zero();
  };
  Depth deepest_at_rest() const;

  // Adds the gradient of the energy (3 per node), appends what pushes and fills `state`. pressures: m, per proxy, kPa;
  // empty: all zero. Proxies that hang on nodes which are not free are not pushed, but count as deep if they have been
  // carried into bone. The same for any number of threads.
  template <class Real>
  void evaluate(std::span<const Real> u, std::span<const double> pressures, std::span<const std::uint8_t> free,
                std::span<double> gradient, std::vector<ContactPenalty>& penalties, ContactState& state) const;

  // m = k f, where some proxy is too deep.
  void update_pressures(const ContactState& at, std::vector<double>& pressures) const;

  // The largest fraction of a step, `max_part` at most, that takes no proxy through a bone: along the way none gets
  // deeper than `kMaxDepthOnTheWay` spacings (or than it is), and none to where another side of the bone is nearer.
  template <class Real>
  double largest_step(std::span<const Real> u, std::span<const Real> step, double max_part) const;

  std::size_t bytes() const { return proxies_.size() * (sizeof(Proxy) + sizeof(double)); }

 private:
  struct Proxy {
    EmbeddedPoint point;
    double area;  // mm^2
  };

  BoneDistance bones_;
  const Lattice& lattice_;
  double stiffness_;
  std::vector<Proxy> proxies_;
  std::vector<Vec3> rest_;                                          // of the proxies
  mutable std::vector<std::vector<ContactState::Touching>> found_;  // per chunk, to write in
};

}  // namespace lappet
