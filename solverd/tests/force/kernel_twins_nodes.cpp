// Gather and scatter of an instruction set against plain loops.
#include "force/kernels/elastic_arrays.h"
#include "kernel_twins_check.h"
#include "kernel_twins_inputs.h"
#include "math/index.h"

namespace lappet {

namespace {

// Gather and scatter move and add numbers: exactly, also where lanes share nodes.
template <class Real>
TwinResult compare_nodes(const KernelTwins<Real>& twins) {
  TwinResult result{"gather and scatter with shared nodes", 0.0};
  Random random;
  const auto lanes = static_cast<std::size_t>(twins.lanes);
  constexpr std::size_t kNodes = 21;
  for (std::size_t distinct = 1; distinct <= kNodes; ++distinct)
    for (int repeat = 0; repeat < 40; ++repeat, ++result.samples) {
      alignas(64) Real values[3 * 64], gathered[3 * 64];
      // exactly as long as the nodes: a checker of addresses sees what reaches beyond
      std::vector<Real> field(3 * kNodes), expected;
      std::vector<std::int32_t> index(lanes);
      for (auto& value : field) value = Real(random.normal());
      for (std::size_t lane = 0; lane < lanes; ++lane)
        index[lane] = std::int32_t(random.uniform(0.0, double(distinct)));
      if (repeat == 0) index[lanes - 1] = kNodes - 1;
      for (std::size_t i = 0; i < 3 * lanes; ++i) values[i] = Real(random.normal());
      twins.gather(field.data(), index.data(), gathered);
      bool right = true;
      for (std::size_t lane = 0; lane < lanes; ++lane)
        for (std::size_t i = 0; i < 3; ++i)
          right = right && gathered[i * lanes + lane] == field[offset_of(3, index[lane]) + i];
      expected = field;
      for (std::size_t lane = 0; lane < lanes; ++lane)
        for (std::size_t i = 0; i < 3; ++i) expected[offset_of(3, index[lane]) + i] += values[i * lanes + lane];
      twins.scatter_add(field.data(), index.data(), values);
      right = right && field == expected;
      if (!right) {
        result.worst = 1;
        result.where = std::to_string(distinct) + " distinct nodes";
      }
    }
  return result;
}

// The same of whole blocks: columns of the grid, which may overlap by one or two nodes in any two lanes, and nodes each
// on its own. What lanes share is added in no promised order: sums of whole numbers are exact in any.
template <class Real>
TwinResult compare_blocks(const KernelTwins<Real>& twins, bool grid) {
  TwinResult result{grid ? "blocks of overlapping columns" : "blocks of single nodes", 0.0};
  Random random;
  const auto lanes = static_cast<std::size_t>(twins.lanes);
  const auto rows = static_cast<std::size_t>(grid ? kBlockColumns : kBlockNodes);
  constexpr std::size_t kNodes = 57, kNumbers = 3 * std::size_t{kBlockNodes};
  for (std::size_t distinct = 1; distinct <= kNodes - 2; ++distinct, ++result.samples) {
    alignas(64) Real values[kNumbers * 16], gathered[kNumbers * 16];
    std::vector<Real> field(3 * kNodes), expected;  // exactly as long as the nodes, see above
    std::vector<std::int32_t> index(rows * lanes);
    const auto whole = [&] { return Real(std::floor(random.uniform(-99.0, 99.0))); };
    for (auto& value : field) value = whole();
    for (auto& node : index) node = std::int32_t(random.uniform(0.0, double(distinct)));
    index.back() = std::int32_t(grid ? kNodes - 3 : kNodes - 1);
    for (std::size_t i = 0; i < kNumbers * lanes; ++i) values[i] = whole();
    expected = field;
    const GroupNodes nodes{index.data(), twins.lanes, grid};
    twins.gather_block(nodes, field.data(), gathered);
    bool right = true;
    for (std::size_t n = 0; n < kBlockNodes; ++n)
      for (std::size_t lane = 0; lane < lanes; ++lane)
        for (std::size_t i = 0; i < 3; ++i) {
          const auto node = static_cast<std::size_t>(index[(grid ? n / 3 : n) * lanes + lane]) + (grid ? n % 3 : 0);
          right = right && gathered[(3 * n + i) * lanes + lane] == field[3 * node + i];
          expected[3 * node + i] += values[(3 * n + i) * lanes + lane];
        }
    const int told = twins.scatter_block(nodes, values, field.data());
    if (right && field == expected && told == kBlockColumns * twins.lanes) continue;
    result.worst = 1;
    result.where = std::to_string(distinct) + " distinct rows";
  }
  return result;
}

}  // namespace

template <class Real>
std::vector<TwinResult> compare_node_kernels(const KernelTwins<Real>& twins) {
  return {compare_nodes(twins), compare_blocks(twins, true), compare_blocks(twins, false)};
}

template std::vector<TwinResult> compare_node_kernels(const KernelTwins<float>&);
template std::vector<TwinResult> compare_node_kernels(const KernelTwins<double>&);

}  // namespace lappet
