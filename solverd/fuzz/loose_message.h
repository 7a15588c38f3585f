// A message whose header and parts need not fit each other: read from a good one, spoilt, and written again.
#pragma once
#include <optional>
#include <vector>

#include "conversation.h"

namespace lappet {

struct LooseMessage {
  Fields header;  // the whole map, `arrays` too
  std::vector<PartBytes> parts;
};

// Nothing where the header is no map of the kinds that the protocol uses.
std::optional<LooseMessage> read_loosely(const RawMessage& message);
RawMessage write_loosely(const LooseMessage& message);

// One entry of `arrays` with its part, and what can be told of it.
struct LooseArray {
  Fields* entry = nullptr;
  PartBytes* part = nullptr;
  std::vector<Value>* shape = nullptr;
  ElementType type = ElementType::kU1;
  std::size_t rows = 0, row_bytes = 0;  // 0 rows where shape and part do not fit each other
};

// Of every entry that has a part, a shape and a known dtype.
std::vector<LooseArray> arrays_of(LooseMessage& message);

}  // namespace lappet
