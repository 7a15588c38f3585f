// Loads, rollers and sections are read from messages into the solver's values; what does not fit is refused.
#include <gtest/gtest.h>

#include "server/decode.h"
#include "server/message_refusals.h"

namespace lappet {
namespace {

struct LoadMessages {
  EpochInput epoch() const {
    const std::vector<double> points(12, 0.5), none;
    const std::vector<std::int32_t> triangles{0, 1, 2, 0, 1, 3}, grip(2, -1), nothing;
    const std::vector<std::uint8_t> fixed{1, 1};
    MessageWriter writer("epoch", 1);
    writer.field("index", std::int64_t{0})
        .array("points", std::span<const double>(points), {4, 3})
        .array("triangles", std::span<const std::int32_t>(triangles), {2, 3})
        .array("fixed", std::span<const std::uint8_t>(fixed), {2})
        .array("support", std::span<const std::uint8_t>(fixed), {2})
        .array("grip", std::span<const std::int32_t>(grip), {2})
        .array("landmarks", std::span<const double>(none), {0, 3})
        .array("landmark_triangles", std::span<const std::int32_t>(nothing), {0})
        .array("fixed_parts", std::span<const std::int32_t>(parts), {2})
        .array("roller_faces", std::span<const std::int32_t>(rollers), {2})
        .array("roller_normals", std::span<const double>(normals), {1, 3})
        .array("loaded_index", std::span<const std::int32_t>(index), {2})
        .array("loaded_faces", std::span<const std::uint8_t>(faces), {2, 2})
        .array("section_points", std::span<const double>(normals), {1, 3})
        .array("section_normals", std::span<const double>(normals), {1, 3});
    const auto message = writer.finish();
    const Views views = array_views(message);
    return decode_epoch(decode_header(message[0]), views, 1, 1);
  }
  FrameInput frame() const {
    const std::vector<double> none;
    const std::vector<std::int32_t> nothing;
    const std::vector<double> pressures{1.5, -2.0};
    MessageWriter writer("solve", 1);
    writer.field("time", 1.0)
        .array("hook_anchors", std::span<const double>(none), {0, 3})
        .array("hook_triangles", std::span<const std::int32_t>(nothing), {0})
        .array("hook_targets", std::span<const double>(none), {0, 3})
        .array("hook_stiffness", std::span<const double>(none), {0})
        .array("suture_index", std::span<const std::int32_t>(nothing), {0})
        .array("suture_anchors", std::span<const double>(none), {0, 2, 3})
        .array("suture_triangles", std::span<const std::int32_t>(nothing), {0, 2})
        .array("suture_closure", std::span<const double>(none), {0})
        .array("suture_stiffness", std::span<const double>(none), {0})
        .array("retractor_index", std::span<const std::int32_t>(nothing), {0})
        .array("retractor_motion", std::span<const double>(none), {0, 4, 4})
        .array("load_index", std::span<const std::int32_t>(index), {2})
        .array("load_traction", std::span<const double>(tractions), {2, 3})
        .array("load_pressure", std::span<const double>(pressures), {2});
    const auto message = writer.finish();
    const Views views = array_views(message);
    FrameLimits limits{};
    return decode_solve(decode_header(message[0]), views, limits);
  }

  std::vector<std::int32_t> parts{0, 1}, rollers{-1, 0}, index{7, 3};
  std::vector<std::uint8_t> faces{1, 0, 0, 1};
  std::vector<double> normals{0, 0, 2}, tractions{0, 0, 0, 1, 2, 3};
};

TEST(DecodeLoads, WhatFacesAreIsRead) {
  LoadMessages messages;
  const EpochInput epoch = messages.epoch();
  EXPECT_EQ(epoch.fixed_parts, (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(epoch.roller, (std::vector<std::int32_t>{-1, 0}));
  EXPECT_EQ(epoch.roller_normals, std::vector<Vec3>{Vec3(0, 0, 2)});
  EXPECT_EQ(epoch.loaded_index, (std::vector<std::int32_t>{7, 3}));
  EXPECT_EQ(epoch.loaded_faces, (std::vector<std::uint8_t>{1, 0, 0, 1}));
  EXPECT_EQ(epoch.section_points.size(), 1U);
  messages.rollers[1] = 1;
  EXPECT_TRUE(says(refusal_of([&] { messages.epoch(); }), ErrorCode::kInvalidInput, "'roller_faces' holds 1"));
  messages.rollers[1] = 0;
  messages.index[1] = 7;
  EXPECT_TRUE(says(refusal_of([&] { messages.epoch(); }), ErrorCode::kInvalidInput, "'loaded_index' holds 7 twice"));
}

TEST(DecodeLoads, LoadsOfAFrameAreToldApartByTheirFaces) {
  LoadMessages messages;
  const FrameInput frame = messages.frame();
  ASSERT_EQ(frame.loads.size(), 2U);
  EXPECT_EQ(frame.loads[1], (LoadState{3, Vec3(1, 2, 3), -2.0}));
  messages.tractions[4] = std::nan("");
  EXPECT_TRUE(says(refusal_of([&] { messages.frame(); }), ErrorCode::kInvalidInput, "load_traction"));
  messages.tractions[4] = 0;
  messages.index[0] = 3;
  EXPECT_TRUE(says(refusal_of([&] { messages.frame(); }), ErrorCode::kInvalidInput, "'load_index' holds 3 twice"));
}

}  // namespace
}  // namespace lappet
