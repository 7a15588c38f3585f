// Bars along x for tests of materials: what a Session finds in the middle of one, away from its held ends.
#pragma once
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <functional>

#include "box.h"
#include "session/session.h"

namespace lappet {

using Matrix3 = Eigen::Matrix3d;

struct Bar {
  double length = 40, width = 4, height = 4;  // mm
  double area() const { return width * height; }
};

// Landmarks of a bar's epoch: both ends of `span` mm along x, across in y and in z, around `at` mm from the held end.
struct Gauge {
  double axial, lateral_y, lateral_z;
};
inline constexpr double kGaugeSpan = 4.0;  // mm

inline void add_gauge(EpochInput& epoch, const Bar& bar, double at) {
  const double x = at, y = bar.width / 2, z = bar.height / 2;
  add_landmark(epoch, Vec3(x - kGaugeSpan / 2, y, bar.height));
  add_landmark(epoch, Vec3(x + kGaugeSpan / 2, y, bar.height));
  add_landmark(epoch, Vec3(x, 0, z));
  add_landmark(epoch, Vec3(x, bar.width, z));
  add_landmark(epoch, Vec3(x, y, 0));
  add_landmark(epoch, Vec3(x, y, bar.height));
}

inline Gauge read_gauge(const FrameOutput& out, const Bar& bar, std::size_t gauge = 0) {
  const std::size_t k = 6 * gauge;
  return {(landmark(out, k + 1) - landmark(out, k)).norm() / kGaugeSpan,
          (landmark(out, k + 3) - landmark(out, k + 2)).norm() / bar.width,
          (landmark(out, k + 5) - landmark(out, k + 4)).norm() / bar.height};
}

// One end fixed, the other gripped by retractor 0 where the session has one; a gauge in the middle.
inline EpochInput bar_epoch(const Bar& bar, bool gripped = true) {
  Surface surface = box_surface({0, 0, 0}, {bar.length, bar.width, bar.height});
  EpochInput epoch = make_epoch(
      surface, [](const Vec3& c) { return c[0] < 1e-9; },
      [&](const Vec3& c) { return gripped && c[0] > bar.length - 1e-9 ? 0 : -1; });
  add_gauge(epoch, bar, bar.length / 2);
  return epoch;
}

// The frame at an elongation, mm; it must converge.
inline FrameOutput pull(Session& session, double elongation, const std::vector<double>& activation = {}) {
  FrameInput frame = pulled({Vec3(elongation, 0, 0)});
  frame.activation = activation;
  FrameOutput out = session.solve(frame, {}, kNever);
  EXPECT_TRUE(out.converged) << out.failure.message;
  return out;
}

// The force on the pulled end, mN: the derivative of the energy in the elongation.
inline double pulling_force(Session& session, double elongation, double step,
                            const std::vector<double>& activation = {}) {
  const double before = pull(session, elongation - step, activation).energy;
  const double after = pull(session, elongation + step, activation).energy;
  return (after - before) / (2 * step);
}

// First Piola stress as a function of F, kPa.
using Piola = std::function<Matrix3(const Matrix3&)>;

// F of a bar along x of that axial stretch whose sides carry no stress, for a material that is symmetric about its xy
// plane: F_xy, F_yy and F_zz by Newton's method with difference quotients.
inline Matrix3 free_sides(const Piola& piola, double axial) {
  Matrix3 f = Vec3(axial, 1 / std::sqrt(axial), 1 / std::sqrt(axial)).asDiagonal();
  const auto traction = [&](const Matrix3& at) {
    const Matrix3 p = piola(at);
    return Vec3(p(0, 1), p(1, 1), p(2, 2));
  };
  const auto unknown = [](Matrix3& at, int k) -> double& { return k == 0 ? at(0, 1) : at(k, k); };
  for (int iteration = 0; iteration < 100; ++iteration) {
    const Vec3 now = traction(f);
    Matrix3 jacobian;
    for (int k = 0; k < 3; ++k) {
      Matrix3 more = f, less = f;
      unknown(more, k) += 1e-6;
      unknown(less, k) -= 1e-6;
      jacobian.col(k) = (traction(more) - traction(less)) / 2e-6;
    }
    Vec3 step = jacobian.fullPivLu().solve(now);
    step *= std::min(1.0, 0.1 / step.norm());
    for (int k = 0; k < 3; ++k) unknown(f, k) -= step[k];
    if (step.norm() < 1e-10) return f;
  }
  ADD_FAILURE() << "the state with free sides was not found at the stretch " << axial;
  return f;
}

inline double von_mises(const Matrix3& cauchy) {
  const Matrix3 deviator = cauchy - cauchy.trace() / 3 * Matrix3::Identity();
  return std::sqrt(1.5) * deviator.norm();
}

inline Matrix3 cauchy_of(const Piola& piola, const Matrix3& f) { return piola(f) * f.transpose() / f.determinant(); }

}  // namespace lappet
