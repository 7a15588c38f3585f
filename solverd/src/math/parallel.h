// Parallel loops over fixed chunks: what a chunk holds does not depend on the number of threads, so sums may be
// ordered.
#pragma once
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace lappet {

inline constexpr std::size_t kChunk = 1024;

template <class Body>
void for_each_chunk(std::size_t count, const Body& body, std::size_t length = kChunk) {
  const std::size_t chunks = (count + length - 1) / length;
  tbb::parallel_for(std::size_t{0}, chunks,
                    [&](std::size_t chunk) { body(chunk, chunk * length, std::min(count, (chunk + 1) * length)); });
}

// For rows that are much work each.
template <class Body>
void for_each_row(std::size_t count, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 16), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
  });
}

template <class Body>
void for_each_index(std::size_t count, const Body& body) {
  for_each_chunk(count, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

}  // namespace lappet
