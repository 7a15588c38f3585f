// The parts of the passes, each alone on arrays of its own (cell_kernels.h).
#include <array>
#include <cmath>
#include <memory>
#include <random>

#include "cell_kernels.h"
#include "counted_number.h"
#include "math/matrix3.h"
#include "working_set.h"

namespace lappet {

namespace {

constexpr std::int64_t kCellsInCache = 512, kTileBlocks = 256;

// Numbers of one record: of a cell, or of the nodes of a block. Deformations reach from near rest to inverted, so that
// tangents are definite in some cells and not in others.
void describe(Content content, std::mt19937& random, float* record) {
  std::normal_distribution<float> noise(0.0f, 1.0f);
  const int count = numbers_per_block(content) / (content == Content::kBlockNodes ? 1 : 8);
  const auto quaternion = [&](float* q) {
    float length = 0.0f;
    for (int k = 0; k < 4; ++k) {
      q[k] = noise(random);
      length += q[k] * q[k];
    }
    for (int k = 0; k < 4; ++k) q[k] /= std::sqrt(length);
  };
  for (int k = 0; k < count; ++k) record[k] = noise(random);
  switch (content) {
    case Content::kDeformation:
      for (int k = 0; k < 9; ++k) record[k] = 0.4f * record[k] + (k % 4 == 0 ? 1.0f : 0.0f);
      break;
    case Content::kRotation: {
      float q[4], r[9];
      quaternion(q);
      rotation_of_quaternion(q, r);
      std::copy_n(r, 9, record);
      break;
    }
    case Content::kQuaternion:
      quaternion(record);
      break;
    case Content::kQuaternions:
    case Content::kTangent:
      quaternion(record);
      quaternion(record + 4);
      break;
    case Content::kSigma:
      for (int k = 0; k < 3; ++k) record[k] = 1.0f + 0.3f * record[k];
      break;
    default:
      break;
  }
}

void fill(Content content, int lanes, std::int64_t groups, float* to) {
  const int per_block = numbers_per_block(content);
  const int records = content == Content::kBlockNodes ? 1 : 8, fields = per_block / records;
  const std::int64_t tile = std::min(groups, std::max<std::int64_t>(1, kTileBlocks / lanes));
  std::mt19937 random(7);
  std::array<float, 81> record{};
  for (std::int64_t g = 0; g < tile; ++g)
    for (int lane = 0; lane < lanes; ++lane)
      for (int r = 0; r < records; ++r) {
        describe(content, random, record.data());
        for (int k = 0; k < fields; ++k) to[((g * records + r) * fields + k) * lanes + lane] = record[k];
      }
  repeat(to, tile, groups, std::int64_t{per_block} * lanes);
}

double bytes_per_cell(const CellKernel& kernel) {
  double bytes = 0.0;
  for (int i = 0; i < kMaxArrays; ++i)
    bytes += sizeof(float) * (numbers_per_block(kernel.in[i]) + numbers_per_block(kernel.out[i])) / 8.0;
  return bytes;
}

struct Arrays {
  const float* in[kMaxArrays] = {};
  float* out[kMaxArrays] = {};

  Arrays() = default;
  Arrays(const CellKernel& kernel, int lanes, std::int64_t groups, Arena& arena) {
    const auto take = [&](Content content) {
      float* array = arena.take<float>(static_cast<std::size_t>(numbers_per_block(content) * lanes * groups));
      fill(content, lanes, groups, array);
      return array;
    };
    for (int i = 0; i < kMaxArrays; ++i) {
      if (kernel.in[i] != Content::kNothing) in[i] = take(kernel.in[i]);
      if (kernel.out[i] != Content::kNothing) out[i] = take(kernel.out[i]);
    }
  }
};

double operations_per_cell(int kernel) {
  CellKernels counted;
  fill_cell_kernels_counted(counted);
  Arena arena(1 << 20);
  const Arrays arrays(counted.kernels[kernel], 1, 1, arena);
  Counted<float>::operations = 0;
  counted.kernels[kernel].run(arrays.in, arrays.out, 0, 1);
  return double(Counted<float>::operations) / 8.0;
}

}  // namespace

void enlist_cell_kernels(Arena& arena) {
  for (const InstructionSet set : available_instruction_sets()) {
    const CellKernels kernels = cell_kernels(set);
    for (int k = 0; k < kCellKernels; ++k)
      for (const Mode mode : {Mode::kCache, Mode::kStream}) {
        const CellKernel kernel = kernels.kernels[k];
        Walk walk{mode};
        walk.cells = 8.0 * kernels.lanes;
        walk.bytes = bytes_per_cell(kernel);
        walk.operations = operations_per_cell(k);
        const double budget = 0.9 * double(arena.bytes());
        walk.items =
            mode == Mode::kCache ? kCellsInCache / 8 / kernels.lanes : std::int64_t(budget / walk.bytes / walk.cells);
        const std::string owner =
            std::string(kernel.name) + "/" + std::string(name(set)) + "/" + std::string(name(mode));
        enlist(
            kernel.name, "float", name(set), mode,
            [&arena, kernel, lanes = kernels.lanes, owner, walk, arrays = Arrays()](benchmark::State& state) mutable {
              if (arena.claim(owner)) arrays = Arrays(kernel, lanes, walk.items, arena);
              walk.measure(state, [&](std::int64_t begin, std::int64_t end) {
                kernel.run(arrays.in, arrays.out, begin, end);
                benchmark::ClobberMemory();
              });
            });
      }
  }
}

}  // namespace lappet
