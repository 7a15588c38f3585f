// The entry that libFuzzer and AFL++ call: bytes as a file of the corpus holds them. The driver in main.cpp calls it
// too.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "replay.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    lappet::Replay replay;
    for (const auto& message : lappet::read_conversation(std::as_bytes(std::span(data, size)))) {
      lappet::decode_alone(message);
      replay.play(message);
    }
  } catch (const lappet::Finding& finding) {
    std::fprintf(stderr, "%s\n", finding.what());
    std::abort();
  }
  return 0;
}
