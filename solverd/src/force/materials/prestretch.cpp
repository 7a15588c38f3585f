#include "force/materials/prestretch.h"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "force/materials/fiber.h"
#include "force/materials/material_models.h"
#include "lattice/refused.h"

namespace lappet {

namespace {
// Between these the third stretch is looked for: 1/4 to 4 keep the volume at prestretches of 2 and of 1/2.
constexpr double kThinnest = 0.05, kThickest = 6.0;
constexpr int kMaxSteps = 300;
constexpr double kDegree = std::numbers::pi / 180.0;
}  // namespace

Eigen::Matrix3d prestretch_matrix(const MaterialParameters& parameters, const Eigen::Vector3d& normal, double third) {
  const auto [along, across] = parameters.prestretch;
  if (!(std::isfinite(along) && std::isfinite(across) && along > 0.0 && across > 0.0))
    throw RefusedError(
        ErrorCode::kInvalidInput,
        fmt::format("the prestretch is ({}, {}) along and across the fibers; both must be positive", along, across));
  const Eigen::Vector3d d = parameters.fiber_direction.normalized(), perpendicular = normal.cross(d);
  if (!(perpendicular.norm() > 1e-6 * normal.norm()))
    throw RefusedError(ErrorCode::kInvalidInput,
                       fmt::format("the normal ({:g}, {:g}, {:g}) of the skin has the direction of its fibers, ({:g}, "
                                   "{:g}, {:g}), so that 'across' is undefined; give a direction in the skin's plane",
                                   normal[0], normal[1], normal[2], d[0], d[1], d[2]));
  const Eigen::Vector3d c = perpendicular.normalized(), e = d.cross(c);
  return along * d * d.transpose() + across * c * c.transpose() + third * e * e.transpose();
}

double free_prestretch(const MaterialParameters& parameters) {
  if (!parameters.has_prestretch()) return 1.0;
  const auto [along, across] = parameters.prestretch;
  const Moduli<double> moduli{parameters.mu(), parameters.lambda(), parameters.mooney_ratio};
  const FiberParameters<double> fibers{parameters.fiber_k1, parameters.fiber_k2, parameters.fiber_dispersion,
                                       parameters.fiber_slack * parameters.fiber_slack - 1.0, 0.0};
  const double aligned = std::pow(std::cos(parameters.fiber_angle * kDegree), 2);
  const auto stress = [&](double third) {
    const double s[3] = {along, across, third};
    double p[3] = {0, 0, 0};
    MaterialModels::with(MaterialModels::index(parameters.model), [&]<class Model>() { Model::p_hat(s, moduli, p); });
    // The families mirror each other: what one of them pulls in the plane aslant the other does too, the other way.
    const double i4 = aligned * along * along + (1.0 - aligned) * across * across;
    const double i1 = along * along + across * across + third * third;
    const auto fiber = fiber_response(i1, i4, along * across * third, fibers);
    return p[2] + fiber.shear * third + fiber.pressure * along * across;
  };
  double low = kThinnest, high = kThickest;
  if (!(stress(low) < 0.0 && stress(high) > 0.0))
    throw RefusedError(
        ErrorCode::kInvalidInput,
        fmt::format(
            "tissue of the model '{}' has no thickness at the prestretch ({:g}, {:g}) for which nothing presses "
            "on it; prestretch it less, or choose another model",
            parameters.model, along, across));
  // Illinois: secants, where the end that stays twice in a row counts half.
  double at_low = stress(low), at_high = stress(high), third = low;
  for (int k = 0, kept = 0; k < kMaxSteps; ++k) {
    const double last = third;
    third = (low * at_high - high * at_low) / (at_high - at_low);
    const double found = stress(third);
    if (found == 0.0 || std::abs(third - last) < 1e-15) break;
    if (found < 0.0) {
      low = third, at_low = found;
      if (kept > 0) at_high *= 0.5;
      kept = 1;
    } else {
      high = third, at_high = found;
      if (kept < 0) at_low *= 0.5;
      kept = -1;
    }
  }
  return third;
}

Eigen::Vector3d direction_of_family(const MaterialParameters& parameters, const Eigen::Vector3d& normal, int family) {
  const Eigen::Vector3d d = parameters.fiber_direction.normalized();
  const bool upright = normal.cross(d).norm() < 1e-3;
  const Eigen::Vector3d axis = upright ? d.unitOrthogonal() : Eigen::Vector3d(normal.normalized());
  return Eigen::AngleAxisd(family * parameters.fiber_angle * kDegree, axis) * d;
}

Eigen::Vector3d direction_in_plane(const MaterialParameters& parameters, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d d = parameters.fiber_direction.normalized(), n = normal.normalized();
  const Eigen::Vector3d flat = d - n.dot(d) * n;
  return flat.norm() > 1e-3 ? flat.normalized() : d;
}

}  // namespace lappet
