// The pieces of a triangle are the triangle, and sampling them costs what its area is worth.
#include "force/constraints/face_pieces.h"

#include <gtest/gtest.h>

#include <vector>

namespace lappet {
namespace {

struct Sampled {
  std::vector<FacePiece> pieces;
  double samples = 0.0, area = 0.0, longest = 0.0;  // longest: edge of a small triangle
  Vec3 moment = Vec3::Zero();
};

Sampled sampled(const std::array<Vec3, 3>& triangle, double edge) {
  Sampled result;
  for_each_piece(triangle, edge, [&](const FacePiece& piece) {
    result.pieces.push_back(piece);
    result.samples += 1.0 * piece.n * piece.n;
    result.area += piece.area();
    result.moment += piece.area() * (piece.at[0] + piece.at[1] + piece.at[2]) / 3.0;
    result.longest = std::max(result.longest, piece.edge(piece.longest_edge()) / piece.n);
    for (std::size_t k = 0; k < 3; ++k)
      if (piece.corner[k] >= 0) {
        EXPECT_EQ(piece.at[k], triangle[std::size_t(piece.corner[k])]);
      }
  });
  return result;
}

TEST(FacePieces, HaveTheAreaAndTheCentroidOfTheirTriangleWhateverItsShape) {
  const double edge = 0.4;
  for (const double length : {0.1, 3.0, 40.0, 900.0})
    for (const double height : {1e-6, 0.02, 1.0, 30.0})
      for (const double foot : {-0.3, 0.0, 0.2, 1.0})
        for (std::size_t turn = 0; turn < 3; ++turn) {
          std::array<Vec3, 3> triangle;
          const std::array<Vec3, 3> drawn{Vec3(1, 2, 3), Vec3(1 + length, 2, 3),
                                          Vec3(1 + foot * length, 2, 3 + height)};
          for (std::size_t k = 0; k < 3; ++k) triangle[(k + turn) % 3] = drawn[k];
          const FacePiece whole{triangle};
          const Sampled found = sampled(triangle, edge);
          EXPECT_NEAR(found.area, whole.area(), 1e-9 * whole.area() + 1e-15 * length * length);
          EXPECT_LT((found.moment - whole.area() * (triangle[0] + triangle[1] + triangle[2]) / 3.0).norm(),
                    1e-9 * whole.area() * (length + 10.0) + 1e-12);
          EXPECT_LE(found.longest, edge * (1.0 + 1e-12));
          const double most = whole.edge(whole.longest_edge());
          EXPECT_LE(found.samples, 8.0 * whole.area() / (edge * edge) + 3.0 * most / edge + 64.0)
              << length << " x " << height << ", foot at " << foot;
        }
}

TEST(FacePieces, ACompactTriangleStaysWhole) {
  for (const double size : {0.1, 5.0, 500.0}) {
    const Sampled found = sampled({Vec3(0, 0, 0), Vec3(size, 0, 0), Vec3(0, 0.5 * size, 0)}, 0.4);
    ASSERT_EQ(found.pieces.size(), 1U);
    EXPECT_EQ(found.pieces[0].corner, (std::array<int, 3>{0, 1, 2}));
  }
}

}  // namespace
}  // namespace lappet
