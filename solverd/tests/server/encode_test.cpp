// Replies hold what the solver's values say, within the limits of the wire.
#include "server/encode.h"

#include <gtest/gtest.h>

#include "server/message_refusals.h"

namespace lappet {
namespace {

TEST(Encode, ResultsSayWhichHooksAndSuturesTheyAreOf) {
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

TEST(Encode, ALongSentenceIsCutBetweenTwoCharacters) {
  std::string sentence(kMaxTextBytes - 1, 'x');
  sentence += "\u00b2 and more";  // two bytes, of which one would fit
  const Header header = decode_header(encode_error({1, 0}, ErrorCode::kInternal, sentence).front());
  EXPECT_EQ(std::get<std::string>(header.fields.at("message")), std::string(kMaxTextBytes - 1, 'x'));
}

}  // namespace
}  // namespace lappet
