// Parallel loops over fixed chunks: what a chunk holds does not depend on the number of threads, so sums may be
// ordered.
#pragma once
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace lappet {

inline constexpr std::size_t kChunk = 1024;

template <class Body>
void for_each_chunk(std::size_t count, const Body& body) {
  const std::size_t chunks = (count + kChunk - 1) / kChunk;
  tbb::parallel_for(std::size_t{0}, chunks,
                    [&](std::size_t chunk) { body(chunk, chunk * kChunk, std::min(count, (chunk + 1) * kChunk)); });
}

template <class Body>
void for_each_index(std::size_t count, const Body& body) {
  for_each_chunk(count, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

}  // namespace lappet
