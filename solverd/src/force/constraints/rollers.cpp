#include "force/constraints/rollers.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "force/constraints/face_samples.h"
#include "lattice/embedding.h"

namespace lappet {

namespace {

// Roots of a face's form below this share of the largest say nothing of it.
constexpr double kMinRoot = 1e-3;

struct Bucket {
  double area = 0.0;
  Vec3 outward = Vec3::Zero();  // times the area
  Eigen::Matrix<double, 8, 8> gram = Eigen::Matrix<double, 8, 8>::Zero();
};

}  // namespace

std::vector<RollerRow> roller_rows(const Lattice& lattice, const Surface& surface, std::span<const Index> roller,
                                   std::span<const Vec3> normals, const Interrupt& interrupt) {
  const double h = lattice.settings.spacing;
  Embedder embedder(lattice, surface);
  std::map<std::tuple<Index, Index, int>, Bucket> buckets;  // by cell, roller, side
  for (std::size_t t = 0; t < roller.size(); ++t) {
    if (roller[t] < 0) continue;
    interrupt.check();
    const Index triangle = to_index(t);
    const SampledFace face(surface, triangle, h);
    if (!face.has_area()) continue;
    const Vec3 normal = face.normal();
    double area = 0.0;
    face.for_each([&](double sample_area) { area = sample_area; },
                  [&](const Vec3& at) {
                    const EmbeddedPoint point = embedder.embed(at, {&triangle, 1});
                    Bucket& bucket = buckets[{point.cell, roller[t], lattice_side(point, normal)}];
                    bucket.area += area;
                    bucket.outward += area * normal;
                    const auto w = Eigen::Map<const Eigen::Matrix<double, 8, 1>>(point.weights.data());
                    bucket.gram += area * w * w.transpose();
                  });
  }
  std::vector<RollerRow> rows;
  std::set<std::pair<Index, Index>> done;  // roller, node
  for (const auto& [key, bucket] : buckets) {
    const auto& [cell, index, side] = key;
    const Vec3 given = normals[static_cast<std::size_t>(index)];
    const Vec3 normal = (given.squaredNorm() > 0.0 ? given : bucket.outward).normalized();
    if (side != kNoSide && bucket.area >= 0.5 * h * h) {
      for (int c = 0; c < 8; ++c)
        if ((c >> (2 - side / 2) & 1) == side % 2 && done.insert({index, lattice.cell_nodes[cell][c]}).second) {
          rows.push_back({cell, index, normal, {}});
          rows.back().weights[static_cast<std::size_t>(c)] = 1.0;
        }
      continue;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 8, 8>> roots(bucket.gram / bucket.area);
    for (int k = 0; k < 8; ++k) {
      if (!(roots.eigenvalues()[k] > kMinRoot * roots.eigenvalues()[7])) continue;
      rows.push_back({cell, index, normal, {}});
      Eigen::Map<Eigen::Matrix<double, 8, 1>>(rows.back().weights.data()) =
          std::sqrt(roots.eigenvalues()[k]) * roots.eigenvectors().col(k);
    }
  }
  return rows;
}

}  // namespace lappet
