#include "lattice/anchor_stencil.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "lattice/voxelize.h"

namespace lappet {

namespace {

// Eigenvalues of A, lengths in stencil radii, over its trace; below, the tissue seen does not span space.
constexpr double kMinSpan = 1e-4;
// How far under the surface an anchor on it looks from, in radii.
constexpr double kSunk = 0.01;
// Gauss-Legendre on [0, 1].
constexpr std::array<std::pair<double, double>, 4> kGauss{{{0.06943184420297371, 0.17392742256872692},
                                                           {0.33000947820757187, 0.32607257743127307},
                                                           {0.66999052179242813, 0.32607257743127307},
                                                           {0.93056815579702629, 0.17392742256872692}}};
constexpr int kAzimuths = 16;
// Under a ridge of a wall the foot of an anchor may miss the triangles on both sides: by how many radii at most.
constexpr double kBeside = 0.2;

// Where the segment from `from` along `way` crosses a triangle, as a fraction of it; infinity where it does not.
template <class Wall>
double crossing(const Vec3& from, const Vec3& way, const Wall& wall) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const double height = (from - wall.corner).dot(wall.normal), fall = way.dot(wall.normal);
  if (fall == 0.0 || height * (height + fall) > 0.0) return kNone;
  const double t = -height / fall;
  const Vec3 off = from + t * way - wall.corner;
  const double aa = wall.first.squaredNorm(), bb = wall.second.squaredNorm(), ab = wall.first.dot(wall.second);
  const double oa = off.dot(wall.first), ob = off.dot(wall.second), area = aa * bb - ab * ab;
  const double u = bb * oa - ab * ob, v = aa * ob - ab * oa;
  const double rounding = -1e-9 * area;  // rays do not slip through between two triangles
  return u >= rounding && v >= rounding && u + v <= area - rounding ? t : kNone;
}

// How far the foot of a point on the plane of a triangle lies outside the triangle.
template <class Wall>
double beside(const Vec3& from, const Wall& wall) {
  const std::array<Vec3, 3> corners{wall.corner, wall.corner + wall.first, wall.corner + wall.second};
  const Vec3 foot = from - (from - wall.corner).dot(wall.normal) * wall.normal;
  double least = std::numeric_limits<double>::infinity();
  bool inside = true;
  for (int k = 0; k < 3; ++k) {
    const Vec3 edge = corners[(k + 1) % 3] - corners[k], off = foot - corners[k];
    inside = inside && edge.cross(off).dot(wall.normal) >= 0.0;
    const double along = std::clamp(off.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (off - along * edge).norm());
  }
  return inside ? 0.0 : least;
}

template <class Walls>
bool is_seen(const Vec3& from, const Vec3& to, const Walls& walls) {
  return std::ranges::none_of(walls, [&](const auto& wall) { return crossing(from, to - from, wall) <= 1.0; });
}

std::array<Vec3, 3> frame_of(const Vec3& normal) {
  const Vec3 side = normal.unitOrthogonal();
  return {side, normal.cross(side), normal};
}

}  // namespace

AnchorStencil point_stencil(const Lattice& lattice, const EmbeddedPoint& anchor) {
  std::map<Index, double> weights;
  for (std::size_t k = 0; k < 8; ++k)
    if (std::abs(anchor.weights[k]) >= 1e-9) weights[lattice.cell_nodes[anchor.cell][k]] += anchor.weights[k];
  AnchorStencil result;
  for (const auto& [node, weight] : weights) {
    result.nodes.push_back(node);
    result.weights.push_back(weight);
  }
  return result;
}

double shared_hold(const AnchorStencil& a, const AnchorStencil& b) {
  double shared = 0.0, most = 0.0;
  for (const double weight : a.weights) most += std::max(weight, 0.0);
  for (std::size_t i = 0, j = 0; i < a.nodes.size() && j < b.nodes.size();) {
    if (a.nodes[i] == b.nodes[j])
      shared += std::max(std::min(a.weights[i++], b.weights[j++]), 0.0);
    else if (a.nodes[i] < b.nodes[j])
      ++i;
    else
      ++j;
  }
  return most > 0.0 ? std::min(shared / most, 1.0) : 0.0;
}

AnchorStencils::AnchorStencils(const Lattice& lattice, const Surface& surface, double radius)
    : lattice_(lattice), surface_(surface), radius_(radius), boxes_(surface.triangles.size()) {
  for (std::size_t t = 0; t < boxes_.size(); ++t)
    for (int axis = 0; axis < 3; ++axis) {
      float low = std::numeric_limits<float>::infinity(), high = -low;
      for (const Index corner : surface.triangles[t]) {
        const auto x = static_cast<float>(surface.points[corner][axis]);
        low = std::min(low, x);
        high = std::max(high, x);
      }
      boxes_[t][axis] = low;
      boxes_[t][3 + axis] = high;
    }
}

std::vector<AnchorStencils::Wall> AnchorStencils::walls_near(const Vec3& point, double reach) const {
  const Eigen::Vector3f low = (point.array() - 1.001 * reach).cast<float>(),
                        high = (point.array() + 1.001 * reach).cast<float>();
  std::vector<Wall> walls;
  for (std::size_t t = 0; t < boxes_.size(); ++t) {
    const Box& box = boxes_[t];
    if (box[0] > high[0] || box[3] < low[0] || box[1] > high[1] || box[4] < low[1] || box[2] > high[2] ||
        box[5] < low[2])
      continue;
    const auto& corners = surface_.triangles[t];
    const Vec3& a = surface_.points[corners[0]];
    Wall wall{a, surface_.points[corners[1]] - a, surface_.points[corners[2]] - a, Vec3::Zero(), to_index(t)};
    wall.normal = wall.first.cross(wall.second);
    if (wall.normal.squaredNorm() == 0.0) continue;
    wall.normal.normalize();
    walls.push_back(wall);
  }
  return walls;
}

// A little inside the tissue where the anchor lies on its surface: away from all faces that meet there.
Vec3 AnchorStencils::viewpoint(const Vec3& anchor, std::span<const Wall> walls) const {
  const double sunk = kSunk * radius_;
  std::vector<Vec3> outwards;
  for (const Wall& wall : walls) {
    const double height = (anchor - wall.corner).dot(wall.normal);
    if (height > 1e-4 * sunk || height < -sunk) continue;  // the far wall of a cut faces the anchor
    if (crossing(Vec3(anchor + sunk * wall.normal), Vec3(-2.0 * sunk * wall.normal), wall) > 1.0) continue;
    if (std::ranges::none_of(outwards, [&](const Vec3& known) { return known.dot(wall.normal) > 0.999; }))
      outwards.push_back(wall.normal);
  }
  Vec3 away = Vec3::Zero();
  for (const Vec3& normal : outwards) away -= normal;
  return away.squaredNorm() > 1e-12 ? Vec3(anchor + sunk * away.normalized()) : anchor;
}

// The cell that holds a point of the tissue: that of the nearest voxel center that the point sees.
Index AnchorStencils::cell_of(const Vec3& point, std::span<const Wall> walls) const {
  const FineVoxels& fine = *lattice_.fine;
  const VoxelBox& box = fine.box();
  const double h = lattice_.settings.spacing, edge = h / box.ratio;
  const Vec3 corner = lattice_.settings.origin + h * Vec3(box.low[0], box.low[1], box.low[2]);
  const Vec3 at = (point - corner) / edge;
  const Voxel own = box.voxel_at(at);
  const auto center = [](const Voxel& voxel) { return Vec3(voxel[0] + 0.5, voxel[1] + 0.5, voxel[2] + 0.5); };
  const auto found = [&](const Voxel& voxel) {
    const Index cell = fine.lattice_cell(voxel);
    return cell >= 0 && is_seen(point, Vec3(corner + edge * center(voxel)), walls) ? cell : -1;
  };
  if (const Index cell = found(own); cell >= 0) return cell;
  std::array<std::pair<double, Voxel>, 27> nearest;
  std::size_t count = 0;
  for (std::int32_t x = -1; x <= 1; ++x)
    for (std::int32_t y = -1; y <= 1; ++y)
      for (std::int32_t z = -1; z <= 1; ++z) {
        const Voxel voxel{own[0] + x, own[1] + y, own[2] + z};
        nearest[count++] = {(center(voxel) - at).squaredNorm(), voxel};
      }
  std::ranges::sort(nearest);
  for (const auto& [distance, voxel] : nearest)
    if (const Index cell = found(voxel); cell >= 0) return cell;
  return -1;
}

// Rays from the eye to the surface or to the radius, with Gauss points on them. They are spread about the normal, half
// of them on either side of its plane, so that a flat face parts them exactly.
std::vector<AnchorStencils::Sample> AnchorStencils::seen_from(const Vec3& eye, const Vec3& normal,
                                                              std::span<const Wall> walls) const {
  const auto [side, other, up] = frame_of(normal);
  std::vector<Sample> samples;
  for (const double sign : {-1.0, 1.0})
    for (const auto& [height, share] : kGauss)
      for (int k = 0; k < kAzimuths; ++k) {
        const double azimuth = 2.0 * std::numbers::pi * (k + 0.5) / kAzimuths, flat = std::sqrt(1.0 - height * height);
        const Vec3 ray = flat * (std::cos(azimuth) * side + std::sin(azimuth) * other) + sign * height * up;
        double length = 1.0;
        for (const Wall& wall : walls) length = std::min(length, crossing(eye, Vec3(radius_ * ray), wall));
        if (length < 2.0 * kSunk) continue;
        for (const auto& [along, part] : kGauss) {
          const double r = along * length;
          const Vec3 point = eye + r * radius_ * ray;
          if (const Index cell = cell_of(point, walls); cell >= 0)
            samples.push_back({point, cell, share * part * length * r * r * (1.0 - r * r)});
        }
      }
  return samples;
}

std::vector<AnchorStencils::Facing> AnchorStencils::faces_above(const Vec3& anchor) const {
  const std::vector<Wall> walls = walls_near(anchor, radius_);
  const Vec3 eye = viewpoint(anchor, walls);
  std::vector<Facing> found;
  for (const Wall& wall : walls) {
    const double depth = std::max((wall.corner - anchor).dot(wall.normal), 0.0);
    if ((wall.corner - eye).dot(wall.normal) < 0.0 || depth > radius_) continue;
    if (beside(eye, wall) > kBeside * radius_) continue;
    const auto known =
        std::ranges::find_if(found, [&](const Facing& other) { return other.normal.dot(wall.normal) > kOneFace; });
    if (known == found.end())
      found.push_back({wall.normal, depth, wall.triangle});
    else if (depth < known->depth)
      *known = {wall.normal, depth, wall.triangle};
  }
  return found;
}

AnchorStencil AnchorStencils::around(const Vec3& anchor, Index triangle, const Vec3& beyond) const {
  const AnchorStencil point = point_stencil(lattice_, embed_on_triangle(lattice_, surface_, anchor, triangle));
  const double voxel = lattice_.settings.spacing / lattice_.fine->box().ratio;
  const std::vector<Wall> walls = walls_near(anchor, radius_ + 3.0 * voxel);
  const auto& corners = surface_.triangles[triangle];
  const Vec3& a = surface_.points[corners[0]];
  Vec3 normal = (surface_.points[corners[1]] - a).cross(surface_.points[corners[2]] - a);
  normal = normal.squaredNorm() > 0.0 ? Vec3(normal.normalized()) : Vec3(Vec3::UnitZ());
  const std::vector<Sample> samples = seen_from(viewpoint(anchor, walls), normal, walls);

  const auto arm = [&](const Vec3& x) -> Eigen::Vector4d {
    const Vec3 off = (x - anchor) / radius_;
    return {1.0, off[0], off[1], off[2]};
  };
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  for (const Sample& sample : samples) moments += sample.weight * arm(sample.point) * arm(sample.point).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> spectrum(moments);
  if (!(spectrum.eigenvalues()[0] > kMinSpan * moments.trace())) return point;
  const Eigen::Vector4d gain = moments.llt().solve(arm(anchor + beyond));

  std::map<Index, double> weights;  // ordered: the result is deterministic
  for (const Sample& sample : samples) {
    const double weight = sample.weight * arm(sample.point).dot(gain);
    const auto trilinear = trilinear_weights(lattice_, sample.cell, sample.point);
    for (std::size_t k = 0; k < 8; ++k) weights[lattice_.cell_nodes[sample.cell][k]] += weight * trilinear[k];
  }
  AnchorStencil result;
  for (const auto& [node, weight] : weights) {
    if (weight == 0.0) continue;
    result.nodes.push_back(node);
    result.weights.push_back(weight);
  }
  return result;
}

}  // namespace lappet
