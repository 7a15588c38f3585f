#include "force/constraints/attachments.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include "force/constraints/face_pieces.h"
#include "lattice/embedding.h"
#include "lattice/refused.h"

namespace lappet {

namespace {

// Samples of one face group in one cell that lie on the same lattice plane (side 0 to 5) or on none (side 6).
struct Bucket {
  double area = 0.0;
  std::array<double, 36> gram{};
};

struct RestingBucket {
  double area = 0.0;
  Vec3 moment = Vec3::Zero();  // of the area
  std::array<double, 8> weights{};
};

struct BedBucket {
  double area = 0.0;
  Vec3 outward = Vec3::Zero();
  std::array<double, 8> weights{};
};

constexpr int kNoSide = 6;
constexpr double kSampleEdge = 0.4;  // of the small triangles that sample a face, spacings

struct HeldFace {
  Index triangle = -1;
  std::array<std::int32_t, 2> groups{};
  int count = 0;
  bool rests = false;
  double sample_area = 0.0;
  Vec3 normal = Vec3::Zero();

  bool attached() const { return count > 0 && groups[static_cast<std::size_t>(count - 1)] == kBedGroup; }
};

int lattice_side(const EmbeddedPoint& point, const Vec3& normal) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(normal[axis]) < 1 - 1e-6) continue;
    double local = 0.0;
    for (int c = 0; c < 8; ++c)
      if (c >> (2 - axis) & 1) local += point.weights[c];
    if (std::abs(local) < 1e-5) return 2 * axis;
    if (std::abs(local - 1.0) < 1e-5) return 2 * axis + 1;
  }
  return kNoSide;
}

// Ordered: the result is deterministic.
struct Buckets {
  std::map<std::tuple<std::int32_t, std::int32_t, int>, Bucket> held;  // by cell, group, side
  std::map<Index, RestingBucket> resting;                              // by cell
  std::map<Index, BedBucket> attached;                                 // by cell

  void add(const HeldFace& face, const Vec3& place, const EmbeddedPoint& point) {
    if (face.rests) {
      auto& bucket = resting[point.cell];
      bucket.area += face.sample_area;
      bucket.moment += face.sample_area * place;
      for (std::size_t p = 0; p < 8; ++p) bucket.weights[p] += face.sample_area * point.weights[p];
    }
    if (face.attached()) {
      auto& bucket = attached[point.cell];
      bucket.area += face.sample_area;
      bucket.outward += face.sample_area * face.normal;
      for (std::size_t p = 0; p < 8; ++p) bucket.weights[p] += face.sample_area * point.weights[p];
    }
    const int side = lattice_side(point, face.normal);
    for (int g = 0; g < face.count; ++g) {
      auto& bucket = held[{point.cell, face.groups[g], side}];
      bucket.area += face.sample_area;
      double* entry = bucket.gram.data();
      for (std::size_t p = 0; p < 8; ++p)
        for (std::size_t q = p; q < 8; ++q) *entry++ += face.sample_area * point.weights[p] * point.weights[q];
    }
  }
};

// Samples are embedded in parallel and added in order, a batch at a time.
class Samples {
 public:
  Samples(const Lattice& lattice, const Surface& surface, const Interrupt& interrupt)
      : interrupt_(interrupt), embedder_([&lattice, &surface] { return Embedder(lattice, surface); }) {}

  // The face that the next samples lie on.
  void begin(const HeldFace& face) { faces_.push_back(face); }
  void add(const Vec3& point, Buckets& buckets) {
    samples_.push_back({point, faces_.size() - 1, {}});
    if (samples_.size() == kBatch) flush(buckets);
  }
  void flush(Buckets& buckets) {
    interrupt_.check();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, samples_.size(), 64), [&](const auto& range) {
      Embedder& embedder = embedder_.local();
      for (std::size_t i = range.begin(); i != range.end(); ++i) {
        Sample& sample = samples_[i];
        sample.embedded = embedder.embed(sample.point, {&faces_[sample.face].triangle, 1});
      }
    });
    for (const Sample& sample : samples_) buckets.add(faces_[sample.face], sample.point, sample.embedded);
    samples_.clear();
    if (faces_.size() > 1) faces_.erase(faces_.begin(), faces_.end() - 1);
  }

 private:
  static constexpr std::size_t kBatch = 2048;
  struct Sample {
    Vec3 point;
    std::size_t face;
    EmbeddedPoint embedded;
  };
  const Interrupt& interrupt_;
  tbb::enumerable_thread_specific<Embedder> embedder_;
  std::vector<HeldFace> faces_;
  std::vector<Sample> samples_;
};

HeldFace held_face(std::uint8_t fixed, std::uint8_t bed, Index grip) {
  HeldFace face;
  if (fixed)
    face.groups[face.count++] = kFixedGroup;
  else if (grip >= 0)
    face.groups[face.count++] = grip;
  if (bed == kAttachedToBed) face.groups[face.count++] = kBedGroup;
  face.rests = bed == kRestsOnBed;
  return face;
}

// Samples a face at the middles of small triangles of equal area.
void sample(const Surface& surface, Index triangle, double spacing, HeldFace face, Samples& samples, Buckets& buckets) {
  const auto& corners = surface.triangles[triangle];
  const Vec3 a = surface.points[corners[0]];
  const Vec3 ab = surface.points[corners[1]] - a;
  const Vec3 ac = surface.points[corners[2]] - a;
  const Vec3 cross = ab.cross(ac);
  const double area = 0.5 * cross.norm();
  if (area < 1e-12 * spacing * spacing) return;
  face.triangle = triangle;
  face.normal = cross.normalized();
  for_each_piece(
      {a, surface.points[corners[1]], surface.points[corners[2]]}, kSampleEdge * spacing, [&](const FacePiece& piece) {
        const int n = piece.n;
        const Vec3 first = piece.at[0], along = piece.at[1] - first, across = piece.at[2] - first;
        face.sample_area = piece.area() / (1.0 * n * n);
        samples.begin(face);
        for (int i = 0; i < n; ++i)
          for (int j = 0; j < 2 * (n - i) - 1; ++j) {  // the upright and inverted triangles of row i
            const bool inverted = j % 2 == 1;
            const double s = (j / 2 + (inverted ? 2.0 / 3 : 1.0 / 3)) / n, r = (i + (inverted ? 2.0 / 3 : 1.0 / 3)) / n;
            samples.add(first + s * along + r * across, buckets);
          }
      });
}

// Prescribes the four nodes on a side of a cell; those that are fixed stay so.
void prescribe_side(const Lattice& lattice, Index cell, int side, Index group, std::vector<Index>& node_group) {
  const int axis = side / 2, value = side % 2;
  for (int c = 0; c < 8; ++c)
    if ((c >> (2 - axis) & 1) == value)
      if (Index& owner = node_group[lattice.cell_nodes[cell][c]]; owner != kFixedGroup) owner = group;
}

}  // namespace

Attachments attach(const Lattice& lattice, const Surface& surface, std::span<const std::uint8_t> fixed,
                   std::span<const std::uint8_t> bed, std::span<const Index> grip, std::shared_ptr<const Ground> ground,
                   const Interrupt& interrupt) {
  if (!ground && std::ranges::find(bed, kRestsOnBed) != bed.end())
    throw RefusedError(ErrorCode::kInternal, "Faces of the tissue rest on the bed, but no ground was given for them.");
  const double h = lattice.settings.spacing;
  Buckets buckets;
  Samples samples(lattice, surface, interrupt);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (const HeldFace face = held_face(fixed[t], bed[t], grip[t]); face.count > 0 || face.rests)
      sample(surface, to_index(t), h, face, samples, buckets);
  samples.flush(buckets);

  Attachments result;
  result.node_group.assign(lattice.node_rest.size(), kFree);
  auto& held = buckets.held;
  for (; !held.empty(); held.erase(held.begin())) {  // what has become a form makes room
    const auto& [key, bucket] = *held.begin();
    const auto [cell, group, side] = key;
    if (group != kBedGroup && side != kNoSide && bucket.area >= 0.5 * h * h) {
      prescribe_side(lattice, cell, side, group, result.node_group);
      continue;
    }
    FaceConstraint face{cell, group, bucket.area, bucket.gram};
    if (group != kBedGroup) {
      const double scale = h * h / bucket.area;
      for (double& value : face.gram) value *= scale;
      face.area = h * h;
    }
    result.face_constraints.push_back(face);
  }
  for (const auto& [cell, bucket] : buckets.resting) {
    const Vec3 rest = bucket.moment / bucket.area;
    RestingFace face{cell, bucket.area, rest, std::min(0.0, ground->height(rest).value), bucket.weights};
    for (double& weight : face.weights) weight /= bucket.area;
    result.resting.push_back(face);
  }
  for (const auto& [cell, bucket] : buckets.attached) {
    BedFace face{cell, bucket.area, bucket.outward.normalized(), bucket.weights};
    for (double& weight : face.weights) weight /= bucket.area;
    result.attached.push_back(face);
  }
  if (!result.resting.empty()) result.ground = std::move(ground);
  return result;
}

}  // namespace lappet
