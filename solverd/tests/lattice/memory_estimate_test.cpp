#include "lattice/memory_estimate.h"

#include <gtest/gtest.h>

#include <string>

#include "lattice/refused.h"
#include "lattice/voxelize.h"
#include "test_surfaces.h"

namespace lappet {
namespace {

std::string refusal(const Surface& surface, const LatticeSettings& settings) {
  try {
    (void)build_lattice(surface, settings);
  } catch (const RefusedError& error) {
    EXPECT_EQ(error.code(), ErrorCode::kMemoryBudget);
    return error.what();
  }
  return "not refused";
}

TEST(MemoryEstimate, MeasuresAreaAndVolumeOfABox) {
  const SurfaceMeasure size = measure(test::box(Vec3(1, 2, 3), Vec3(5, 8, 4)));
  EXPECT_NEAR(size.volume, 24.0, 1e-12);
  EXPECT_NEAR(size.projected_area.x(), 2 * 6 * 1, 1e-12);
  EXPECT_NEAR(size.projected_area.y(), 2 * 4 * 1, 1e-12);
  EXPECT_NEAR(size.projected_area.z(), 2 * 4 * 6, 1e-12);
}

TEST(MemoryEstimate, ALatticeBeyondTheBudgetIsRefusedBeforeAnythingIsAllocatedNamingTheRemedy) {
  LatticeSettings settings;
  settings.spacing = 1e-3;  // 32 million million cells: must not even be tried
  const std::string sentence = refusal(test::box(Vec3(0, 0, 0), Vec3(100, 80, 4)), settings);
  EXPECT_NE(sentence.find("spacing 0.001 mm"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("100 mm x 80 mm x 4 mm"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("budget of 8 GiB"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("use a spacing of at least"), std::string::npos) << sentence;
}

TEST(MemoryEstimate, TheSpacingAndTheRatioThatARefusalAdvisesAreAccepted) {
  const Surface surface = test::box(Vec3(0, 0, 0), Vec3(30, 30, 4));
  LatticeSettings settings;
  settings.spacing = 0.25;
  settings.fine_ratio = 8;
  settings.memory_budget = std::size_t{90} << 20;
  const std::string sentence = refusal(surface, settings);
  const std::string spacing_words = "use a spacing of at least ", ratio_words = "or a fine ratio of at most ";
  ASSERT_NE(sentence.find(spacing_words), std::string::npos) << sentence;
  LatticeSettings coarser = settings;
  coarser.spacing = std::stod(sentence.substr(sentence.find(spacing_words) + spacing_words.size()));
  EXPECT_GT(coarser.spacing, settings.spacing);
  EXPECT_NO_THROW((void)build_lattice(surface, coarser));
  ASSERT_NE(sentence.find(ratio_words), std::string::npos) << sentence;
  LatticeSettings fewer = settings;
  fewer.fine_ratio = std::stoi(sentence.substr(sentence.find(ratio_words) + ratio_words.size()));
  EXPECT_NO_THROW((void)build_lattice(surface, fewer));
}

TEST(MemoryEstimate, CoversWhatTheVoxelsTake) {
  for (const auto& surface : {test::box(Vec3(0, 0, 0), Vec3(30, 20, 4)), test::sphere(Vec3(10, 10, 10), 9.3, 30)})
    for (const int ratio : {1, 4, 10}) {
      LatticeSettings settings;
      settings.fine_ratio = ratio;
      const Lattice lattice = build_lattice(surface, settings);
      const auto kept = double(lattice.bytes());
      EXPECT_GT(estimate_bytes(measure(surface), settings.spacing, ratio), kept) << ratio;
    }
}

}  // namespace
}  // namespace lappet
