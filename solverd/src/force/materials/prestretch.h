// In-vivo prestretch: tissue is stretched by A before anything is cut, F <- F A and P <- P A^T.
#pragma once
#include <Eigen/Core>

#include "force/materials/material_parameters.h"

namespace lappet {

// A, 3x3, symmetric: parameters.prestretch[0] along the fiber direction d, prestretch[1] along normal x d in the plane
// of the skin, and `third` in the direction across both. `normal`: of the skin, any length. Throws RefusedError where a
// stretch is not positive or the normal has the direction of the fibers.
Eigen::Matrix3d prestretch_matrix(const MaterialParameters& parameters, const Eigen::Vector3d& normal, double third);

// The stretch in the third direction for which the prestretched tissue presses on nothing there, so that intact skin
// stays as it is: near 1/(along across), exactly that as Poisson's ratio nears 1/2. Throws RefusedError where the
// material has none (corotated tissue stretched so far that it would turn inside out).
double free_prestretch(const MaterialParameters& parameters);

// The direction of one of a material's families of fibers (MaterialShare::family), turned from that of both around the
// skin's normal.
Eigen::Vector3d direction_of_family(const MaterialParameters& parameters, const Eigen::Vector3d& normal, int family);

// The fibers' direction turned into the plane of the skin; as it is where it stands upright on the skin.
Eigen::Vector3d direction_in_plane(const MaterialParameters& parameters, const Eigen::Vector3d& normal);

}  // namespace lappet
