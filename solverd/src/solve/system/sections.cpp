#include <algorithm>
#include <vector>

#include "lattice/node_field.h"
#include "solve/system/system.h"

namespace lappet {

template <class Real>
std::vector<Vec3> System<Real>::section_forces(std::span<const Section> sections, std::span<const Real> u) {
  std::vector<Vec3> forces;
  if (sections.empty()) return forces;
  std::vector<double> of_cells(3 * free_.size());
  elastic_.evaluate(u, of_cells, node_scale_);
  for (const Section& section : sections) {
    Vec3 force = Vec3::Zero();
    for (std::size_t n = 0; n < free_.size(); ++n) {
      const double beyond = section.normal.dot(lattice().node_rest[n] - section.point) / lattice().settings.spacing;
      force += std::clamp(beyond + 0.5, 0.0, 1.0) * Vec3::Map(&of_cells[3 * n]);
    }
    forces.push_back(force);
  }
  return forces;
}

template std::vector<Vec3> System<float>::section_forces(std::span<const Section>, std::span<const float>);
template std::vector<Vec3> System<double>::section_forces(std::span<const Section>, std::span<const double>);

}  // namespace lappet
