// In-vivo prestretch: tissue is stretched by A before anything is cut, F <- F A and P <- P A^T.
#pragma once
#include <Eigen/Core>

#include "force/material_parameters.h"

namespace lappet {

// A, 3x3, symmetric, of determinant 1: parameters.prestretch[0] along the fibre direction d, prestretch[1] along
// normal x d in the plane of the skin, and what keeps the volume in the third direction. `normal`: of the skin, any
// length. Throws RefusedError where a stretch is not positive or the normal has the direction of the fibres.
Eigen::Matrix3d prestretch_matrix(const MaterialParameters& parameters, const Eigen::Vector3d& normal);

// The fibres' direction turned into the plane of the skin; as it is where it stands upright on the skin.
Eigen::Vector3d direction_in_plane(const MaterialParameters& parameters, const Eigen::Vector3d& normal);

}  // namespace lappet
