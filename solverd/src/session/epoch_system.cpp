#include "session/epoch_system.h"

#include <algorithm>

#include "session/bones.h"

namespace lappet {

namespace {

constexpr int kChebyshevDegree = 4;

LatticeSettings lattice_settings(const SessionSettings& settings) {
  LatticeSettings result;
  result.spacing = settings.spacing;
  result.fine_ratio = settings.fine_ratio;
  result.origin = settings.origin;
  result.memory_budget = settings.memory_budget;
  return result;
}

Attachments attachments_of(const EpochInput& epoch, const Lattice& lattice, const Surface& surface,
                           std::shared_ptr<const Ground> ground, const Interrupt& interrupt) {
  Attachments result =
      attach(lattice, surface, epoch.fixed, epoch.bed, epoch.grip, std::move(ground), epoch.fixed_parts, interrupt);
  result.rollers = roller_rows(lattice, surface, epoch.roller, epoch.roller_normals, interrupt);
  return result;
}

LoadedFacesByIndex loaded_faces(const EpochInput& epoch, const Lattice& lattice, const Surface& surface,
                                const Interrupt& interrupt) {
  LoadedFacesByIndex result;
  const std::size_t count = surface.triangles.size();
  for (std::size_t k = 0; k < epoch.loaded_index.size(); ++k)
    result[epoch.loaded_index[k]] = std::make_shared<const LoadedFaces>(
        lattice, surface, std::span(epoch.loaded_faces).subspan(k * count, count), interrupt);
  return result;
}

std::vector<Section> sections_of(const EpochInput& epoch) {
  std::vector<Section> result;
  for (std::size_t k = 0; k < epoch.section_points.size(); ++k)
    result.push_back({epoch.section_points[k], epoch.section_normals[k].normalized()});
  return result;
}

}  // namespace

template <class Real>
EpochSystem<Real>::EpochSystem(const EpochInput& epoch, const SessionSettings& settings,
                               const std::optional<BoneDistance>& bones, std::shared_ptr<const Ground> ground,
                               const Interrupt& interrupt)
    : surface(epoch.surface),
      walls(epoch.walls),
      box(box_around(surface)),
      lattice(build_lattice(surface, lattice_settings(settings), interrupt)),
      loaded(loaded_faces(epoch, lattice, surface, interrupt)),
      sections(sections_of(epoch)),
      system(lattice,
             assign_materials(lattice, settings.materials, epoch.skin, epoch.regions, epoch.skin_fields, interrupt,
                              epoch.strands),
             settings.quadrature, attachments_of(epoch, lattice, surface, std::move(ground), interrupt),
             settings.retractors, BedStiffness{settings.bed_stiffness, settings.bed_shear}, settings.gravity,
             interrupt),
      preconditioner(system, kChebyshevDegree),
      constraints(settings, lattice, surface, walls, loaded, system) {
  if (bones) system.set_contact(contact_with_bones(*bones, lattice, epoch, settings, interrupt));
  if (settings.self_contact)
    system.set_self_contact(std::make_unique<SelfContact>(lattice, surface, settings.materials[0].youngs_modulus,
                                                          settings.friction, interrupt));
  if (settings.preconditioner == "chebyshev") preconditioner.smoother_only();
  for (std::size_t k = 0; k < epoch.landmarks.size(); ++k) {
    interrupt.check();
    landmarks.push_back(embed_on_triangle(lattice, surface, epoch.landmarks[k], epoch.landmark_triangles[k]));
  }
}

template <class Real>
EpochReport EpochSystem<Real>::report(bool with_nodes) const {
  EpochReport report;
  report.fine_voxels = lattice.fine_voxels;
  report.cells = static_cast<std::int32_t>(lattice.cell_nodes.size());
  report.grid_cells = lattice.grid_cells;
  report.mesh_cells = lattice.mesh_cells;
  report.nodes = static_cast<std::int32_t>(lattice.node_rest.size());
  report.fragments = lattice.fragments;
  report.blocks = static_cast<std::int32_t>(system.elastic().layout().blocks);
  report.fixed_nodes = static_cast<std::int32_t>(std::ranges::count(system.attachments().node_group, kFixedGroup));
  report.dropped_voxels = lattice.dropped_voxels;
  report.volume = lattice.volume();
  report.bytes = static_cast<double>(lattice.bytes() + system.bytes() + preconditioner.bytes());
  for (const auto& [index, faces] : loaded) report.bytes += static_cast<double>(faces->bytes());
  if (with_nodes)
    for (const Vec3& rest : lattice.node_rest)
      report.nodes_at_rest.insert(report.nodes_at_rest.end(), rest.begin(), rest.end());
  return report;
}

template struct EpochSystem<float>;
template struct EpochSystem<double>;

}  // namespace lappet
