// What a session is told and what it answers: plain values, filled from and turned into messages by server/.
// Units: mm, kPa, mN, seconds.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "force/materials/cell_materials.h"
#include "lattice/surface.h"
#include "solve/newton/failure.h"
#include "solve/system/work.h"

namespace lappet {

struct SessionSettings {
  double spacing = 1.0;  // mm
  int fine_ratio = 4;
  Vec3 origin = Vec3::Zero();       // lattice origin, mm
  int quadrature = 1;               // 1, 4 or 8 points per cell
  std::string precision = "float";  // or "double"
  double tolerance = 1e-3;          // residual / force scale
  double gap_tolerance = 1e-3;      // suture and grip gaps, fraction of spacing
  int max_newton = 100;             // per frame
  double bed_stiffness = 10.0;      // kPa/mm, along the normal
  double bed_shear = 10.0;          // kPa/mm, at most bed_stiffness
  Vec3 gravity = Vec3::Zero();      // m/s^2
  double time_budget = 0.0;         // seconds per frame, 0: none
  std::size_t memory_budget = std::size_t{8} << 30;
  int threads = 0;                          // 0: all
  std::string preconditioner = "twoLevel";  // or "chebyshev": the smoother alone
  std::string region = "auto";  // or "whole": frames are solved everywhere (solve/newton/change_neighborhood.h)
  bool correction = false;      // frames carry the displacement that is still to come
  bool strain = true;           // frames carry strain, stress and tension on the surface
  bool stability = true;        // saddles of the energy are looked for and left (solve/newton/lowest_mode.h)
  bool self_contact = false;    // tissue does not pass through tissue (force/self_contact/self_contact.h)
  double friction = 0.0;        // Coulomb's, where it presses on itself (force/self_contact/contact_friction.h)
  // Frames follow what somebody drags: what is set up for one serves the next, and none can be resumed bit for bit.
  bool live = false;
  std::int32_t sutures = 0;     // number of sutures in the whole procedure; frames refer to them by index
  std::int32_t retractors = 0;  // likewise
  // materials[0] is what the tissue is made of where no region says otherwise.
  std::vector<MaterialParameters> materials{MaterialParameters{}};
  Surface bones;  // all of them as one closed surface; empty: none
  // Per triangle of the bones: the body that it is of, from 0 on, each closed; frames move each. Empty: all stay.
  std::vector<std::int32_t> bone_bodies;

  std::int32_t moving_bones() const {
    return bone_bodies.empty() ? 0 : *std::max_element(bone_bodies.begin(), bone_bodies.end()) + 1;
  }
};

// Every setting of the message `open` with its name on the wire, and what it may be: a setting is defined in
// SessionSettings and here. An optional one may be left out.
template <class Visitor>
void visit_settings(SessionSettings& settings, Visitor&& visit) {
  visit("spacing", settings.spacing);
  visit("fine_ratio", settings.fine_ratio, 1);
  visit("origin", settings.origin);
  visit("quadrature", settings.quadrature);
  visit("precision", settings.precision);
  visit("tolerance", settings.tolerance);
  visit("gap_tolerance", settings.gap_tolerance);
  visit("max_newton", settings.max_newton);
  visit("bed_stiffness", settings.bed_stiffness);
  visit("bed_shear", settings.bed_shear);
  visit("gravity", settings.gravity);
  visit("time_budget", settings.time_budget);
  visit("memory_budget", settings.memory_budget);
  visit("threads", settings.threads, 0, 4096);
  visit("sutures", settings.sutures);
  visit("retractors", settings.retractors);
  visit.optional("region", settings.region);
  visit.optional("preconditioner", settings.preconditioner);
  visit.optional("correction", settings.correction);
  visit.optional("strain", settings.strain);
  visit.optional("stability", settings.stability);
  visit.optional("self_contact", settings.self_contact);
  visit.optional("friction", settings.friction);
  visit.optional("live", settings.live);
}

struct EpochInput {
  std::int32_t index = 0;
  Surface surface;
  std::vector<std::uint8_t> fixed;  // per triangle
  std::vector<std::uint8_t> bed;    // per triangle: 0, 1 attached to the bed, 2 resting on it (undermined)
  std::vector<std::int32_t> grip;   // per triangle: index of the retractor that grips it, or -1
  std::vector<std::uint8_t> walls;  // per triangle: whether it is a wall of a wound; empty: none is
  // Per triangle: the part of the fixed faces that it belongs to, or -1 where it is not fixed; empty: they are one.
  std::vector<std::int32_t> fixed_parts;
  // Per triangle: the roller that it slides on, or -1; empty: none. Of each roller the direction that it holds, or
  // zero: that of each face's normal at rest.
  std::vector<std::int32_t> roller;
  std::vector<Vec3> roller_normals;
  // Faces that loads act on: the number of each such set, and whether each triangle is one of it, set after set.
  std::vector<std::int32_t> loaded_index;
  std::vector<std::uint8_t> loaded_faces;
  // Planes at rest, across which the force is wanted.
  std::vector<Vec3> section_points, section_normals;
  std::vector<Vec3> landmarks;  // rest points
  std::vector<std::int32_t> landmark_triangles;
  // The outer skin before any cut: regions measure their depth from it, fibers and prestretch run along it. May be
  // empty without regions; directions are then taken as they are, in tissue whose skin is upright to z.
  Surface skin;
  SkinFields skin_fields;
  std::vector<MaterialRegion> regions;
  std::vector<Strand> strands;  // of muscles
  // What faces with the bed label 2 rest on: the underside before any cut. Empty: that of `surface`, its faces with a
  // bed label.
  Surface ground;
  bool nodes = false;  // the report gives the lattice's nodes
};

struct EpochReport {
  std::int64_t fine_voxels = 0;
  std::int32_t cells = 0, grid_cells = 0, mesh_cells = 0, nodes = 0, fragments = 0, blocks = 0;
  std::int32_t fixed_nodes = 0;
  std::int64_t dropped_voxels = 0;    // specks at sharp tips that nothing holds; not among fine_voxels
  double volume = 0.0;                // mm^3 of tissue in the cells
  double bytes = 0.0;                 // what the session holds now
  double seconds = 0.0;               // to build it
  std::vector<double> nodes_at_rest;  // 3 per node, mm; empty: not wanted
};

struct Anchor {
  Vec3 point;             // rest
  std::int32_t triangle;  // of the epoch's surface
  bool operator==(const Anchor&) const = default;
};

struct HookState {
  Anchor anchor;
  Vec3 target;
  double stiffness;        // mN/mm
  std::int32_t index = 0;  // tells it from the others of the frame
  bool operator==(const HookState&) const = default;
};

struct SutureState {
  std::int32_t index;  // in the procedure
  Anchor a, b;         // its ends
  double closure;      // 0: as it was when the suture was placed; 1: drawn together
  double stiffness;    // of a thread, mN/mm
  // A thread pulls and never pushes; without, the ends are demanded to meet.
  bool is_thread = false;
  double length = 0.0;          // to which a thread is drawn, mm
  double tension = 0.0;         // with which it is drawn at most, mN; 0: as much as it takes
  std::vector<Anchor> inner{};  // the anchors of a thread between its ends, in order; it slides through them
  bool operator==(const SutureState&) const = default;
};

struct RetractorState {
  std::int32_t index;
  Eigen::Matrix4d motion;  // relative to its start; column-vector convention
  bool operator==(const RetractorState&) const = default;
};

// On the faces of that number: a traction by the area at rest and a pressure by the area as it is, kPa.
struct LoadState {
  std::int32_t index;
  Vec3 traction;
  double pressure;
  bool operator==(const LoadState&) const = default;
};

struct FrameInput {
  double time = 0.0;
  std::vector<HookState> hooks;
  std::vector<SutureState> sutures;
  std::vector<RetractorState> retractors;       // the active ones
  std::vector<LoadState> loads{};               // likewise
  std::vector<double> activation;               // of the muscles, per material, in [0, 1]; empty: all 0
  std::vector<Eigen::Matrix4d> bone_motions{};  // of each body of bones, from rest; empty: all are there
  bool operator==(const FrameInput&) const = default;
};

// Everything a later frame depends on: give it back with set_state and the solve goes on bit for bit.
struct SolverState {
  bool is_double = false;
  std::vector<double> nodes;  // 3 per node (float values when !is_double)
  // 3 per suture: separation when placed, NaN before; of a thread with anchors between its ends its length then, 0, 0.
  std::vector<double> suture_gaps;
  std::vector<double> suture_multipliers;  // 3 per suture, mN
  std::vector<double> grip_multipliers;    // opaque
  std::vector<double> roller_multipliers;  // opaque
  std::vector<double> loads;               // 5 per load of the last frame: index, traction, pressure
  std::vector<double> activation;          // per material, as the last frame had it
  std::vector<double> bone_motions;        // 16 per body of bones, by rows, likewise; empty: all are at rest
  std::vector<double> stability;           // opaque
  std::vector<float> motion;               // how the nodes moved last, 3 per node, mm; empty: not yet, or nobody knows
};

// What a frame says of the tissue: its surface, landmarks and constraints.
struct FrameFields {
  std::vector<float> points;                 // 3 per surface vertex, mm
  std::vector<float> strain;                 // largest principal stretch - 1, per surface vertex
  std::vector<float> stress;                 // von Mises Cauchy, kPa
  std::vector<float> tension;                // largest principal Cauchy stress, kPa
  std::vector<double> landmarks;             // 3 per landmark, mm
  std::vector<double> suture_gaps;           // per active suture: distance from its demanded separation, mm
  std::vector<double> suture_forces;         // per active suture, mN
  std::vector<double> suture_force_vectors;  // 3 per active suture, mN, on the tissue at its first end
  std::vector<std::int32_t> suture_indices, hook_indices;  // which suture or hook each of these is of
  std::vector<double> hook_forces;                         // 3 per hook, mN, on the tissue
  std::vector<double> hook_points;                         // 3 per hook: where the anchor is now, mm
  std::vector<double> suture_points;                       // 6 per active suture: both ends, mm
  std::vector<double> inner_bite_points;    // 3 per anchor between the ends of a suture, in their order, mm
  std::vector<double> suture_shared;        // per two anchors of a suture that follow each other: their shared_hold
  std::vector<std::int32_t> holders;        // 2 per reaction: Holder::Kind, index (solve/system/reaction.h)
  std::vector<double> reactions;            // 3 per reaction, mN, on the tissue
  std::vector<double> section_forces;       // 3 per section, mN: what lies beyond it pulls with
  std::vector<float> correction;            // 3 per surface vertex, mm: what is still to come; empty: not wanted
  std::vector<double> landmark_correction;  // 3 per landmark, mm
  // The share of its stiffness that compression leaves the softest displacement (solve/newton/lowest_mode.h); NaN where
  // it was not looked for. The rest point of the surface that moves most in it, mm; empty: nothing is compressed.
  double lowest_stiffness = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> softest_point;
};

// Why a frame was solved from rest although there was a state before it.
enum class Restart : std::uint8_t {
  kNone,           // it was not
  kInvalidStart,   // too many cells of the state before are inverted or flat
  kNoEquilibrium,  // none was found from the state before
  kInverted,       // the one found from the state before had inverted cells, and more energy
};

// What it took to find a frame, all attempts together.
struct SolveEffort {
  int newton_iterations = 0, pcg_iterations = 0;
  int load_steps = 0;             // of the last attempt
  std::int64_t active_cells = 0;  // that were solved for; all others stayed where they were
  double seconds_update = 0.0, seconds_linear = 0.0, seconds_setup = 0.0;
  double seconds_stability = 0.0;  // in the search for the softest displacement
  int saddles_left = 0;            // unstable equilibria that were found on the way and left
  Restart restart = Restart::kNone;

  // What a search took that was given up before.
  void add(const SolveEffort& before) {
    newton_iterations += before.newton_iterations;
    pcg_iterations += before.pcg_iterations;
    active_cells = std::max(active_cells, before.active_cells);
    seconds_update += before.seconds_update;
    seconds_linear += before.seconds_linear;
    seconds_setup += before.seconds_setup;
    seconds_stability += before.seconds_stability;
  }
};

struct FrameOutput : FrameFields, SolveEffort {
  double time = 0.0;
  bool converged = false;
  Failure failure;                    // none when converged
  double residual = 0.0;              // relative to the force scale
  double force_scale = 0.0;           // mN
  double displacement_to_come = 0.0;  // estimate of its largest, mm; of a converged frame
  double largest_gap = 0.0;           // mm, over sutures and grips
  double minimum_j = 0.0;
  std::int32_t inverted_cells = 0;
  double energy = 0.0;               // mN mm
  double largest_penetration = 0.0;  // of the tissue into bone, mm
  std::int32_t contacts = 0;         // points of its surface that touch bone
  // With self-contact: pairs of vertices and faces, or of edges, that press on each other, and how often edges of the
  // surface go through faces of it, where the frame ends and where it was solved from; how many of the latter were
  // taken apart first (the others do not press).
  std::int32_t self_contacts = 0, piercings = 0, piercings_before = 0, untangled = 0;
  double seconds_total = 0.0;
  Work work;
  double peak_bytes = 0.0;  // of the process
  SolverState state;
};

struct Progress {
  double time = 0.0;
  int newton_iteration = 0;
  double residual = 0.0, gap = 0.0;
};
using ProgressCallback = std::function<void(const Progress&)>;

}  // namespace lappet
