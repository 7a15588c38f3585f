// The whole energy of a frame: elastic cells, attachments, point constraints, gravity, loads on faces, the push of the
// bed on resting faces and of bones on whatever meets them; its gradient and its tangent product.
//
// Prescribed nodes (fixed, or gripped on a lattice plane) are not unknowns: products and residuals are zero there. A
// fragment that no face holds is kept near its rest position by a very weak bed, so that the tangent is never singular.
#pragma once
#include <memory>

#include "force/constraints/attachments.h"
#include "force/constraints/loaded_faces.h"
#include "force/elastic/elastic.h"
#include "solve/system/evaluation.h"
#include "solve/system/multipliers.h"
#include "solve/system/penalty_rows.h"
#include "solve/system/reaction.h"
#include "solve/system/residual_clusters.h"
#include "solve/system/work.h"

namespace lappet {

// kPa/mm: stress per displacement.
struct BedStiffness {
  double normal = 0.0;  // of attached faces both ways, of resting ones where they sink
  double shear = 0.0;   // of attached faces; at most `normal`
};

// What acts on some faces: a traction that keeps its direction and the area at rest that it is measured by (kPa), and a
// pressure that pushes on the area as it is now, against its normal (kPa).
struct FaceLoad {
  std::int32_t index = 0;  // tells these faces from others
  std::shared_ptr<const LoadedFaces> faces;
  Vec3 traction = Vec3::Zero();
  double pressure = 0.0;
};

// A plane across the tissue at rest.
struct Section {
  Vec3 point;   // mm
  Vec3 normal;  // unit
};

template <class Real>
class System {
 public:
  System(const Lattice& lattice, CellMaterials materials, int quadrature, Attachments attachments,
         std::int32_t retractors, BedStiffness bed, const Vec3& gravity, const Interrupt& interrupt = {});

  // Where a subdomain lies in this whole (solve/subdomain/subdomain.h). cells, nodes: their indices here; moves: per
  // node of the subdomain, only of those that are free.
  struct Place {
    std::span<const std::int32_t> cells, nodes;
    std::span<const std::uint8_t> moves;
  };
  // This system where only the nodes of a subdomain move, all others staying at u: its energy falls by what that of the
  // whole falls. Keeps a reference to `subdomain`, the cells around every node that moves.
  std::unique_ptr<System> restricted(const Lattice& subdomain, const Place& place, std::span<const Real> u) const;
  // The multipliers of this whole, as those of such a system.
  Multipliers restricted(const Multipliers& multipliers, const System& subdomain, const Place& place) const;

  // Rigid motions (4x4, column vectors) of the retractors that grip now; the others let go.
  void set_retractors(std::span<const std::int32_t> active, std::span<const Eigen::Matrix4d> motions);
  // Those that hold exactly have different ids.
  void set_point_constraints(std::vector<PointConstraint> constraints);
  // Those of the frame, which starts at u.
  void set_loads(std::vector<FaceLoad> loads, std::span<const Real> u);
  // How active the muscle of each material is, in [0, 1].
  void set_activation(std::span<const double> activation) { elastic_.set_activation(activation); }
  // Where there are bones; null: none.
  void set_contact(std::unique_ptr<Contact> contact) { contact_ = std::move(contact); }
  // Moves the bones, as BoneDistance::place.
  void place_bones(std::span<const Eigen::Matrix4d> motions) {
    if (contact_) contact_->place_bones(motions);
  }
  const Contact* contact() const;
  // What the surface does to itself; null: it passes through itself.
  void set_self_contact(std::unique_ptr<SelfContact> contact) { self_contact_ = std::move(contact); }
  // Null also while it is suspended, as in the search for a frame in which nothing may meet (session/find_frame.cpp).
  SelfContact* self_contact() const { return self_contact_suspended_ ? nullptr : self_contact_.get(); }
  SelfContact* self_contact_or_suspended() const { return self_contact_.get(); }
  void suspend_self_contact(bool suspend) { self_contact_suspended_ = suspend; }
  const std::vector<PointConstraint>& point_constraints() const { return point_constraints_; }
  const PointConstraint& point_constraint(const ConstraintId& id) const;

  // The energy and its gradient at u, with all else that is found on the way. reused: an evaluation that is no longer
  // needed, whose memory this one takes.
  Evaluation evaluate(std::span<const Real> u, const Multipliers& multipliers, Evaluation reused = {});
  // Computes the tangent where `at` was found. That must be the last evaluation: the decomposition of each cell is kept
  // where the kernels put it, once.
  // contact: likewise for tissue that presses on tissue, where it does.
  void linearize(const Evaluation& at, PsdProjection how) { linearize(at, how, how); }
  void linearize(const Evaluation& at, PsdProjection how, PsdProjection contact);
  void multiply(std::span<const Real> x, std::span<Real> y) const;  // y = K x on free nodes, 0 elsewhere

  bool is_free(std::size_t node) const { return free_[node]; }
  std::size_t nodes() const { return free_.size(); }
  std::size_t free_nodes() const { return free_count_; }
  // Per node: its fragment, named by its lowest node; empty where all nodes hang together.
  std::span<const std::int32_t> fragment_of_node() const { return fragment_of_node_; }
  std::size_t floating_cells() const { return floating_cells_.size(); }
  // What is left to move the prescribed nodes to where they belong; true if any.
  bool prescribed_increment(std::span<const Real> u, std::span<Real> increment) const;

  // The rigid motion a fraction of the way from that of the nodes gripped by a retractor now (least squares) to
  // another: their center moves straight while they turn about it.
  Eigen::Matrix4d motion_towards(const Eigen::Matrix4d& motion, double fraction, std::int32_t retractor,
                                 std::span<const Real> u) const;

  // The fraction of a step, `most` at most, that takes no tissue through a bone or the ground.
  double largest_step(std::span<const Real> u, std::span<const Real> step, double most) const;

  // Whether the surface does not meet itself on the straight way between two states.
  bool is_clear_way(std::span<const Real> from, std::span<const Real> to) const;

  // The largest violation of what must hold exactly, mm: sutures, held faces off the lattice planes (root mean square
  // over the face in a cell), and what is deeper in bone than a penalty may leave. at: the evaluation at u.
  // kOpen: of what is to be closed further, beyond the slack of sutures; kButWalls: likewise, without those whose walls
  // are no farther from each other than walls that touch and do not fit may be.
  enum class Gaps : std::uint8_t { kAll, kOpen, kButWalls };
  double largest_gap(std::span<const Real> u, const Multipliers& multipliers, const Evaluation& at,
                     Gaps which = Gaps::kAll) const;
  // Draws sutures no further whose walls touch at u, until the point constraints are set again.
  void leave_closed(std::span<const Real> u, const Multipliers& multipliers);
  // lambda += stiffness c, for sutures, held faces and tissue that is too deep in bone. at: the evaluation at u.
  void update(Multipliers& multipliers, std::span<const Real> u, const Evaluation& at) const;
  // Raises the penalty of what keeps the largest gap at u, sutures that close exactly or held faces, until the point
  // constraints are set again; what was evaluated before does not hold any more.
  void stiffen_widest(double factor, std::span<const Real> u, const Multipliers& multipliers);
  // Makes room for those of the faces that are held now; zero where they are new.
  void fit(Multipliers& multipliers) const;
  // The force that the tissue beyond each section, where its normal points, has on what lies before it, mN: the
  // weighted sum of the cells' forces on their nodes, whose weight goes from 0 to 1 in a layer one spacing thick, the
  // section in its middle. It is in balance with all that acts on the nodes by their weights. u: where it was evaluated
  // last.
  std::vector<Vec3> section_forces(std::span<const Section> sections, std::span<const Real> u);
  bool has_exact_constraints() const { return has_held_faces_ || has_sutures_; }
  // Whether the pressures at u have an energy, as far as the nodes can move: else no equilibrium is a minimum of it.
  bool pressures_have_energy(std::span<const Real> u) const;
  // What holds the tissue in the equilibrium at u, by what holds it, in order. at: the evaluation at u.
  std::vector<Reaction> reactions(std::span<const Real> u, const Multipliers& multipliers, const Evaluation& at) const;

  // Of the tangent: what the bed and the bones push with.
  std::span<const ContactPenalty> contact_penalties() const { return contact_penalties_; }
  // Likewise: what the surface pushes itself with, and where.
  const SparseRows& self_contact_rows() const { return self_contact_rows_; }
  std::span<const SelfContact::Place> self_contact_places() const { return self_contact_places_; }
  // Of the tangent: what the point constraints add.
  const PointTangent& point_tangent() const { return point_tangent_; }
  const Elastic<Real>& elastic() const { return elastic_; }
  // The same, with the decompositions of an evaluation, which must be the last one.
  const Elastic<Real>& elastic_at(const Evaluation& at) const;
  const Attachments& attachments() const { return attachments_; }
  const BedStiffness& bed() const { return bed_; }
  const Lattice& lattice() const { return elastic_.lattice(); }
  // Changes whenever free nodes, point constraints or active attachments change: preconditioners look at it.
  std::uint64_t constraint_revision() const { return revision_; }
  // With an evaluation and the multipliers of a state.
  std::size_t bytes() const;
  // Since the system was made.
  const Work& work() const { return work_; }

 private:
  Vec3 held_displacement(std::int32_t group, std::size_t node) const;
  std::vector<std::size_t> gripped_nodes(std::int32_t retractor) const;
  bool acts(const FaceConstraint& face) const {
    return face.group < 0 || retractor_active_[static_cast<std::size_t>(face.group)];
  }
  double held_stiffness() const { return held_growth_ * held_stiffness_; }
  double suture_gap(std::span<const Real> u, const Multipliers& multipliers, Gaps which) const;
  double held_gap(std::span<const Real> u) const;
  // Parts of evaluate: each adds to the gradient and returns its energy, or adds it.
  double add_face_constraints(std::span<const Real> u, const Multipliers& multipliers,
                              std::span<double> gradient) const;
  void evaluate_face_constraint(const FaceConstraint& face, std::span<const Real> u, const Multipliers& multipliers,
                                std::array<double, 25>& out) const;
  void add_bed_faces(std::span<const Real> u, Evaluation& result) const;
  void add_resting_faces(std::span<const Real> u, Evaluation& result) const;
  void add_point_constraints(std::span<const Real> u, const Multipliers& multipliers, Evaluation& result) const;
  void multiply_point_constraints(std::span<const Real> x, std::span<Real> y) const;
  void add_drift(std::span<const Real> u, Evaluation& result) const;
  void add_loads(std::span<const Real> u, Evaluation& result) const;
  void add_pressures(std::span<const Real> u, Evaluation& result) const;
  void linearize_pressures();
  std::vector<FaceMotion> pressed_motions(std::span<const Real> u) const;
  void leave_on_rollers(std::span<Real> x) const;
  void multiply_pressure(std::span<const Real> x, std::span<Real> y) const;
  Vec3 load_force(const FaceLoad& load, std::span<const FaceMotion> motions) const;
  double roller_stiffness() const;
  bool acts(const RollerRow& row) const;
  double off(const RollerRow& row, std::span<const Real> u) const;
  void add_rollers(std::span<const Real> u, const Multipliers& multipliers, Evaluation& result) const;
  void mark_rolling_fragments(std::vector<std::uint8_t>& held) const;
  void measure_residual(std::span<const Real> u, Evaluation& result);

  void find_fragments();
  std::size_t fragment(std::size_t node) const {
    return fragment_of_node_.empty() ? 0 : static_cast<std::size_t>(fragment_of_node_[node]);
  }
  void find_floating_cells();
  void rebuild_constraints();
  void set_quadratics();
  Attachments restricted_attachments(const Place& place, std::span<const std::int32_t> place_of_cell) const;
  std::vector<PointConstraint> restricted_point_constraints(const Place& place, std::span<const Real> u) const;

  Elastic<Real> elastic_;
  Attachments attachments_;
  BedStiffness bed_;
  double held_stiffness_;
  double held_growth_ = 1.0;            // of that, where it turned out too soft
  std::vector<double> gravity_force_;   // 3 per node or empty
  std::vector<double> traction_force_;  // likewise
  std::vector<FaceLoad> loads_;
  // Where the work of the pressures is counted from, as in Evaluation: the state of the tangent.
  std::vector<FaceMotion> pressed_from_;
  double pressure_energy_from_ = 0.0;
  std::vector<NodePairs> pressure_tangent_;  // of each cell of the faces under pressure; empty: it leaves them out
  std::vector<std::uint8_t> retractor_active_;
  std::vector<Eigen::Matrix4d> retractor_motion_;
  std::vector<PointConstraint> point_constraints_;
  std::unique_ptr<Contact> contact_;
  std::vector<ContactPenalty> contact_penalties_;  // of the tangent
  std::unique_ptr<SelfContact> self_contact_;
  bool self_contact_suspended_ = false;
  SparseRows self_contact_rows_;  // of the tangent
  std::vector<SelfContact::Place> self_contact_places_;
  PenaltyRows<Real> penalty_rows_;              // all of these
  PointTangent point_tangent_;                  // likewise
  std::vector<std::int32_t> fragment_of_node_;  // its lowest node; empty: all hang together
  std::vector<std::int32_t> floating_cells_;
  double drift_stiffness_ = 0.0;  // mN/mm on a corner of a floating cell
  std::vector<std::uint8_t> free_;
  std::size_t free_count_ = 0;
  std::vector<std::int32_t> prescribed_nodes_;
  bool has_held_faces_ = false, has_sutures_ = false;
  std::vector<double> node_scale_;  // to write in
  ResidualClusters clusters_;
  std::uint64_t revision_ = 0, evaluations_ = 0;
  mutable Work work_;
};

extern template class System<float>;
extern template class System<double>;

}  // namespace lappet
