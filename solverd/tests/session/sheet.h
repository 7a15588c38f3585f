// The public sheet benchmark: 100 x 60 x 4 mm, E = 50 kPa, the face x = 0 fixed, the face x = 100 gripped by a
// retractor that pulls it along x and turns it about the long axis.
#pragma once
#include <Eigen/Geometry>
#include <numbers>

#include "box.h"
#include "session/session.h"

namespace lappet {

inline const Vec3 kSheet(100.0, 60.0, 4.0);  // mm

struct SheetScene {
  std::string model = "neoHookean";
  double poissons_ratio = 0.45, spacing = 2.0;
  double pull = 30.0, turn = std::numbers::pi / 6;  // mm, radians
  double tolerance = 1e-6;
  int quadrature = 1, threads = 1;
};

inline SessionSettings sheet_settings(const SheetScene& scene) {
  SessionSettings s;
  s.spacing = scene.spacing;
  s.fine_ratio = 1;  // the sides are multiples of the spacing: a cell is full or it is not there
  s.quadrature = scene.quadrature;
  s.precision = scene.tolerance < 1e-5 ? "double" : "float";
  s.tolerance = scene.tolerance;
  s.retractors = 1;
  s.threads = scene.threads;
  s.materials[0].model = scene.model;
  s.materials[0].youngs_modulus = 50.0;
  s.materials[0].poissons_ratio = scene.poissons_ratio;
  return s;
}

inline EpochInput sheet_epoch() {
  return make_epoch(
      box_surface(Vec3::Zero(), kSheet), [](const Vec3& c) { return c[0] < 1e-9; },
      [](const Vec3& c) { return c[0] > kSheet[0] - 1e-9 ? 0 : -1; });
}

// The retractor's motion, at a fraction of the way.
inline Eigen::Matrix4d sheet_motion(const SheetScene& scene, double fraction = 1.0) {
  const Vec3 axis(0.0, 0.5 * kSheet[1], 0.5 * kSheet[2]);
  Eigen::Isometry3d motion = Eigen::Translation3d(Vec3(fraction * scene.pull, 0, 0) + axis) *
                             Eigen::AngleAxisd(fraction * scene.turn, Vec3::UnitX()) * Eigen::Translation3d(-axis);
  return motion.matrix();
}

inline FrameInput sheet_frame(const SheetScene& scene, double fraction = 1.0) {
  FrameInput frame;
  frame.time = 1;
  frame.retractors = {{0, sheet_motion(scene, fraction)}};
  return frame;
}

// The lattice that the session builds, for the rest positions of the nodes in its states.
inline Lattice sheet_lattice(const SheetScene& scene) {
  LatticeSettings settings;
  settings.spacing = scene.spacing;
  settings.fine_ratio = 1;
  return build_lattice(box_surface(Vec3::Zero(), kSheet), settings);
}

}  // namespace lappet
