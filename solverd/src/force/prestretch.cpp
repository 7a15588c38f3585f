#include "force/prestretch.h"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Geometry>
#include <cmath>

#include "lattice/refused.h"

namespace lappet {

Eigen::Matrix3d prestretch_matrix(const MaterialParameters& parameters, const Eigen::Vector3d& normal) {
  const auto [along, across] = parameters.prestretch;
  if (!(std::isfinite(along) && std::isfinite(across) && along > 0.0 && across > 0.0))
    throw RefusedError(
        ErrorCode::kInvalidInput,
        fmt::format("the prestretch is ({}, {}) along and across the fibres; both must be positive", along, across));
  const Eigen::Vector3d d = parameters.fibre_direction.normalized(), perpendicular = normal.cross(d);
  if (!(perpendicular.norm() > 1e-6 * normal.norm()))
    throw RefusedError(ErrorCode::kInvalidInput,
                       fmt::format("the normal ({:g}, {:g}, {:g}) of the skin has the direction of its fibres, ({:g}, "
                                   "{:g}, {:g}), so that 'across' is undefined; give a direction in the skin's plane",
                                   normal[0], normal[1], normal[2], d[0], d[1], d[2]));
  const Eigen::Vector3d c = perpendicular.normalized(), third = d.cross(c);
  return along * d * d.transpose() + across * c * c.transpose() + third * third.transpose() / (along * across);
}

Eigen::Vector3d direction_in_plane(const MaterialParameters& parameters, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d d = parameters.fibre_direction.normalized(), n = normal.normalized();
  const Eigen::Vector3d flat = d - n.dot(d) * n;
  return flat.norm() > 1e-3 ? flat.normalized() : d;
}

}  // namespace lappet
