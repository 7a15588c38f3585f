#include "pass_operations.h"

#include "box_lattice.h"
#include "counted_number.h"
#include "force/elastic/elastic.h"
#include "force/kernels/diagonal_kernel.h"
#include "force/kernels/state_kernel.h"

namespace lappet {

PassOperations count_pass_operations() {
  const Lattice lattice = box_lattice(4, 4, 4);
  Elastic<float> elastic(lattice, CellMaterials{{MaterialParameters{}}}, 1, InstructionSet::kScalar);
  const auto& arrays = elastic.arrays();
  const std::int64_t groups = elastic.layout().groups;
  const auto cells = double(lattice.cell_nodes.size());
  const std::size_t size = 3 * lattice.node_rest.size();
  std::vector<float> u(size, 0.0f), y(size), blocks(2 * size);
  std::vector<double> gradient(size), magnitude(size / 3);
  StateSums sums;
  const auto counted = [&]<class T>(T, const auto& run) {
    Counted<T>::operations = 0;
    run();
    return double(Counted<T>::operations) / cells;
  };
  using Float = Counted<float>;
  using Double = Counted<double>;
  PassOperations result{};
  result.evaluate = counted(0.0, [&] {
    evaluate_groups<Double, float, 1, NeoHookean, true, false, false, false>(arrays, 0, groups, u.data(),
                                                                             gradient.data(), magnitude.data(), sums);
  });
  result.stress_derivative = counted(
      0.0f, [&] { linearize_groups<Float, NeoHookean, true, false>(arrays, 0, groups, PsdProjection::kClamp); });
  result.product =
      counted(0.0f, [&] { multiply_groups<Float, true, false, false, false>(arrays, 0, groups, u.data(), y.data()); });
  result.diagonal =
      counted(0.0f, [&] { diagonal_groups<Float, true, false, false, false>(arrays, 0, groups, blocks.data()); });
  return result;
}

}  // namespace lappet
