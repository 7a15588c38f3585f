#include "session/checks.h"

#include <spdlog/fmt/fmt.h>

#include <Eigen/LU>
#include <cmath>
#include <map>
#include <set>

#include "force/constraints/attachments.h"
#include "force/materials/material_models.h"
#include "force/materials/prestretch.h"
#include "lattice/refused.h"
#include "math/features.h"
#include "session/bone_bodies.h"

namespace lappet {

namespace {

// A cell keeps the number of its material in one byte.
constexpr std::size_t kMaxMaterials = 256;
constexpr std::int32_t kMaxBoneBodies = 1024;
// A thread couples all that it holds with itself.
constexpr std::size_t kMaxInnerBites = 254;
constexpr double kMaxPoissonsRatio = 0.4999, kMaxDispersion = 1.0 / 3.0 + 1e-12;
constexpr double kMaxFriction = 10.0;
constexpr double kMaxFiberSlack = 4.0, kMaxFiberAngle = 90.0, kMinPrestretch = 0.5, kMaxPrestretch = 2.0;

template <class... Arguments>
void require(bool condition, fmt::format_string<Arguments...> sentence, Arguments&&... arguments) {
  if (!condition)
    throw RefusedError(ErrorCode::kInvalidInput, fmt::format(sentence, std::forward<Arguments>(arguments)...));
}

bool finite(const Vec3& v) { return v.allFinite(); }

// Only a yardstick (math/features.h) lacks anything.
void require_held(bool held, bool wanted, const char* what) {
  require(held || !wanted, "this daemon was built without {}, which the scene needs; take one that has everything",
          what);
}

void check_anchor(const Anchor& anchor, const Surface& surface, const Box3& box, const char* what) {
  require(finite(anchor.point), "the anchor of a {} is not finite; give three numbers", what);
  require(
      box.exteriorDistance(anchor.point) <= box.diagonal().norm(),
      "the anchor of a {} at ({:g}, {:g}, {:g}) mm is farther from the tissue than the tissue is large; anchors lie "
      "in the tissue or on its surface",
      what, anchor.point[0], anchor.point[1], anchor.point[2]);
  require(anchor.triangle >= 0 && static_cast<std::size_t>(anchor.triangle) < surface.triangles.size(),
          "the anchor of a {} names triangle {} of {}; give one of this epoch's surface", what, anchor.triangle,
          surface.triangles.size());
}

void check_material(const MaterialParameters& m, std::size_t i) {
  require(MaterialModels::index(m.model) >= 0,
          "the model of material {} is '{}', which this daemon does not solve; use one of {}", i, m.model,
          fmt::join(MaterialModels::kNames, ", "));
  require(std::isfinite(m.youngs_modulus) && m.youngs_modulus > 0,
          "Young's modulus of material {} is {} kPa; it must be positive", i, m.youngs_modulus);
  require(m.poissons_ratio >= 0 && m.poissons_ratio <= kMaxPoissonsRatio,
          "Poisson's ratio of material {} is {}; it must be 0 to {}", i, m.poissons_ratio, kMaxPoissonsRatio);
  require(std::isfinite(m.density) && m.density >= 0,
          "the density of material {} is {} kg/m^3; it must not be negative", i, m.density);
  require(std::isfinite(m.mooney_ratio) && m.mooney_ratio >= 0,
          "the Mooney ratio mu01/mu10 of material {} is {}; it must not be negative", i, m.mooney_ratio);
  require(finite(m.fiber_direction) && std::abs(m.fiber_direction.norm() - 1.0) < 1e-6,
          "the fiber direction of material {} is ({:g}, {:g}, {:g}); it must have length 1", i, m.fiber_direction[0],
          m.fiber_direction[1], m.fiber_direction[2]);
  require(std::isfinite(m.fiber_k1) && m.fiber_k1 >= 0,
          "the fiber stiffness k1 of material {} is {} kPa; give 0 for no fibers", i, m.fiber_k1);
  require(std::isfinite(m.fiber_k2) && m.fiber_k2 >= 0,
          "the fiber exponent k2 of material {} is {}; it must not be negative", i, m.fiber_k2);
  require(m.fiber_dispersion >= 0 && m.fiber_dispersion <= kMaxDispersion,
          "the fiber dispersion of material {} is {}; it must be 0 (aligned) to 1/3 (isotropic)", i,
          m.fiber_dispersion);
  require(m.fiber_slack >= 1.0 && m.fiber_slack <= kMaxFiberSlack,
          "the fiber slack of material {} is {}; it must be a stretch of 1 to {}", i, m.fiber_slack, kMaxFiberSlack);
  require(m.fiber_angle >= 0.0 && m.fiber_angle <= kMaxFiberAngle,
          "the fiber angle of material {} is {} degrees; it must be 0 to {}", i, m.fiber_angle, kMaxFiberAngle);
  require(std::isfinite(m.muscle_stress) && m.muscle_stress >= 0,
          "the muscle stress of material {} is {} kPa; give 0 for no muscle", i, m.muscle_stress);
  for (const double stretch : m.prestretch)
    require(stretch >= kMinPrestretch && stretch <= kMaxPrestretch,
            "a prestretch of material {} is {}; it must be {} to {}", i, stretch, kMinPrestretch, kMaxPrestretch);
  require_held(kHasFibers, m.has_fibers(), "fibers");
  require_held(kHasMuscle, m.has_muscle(), "muscle");
  require_held(kHasPrestretch, m.has_prestretch(), "prestretch");
  try {
    free_prestretch(m);
  } catch (const RefusedError& error) {
    throw RefusedError(error.code(), fmt::format("material {}: {}", i, error.what()));
  }
}

void check_regions(const EpochInput& epoch, const SessionSettings& settings) {
  const auto& skin = epoch.skin;
  for (std::size_t i = 0; i < skin.points.size(); ++i)
    require(finite(skin.points[i]), "point {} of the skin of epoch {} is not finite", i, epoch.index);
  for (std::size_t t = 0; t < skin.triangles.size(); ++t)
    for (const std::int32_t p : skin.triangles[t])
      require(p >= 0 && static_cast<std::size_t>(p) < skin.points.size(),
              "triangle {} of the skin of epoch {} names point {} of {}", t, epoch.index, p, skin.points.size());
  require(epoch.regions.empty() || !skin.triangles.empty(),
          "epoch {} has {} regions of materials but no skin to measure their depth from; send the skin", epoch.index,
          epoch.regions.size());
  const auto per_point = [&](std::size_t size, const char* what) {
    require(size == 0 || size == skin.points.size(), "epoch {} has {} {} for {} points of its skin", epoch.index, size,
            what, skin.points.size());
  };
  per_point(epoch.skin_fields.directions.size(), "directions");
  per_point(epoch.skin_fields.stretch.size(), "stretches");
  for (const Vec3& direction : epoch.skin_fields.directions)
    require(finite(direction), "a direction of the skin of epoch {} is not finite", epoch.index);
  for (const auto& pair : epoch.skin_fields.stretch)
    for (const double stretch : pair)
      require(stretch >= kMinPrestretch && stretch <= kMaxPrestretch,
              "a stretch of the skin of epoch {} is {}; it must be {} to {}", epoch.index, stretch, kMinPrestretch,
              kMaxPrestretch);
  for (std::size_t r = 0; r < epoch.regions.size(); ++r) {
    const auto& region = epoch.regions[r];
    require(region.material >= 0 && static_cast<std::size_t>(region.material) < settings.materials.size(),
            "region {} of epoch {} is of material {} of {}", r, epoch.index, region.material,
            settings.materials.size());
    require(
        std::isfinite(region.from_depth) && region.from_depth >= 0 && region.to_depth > region.from_depth,
        "region {} of epoch {} lies {:g} to {:g} mm below the skin; it must begin at 0 or deeper and end below that", r,
        epoch.index, region.from_depth, region.to_depth);
    require(region.faces.size() == skin.triangles.size(), "region {} of epoch {} labels {} triangles; its skin has {}",
            r, epoch.index, region.faces.size(), skin.triangles.size());
  }
}

void check_strands(const EpochInput& epoch, const SessionSettings& settings) {
  for (std::size_t k = 0; k < epoch.strands.size(); ++k) {
    const Strand& strand = epoch.strands[k];
    require(strand.material >= 0 && strand.material < std::ssize(settings.materials),
            "strand {} of epoch {} is of material {} of {}", k, epoch.index, strand.material,
            settings.materials.size());
    require(strand.points.size() >= 2 && strand.radii.size() == strand.points.size(),
            "strand {} of epoch {} has {} points and {} radii; give two points or more, and a radius for each", k,
            epoch.index, strand.points.size(), strand.radii.size());
    double length = 0.0;
    for (std::size_t p = 0; p < strand.points.size(); ++p) {
      require(finite(strand.points[p]) && strand.points[p].cwiseAbs().maxCoeff() <= kMaxCoordinate,
              "point {} of strand {} of epoch {} is not finite", p, k, epoch.index);
      require(strand.radii[p] >= 0.0 && strand.radii[p] <= kMaxCoordinate,
              "strand {} of epoch {} has the radius {} mm; it must not be negative", k, epoch.index, strand.radii[p]);
      if (p > 0) length += (strand.points[p] - strand.points[p - 1]).norm();
    }
    require(length > 0.0, "strand {} of epoch {} has no length", k, epoch.index);
  }
}

void check_loads_and_rollers(const EpochInput& epoch) {
  const std::size_t count = epoch.surface.triangles.size();
  require(epoch.roller.empty() || epoch.roller.size() == count,
          "epoch {} says of {} triangles on which roller they are", epoch.index, epoch.roller.size());
  for (const std::int32_t r : epoch.roller)
    require(r >= -1 && r < std::ssize(epoch.roller_normals), "a triangle of epoch {} is on roller {} of {}",
            epoch.index, r, epoch.roller_normals.size());
  for (const Vec3& normal : epoch.roller_normals)
    require(finite(normal), "the direction of a roller of epoch {} is not finite", epoch.index);
  require(epoch.loaded_faces.size() == count * epoch.loaded_index.size(),
          "epoch {} has {} labels for {} sets of loaded faces", epoch.index, epoch.loaded_faces.size(),
          epoch.loaded_index.size());
  require(epoch.section_points.size() == epoch.section_normals.size(),
          "epoch {} has {} points of sections but {} normals", epoch.index, epoch.section_points.size(),
          epoch.section_normals.size());
  for (std::size_t k = 0; k < epoch.section_points.size(); ++k)
    require(finite(epoch.section_points[k]) && finite(epoch.section_normals[k]) &&
                epoch.section_normals[k].squaredNorm() > 0.0,
            "section {} of epoch {} is no plane; give a point and a normal that is not zero", k, epoch.index);
}

void check_activation(const std::vector<double>& activation, std::size_t materials, const char* what) {
  require(activation.size() == materials, "{} has {} activations; there are {} materials", what, activation.size(),
          materials);
  for (std::size_t m = 0; m < activation.size(); ++m)
    require(activation[m] >= 0 && activation[m] <= 1, "{} activates material {} by {}; it must be 0 to 1", what, m,
            activation[m]);
}

// Every edge is passed as often one way as the other, by triangles that name points there are.
void check_bones(const Surface& bones) {
  require(bones.points.empty() == bones.triangles.empty(),
          "the bones have {} points and {} triangles; give both or none", bones.points.size(), bones.triangles.size());
  for (std::size_t i = 0; i < bones.points.size(); ++i)
    require(finite(bones.points[i]), "point {} of the bones is not finite", i);
  std::map<std::pair<std::int32_t, std::int32_t>, int> passed;
  for (std::size_t t = 0; t < bones.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = bones.triangles[t][k], b = bones.triangles[t][(k + 1) % 3];
      require(a >= 0 && static_cast<std::size_t>(a) < bones.points.size(),
              "triangle {} of the bones names point {} of {}", t, a, bones.points.size());
      if (a != b) passed[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  for (const auto& [edge, balance] : passed)
    require(
        balance == 0,
        "the bones are not closed: the edge from point {} to point {} has faces on one side only; close the mesh and "
        "orient its faces alike",
        edge.first, edge.second);
}

// Each body is closed by itself.
void check_bone_bodies(const SessionSettings& settings) {
  if (settings.bone_bodies.empty()) return;
  const auto& triangles = settings.bones.triangles;
  require(settings.bone_bodies.size() == triangles.size(), "{} triangles of bones are of a body; there are {}",
          settings.bone_bodies.size(), triangles.size());
  for (const std::int32_t body : settings.bone_bodies)
    require(body >= 0 && body < kMaxBoneBodies, "a triangle of the bones is of body {}; give 0 to {}", body,
            kMaxBoneBodies - 1);
  for (const Surface& body : bone_bodies(settings)) {
    require(!body.triangles.empty(), "of the bodies of bones 0 to {} one has no triangles",
            settings.moving_bones() - 1);
    check_bones(body);
  }
}

void check_rigid(const Eigen::Matrix4d& motion, const char* what, std::size_t index, double time) {
  require(motion.allFinite() && motion.cwiseAbs().maxCoeff() <= kMaxCoordinate,
          "the motion of {} {} at frame {:g} is not finite", what, index, time);
  const Eigen::Matrix3d rotation = motion.topLeftCorner<3, 3>();
  require((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm() < 1e-4 && rotation.determinant() > 0 &&
              motion.row(3) == Eigen::RowVector4d(0, 0, 0, 1),
          "the motion of {} {} at frame {:g} is not rigid; give a rotation and a translation only", what, index, time);
}

void check_bone_motions(const std::vector<Eigen::Matrix4d>& motions, std::int32_t bodies, double time) {
  require(motions.empty() || std::ssize(motions) == bodies, "{} bones move at frame {:g}; there are {} that can",
          motions.size(), time, bodies);
  for (std::size_t k = 0; k < motions.size(); ++k) check_rigid(motions[k], "bone", k, time);
}

}  // namespace

void check_settings(const SessionSettings& s) {
  require(s.spacing > 0 && s.spacing <= kMaxCoordinate, "the spacing is {} mm; it must be positive, at most {:g} mm",
          s.spacing, kMaxCoordinate);
  require(s.fine_ratio >= 1 && s.fine_ratio <= 32, "the fine ratio is {}; it must be 1 to 32", s.fine_ratio);
  require(finite(s.origin) && s.origin.cwiseAbs().maxCoeff() <= kMaxCoordinate,
          "the lattice origin is ({:g}, {:g}, {:g}) mm; give three numbers of at most {:g} mm", s.origin[0],
          s.origin[1], s.origin[2], kMaxCoordinate);
  require(s.quadrature == 1 || s.quadrature == 4 || s.quadrature == 8, "the quadrature has {} points; give 1, 4 or 8",
          s.quadrature);
  require(s.precision == "float" || s.precision == "double", "the precision is '{}'; give 'float' or 'double'",
          s.precision);
  require(std::isfinite(s.tolerance) && s.tolerance > 0 && s.tolerance < 1, "the tolerance is {}; it must be in (0, 1)",
          s.tolerance);
  require(s.precision == "double" || s.tolerance >= 1e-5,
          "the tolerance {} is below what float reaches (1e-5); use precision 'double'", s.tolerance);
  require(std::isfinite(s.gap_tolerance) && s.gap_tolerance > 0, "the gap tolerance is {}; it must be positive",
          s.gap_tolerance);
  require(std::isfinite(s.friction) && s.friction >= 0 && s.friction <= kMaxFriction,
          "the coefficient of friction is {}; it must be 0 to {:g}", s.friction, kMaxFriction);
  require(s.friction == 0 || s.self_contact,
          "the coefficient of friction is {} without self-contact; turn self-contact on, or leave friction out",
          s.friction);
  require(s.region == "auto" || s.region == "whole", "the region is '{}'; give 'auto' or 'whole'", s.region);
  require(s.preconditioner == "twoLevel" || s.preconditioner == "chebyshev",
          "the preconditioner is '{}'; give 'twoLevel' or 'chebyshev'", s.preconditioner);
  require(s.max_newton > 0, "at most {} Newton iterations are allowed; give at least 1", s.max_newton);
  require(std::isfinite(s.bed_stiffness) && s.bed_stiffness >= 0,
          "the bed stiffness is {} kPa/mm; it must not be negative", s.bed_stiffness);
  require(s.bed_shear >= 0 && s.bed_shear <= s.bed_stiffness,
          "the bed's shear stiffness is {} kPa/mm; it must be 0 to its normal stiffness, {} kPa/mm", s.bed_shear,
          s.bed_stiffness);
  require(finite(s.gravity), "gravity is not finite; give three numbers in m/s^2");
  require(std::isfinite(s.time_budget) && s.time_budget >= 0, "the time budget is {} s; give 0 for none",
          s.time_budget);
  require(s.threads >= 0 && s.threads <= 1024, "{} threads are asked for; give 0 for all", s.threads);
  require(s.sutures >= 0 && s.sutures <= 1000000, "the procedure has {} sutures; give 0 to 1000000", s.sutures);
  require(s.retractors >= 0 && s.retractors <= 100000, "the procedure has {} retractors; give 0 to 100000",
          s.retractors);
  require(!s.materials.empty() && s.materials.size() <= kMaxMaterials,
          "the session has {} materials; give 1 to {}, the first for the tissue", s.materials.size(), kMaxMaterials);
  for (std::size_t i = 0; i < s.materials.size(); ++i) check_material(s.materials[i], i);
  for (std::size_t i = 1; i < s.materials.size(); ++i)
    require(s.materials[i].model == s.materials[0].model,
            "material {} is of the model '{}' but material 0 of '{}'; give all materials of one tissue the same model",
            i, s.materials[i].model, s.materials[0].model);
  check_bones(s.bones);
  check_bone_bodies(s);
  require_held(kHasContact, !s.bones.triangles.empty(), "contact");
  require_held(kHasErrorEstimate, s.correction, "the error estimate");
  require_held(kHasStrain, s.strain, "strain");
}

void check_epoch(const EpochInput& epoch, const SessionSettings& settings) {
  const auto& surface = epoch.surface;
  require(!surface.points.empty() && !surface.triangles.empty(), "the surface of epoch {} is empty", epoch.index);
  require_held(kHasLandmarks, !epoch.landmarks.empty(), "landmarks");
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    require(finite(surface.points[i]), "point {} of the surface of epoch {} is not finite", i, epoch.index);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (const std::int32_t p : surface.triangles[t])
      require(p >= 0 && static_cast<std::size_t>(p) < surface.points.size(),
              "triangle {} of epoch {} names point {} of {}", t, epoch.index, p, surface.points.size());
  const auto labels = [&](std::size_t size, const char* name) {
    require(size == surface.triangles.size(), "epoch {} labels {} triangles as {}; its surface has {}", epoch.index,
            size, name, surface.triangles.size());
  };
  labels(epoch.fixed.size(), "fixed");
  labels(epoch.bed.size(), "bed");
  labels(epoch.grip.size(), "gripped");
  if (!epoch.walls.empty()) labels(epoch.walls.size(), "walls of wounds");
  if (!epoch.fixed_parts.empty()) {
    labels(epoch.fixed_parts.size(), "parts of the fixed faces");
    for (std::size_t t = 0; t < epoch.fixed.size(); ++t)
      require((epoch.fixed_parts[t] >= 0) == (epoch.fixed[t] != 0),
              "triangle {} of epoch {} is of part {} of the fixed faces; give a part to these and -1 to all others", t,
              epoch.index, epoch.fixed_parts[t]);
  }
  check_loads_and_rollers(epoch);
  for (const std::uint8_t b : epoch.bed)
    require(b <= kRestsOnBed, "a triangle of epoch {} has the bed label {}; give 0, 1 (attached) or 2 (resting)",
            epoch.index, b);
  for (const std::int32_t g : epoch.grip)
    require(g >= -1 && g < settings.retractors, "a triangle of epoch {} is gripped by retractor {} of {}", epoch.index,
            g, settings.retractors);
  require(epoch.landmarks.size() == epoch.landmark_triangles.size(),
          "epoch {} has {} landmarks but {} triangles for them", epoch.index, epoch.landmarks.size(),
          epoch.landmark_triangles.size());
  const Box3 box = epoch.landmarks.empty() ? Box3() : box_around(surface);
  for (std::size_t k = 0; k < epoch.landmarks.size(); ++k)
    check_anchor({epoch.landmarks[k], epoch.landmark_triangles[k]}, surface, box, "landmark");
  check_regions(epoch, settings);
  check_strands(epoch, settings);
}

void check_frame(const FrameInput& frame, const SessionSettings& settings, const Surface& surface, const Box3& box) {
  require(std::isfinite(frame.time), "the time of a frame is not finite");
  std::set<std::int32_t> hooks;
  for (const auto& hook : frame.hooks) {
    require(hooks.insert(hook.index).second, "frame {:g} names hook {} twice", frame.time, hook.index);
    check_anchor(hook.anchor, surface, box, "hook");
    require(finite(hook.target), "the target of a hook at frame {:g} is not finite", frame.time);
    require(std::isfinite(hook.stiffness) && hook.stiffness > 0,
            "the stiffness of a hook at frame {:g} is {} mN/mm; it must be positive", frame.time, hook.stiffness);
  }
  std::vector<std::uint8_t> seen(static_cast<std::size_t>(settings.sutures), 0);
  for (const auto& suture : frame.sutures) {
    require(suture.index >= 0 && suture.index < settings.sutures, "frame {:g} names suture {} of {}", frame.time,
            suture.index, settings.sutures);
    auto& before = seen[static_cast<std::size_t>(suture.index)];
    require(!before, "frame {:g} names suture {} twice", frame.time, suture.index);
    before = 1;
    check_anchor(suture.a, surface, box, "suture");
    check_anchor(suture.b, surface, box, "suture");
    for (const Anchor& anchor : suture.inner) check_anchor(anchor, surface, box, "suture");
    require(suture.inner.empty() || suture.is_thread,
            "suture {} has {} anchors but is to close exactly; give it two, or make it a thread", suture.index,
            suture.inner.size() + 2);
    require(suture.inner.size() <= kMaxInnerBites, "suture {} has {} anchors; give at most {}", suture.index,
            suture.inner.size() + 2, kMaxInnerBites + 2);
    require(suture.closure >= 0 && suture.closure <= 1, "suture {} is closed by {} at frame {:g}; it must be 0 to 1",
            suture.index, suture.closure, frame.time);
    require(std::isfinite(suture.stiffness) && suture.stiffness > 0,
            "the stiffness of suture {} is {} mN/mm; it must be positive", suture.index, suture.stiffness);
    require(std::isfinite(suture.length) && suture.length >= 0 && std::isfinite(suture.tension) && suture.tension >= 0,
            "suture {} is drawn to {} mm with {} mN; neither may be negative", suture.index, suture.length,
            suture.tension);
  }
  for (const auto& retractor : frame.retractors) {
    require(retractor.index >= 0 && retractor.index < settings.retractors, "frame {:g} names retractor {} of {}",
            frame.time, retractor.index, settings.retractors);
    require(retractor.motion.allFinite(), "the motion of retractor {} at frame {:g} is not finite", retractor.index,
            frame.time);
    const Eigen::Matrix3d rotation = retractor.motion.topLeftCorner<3, 3>();
    require((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm() < 1e-4 && rotation.determinant() > 0,
            "the motion of retractor {} at frame {:g} is not rigid; give a rotation and a translation only",
            retractor.index, frame.time);
  }
  check_bone_motions(frame.bone_motions, settings.moving_bones(), frame.time);
  std::set<std::int32_t> loads;
  for (const auto& load : frame.loads) {
    require(loads.insert(load.index).second, "frame {:g} loads the faces {} twice", frame.time, load.index);
    require(finite(load.traction) && std::isfinite(load.pressure), "a load at frame {:g} is not finite", frame.time);
  }
  if (!frame.activation.empty())
    check_activation(frame.activation, settings.materials.size(), fmt::format("frame {:g}", frame.time).c_str());
}

void check_state(const SolverState& state, std::size_t node_values, std::size_t suture_values, std::size_t materials,
                 bool is_double, std::int32_t bones) {
  require(state.bone_motions.empty() || std::ssize(state.bone_motions) == 16 * bones,
          "the state has {} values of motions of bones; give none or {}", state.bone_motions.size(), 16 * bones);
  for (const double value : state.bone_motions)
    require(std::isfinite(value) && std::abs(value) <= kMaxCoordinate,
            "the state holds a motion of a bone that is not finite");
  require(state.is_double == is_double, "the state is in {} but the session solves in {}",
          state.is_double ? "double" : "float", is_double ? "double" : "float");
  require(state.nodes.size() == node_values, "the state has {} nodes but the epoch's lattice has {}",
          state.nodes.size() / 3, node_values / 3);
  require(state.suture_gaps.size() == suture_values && state.suture_multipliers.size() == suture_values,
          "the state has {} sutures but the session has {}", state.suture_gaps.size() / 3, suture_values / 3);
  require(state.stability.empty() || state.stability.size() == 2 || state.stability.size() == 5,
          "the state's stability has {} values; give none, 2 or 5", state.stability.size());
  require(state.grip_multipliers.empty() || state.grip_multipliers.size() == node_values,
          "the state's grip multipliers have {} values; give none or {}", state.grip_multipliers.size(), node_values);
  require(state.motion.empty() || state.motion.size() == node_values,
          "the state's motion has {} values; give none or {}", state.motion.size(), node_values);
  require(state.loads.size() % 5 == 0, "the state's loads have {} values; give 5 for each", state.loads.size());
  for (const double value : state.nodes) require(std::isfinite(value), "the state holds a number that is not finite");
  check_activation(state.activation, materials, "the state");
}

}  // namespace lappet
