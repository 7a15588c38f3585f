// Faces of the tissue that a load acts on, as samples that integrate over them: what of a face lies in one cell of the
// lattice has samples of its own, so that on a lattice plane all integrals of trilinear displacements are exact.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice/lattice.h"

namespace lappet {

// How a place of a face has moved, mm, and how two vectors in it that are 1 long, and whose product is its normal out
// of the tissue, have changed.
struct FaceMotion {
  Vec3 middle = Vec3::Zero(), first = Vec3::Zero(), second = Vec3::Zero();

  FaceMotion operator-(const FaceMotion& other) const {
    return {middle - other.middle, first - other.first, second - other.second};
  }
};

class LoadedFaces {
 public:
  struct Sample {
    Index cell;
    Index face;   // whose directions it has
    double area;  // at rest, mm^2
    Vec3 place;   // in the cell, from 0 to 1
    // Of its cell's nodes.
    std::array<double, 8> weights() const;
    // What a displacement of each node changes a vector along `direction` by, 1/mm.
    std::array<double, 8> slopes(const Vec3& direction, double spacing) const;
  };
  struct Directions {
    Vec3 first, second;
  };

  // chosen: per triangle of the surface, whether it is one of the faces.
  LoadedFaces(const Lattice& lattice, const Surface& surface, std::span<const std::uint8_t> chosen,
              const Interrupt& interrupt = {});
  // Those in some cells of a lattice, as those of another lattice; place: per cell, its index there or -1.
  LoadedFaces(const LoadedFaces& whole, std::span<const Index> place);

  // In the order of their cells.
  const std::vector<Sample>& samples() const { return samples_; }
  // Where those of each cell begin, and the end.
  const std::vector<std::size_t>& cell_begins() const { return cell_begins_; }
  const Directions& directions(const Sample& sample) const { return directions_[sample.face]; }
  double area() const;  // at rest, mm^2
  // Along its normal, mm^2.
  Vec3 area_now(const Sample& sample, const FaceMotion& motion) const;
  std::size_t bytes() const { return samples_.size() * sizeof(Sample) + directions_.size() * sizeof(Directions); }

 private:
  void find_cells();

  std::vector<Sample> samples_;
  std::vector<std::size_t> cell_begins_;
  std::vector<Directions> directions_;
};

// The volume per area at rest that a place of a face sweeps, out of the tissue, on a straight way: how it is there
// before, and how it moves on. Its vectors are those of FaceMotion.
double swept_volume(const LoadedFaces::Directions& before, const FaceMotion& way);
// The symmetric part of the derivative of the area vector of a sample, which pushes on its nodes: a motion d of node b
// changes the force on node a by c_ab x d per pressure, with c_ba = -c_ab. Of the 28 pairs a < b, in order.
using NodePairs = std::array<Vec3, 28>;
void add_symmetric_change(const LoadedFaces::Sample& sample, const LoadedFaces::Directions& rest,
                          const LoadedFaces::Directions& now, double spacing, NodePairs& pairs);

}  // namespace lappet
