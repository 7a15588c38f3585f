// Messages are read into the solver's values, and what lies out of range is refused with a sentence.
#include "server/decode.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "server/message_refusals.h"

namespace lappet {
namespace {

TEST(Decode, IndicesOutOfRangeNeverReachTheSolver) {
  const std::vector<double> points(12, 0.5);
  std::vector<std::int32_t> triangles = {0, 1, 2, 0, 1, 3};
  std::vector<std::int32_t> grip = {-1, 0};
  const std::vector<std::uint8_t> marks(2, 0);
  const auto decode = [&](std::int32_t retractors) {
    const std::vector<PartBytes> parts =
        MessageWriter("epoch", 1)
            .field("index", std::int64_t{0})
            .array("points", std::span<const double>(points), {4, 3})
            .array("triangles", std::span<const std::int32_t>(triangles), {2, 3})
            .array("fixed", std::span<const std::uint8_t>(marks), {2})
            .array("support", std::span<const std::uint8_t>(marks), {2})
            .array("grip", std::span<const std::int32_t>(grip), {2})
            .array("landmarks", std::span<const double>(points), {4, 3})
            .array("landmark_triangles", std::span<const std::int32_t>(std::vector<std::int32_t>{0, 1, 1, 0}), {4})
            .finish();
    const Views views = array_views(parts);
    return decode_epoch(decode_header(parts[0]), views, retractors, 1);
  };
  const EpochInput epoch = decode(1);
  EXPECT_EQ(epoch.surface.triangles[1], (std::array<std::int32_t, 3>{0, 1, 3}));
  EXPECT_EQ(epoch.landmarks.size(), 4U);
  EXPECT_TRUE(says(refusal_of([&] { decode(0); }), ErrorCode::kInvalidInput, "'grip' holds 0"));
  triangles[5] = 4;
  EXPECT_TRUE(says(refusal_of([&] { decode(1); }), ErrorCode::kInvalidInput, "there are 4 surface points"));
  triangles[5] = -1;
  EXPECT_TRUE(says(refusal_of([&] { decode(1); }), ErrorCode::kInvalidInput, "'triangles' holds -1"));
}

Fields material_fields() {
  return {
      {"model", std::string("mooneyRivlin")}, {"youngs_modulus", 40.0}, {"poissons_ratio", 0.4}, {"density", 900.0}};
}

TEST(Decode, EveryParameterOfAMaterialIsRead) {
  const std::vector<Value> zero = {0.0, 0.0, 0.0};
  const Fields settings = {{"spacing", 1.0},
                           {"fine_ratio", std::int64_t{4}},
                           {"origin", zero},
                           {"quadrature", std::int64_t{1}},
                           {"precision", std::string("float")},
                           {"tolerance", 1e-3},
                           {"gap_tolerance", 1e-3},
                           {"max_newton", std::int64_t{9}},
                           {"bed_stiffness", 1.0},
                           {"bed_shear", 0.5},
                           {"gravity", zero},
                           {"time_budget", 0.0},
                           {"memory_budget", std::int64_t{1} << 30},
                           {"threads", std::int64_t{1}},
                           {"sutures", std::int64_t{0}},
                           {"retractors", std::int64_t{0}}};
  const auto decode = [&](Value materials) {
    const auto parts =
        MessageWriter("open", 1).field("settings", settings).field("materials", std::move(materials)).finish();
    return decode_open(decode_header(parts[0]), {});
  };
  Fields full = material_fields();
  full["mooney_ratio"] = 0.5;
  full["fiber_direction"] = std::vector<Value>{0.0, 0.6, 0.8};
  full["fiber_k1"] = 11.0;
  full["fiber_k2"] = 12.0;
  full["fiber_dispersion"] = 0.1;
  full["fiber_slack"] = 1.15;
  full["fiber_angle"] = 35.0;
  full["muscle_stress"] = 300.0;
  full["prestretch"] = std::vector<Value>{1.2, 1.1};
  const SessionSettings read = decode(std::vector<Value>{material_fields(), full});
  ASSERT_EQ(read.materials.size(), 2U);
  const MaterialParameters &plain = read.materials[0], &all = read.materials[1];
  EXPECT_EQ(plain.model, "mooneyRivlin");
  EXPECT_EQ(plain.density, 900.0);
  EXPECT_FALSE(plain.has_fibers() || plain.has_muscle() || plain.has_prestretch());
  EXPECT_EQ(all.mooney_ratio, 0.5);
  EXPECT_EQ(all.fiber_direction, Vec3(0.0, 0.6, 0.8));
  EXPECT_EQ(all.fiber_k1, 11.0);
  EXPECT_EQ(all.fiber_k2, 12.0);
  EXPECT_EQ(all.fiber_dispersion, 0.1);
  EXPECT_EQ(all.fiber_slack, 1.15);
  EXPECT_EQ(plain.fiber_slack, 1.0);
  EXPECT_EQ(all.fiber_angle, 35.0);
  EXPECT_EQ(plain.fiber_angle, 0.0);
  EXPECT_EQ(all.muscle_stress, 300.0);
  EXPECT_EQ(all.prestretch, (std::array<double, 2>{1.2, 1.1}));
  Fields misspelt = material_fields();
  misspelt["fiber_k3"] = 3.0;
  EXPECT_TRUE(says(refusal_of([&] { decode(std::vector<Value>{material_fields(), misspelt}); }), ErrorCode::kMalformed,
                   "'materials[1]' has the field 'fiber_k3'"));
  full["prestretch"] = std::vector<Value>{1.2};
  EXPECT_TRUE(
      says(refusal_of([&] { decode(std::vector<Value>{full}); }), ErrorCode::kMalformed, "list of two numbers"));
  EXPECT_TRUE(says(refusal_of([&] { decode(material_fields()); }), ErrorCode::kMalformed, "a list of maps"));
  EXPECT_TRUE(says(refusal_of([&] { decode(std::vector<Value>{1.0}); }), ErrorCode::kMalformed, "entry 0"));
}

TEST(Decode, RegionsComeWithTheSkinThatTheyLieBelow) {
  const std::vector<double> points(12, 0.5);
  std::vector<std::int32_t> triangles = {0, 1, 2, 0, 1, 3};
  const std::vector<std::int32_t> grip(2, -1), none;
  const std::vector<std::uint8_t> marks(2, 0);
  std::vector<std::uint8_t> faces = {1, 0, 0, 1};
  Fields first = {{"material", std::int64_t{1}}, {"depth_from", 0.5}, {"depth_to", 2.0}};
  const Fields second = {{"material", std::int64_t{0}}, {"depth_from", 2.0}};
  const auto message = [&] {
    MessageWriter writer("epoch", 1);
    writer.field("index", std::int64_t{0})
        .array("points", std::span<const double>(points), {4, 3})
        .array("triangles", std::span<const std::int32_t>(triangles), {2, 3})
        .array("fixed", std::span<const std::uint8_t>(marks), {2})
        .array("support", std::span<const std::uint8_t>(marks), {2})
        .array("grip", std::span<const std::int32_t>(grip), {2})
        .array("landmarks", std::span<const double>(), {0, 3})
        .array("landmark_triangles", std::span<const std::int32_t>(none), {0});
    return writer;
  };
  const auto decode = [](MessageWriter writer, std::int32_t materials) {
    const auto parts = writer.finish();
    const Views views = array_views(parts);
    return decode_epoch(decode_header(parts[0]), views, 0, materials);
  };
  const auto with_regions = [&](bool labeled = true) {
    MessageWriter writer = message();
    writer.field("regions", std::vector<Value>{first, second})
        .array("skin_points", std::span<const double>(points), {4, 3})
        .array("skin_triangles", std::span<const std::int32_t>(triangles), {2, 3});
    if (labeled) writer.array("region_faces", std::span<const std::uint8_t>(faces), {2, 2});
    return writer;
  };
  EXPECT_TRUE(decode(message(), 1).regions.empty());
  const EpochInput epoch = decode(with_regions(), 2);
  EXPECT_EQ(epoch.skin.triangles.size(), 2U);
  ASSERT_EQ(epoch.regions.size(), 2U);
  EXPECT_EQ(epoch.regions[0].material, 1);
  EXPECT_EQ(epoch.regions[0].from_depth, 0.5);
  EXPECT_EQ(epoch.regions[0].to_depth, 2.0);
  EXPECT_EQ(epoch.regions[0].faces, (std::vector<std::uint8_t>{1, 0}));
  EXPECT_TRUE(std::isinf(epoch.regions[1].to_depth));
  EXPECT_EQ(epoch.regions[1].faces, (std::vector<std::uint8_t>{0, 1}));
  EXPECT_TRUE(says(refusal_of([&] { decode(with_regions(), 1); }), ErrorCode::kInvalidInput, "'material'"));
  EXPECT_TRUE(says(refusal_of([&] { decode(with_regions(false), 2); }), ErrorCode::kMalformed, "'region_faces'"));
  MessageWriter skin_alone = message();  // for the directions of materials
  skin_alone.array("skin_points", std::span<const double>(points), {4, 3});
  EXPECT_TRUE(says(refusal_of([&] { decode(skin_alone, 1); }), ErrorCode::kMalformed, "'skin_triangles'"));
  skin_alone.array("skin_triangles", std::span<const std::int32_t>(triangles), {2, 3});
  EXPECT_EQ(decode(skin_alone, 1).skin.triangles.size(), 2U);
  EXPECT_TRUE(decode(skin_alone, 1).skin_fields.directions.empty());
  std::vector<double> directions(12, 0.0), stretch(8, 1.1);  // and of their directions and stretches, point by point
  directions[10] = 2.0;
  skin_alone.array("skin_directions", std::span<const double>(directions), {4, 3})
      .array("skin_stretch", std::span<const double>(stretch), {4, 2});
  EXPECT_EQ(decode(skin_alone, 1).skin_fields.directions[3], Vec3(0, 2, 0));
  EXPECT_EQ(decode(skin_alone, 1).skin_fields.stretch[3], (std::array<double, 2>{1.1, 1.1}));
  MessageWriter short_of_one = message();
  short_of_one.array("skin_points", std::span<const double>(points), {4, 3})
      .array("skin_triangles", std::span<const std::int32_t>(triangles), {2, 3})
      .array("skin_directions", std::span<const double>(directions).first(9), {3, 3});
  EXPECT_TRUE(says(refusal_of([&] { decode(short_of_one, 1); }), ErrorCode::kMalformed, "'skin_directions'"));
  EXPECT_TRUE(decode(skin_alone, 1).regions.empty());
  MessageWriter stray = message();
  stray.array("region_faces", std::span<const std::uint8_t>(faces), {2, 2});
  EXPECT_TRUE(says(refusal_of([&] { decode(stray, 2); }), ErrorCode::kMalformed, "'region_faces'"));
  first["depth"] = 1.0;
  EXPECT_TRUE(says(refusal_of([&] { decode(with_regions(), 2); }), ErrorCode::kMalformed, "'regions[0]'"));
}

TEST(Decode, AFrameActivatesEveryMaterialOrNone) {
  const std::span<const double> reals;
  const std::span<const std::int32_t> wholes;
  const auto decode = [&](std::vector<double> activation, std::int32_t materials) {
    MessageWriter writer("solve", 1);
    writer.field("time", 1.0)
        .array("hook_anchors", reals, {0, 3})
        .array("hook_triangles", wholes, {0})
        .array("hook_targets", reals, {0, 3})
        .array("hook_stiffness", reals, {0})
        .array("suture_index", wholes, {0})
        .array("suture_anchors", reals, {0, 2, 3})
        .array("suture_triangles", wholes, {0, 2})
        .array("suture_closure", reals, {0})
        .array("suture_stiffness", reals, {0})
        .array("retractor_index", wholes, {0})
        .array("retractor_motion", reals, {0, 4, 4});
    if (!activation.empty()) writer.array("activation", std::span<const double>(activation), {activation.size()});
    const auto parts = writer.finish();
    const Views views = array_views(parts);
    return decode_solve(decode_header(parts[0]), views, {2, 0, 0, materials}).activation;
  };
  EXPECT_TRUE(decode({}, 3).empty());
  EXPECT_EQ(decode({0.0, 0.5}, 2), (std::vector<double>{0.0, 0.5}));
  EXPECT_TRUE(says(refusal_of([&] { decode({0.5}, 2); }), ErrorCode::kMalformed, "'activation'"));
  EXPECT_TRUE(says(refusal_of([&] { decode({0.5, std::nan("")}, 2); }), ErrorCode::kInvalidInput, "'activation'"));
}

TEST(Decode, HooksAreToldApartByTheirIndexOrTheirPlace) {
  const std::vector<double> zeros(6, 0.0), stiffness(2, 1.0);
  const std::vector<std::int32_t> triangles(2, 0);
  const std::span<const double> reals;
  const std::span<const std::int32_t> wholes;
  const auto decode = [&](const std::vector<std::int32_t>& index) {
    MessageWriter writer("solve", 1);
    writer.field("time", 1.0)
        .array("hook_anchors", std::span(zeros), {2, 3})
        .array("hook_triangles", std::span(triangles), {2})
        .array("hook_targets", std::span(zeros), {2, 3})
        .array("hook_stiffness", std::span(stiffness), {2})
        .array("suture_index", wholes, {0})
        .array("suture_anchors", reals, {0, 2, 3})
        .array("suture_triangles", wholes, {0, 2})
        .array("suture_closure", reals, {0})
        .array("suture_stiffness", reals, {0})
        .array("retractor_index", wholes, {0})
        .array("retractor_motion", reals, {0, 4, 4});
    if (!index.empty()) writer.array("hook_index", std::span(index), {index.size()});
    const auto parts = writer.finish();
    const Views views = array_views(parts);
    const FrameInput frame = decode_solve(decode_header(parts[0]), views, {2, 0, 0, 1});
    return std::pair{frame.hooks[0].index, frame.hooks[1].index};
  };
  EXPECT_EQ(decode({}), (std::pair{0, 1}));
  EXPECT_EQ(decode({7, 3}), (std::pair{7, 3}));
  EXPECT_TRUE(says(refusal_of([&] { decode({7, 7}); }), ErrorCode::kInvalidInput, "'hook_index' holds 7 twice"));
  EXPECT_TRUE(says(refusal_of([&] { decode({7}); }), ErrorCode::kMalformed, "'hook_index'"));
}

TEST(Decode, BitesBetweenTheEndsOfSuturesAreCountedOut) {
  const std::vector<double> ends(3 * 2 * 3, 0.0), ones(3, 1.0), zeros(3, 0.0);
  const std::vector<double> inner{1, 2, 3, 4, 5, 6, 7, 8, 9};
  const std::vector<std::int32_t> index{0, 1, 2}, triangles(6, 0);
  const std::vector<std::uint8_t> threads(3, 1);
  const std::span<const double> reals;
  const std::span<const std::int32_t> wholes;
  const auto decode = [&](const std::vector<std::int32_t>& counts, const std::vector<std::int32_t>& of_bites) {
    MessageWriter writer("solve", 1);
    writer.field("time", 1.0)
        .array("hook_anchors", reals, {0, 3})
        .array("hook_triangles", wholes, {0})
        .array("hook_targets", reals, {0, 3})
        .array("hook_stiffness", reals, {0})
        .array("suture_index", std::span(index), {3})
        .array("suture_anchors", std::span(ends), {3, 2, 3})
        .array("suture_triangles", std::span(triangles), {3, 2})
        .array("suture_closure", std::span(ones), {3})
        .array("suture_stiffness", std::span(ones), {3})
        .array("suture_is_thread", std::span(threads), {3})
        .array("suture_length", std::span(zeros), {3})
        .array("suture_tension", std::span(zeros), {3})
        .array("retractor_index", wholes, {0})
        .array("retractor_motion", reals, {0, 4, 4});
    if (!counts.empty())
      writer.array("suture_inner_bites", std::span(counts), {counts.size()})
          .array("inner_bite_triangles", std::span(of_bites), {of_bites.size()})
          .array("inner_bite_anchors", std::span(inner).first(3 * of_bites.size()), {of_bites.size(), 3});
    const auto parts = writer.finish();
    const Views views = array_views(parts);
    return decode_solve(decode_header(parts[0]), views, {4, 3, 0, 1}).sutures;
  };
  for (const SutureState& suture : decode({}, {})) EXPECT_TRUE(suture.inner.empty());
  const std::vector<SutureState> read = decode({1, 0, 2}, {3, 1, 2});
  ASSERT_EQ(read[0].inner.size(), 1U);
  EXPECT_TRUE(read[1].inner.empty());
  ASSERT_EQ(read[2].inner.size(), 2U);
  EXPECT_EQ(read[0].inner[0], (Anchor{Vec3(1, 2, 3), 3}));
  EXPECT_EQ(read[2].inner[1], (Anchor{Vec3(7, 8, 9), 2}));
  const auto refused = [&](std::vector<std::int32_t> counts, std::vector<std::int32_t> of_bites, const char* sentence) {
    return says(refusal_of([&] { decode(counts, of_bites); }), ErrorCode::kInvalidInput, sentence);
  };
  EXPECT_TRUE(refused({1, 0, 1}, {3, 1, 2}, "adds up to 2"));
  EXPECT_TRUE(refused({1, 0, 3}, {3, 1, 2}, "says 3 in row 2"));
  EXPECT_TRUE(refused({-1, 2, 2}, {3, 1, 2}, "says -1 in row 0"));
  EXPECT_TRUE(refused({1, 0, 2}, {3, 4, 2}, "'inner_bite_triangles'"));
  EXPECT_TRUE(says(refusal_of([&] { decode({1, 2}, {3, 1, 2}); }), ErrorCode::kMalformed, "'suture_inner_bites'"));
}

}  // namespace
}  // namespace lappet
