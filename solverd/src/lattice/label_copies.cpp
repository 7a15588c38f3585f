// The connected components of the inside voxels of each coarse cell (GRIDiron Algorithm 2, line 2).
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>

#include "lattice/fine_voxels_builder.h"

namespace lappet {

namespace {

constexpr std::uint16_t kNoLabel = 0xFFFF;

}  // namespace

bool FineVoxels::Builder::is_connected(Index block, const std::array<std::uint64_t, 3>& upper_end) const {
  const unsigned r = out.box_.ratio;
  const std::array<unsigned, 3> stride{r * r, r, 1};
  const std::uint64_t inside = out.inside_[block];
  std::array<std::uint64_t, 3> open;  // the lower ends of links
  for (std::size_t a = 0; a < 3; ++a) open[a] = inside & (inside >> stride[a]) & ~upper_end[a] & ~out.cut_[a][block];
  std::uint64_t reached = inside & (~inside + 1), before = 0;
  while (reached != before) {
    before = reached;
    for (std::size_t a = 0; a < 3; ++a)
      reached |= ((reached & open[a]) << stride[a]) | ((reached >> stride[a]) & open[a]);
  }
  return reached == inside;
}

std::array<std::uint64_t, 3> FineVoxels::Builder::upper_ends() const {
  const std::int32_t r = out.box_.ratio;
  std::array<std::uint64_t, 3> upper_end{};
  if (out.words_ > 1) return upper_end;
  for (std::int32_t x = 0; x < r; ++x)
    for (std::int32_t y = 0; y < r; ++y)
      for (std::int32_t z = 0; z < r; ++z)
        for (std::size_t a = 0; a < 3; ++a)
          if (const Voxel at{x, y, z}; at[a] + 1 == r) upper_end[a] |= std::uint64_t{1} << out.bit(at);
  return upper_end;
}

std::int32_t FineVoxels::Builder::inside_voxels(Index block) const {
  std::int32_t count = 0;
  for (std::size_t w = 0; w < out.words_; ++w) count += std::popcount(out.inside_[block * out.words_ + w]);
  return count;
}

std::int32_t FineVoxels::Builder::label(Index block, Labels& result) const {
  auto& [labels, stack, sizes] = result;
  const std::size_t r = out.box_.ratio;
  const std::array<std::size_t, 3> stride{r * r, r, 1};
  labels.assign(r * r * r, kNoLabel);
  sizes.clear();
  for (std::size_t seed = 0; seed < r * r * r; ++seed) {
    if (labels[seed] != kNoLabel || !out.get(out.inside_, block, seed)) continue;
    const std::uint16_t name = sizes.size();
    sizes.push_back(0);
    labels[seed] = name;
    stack.push_back(std::uint32_t(seed));
    while (!stack.empty()) {
      const std::size_t at = stack.back();
      stack.pop_back();
      ++sizes.back();
      for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t along = at / stride[a] % r;
        const auto visit = [&](std::size_t next, std::size_t lower) {
          if (labels[next] != kNoLabel || !out.get(out.inside_, block, next) || out.get(out.cut_[a], block, lower))
            return;
          labels[next] = name;
          stack.push_back(std::uint32_t(next));
        };
        if (along + 1 < r) visit(at + stride[a], at);
        if (along > 0) visit(at - stride[a], at - stride[a]);
      }
    }
  }
  return to_index(sizes.size());
}

void FineVoxels::Builder::make_copies() {
  tbb::enumerable_thread_specific<Labels> scratch;
  const std::size_t cells = out.position_.size();
  const std::int32_t r = out.box_.ratio;
  std::vector<Index> count(cells, 1);
  const auto each_touched = [&](const auto& body) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells, 256), [&](const auto& range) {
      interrupt.check();
      Labels& local = scratch.local();
      for (std::size_t c = range.begin(); c != range.end(); ++c)
        if (out.block_[c] >= 0) body(c, out.block_[c], local);
    });
  };
  const auto upper_end = upper_ends();
  each_touched([&](std::size_t c, Index block, Labels& local) {
    if (out.words_ == 1 && is_connected(block, upper_end))
      count[c] = inside_voxels(block) > 0;
    else
      count[c] = label(block, local);
  });
  out.copy_first_.assign(cells + 1, 0);
  std::int64_t labeled = 0;
  for (std::size_t c = 0; c < cells; ++c) {
    out.copy_first_[c + 1] = out.copy_first_[c] + count[c];
    if (out.block_[c] >= 0 && count[c] > 1) out.label_first_[out.block_[c]] = std::int64_t{r} * r * r * labeled++;
  }
  out.copy_voxels_.assign(out.copy_first_.back(), r * r * r);
  out.labels_.resize(std::int64_t{r} * r * r * labeled);
  each_touched([&](std::size_t c, Index block, Labels& local) {
    const auto sizes = out.copy_voxels_.begin() + out.copy_first_[c];
    if (count[c] == 1) *sizes = inside_voxels(block);
    if (count[c] <= 1) return;
    label(block, local);
    std::copy(local.sizes.begin(), local.sizes.end(), sizes);
    std::copy(local.of_voxel.begin(), local.of_voxel.end(), out.labels_.begin() + out.label_first_[block]);
  });
}

}  // namespace lappet
