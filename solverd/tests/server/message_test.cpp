// The wire's messages: what is written is read back, and what breaks PROTOCOL.md is refused with a sentence.
#include "server/message.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "lattice/refused.h"
#include "server/message_refusals.h"
#include "server/private_address.h"

namespace lappet {
namespace {

PartBytes bytes(std::initializer_list<int> values) {
  PartBytes result;
  for (const int value : values) result.push_back(static_cast<std::byte>(value));
  return result;
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
  EXPECT_TRUE(says(read([](ArrayReader&) {}), ErrorCode::kMalformed, "holds 0 array parts"));
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

TEST(Loopback, OnlyLoopbackAddressesAreServed) {
  for (const char* address :
       {"tcp://127.0.0.1:*", "tcp://127.0.0.1:0", "tcp://127.255.3.4:65535", "tcp://[::1]:5555"}) {
    EXPECT_NO_THROW(require_private(address)) << address;
  }
  for (const char* address :
       {"tcp://0.0.0.0:*", "tcp://*:5555", "tcp://192.168.1.5:80", "tcp://eth0:5555", "tcp://localhost:5555",
        "tcp://127.0.0.1.evil.org:1", "tcp://127.0.0.1", "tcp://127.0.0.1:", "tcp://127.0.0.1:99999", "tcp://[::]:5555",
        "ipc:///tmp/x", "inproc://x", "tcp://127.0.0.1:1;0.0.0.0:2", "", "tcp://:5", "tcp://128.0.0.1:5"}) {
    EXPECT_TRUE(says(refusal_of([&] { require_private(address); }), ErrorCode::kInvalidInput, "only loopback"))
        << address;
  }
}

}  // namespace
}  // namespace lappet
