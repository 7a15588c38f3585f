#include "session/check_targets.h"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Geometry>

namespace lappet {

namespace {

// Diagonals of the tissue that something may be moved in a frame.
constexpr double kReach = 20.0;
// A far target may stand for a constant force; this many E diagonal^2 tear any tissue.
constexpr double kForce = 10.0;

}  // namespace

std::string check_targets_reachable(const FrameInput& frame, double youngs_modulus, const Vec3& lowest,
                                    const Vec3& highest, const std::function<Vec3(const Anchor&)>& place) {
  const double diagonal = (highest - lowest).norm();
  const Vec3 center = 0.5 * (lowest + highest);
  for (const auto& hook : frame.hooks) {
    const double distance = (hook.target - place(hook.anchor)).norm(), force = distance * hook.stiffness;
    if (distance > kReach * diagonal && force > kForce * youngs_modulus * diagonal * diagonal)
      return fmt::format(
          "the target of a hook is {:.3g} mm from its anchor, {:.3g} times the size of the tissue, and pulls with "
          "{:.3g} mN; move the target nearer or lower the stiffness",
          distance, distance / diagonal, force);
  }
  for (const auto& retractor : frame.retractors) {
    const Vec3 moved = (retractor.motion * center.homogeneous()).head<3>();
    const double distance = (moved - center).norm();
    if (distance > kReach * diagonal)
      return fmt::format(
          "the motion of retractor {} carries the tissue {:.3g} mm away, {:.3g} times its size; move it less",
          retractor.index, distance, distance / diagonal);
  }
  return {};
}

}  // namespace lappet
