// The whole energy of a frame: elastic cells, attachments, point constraints, gravity, the push of the bed on resting
// faces and of bones on whatever meets them; its gradient and its tangent product.
//
// Prescribed nodes (fixed, or gripped on a lattice plane) are not unknowns: products and residuals are zero there. A
// fragment that no face holds is kept near its rest position by a very weak bed, so that the tangent is never singular.
#pragma once
#include <memory>

#include "force/constraints/attachments.h"
#include "force/constraints/contact.h"
#include "force/constraints/contact_penalty.h"
#include "force/constraints/point_constraint.h"
#include "force/elastic/elastic.h"
#include "math/features.h"
#include "solve/system/work.h"

namespace lappet {

struct Evaluation {
  double energy = 0.0;
  double residual = 0.0;     // 2-norm of the force on free nodes, mN
  double force_scale = 0.0;  // 2-norm of the elastic nodal force magnitudes plus a floor, mN
  double minimum_j = 1.0;
  std::int32_t inverted = 0;
};

template <class Real>
class System {
 public:
  System(const Lattice& lattice, CellMaterials materials, int quadrature, Attachments attachments,
         std::int32_t retractors, double bed_stiffness, const Vec3& gravity);

  // The whole restricted to some nodes that move: its energy falls by what the whole's falls when they do.
  // subdomain: cells of the whole's lattice, all around every node that moves; cells, nodes: their indices in the
  // whole; moves: per node of the subdomain, only of those that are free; u: of the whole, whose other nodes stay where
  // they are. Keeps a reference to `subdomain`.
  static std::unique_ptr<System> restrict_to(const System& whole, const Lattice& subdomain,
                                             std::span<const std::int32_t> cells, std::span<const std::int32_t> nodes,
                                             std::span<const std::uint8_t> moves, std::span<const Real> u);
  // Takes over the multipliers of a subdomain of this as they are now; nodes: as for restrict_to.
  void take_multipliers(const System& subdomain, std::span<const std::int32_t> nodes);

  // Rigid motions (4x4, column vectors) of the retractors that grip now; the others let go.
  void set_retractors(std::span<const std::int32_t> active, std::span<const Eigen::Matrix4d> motions);
  void set_point_constraints(std::vector<PointConstraint> constraints);
  // How active the muscle of each material is, in [0, 1].
  void set_activation(std::span<const double> activation) { elastic_.set_activation(activation); }
  // Where there are bones; null: none.
  void set_contact(std::unique_ptr<Contact> contact) { contact_ = std::move(contact); }
  Contact* contact() { return kHasContact ? contact_.get() : nullptr; }
  const Contact* contact() const { return kHasContact ? contact_.get() : nullptr; }
  const std::vector<PointConstraint>& point_constraints() const { return point_constraints_; }

  Evaluation evaluate(std::span<const Real> u);
  std::span<const double> gradient() const { return gradient_; }
  void linearize(PsdProjection how) {
    const Timed timed(work_.linearizations);
    elastic_.linearize(how);
  }
  void multiply(std::span<const Real> x, std::span<Real> y) const;  // y = K x on free nodes, 0 elsewhere

  bool is_free(std::size_t node) const { return free_[node]; }
  std::size_t nodes() const { return free_.size(); }
  std::size_t free_nodes() const { return free_count_; }
  std::size_t floating_cells() const { return floating_cells_.size(); }
  // What is left to move the prescribed nodes to where they belong; true if any.
  bool prescribed_increment(std::span<const Real> u, std::span<Real> increment) const;

  // The rigid motion a fraction of the way from that of the nodes gripped by a retractor now (least squares) to
  // another: their center moves straight while they turn about it.
  Eigen::Matrix4d motion_towards(const Eigen::Matrix4d& motion, double fraction, std::int32_t retractor,
                                 std::span<const Real> u) const;

  // The fraction of a step, `most` at most, that takes no tissue through a bone.
  double largest_step(std::span<const Real> u, std::span<const Real> step, double most) const {
    return contact() ? contact()->template largest_step<Real>(u, step, most) : most;
  }

  // The largest violation of what must hold exactly, mm: sutures, held faces off the lattice planes (root mean square
  // over the face in a cell), and what is deeper in bone at the last evaluated u than a penalty may leave.
  double largest_gap(std::span<const Real> u) const;
  bool has_exact_constraints() const { return has_held_faces_ || has_sutures_; }
  // lambda += stiffness c, for sutures, held faces and tissue that is too deep in bone.
  void update_multipliers(std::span<const Real> u);
  std::vector<double>& held_multipliers() { return held_multipliers_; }  // 3 per node, or empty

  // Calls body(penalty) for what the bed and the bones push at the last evaluated u.
  template <class Body>
  void for_each_contact_penalty(const Body& body) const {
    for (const ContactPenalty& penalty : contact_penalties_) body(penalty);
  }
  const Elastic<Real>& elastic() const { return elastic_; }
  const Attachments& attachments() const { return attachments_; }
  double bed_stiffness() const { return bed_stiffness_; }
  const Lattice& lattice() const { return elastic_.lattice(); }
  // Changes whenever free nodes, point constraints or active attachments change: preconditioners look at it.
  std::uint64_t constraint_revision() const { return revision_; }
  std::size_t bytes() const;
  // Since the system was made.
  const Work& work() const { return work_; }

 private:
  Vec3 held_displacement(std::int32_t group, std::size_t node) const;
  std::vector<std::size_t> gripped_nodes(std::int32_t retractor) const;
  bool acts(const FaceConstraint& face) const {
    return face.group < 0 || retractor_active_[static_cast<std::size_t>(face.group)];
  }
  double add_face_constraints(std::span<const Real> u);
  void evaluate_face_constraint(const FaceConstraint& face, std::span<const Real> u, std::array<double, 25>& out) const;
  void find_fragments();
  std::size_t fragment(std::size_t node) const {
    return fragment_of_node_.empty() ? 0 : static_cast<std::size_t>(fragment_of_node_[node]);
  }
  void find_floating_cells();
  void rebuild_constraints();

  Elastic<Real> elastic_;
  Attachments attachments_;
  double bed_stiffness_, held_stiffness_;
  std::vector<double> gravity_force_;  // 3 per node or empty
  std::vector<std::uint8_t> retractor_active_;
  std::vector<Eigen::Matrix4d> retractor_motion_;
  std::vector<PointConstraint> point_constraints_;
  std::unique_ptr<Contact> contact_;
  std::vector<ContactPenalty> contact_penalties_;
  std::vector<std::int32_t> fragment_of_node_;  // its lowest node; empty: all hang together
  std::vector<std::int32_t> floating_cells_;
  double drift_stiffness_ = 0.0;  // mN/mm on a corner of a floating cell
  std::vector<std::uint8_t> free_;
  std::size_t free_count_ = 0;
  std::vector<std::int32_t> prescribed_nodes_;
  bool has_held_faces_ = false, has_sutures_ = false;
  std::vector<double> held_multipliers_;
  std::vector<double> gradient_, node_scale_;
  std::uint64_t revision_ = 0;
  mutable Work work_;
};

extern template class System<float>;
extern template class System<double>;

}  // namespace lappet
