// What the gate to a network lets a peer cost (gate.h).
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace lappet {

struct GateLimits {
  std::size_t unknown = 128;                  // connections whose peer is not known
  std::size_t known = 256;                    // the others
  std::uint64_t bytes_before_known = 4096;    // of a peer; a handshake has less than 1 KiB
  std::chrono::milliseconds handshake{2000};  // until it is known
  double handshakes_per_second = 64.0;        // from one address; four times that from all
};

}  // namespace lappet
