// What holds the tissue: fixed faces, faces gripped by a retractor, faces attached to the bed, faces that rest on it.
//
// A held face holds its surface points, not whole cells. With W_s the trilinear weights of a point s of the face and
// xbar the rigidly moved rest positions, W_s (x - xbar) = 0 for every s is the quadratic form (x - xbar)^T M (x - xbar)
// = 0, M = sum of area W_s^T W_s per cell. Where a face lies on a lattice plane M only sees the four nodes of that
// plane: they are prescribed exactly. Elsewhere the form is a penalty with multipliers (augmented Lagrangian); there
// only the demand counts, so that a sliver of a face weighs as much as a whole face and its multiplier converges as
// fast. Bed faces are the same form with the bed's stiffness in shear and no multipliers; what the bed is stiffer along
// its normal acts on the mean height of the face in a cell. Undermined faces rest on the ground
// (force/constraints/ground.h): they may lift off and slide, but where they sink deeper into it than they lay at rest
// the bed pushes back with its normal stiffness.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "force/constraints/ground.h"
#include "force/constraints/rollers.h"
#include "lattice/lattice.h"

namespace lappet {

inline constexpr std::int32_t kBedGroup = -2;
inline constexpr std::int32_t kFixedGroup = -1;  // groups from 0 on: retractors
inline constexpr std::int32_t kFree = -3;
inline constexpr std::int32_t kStillGroup = -4;  // stays where it is, wherever that is: the rim of a subdomain

struct FaceConstraint {
  Index cell;
  Index group;
  double area;  // what the form integrates 1 to, mm^2
  // Integral of W^T W over the face inside the cell; held: scaled to the area h^2; mm^2. The upper triangle by rows.
  std::array<double, 36> gram;

  Eigen::Matrix<double, 8, 8> matrix() const {
    Eigen::Matrix<double, 8, 8> m;
    const double* entry = gram.data();
    for (int p = 0; p < 8; ++p)
      for (int q = p; q < 8; ++q) m(p, q) = m(q, p) = *entry++;
    return m;
  }
};

// What rests of a face inside a cell, at its mean point: at rest, and sum_k weights_k u_k from there.
struct RestingFace {
  Index cell;
  double area;    // mm^2
  Vec3 rest;      // mm
  double height;  // above the ground that it may sink to, mm: that at rest where it lay lower than the ground
  std::array<double, 8> weights;
};

// The mean height of the faces attached to the bed inside a cell: n . sum_k weights_k u_k.
struct BedFace {
  Index cell;
  double area;   // mm^2
  Vec3 outward;  // unit
  std::array<double, 8> weights;
};

inline constexpr std::uint8_t kAttachedToBed = 1, kRestsOnBed = 2;  // labels of triangles

struct Attachments {
  std::vector<Index> node_group;                 // per node: kFree, kFixedGroup or a retractor; prescribed nodes
  std::vector<FaceConstraint> face_constraints;  // bed faces, and held faces off the lattice planes
  std::vector<RestingFace> resting;
  std::vector<BedFace> attached;
  std::vector<RollerRow> rollers;
  std::shared_ptr<const Ground> ground;  // what they rest on; null where none does
  // Which part of the fixed faces holds a node or is a face constraint's, -1: none; empty where they are one part.
  std::vector<Index> part_of_node, part_of_face_constraint;
};

// Per triangle: fixed, 0 or 1; bed, 0, kAttachedToBed or kRestsOnBed; grip, retractor index or -1. A face both fixed
// and gripped is fixed. ground: needed where triangles rest. Throws RefusedError without it. parts: per triangle, to
// which part of the fixed faces it belongs; empty: they are one.
Attachments attach(const Lattice& lattice, const Surface& surface, std::span<const std::uint8_t> fixed,
                   std::span<const std::uint8_t> bed, std::span<const Index> grip,
                   std::shared_ptr<const Ground> ground = nullptr, std::span<const Index> parts = {},
                   const Interrupt& interrupt = {});

}  // namespace lappet
