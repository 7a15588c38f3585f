#include "force/attachments.h"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <tuple>

#include "lattice/embedding.h"

namespace lappet {

namespace {

// Samples of one face group in one cell that lie on the same lattice plane (side 0 to 5) or on none (side 6).
struct Bucket {
  double area = 0.0;
  std::array<double, 36> gram{};
};

struct RestingBucket {
  double area = 0.0;
  Vec3 inward = Vec3::Zero();
  std::array<double, 8> weights{};
};

constexpr int kNoSide = 6;

int lattice_side(const EmbeddedPoint& point, const Vec3& normal) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(normal[axis]) < 1 - 1e-6) continue;
    double local = 0.0;
    for (int c = 0; c < 8; ++c)
      if (c >> (2 - axis) & 1) local += point.weights[static_cast<std::size_t>(c)];
    if (std::abs(local) < 1e-5) return 2 * axis;
    if (std::abs(local - 1.0) < 1e-5) return 2 * axis + 1;
  }
  return kNoSide;
}

}  // namespace

Attachments attach(const Lattice& lattice, const Surface& surface, std::span<const std::uint8_t> fixed,
                   std::span<const std::uint8_t> bed, std::span<const std::int32_t> grip) {
  const double h = lattice.settings.spacing;
  Embedder embedder(lattice, surface);
  std::map<std::tuple<std::int32_t, std::int32_t, int>, Bucket> buckets;  // ordered: the result is deterministic
  std::map<std::int32_t, RestingBucket> resting;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    std::int32_t groups[2];
    int count = 0;
    if (fixed[t])
      groups[count++] = kFixedGroup;
    else if (grip[t] >= 0)
      groups[count++] = grip[t];
    if (bed[t] == kAttachedToBed) groups[count++] = kBedGroup;
    const bool rests = bed[t] == kRestsOnBed;
    if (count == 0 && !rests) continue;
    const auto& corners = surface.triangles[t];
    const Vec3 a = surface.points[static_cast<std::size_t>(corners[0])];
    const Vec3 ab = surface.points[static_cast<std::size_t>(corners[1])] - a;
    const Vec3 ac = surface.points[static_cast<std::size_t>(corners[2])] - a;
    const Vec3 cross = ab.cross(ac);
    const double area = 0.5 * cross.norm();
    if (area < 1e-12 * h * h) continue;
    const Vec3 normal = cross.normalized();
    const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
    const int n = std::max(1, static_cast<int>(std::ceil(longest / (0.4 * h))));
    const double sample_area = area / (n * n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < 2 * (n - i) - 1; ++j) {  // the upright and inverted triangles of row i
        const bool inverted = j % 2 == 1;
        const double s = (j / 2 + (inverted ? 2.0 / 3 : 1.0 / 3)) / n, r = (i + (inverted ? 2.0 / 3 : 1.0 / 3)) / n;
        const auto triangle = static_cast<std::int32_t>(t);
        const EmbeddedPoint point = embedder.embed(a + s * ab + r * ac, {&triangle, 1});
        const int side = lattice_side(point, normal);
        if (rests) {
          auto& bucket = resting[point.cell];
          bucket.area += sample_area;
          bucket.inward -= sample_area * normal;
          for (std::size_t p = 0; p < 8; ++p) bucket.weights[p] += sample_area * point.weights[p];
        }
        for (int g = 0; g < count; ++g) {
          auto& bucket = buckets[{point.cell, groups[g], side}];
          bucket.area += sample_area;
          double* entry = bucket.gram.data();
          for (std::size_t p = 0; p < 8; ++p)
            for (std::size_t q = p; q < 8; ++q) *entry++ += sample_area * point.weights[p] * point.weights[q];
        }
      }
  }

  Attachments result;
  result.node_group.assign(lattice.node_rest.size(), kFree);
  for (; !buckets.empty(); buckets.erase(buckets.begin())) {  // what has become a form makes room
    const auto& [key, bucket] = *buckets.begin();
    const auto [cell, group, side] = key;
    if (group != kBedGroup && side != kNoSide && bucket.area >= 0.5 * h * h) {
      const int axis = side / 2, value = side % 2;
      for (int c = 0; c < 8; ++c)
        if ((c >> (2 - axis) & 1) == value) {
          auto& owner = result.node_group[static_cast<std::size_t>(
              lattice.cell_nodes[static_cast<std::size_t>(cell)][static_cast<std::size_t>(c)])];
          if (owner != kFixedGroup) owner = group;
        }
    } else {
      FaceForm form{cell, group, bucket.area, bucket.gram};
      if (group != kBedGroup) {
        const double scale = h * h / bucket.area;
        for (double& value : form.gram) value *= scale;
        form.area = h * h;
      }
      result.forms.push_back(form);
    }
  }
  for (const auto& [cell, bucket] : resting) {
    RestingFace face{cell, bucket.area, bucket.inward.normalized(), bucket.weights};
    for (double& weight : face.weights) weight /= bucket.area;
    result.resting.push_back(face);
  }
  return result;
}

}  // namespace lappet
