// The wire's messages: what is written is read back, and what breaks PROTOCOL.md is refused with a sentence.
#include "server/message.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "lattice/refused.h"
#include "server/codec.h"
#include "server/loopback.h"

namespace lappet {
namespace {

using Views = std::vector<std::span<const std::byte>>;

Views array_views(const std::vector<PartBytes>& parts) { return {parts.begin() + 1, parts.end()}; }

PartBytes bytes(std::initializer_list<int> values) {
  PartBytes result;
  for (const int value : values) result.push_back(static_cast<std::byte>(value));
  return result;
}

template <class Action>
RefusedError refusal_of(Action action) {
  try {
    action();
  } catch (const RefusedError& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was refused";
  return {ErrorCode::kInternal, ""};
}

testing::AssertionResult says(const RefusedError& error, ErrorCode code, const std::string& part) {
  if (error.code() == code && std::string(error.what()).find(part) != std::string::npos) {
    return testing::AssertionSuccess();
  }
  return testing::AssertionFailure() << error_name(error.code()) << ": " << error.what();
}

// A header whose `arrays` holds one array of this shape.
std::vector<PartBytes> with_shape(std::vector<Value> shape, const std::string& dtype = "f8") {
  const Fields array = {{"name", std::string("points")}, {"dtype", dtype}, {"shape", std::move(shape)}};
  // The writer adds its own empty `arrays`; write the list as a field of a header made by hand.
  const std::vector<PartBytes> entry = MessageWriter("x", 1).field("entry", array).finish();
  PartBytes header = MessageWriter("epoch", 7).finish().front();
  // The header ends with the empty list of arrays: 0x90. Replace it by a list of one and the packed map.
  EXPECT_EQ(header.back(), std::byte{0x90});
  header.back() = std::byte{0x91};
  const std::string key = "entry";
  const auto at = std::search(entry[0].begin(), entry[0].end(), reinterpret_cast<const std::byte*>(key.data()),
                              reinterpret_cast<const std::byte*>(key.data()) + key.size());
  header.insert(header.end(), at + static_cast<std::ptrdiff_t>(key.size()), entry[0].end());
  return {header};
}

TEST(Message, IsReadBackAsItWasWritten) {
  const std::vector<double> points = {1.5, -2.0, std::numeric_limits<double>::denorm_min(), 4.0, 1e300, 6.0};
  const std::vector<std::int32_t> index = {-1, 2147483647};
  const std::vector<PartBytes> parts = MessageWriter("frame", 18446744073709551615U, 3)
                                           .field("whole", std::int64_t{-5})
                                           .field("real", 2.0)
                                           .field("nothing", std::numeric_limits<double>::quiet_NaN())
                                           .field("yes", true)
                                           .field("text", std::string("a sentence"))
                                           .field("list", std::vector<Value>{1.0, 2.0, 3.0})
                                           .field("map", Fields{{"total", 0.25}})
                                           .array("points", std::span<const double>(points), {2, 3})
                                           .array("index", std::span<const std::int32_t>(index), {2})
                                           .array("none", std::span<const float>(), {0, 3})
                                           .finish();
  ASSERT_EQ(parts.size(), 4U);
  const Header header = decode_header(parts[0]);
  EXPECT_EQ(header.type, "frame");
  EXPECT_EQ(header.id, 18446744073709551615U);
  EXPECT_EQ(header.session, 3U);
  EXPECT_EQ(std::get<std::int64_t>(header.fields.at("whole")), -5);
  EXPECT_EQ(std::get<double>(header.fields.at("real")), 2.0);
  EXPECT_TRUE(std::isnan(std::get<double>(header.fields.at("nothing"))));
  EXPECT_EQ(std::get<bool>(header.fields.at("yes")), true);
  EXPECT_EQ(std::get<std::string>(header.fields.at("text")), "a sentence");
  FieldReader fields(header.fields, "frame");
  EXPECT_EQ(fields.vector3("list"), (std::array<double, 3>{1.0, 2.0, 3.0}));
  EXPECT_EQ(FieldReader(fields.map("map"), "map").number("total"), 0.25);

  const Views views = array_views(parts);
  ArrayReader arrays(header, views);
  EXPECT_EQ(arrays.read<double>("points", {kAny, 3}), points);
  EXPECT_EQ(arrays.read<std::int32_t>("index", {2}), index);
  EXPECT_TRUE(arrays.read<float>("none", {kAny, 3}).empty());
  arrays.finish();
}

TEST(Message, ARealNumberKeepsItsKindEvenWhenItIsWhole) {
  const Header header = decode_header(MessageWriter("frame", 1).field("time", 3.0).finish().front());
  EXPECT_TRUE(std::holds_alternative<double>(header.fields.at("time")));
}

TEST(Message, WhatIsNoMapIsRefused) {
  const std::vector<PartBytes> broken = {bytes({}),
                                         bytes({0xc1}),
                                         bytes({0x93, 1, 2}),
                                         bytes({0xc0}),
                                         bytes({0x05}),
                                         bytes({0xdf, 0xff, 0xff, 0xff, 0xff}),
                                         bytes({0x80, 0x80}),
                                         bytes({0x81, 0x01, 0x02}),
                                         PartBytes(4096, std::byte{0x91})};
  for (const PartBytes& part : broken) {
    const RefusedError error = refusal_of([&] { decode_header(part); });
    EXPECT_EQ(error.code(), ErrorCode::kMalformed) << error.what();
  }
}

TEST(Message, EveryCutOffHeaderIsRefused) {
  const PartBytes whole = with_shape({std::uint64_t{2}, std::uint64_t{3}}).front();
  EXPECT_EQ(decode_header(whole).arrays.at(0).bytes, 48U);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const std::span<const std::byte> cut(whole.data(), length);
    EXPECT_EQ(refusal_of([&] { decode_header(cut); }).code(), ErrorCode::kMalformed) << length;
  }
}

TEST(Message, ShapesThatOverflowAreRefused) {
  constexpr std::uint64_t kHuge = std::uint64_t{1} << 60;
  for (const std::vector<Value>& shape : {std::vector<Value>{kHuge},
                                          {kHuge, kHuge},
                                          {std::uint64_t{1} << 32, std::uint64_t{1} << 32},
                                          {std::uint64_t{18446744073709551615U}, std::uint64_t{2}},
                                          {kHuge, std::uint64_t{0}}}) {
    EXPECT_TRUE(
        says(refusal_of([&] { decode_header(with_shape(shape).front()); }), ErrorCode::kMalformed, "too large"));
  }
  EXPECT_TRUE(says(refusal_of([&] { decode_header(with_shape({std::uint64_t{1000}}).front(), 7999); }),
                   ErrorCode::kMalformed, "this daemon takes 7999"));
  EXPECT_TRUE(says(refusal_of([&] { decode_header(with_shape({std::int64_t{-1}}).front()); }), ErrorCode::kMalformed,
                   "lengths of 0 or more"));
  EXPECT_TRUE(says(refusal_of([&] { decode_header(with_shape(std::vector<Value>(5, std::uint64_t{1})).front()); }),
                   ErrorCode::kMalformed, "5 dimensions"));
  EXPECT_TRUE(says(refusal_of([&] { decode_header(with_shape({std::uint64_t{1}}, "O").front()); }),
                   ErrorCode::kMalformed, "dtype 'O'"));
}

TEST(Message, AnotherVersionIsRefusedAndItsIdIsKnown) {
  PartBytes header = MessageWriter("ping", 9).finish().front();
  const auto version = std::ranges::find(header, std::byte{'v'});
  *(version + 1) = std::byte{2};
  EXPECT_TRUE(says(refusal_of([&] { decode_header(header); }), ErrorCode::kMalformed, "version 2"));
  EXPECT_EQ(guess_id(header), 9U);
  EXPECT_EQ(guess_id(bytes({0xc1})), 0U);
  EXPECT_EQ(guess_id({}), 0U);
}

TEST(Message, ArraysMustHaveTheLengthKindAndShapeThatAreAskedFor) {
  const std::vector<double> points(6, 1.0);
  std::vector<PartBytes> parts =
      MessageWriter("epoch", 1).array("points", std::span<const double>(points), {2, 3}).finish();
  const Header header = decode_header(parts[0]);
  const auto read = [&](auto action) {
    return refusal_of([&] {
      const Views views = array_views(parts);
      ArrayReader reader(header, views);
      action(reader);
    });
  };
  EXPECT_TRUE(
      says(read([](ArrayReader& r) { r.read<float>("points", {kAny, 3}); }), ErrorCode::kMalformed, "dtype f8"));
  EXPECT_TRUE(
      says(read([](ArrayReader& r) { r.read<double>("points", {kAny, 2}); }), ErrorCode::kMalformed, "(any, 2)"));
  EXPECT_TRUE(says(read([](ArrayReader& r) { r.read<double>("points", {6}); }), ErrorCode::kMalformed, "(2, 3)"));
  EXPECT_TRUE(
      says(read([](ArrayReader& r) { r.read<double>("triangles", {kAny}); }), ErrorCode::kMalformed, "no array"));
  EXPECT_TRUE(says(read([](ArrayReader& r) { r.finish(); }), ErrorCode::kMalformed, "does not know"));
  parts[1].pop_back();
  EXPECT_TRUE(says(read([](ArrayReader&) {}), ErrorCode::kMalformed, "47 bytes"));
  parts.pop_back();
  EXPECT_TRUE(says(read([](ArrayReader&) {}), ErrorCode::kMalformed, "holds 0 array frames"));
}

TEST(Message, ValuesThatAreNotFiniteAreNamed) {
  std::vector<double> points(6, 1.0);
  points[4] = std::numeric_limits<double>::infinity();
  const std::vector<PartBytes> parts =
      MessageWriter("epoch", 1).array("points", std::span<const double>(points), {2, 3}).finish();
  const Header header = decode_header(parts[0]);
  const Views views = array_views(parts);
  ArrayReader reader(header, views);
  EXPECT_TRUE(
      says(refusal_of([&] { reader.read_finite("points", {kAny, 3}); }), ErrorCode::kInvalidInput, "element 4"));
}

TEST(Message, FieldsAreCheckedByKindAndRange) {
  const Fields fields = {{"spacing", std::string("one")},
                         {"threads", std::uint64_t{5000}},
                         {"low", std::int64_t{-3}},
                         {"real", 1.5},
                         {"yes", true}};
  FieldReader reader(fields, "settings");
  EXPECT_TRUE(
      says(refusal_of([&] { reader.number("spacing"); }), ErrorCode::kMalformed, "'spacing' of 'settings' is a text"));
  EXPECT_TRUE(says(refusal_of([&] { reader.number("yes"); }), ErrorCode::kMalformed, "a truth value"));
  EXPECT_TRUE(says(refusal_of([&] { reader.integer("real", 0, 9); }), ErrorCode::kMalformed, "a whole number"));
  EXPECT_TRUE(says(refusal_of([&] { reader.integer("threads", 0, 4096); }), ErrorCode::kInvalidInput, "is 5000"));
  EXPECT_TRUE(says(refusal_of([&] { reader.integer("low", 0, 4096); }), ErrorCode::kInvalidInput, "is -3"));
  EXPECT_EQ(reader.integer("low", -3, -3), -3);
  EXPECT_TRUE(says(refusal_of([&] { reader.text("missing"); }), ErrorCode::kMalformed, "no field 'missing'"));
  const Fields misspelt = {{"spaceing", 1.0}};
  EXPECT_TRUE(
      says(refusal_of([&] { FieldReader(misspelt, "settings").finish(); }), ErrorCode::kMalformed, "'spaceing'"));
}

TEST(Message, RandomBytesAreRefusedAndNothingElseHappens) {
  std::mt19937 random(20261121);
  const PartBytes seed = with_shape({std::uint64_t{2}, std::uint64_t{3}}).front();
  int refused = 0;
  for (int turn = 0; turn < 20000; ++turn) {
    PartBytes part = seed;
    const int changes = 1 + static_cast<int>(random() % 6);
    for (int i = 0; i < changes; ++i) part[random() % part.size()] = static_cast<std::byte>(random());
    if (random() % 4 == 0) part.resize(random() % part.size());
    guess_id(part);
    try {
      decode_header(part, 1 << 20);
    } catch (const RefusedError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 10000);
}

TEST(Codec, IndicesOutOfRangeNeverReachTheSolver) {
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

TEST(Codec, EveryParameterOfAMaterialIsRead) {
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
  EXPECT_EQ(all.muscle_stress, 300.0);
  EXPECT_EQ(all.prestretch, (std::array<double, 2>{1.2, 1.1}));
  Fields misspelt = material_fields();
  misspelt["fiber_k1"] = 3.0;
  EXPECT_TRUE(says(refusal_of([&] { decode(std::vector<Value>{material_fields(), misspelt}); }), ErrorCode::kMalformed,
                   "'materials[1]' has the field 'fiber_k1'"));
  full["prestretch"] = std::vector<Value>{1.2};
  EXPECT_TRUE(
      says(refusal_of([&] { decode(std::vector<Value>{full}); }), ErrorCode::kMalformed, "list of two numbers"));
  EXPECT_TRUE(says(refusal_of([&] { decode(material_fields()); }), ErrorCode::kMalformed, "a list of maps"));
  EXPECT_TRUE(says(refusal_of([&] { decode(std::vector<Value>{1.0}); }), ErrorCode::kMalformed, "entry 0"));
}

TEST(Codec, RegionsComeWithTheSkinThatTheyLieBelow) {
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
  EXPECT_TRUE(decode(skin_alone, 1).regions.empty());
  MessageWriter stray = message();
  stray.array("region_faces", std::span<const std::uint8_t>(faces), {2, 2});
  EXPECT_TRUE(says(refusal_of([&] { decode(stray, 2); }), ErrorCode::kMalformed, "'region_faces'"));
  first["depth"] = 1.0;
  EXPECT_TRUE(says(refusal_of([&] { decode(with_regions(), 2); }), ErrorCode::kMalformed, "'regions[0]'"));
}

TEST(Codec, AFrameActivatesEveryMaterialOrNone) {
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

TEST(Codec, HooksAreToldApartByTheirIndexOrTheirPlaceAndResultsSayWhichTheyAreOf) {
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

  FrameOutput frame;
  frame.hook_indices = {7, 3};
  frame.suture_indices = {2};
  const auto parts = encode_frame({1, 1}, frame);
  const Header header = decode_header(parts[0]);
  const Views views = array_views(parts);
  ArrayReader arrays(header, views);
  EXPECT_EQ(arrays.read<std::int32_t>("hook_index", {kAny}), frame.hook_indices);
  EXPECT_EQ(arrays.read<std::int32_t>("suture_index", {kAny}), frame.suture_indices);
}

TEST(Codec, ALongSentenceIsCutBetweenTwoCharacters) {
  std::string sentence(kMaxTextBytes - 1, 'x');
  sentence += "\u00b2 and more";  // two bytes, of which one would fit
  const Header header = decode_header(encode_error({1, 0}, ErrorCode::kInternal, sentence).front());
  EXPECT_EQ(std::get<std::string>(header.fields.at("message")), std::string(kMaxTextBytes - 1, 'x'));
}

TEST(Loopback, OnlyLoopbackAddressesAreServed) {
  for (const char* address :
       {"tcp://127.0.0.1:*", "tcp://127.0.0.1:0", "tcp://127.255.3.4:65535", "tcp://[::1]:5555"}) {
    EXPECT_NO_THROW(require_loopback(address)) << address;
  }
  for (const char* address :
       {"tcp://0.0.0.0:*", "tcp://*:5555", "tcp://192.168.1.5:80", "tcp://eth0:5555", "tcp://localhost:5555",
        "tcp://127.0.0.1.evil.org:1", "tcp://127.0.0.1", "tcp://127.0.0.1:", "tcp://127.0.0.1:99999", "tcp://[::]:5555",
        "ipc:///tmp/x", "inproc://x", "tcp://127.0.0.1:1;0.0.0.0:2", "", "tcp://:5", "tcp://128.0.0.1:5"}) {
    EXPECT_TRUE(says(refusal_of([&] { require_loopback(address); }), ErrorCode::kInvalidInput, "only loopback"))
        << address;
  }
}

}  // namespace
}  // namespace lappet
