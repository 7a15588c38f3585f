// What the elastic kernels read and write: plain pointers into arrays that force/elastic/elastic.h owns, ordered so
// that SIMD lanes are `lanes` blocks of 2x2x2 cells in lockstep.
//
//   group   `lanes` blocks;   node    27 per block, corner (x, y, z) of 3x3x3 at 9 x + 3 y + z
//   column  the three nodes (x, y, .) of a block; nodes of the grid are numbered along it without a gap, so that a grid
//           group stores the first node of each column, and a mesh group, at wounds and rims, stores all nodes
//   place   8 per block, (x<<2 | y<<1 | z);   slot  a place of a lane: cells lie at [group][place][lane]
// Missing cells have no volume and use nodes of their own block. Gradients of shape functions are scaled by 4 h, so
// that those of the cell center are +-1; the tangents carry 1 / (16 h^2) and the volume.
#pragma once
#include <cstddef>
#include <cstdint>

namespace lappet {

// The tangent of a quadrature point: dP = U (T : U^T dF V) V^T, the rotations U and V as quaternions (w x y z).
enum TangentField { kU = 0, kV = 4, kHessian = 8, kSame = 14, kCross = 17, kTangentFields = 20 };
// Where dP_ij = same dF_ij + cross dF_ji for the pairs 01 02 12 and the Hessian is 00 01 02 11 12 22.

// The tangent of fibers and muscle that is not in that of the isotropic material, see force/materials/fiber.h.
enum FiberField { kAlong, kCurvature, kVolumeSlope, kMuscleCurvature, kFiberFields };

// What a cell is made of. A record ends where what the scene needs ends: before kFiberK1, before kPrestretch or at the
// end.
enum MaterialField {
  kMu,
  kLambda,
  kMooney,
  kFiberK1,
  kFiberK2,
  kFiberDispersion,
  kFiberThreshold,
  kMuscle,
  kFiberDirection,                    // 3
  kPrestretch = kFiberDirection + 3,  // symmetric, 00 01 02 11 12 22
  kMaterialFields = kPrestretch + 6
};

// Where the quadrature points of a part of a cell lie: the cell's own, in [-1, 1], times the scale, plus the center;
// and what of the stabilization its hourglass modes have: 1 for xy, xz, yz and 0.5 for xyz where it fills the cell.
enum ShareField { kShareCenter, kShareScale = 3, kShareHourglass = 6, kShareFields = 10 };

inline constexpr int kBlockNodes = 27, kBlockCells = 8, kBlockColumns = 9;

// The nodes of a group: node n of lane k is row[k] + shift.
struct GroupNodes {
  const std::int32_t* nodes;
  int lanes;
  bool grid;

  // Calls body(n, row, shift) for each node. A loop for either kind of group: one for both is slower.
  template <class Body>
  [[gnu::always_inline]] void for_each(const Body& body) const {
    if (grid)
      for (int c = 0; c < kBlockColumns; ++c)
        for (int z = 0; z < 3; ++z) body(3 * c + z, nodes + c * lanes, z);
    else
      for (int n = 0; n < kBlockNodes; ++n) body(n, nodes + n * lanes, 0);
  }
};

template <class Real>
struct ElasticArrays {
  int points = 1;                            // quadrature points per cell
  double spacing = 1.0;                      // h, mm
  const double* gradients = nullptr;         // [point][3][8], 4 h grad N
  const double* positions = nullptr;         // [point][3], in [-1, 1]
  const double* weights = nullptr;           // [point], of the unit volume
  const std::int32_t* nodes = nullptr;       // per group [27][lane], or of a grid group [9][lane]
  const std::int64_t* node_start = nullptr;  // [group] and the end: where its nodes begin
  const Real* volume = nullptr;              // [group][place][lane], mm^3
  const Real* stabilization = nullptr;       // [group][place][lane], laplacian mu volume / (24 h^2), or null
  const Real* material = nullptr;            // [group][place][field][lane], or one record for all: stride 0
  std::int64_t material_stride = 0;          // from place to place
  const Real* share = nullptr;               // [group][place][kShareFields][lane], or null: all cells are whole
  bool active = true;                        // some muscle pulls; else kMuscle is 0 in every record
  Real* tangent = nullptr;                   // [group][place][point][kTangentFields][lane]
  Real* sigma = nullptr;                     // [group][place][point][3][lane]
  Real* fiber_tangent = nullptr;             // [group][place][point][kFiberFields][lane], or null
  // Quadratic terms on cells (attachments), 8x8 symmetric, the same for each component.
  const std::int32_t* quadratic_of = nullptr;  // [group][place]: index of a matrix, -1 for none; or null
  const Real* quadratics = nullptr;            // [index][36][lane], upper half by rows

  // The record of where a place has its quadrature points; only of a scene with shares.
  [[gnu::always_inline]] const Real* share_of(std::int64_t place, int lanes) const {
    return share + place * kShareFields * lanes;
  }
};

}  // namespace lappet
