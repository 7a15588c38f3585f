#include "force/constraints/attachments.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <vector>

#include "force/constraints/face_samples.h"
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

struct HeldFace {
  Index triangle = -1;
  std::array<std::int32_t, 2> groups{};
  int count = 0;
  Index part = -1;  // of the fixed faces
  bool rests = false;
  double sample_area = 0.0;
  Vec3 normal = Vec3::Zero();

  bool attached() const { return count > 0 && groups[static_cast<std::size_t>(count - 1)] == kBedGroup; }
};

// Ordered: the result is deterministic.
struct Buckets {
  std::map<std::tuple<std::int32_t, std::int32_t, int>, Bucket> held;  // by cell, group, side
  std::map<Index, RestingBucket> resting;                              // by cell
  std::map<Index, BedBucket> attached;                                 // by cell
  std::map<std::pair<Index, int>, std::map<Index, double>> parts;      // areas of fixed parts by cell, side

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
    if (face.part >= 0) parts[{point.cell, side}][face.part] += face.sample_area;
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

void sample(const Surface& surface, Index triangle, double spacing, HeldFace face, Samples& samples, Buckets& buckets) {
  const SampledFace sampled(surface, triangle, spacing);
  if (!sampled.has_area()) return;
  face.triangle = triangle;
  face.normal = sampled.normal();
  sampled.for_each(
      [&](double area) {
        face.sample_area = area;
        samples.begin(face);
      },
      [&](const Vec3& point) { samples.add(point, buckets); });
}

// Prescribes the four nodes on a side of a cell; those that are fixed stay so, and of their part.
void prescribe_side(const Lattice& lattice, Index cell, int side, Index group, Index part, Attachments& result) {
  const int axis = side / 2, value = side % 2;
  for (int c = 0; c < 8; ++c)
    if ((c >> (2 - axis) & 1) == value) {
      const Index node = lattice.cell_nodes[cell][c];
      if (Index& owner = result.node_group[node]; owner != kFixedGroup) {
        owner = group;
        if (!result.part_of_node.empty()) result.part_of_node[node] = part;
      }
    }
}

// The part that most of the fixed face on a side of a cell is of; -1: none.
Index largest_part(const Buckets& buckets, Index cell, int side) {
  const auto areas = buckets.parts.find({cell, side});
  if (areas == buckets.parts.end()) return -1;
  return std::ranges::max_element(areas->second, {}, [](const auto& entry) { return entry.second; })->first;
}

}  // namespace

Attachments attach(const Lattice& lattice, const Surface& surface, std::span<const std::uint8_t> fixed,
                   std::span<const std::uint8_t> bed, std::span<const Index> grip, std::shared_ptr<const Ground> ground,
                   std::span<const Index> parts, const Interrupt& interrupt) {
  if (!ground && std::ranges::find(bed, kRestsOnBed) != bed.end())
    throw RefusedError(ErrorCode::kInternal, "Faces of the tissue rest on the bed, but no ground was given for them.");
  const double h = lattice.settings.spacing;
  Buckets buckets;
  Samples samples(lattice, surface, interrupt);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (HeldFace face = held_face(fixed[t], bed[t], grip[t]); face.count > 0 || face.rests) {
      if (fixed[t] && !parts.empty()) face.part = parts[t];
      sample(surface, to_index(t), h, face, samples, buckets);
    }
  samples.flush(buckets);

  Attachments result;
  result.node_group.assign(lattice.node_rest.size(), kFree);
  if (!parts.empty()) result.part_of_node.assign(lattice.node_rest.size(), -1);
  auto& held = buckets.held;
  for (; !held.empty(); held.erase(held.begin())) {  // what has become a form makes room
    const auto& [key, bucket] = *held.begin();
    const auto [cell, group, side] = key;
    const Index part = group == kFixedGroup ? largest_part(buckets, cell, side) : -1;
    if (group != kBedGroup && side != kNoSide && bucket.area >= 0.5 * h * h) {
      prescribe_side(lattice, cell, side, group, part, result);
      continue;
    }
    FaceConstraint face{cell, group, bucket.area, bucket.gram};
    if (group != kBedGroup) {
      const double scale = h * h / bucket.area;
      for (double& value : face.gram) value *= scale;
      face.area = h * h;
    }
    result.face_constraints.push_back(face);
    if (!parts.empty()) result.part_of_face_constraint.push_back(part);
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
