// The passes over the lattice as the daemon runs them, and the gather and scatter inside them, on one thread; and the
// product of 50 000 cells on several.
//
// Streaming walks through copies of one box, side by side in memory, each with nodes of its own.
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include "box_lattice.h"
#include "cell_kernels.h"
#include "force/elastic/elastic.h"
#include "force/kernels/state_kernel.h"
#include "pass_operations.h"
#include "working_set.h"

namespace lappet {

namespace {

// A bent and twisted box, with a ripple that leaves the tangents of some cells indefinite.
template <class Real>
std::vector<Real> displacements(const Lattice& lattice) {
  std::vector<Real> u;
  for (const Vec3& p : lattice.node_rest) {
    const double s = 0.02 * p[0];
    u.push_back(Real(0.15 * p[0] + 0.3 * std::sin(2.1 * p[1] + 1.3 * p[2])));
    u.push_back(Real(-s * p[2] + 0.3 * std::sin(1.7 * p[0] + 2.3 * p[2])));
    u.push_back(Real(s * p[1] + 0.3 * std::sin(2.7 * p[0] + 1.9 * p[1])));
  }
  return u;
}

CellMaterials tissue() { return CellMaterials{{MaterialParameters{}}}; }
// The paper's smaller scenes have about 50 000 cells.
Lattice paper_sized_box() { return box_lattice(100, 50, 10); }

// The arrays of `copies` boxes in the arena.
template <class Real>
struct Copies {
  std::unique_ptr<Lattice> lattice;
  std::unique_ptr<Elastic<Real>> elastic;
  ElasticArrays<Real> arrays;
  std::int64_t copies, groups, nodes;  // groups and nodes: of one
  double slots_per_cell, nodes_per_cell;
  double index_bytes;  // the nodes of a slot
  std::vector<std::int64_t> node_start;
  Real *x, *y, *blocks;
  double *gradient, *magnitude;
  float *at, *sum;

  Copies(InstructionSet set, Mode mode, Arena& arena) {
    lattice = std::make_unique<Lattice>(mode == Mode::kCache ? box_lattice(16, 8, 4) : paper_sized_box());
    elastic = std::make_unique<Elastic<Real>>(*lattice, tissue(), 1, set);
    const auto u = displacements<Real>(*lattice);
    std::vector<double> force(u.size()), scale(u.size() / 3);
    elastic->evaluate(u, force, scale);
    elastic->linearize(PsdProjection::kClamp);
    const BlockLayout& layout = elastic->layout();
    groups = layout.groups;
    nodes = std::int64_t(lattice->node_rest.size());
    const auto cells = double(lattice->cell_nodes.size());
    slots_per_cell = double(layout.slots()) / cells;
    nodes_per_cell = double(nodes) / cells;
    const std::int64_t slots = layout.slots();
    // What comes out shares one place: of all passes the block nodes need most.
    const double a_box = double(slots) * (sizeof(Real) * (kTangentFields + 5) + 4 * 27 / 8.0) +
                         double(nodes) * 3 * sizeof(Real) + double(outputs(slots, nodes));
    copies = mode == Mode::kCache ? 1 : std::max<std::int64_t>(1, std::int64_t(double(arena.bytes()) / a_box));
    arrays = elastic->arrays();
    const auto copy = [&](auto& pointer, std::int64_t count) {
      using T = std::remove_const_t<std::remove_pointer_t<std::decay_t<decltype(pointer)>>>;
      T* place = arena.take<T>(static_cast<std::size_t>(copies * count));
      std::copy_n(pointer, count, place);
      repeat(place, 1, copies, count);
      pointer = place;
    };
    copy(arrays.tangent, slots * kTangentFields);
    copy(arrays.sigma, slots * 3);
    copy(arrays.volume, slots);
    copy(arrays.stabilization, slots);
    const std::int32_t* index = arrays.nodes;
    const std::int64_t per_box = layout.nodes.size();
    copy(index, per_box);
    auto* moved = const_cast<std::int32_t*>(index);
    for (std::int64_t k = 0; k < copies * per_box; ++k) moved[k] += to_index(k / per_box * nodes);
    arrays.nodes = index;
    for (std::int64_t k = 0; k < copies; ++k)
      for (std::int64_t group = 0; group < groups; ++group)
        node_start.push_back(k * per_box + layout.node_start[group]);
    node_start.push_back(copies * per_box);
    arrays.node_start = node_start.data();
    index_bytes = 4.0 * double(per_box) / double(slots);
    const Real* from = u.data();
    copy(from, 3 * nodes);
    x = const_cast<Real*>(from);
    double* out = arena.take<double>(static_cast<std::size_t>(copies * outputs(slots, nodes)) / sizeof(double));
    gradient = out;
    magnitude = out + copies * 3 * nodes;
    y = blocks = reinterpret_cast<Real*>(out);
    at = sum = reinterpret_cast<float*>(out);
  }

  // Other passes leave numbers of another kind where results go, among them ones that processors are slow at.
  void clear() { std::fill_n(gradient, copies * outputs(std::int64_t(elastic->layout().slots()), nodes) / 8, 0.0); }

  static std::int64_t outputs(std::int64_t slots, std::int64_t nodes) {
    return std::max({slots / 8 * kBlockNodes * 3 * std::int64_t{sizeof(float)}, nodes * 4 * std::int64_t{8},
                     nodes * 6 * std::int64_t{sizeof(Real)}}) /
               64 * 64 +
           64;
  }
};

template <class Real>
using Run = std::function<void(Copies<Real>&, std::int64_t begin, std::int64_t end)>;

// per_slot: bytes that a pass reads and writes per slot of a block; per_node: likewise. What it adds to counts twice.
template <class Real>
struct Pass {
  const char* kernel;
  const char* precision;  // of the arithmetic
  double per_slot, per_node, operations;
  Run<Real> run;
};

constexpr double kBlockValues = 4.0 * 3 * kBlockNodes / kBlockCells;  // [27][3][lane] of a slot, float

template <class Real>
std::vector<Pass<Real>> passes(InstructionSet set) {
  constexpr double r = sizeof(Real);
  const PassOperations count = count_pass_operations();
  const bool is_float = sizeof(Real) == 4;
  const char* precision = is_float ? "float" : "double";
  std::vector<Pass<Real>> list;
  list.push_back({"product", precision, r * (kTangentFields + 1), 9 * r, count.product,
                  [](Copies<Real>& c, std::int64_t begin, std::int64_t end) {
                    c.elastic->kernels().multiply(c.arrays, begin, end, c.x, c.y);
                  }});
  const double evaluated = r * (8 + 3 + 2), forces = 3 * r + 2 * 4 * sizeof(double);
  list.push_back({"evaluate", "double", evaluated, forces, count.evaluate,
                  [](Copies<Real>& c, std::int64_t begin, std::int64_t end) {
                    StateSums sums;
                    c.elastic->kernels().evaluate(c.arrays, begin, end, c.x, c.gradient, c.magnitude, sums);
                    benchmark::DoNotOptimize(sums);
                  }});
  if (!is_float) return list;
  list.push_back({"stress_derivative", precision, r * (3 + 1 + 12), 0.0, count.stress_derivative,
                  [](Copies<Real>& c, std::int64_t begin, std::int64_t end) {
                    c.elastic->kernels().linearize(c.arrays, begin, end, PsdProjection::kClamp);
                  }});
  list.push_back({"diagonal", precision, r * (kTangentFields + 1), 12 * r, count.diagonal,
                  [](Copies<Real>& c, std::int64_t begin, std::int64_t end) {
                    c.elastic->kernels().diagonal(c.arrays, begin, end, c.blocks);
                  }});
  if constexpr (sizeof(Real) == 4) {
    const CellKernels parts = cell_kernels(set);
    list.push_back(
        {"gather", precision, kBlockValues, 3 * r, 0.0, [parts](Copies<Real>& c, std::int64_t begin, std::int64_t end) {
           parts.gather(c.arrays, begin, end, c.x, c.at);
         }});
    // x takes the place of what is added to: the sums lie where y would, and are zero
    list.push_back({"scatter", precision, kBlockValues, 6 * r, 3.0 * kBlockNodes / kBlockCells,
                    [parts](Copies<Real>& c, std::int64_t begin, std::int64_t end) {
                      parts.scatter(c.arrays, begin, end, c.sum, c.x);
                    }});
  }
  return list;
}

template <class Real>
void enlist_precision(InstructionSet set, Arena& arena) {
  for (const Mode mode : {Mode::kCache, Mode::kStream}) {
    // The boxes last from one kernel to the next of the same set and mode.
    auto boxes = std::make_shared<std::optional<Copies<Real>>>();
    const std::string owner = std::string(sizeof(Real) == 4 ? "float" : "double") + "/" + std::string(name(set)) + "/" +
                              std::string(name(mode));
    for (const auto& pass : passes<Real>(set)) {
      // A double session evaluates in double as well: its arithmetic is told by its name, what it stores by this one.
      const std::string kernel =
          std::string(pass.kernel) == "evaluate" && sizeof(Real) == 8 ? "evaluate_stored_double" : pass.kernel;
      enlist(kernel, pass.precision, name(set), mode,
             [&arena, set, mode, boxes, owner, pass, walk = Walk{mode}](benchmark::State& state) mutable {
               if (arena.claim(owner) || !boxes->has_value()) boxes->emplace(set, mode, arena);
               auto& work = boxes->value();
               walk.items = work.copies * work.groups;
               walk.cells = double(work.lattice->cell_nodes.size()) / double(work.groups);
               // what touches nodes reads their indices
               const double per_slot = pass.per_slot + (pass.per_node > 0.0 ? work.index_bytes : 0.0);
               walk.bytes = per_slot * work.slots_per_cell + pass.per_node * work.nodes_per_cell;
               walk.operations = pass.operations;
               work.clear();
               walk.measure(state, [&](std::int64_t begin, std::int64_t end) {
                 pass.run(work, begin, end);
                 benchmark::ClobberMemory();
               });
             });
    }
  }
}

}  // namespace

void enlist_passes(Arena& arena) {
  for (const InstructionSet set : available_instruction_sets()) {
    enlist_precision<float>(set, arena);
    enlist_precision<double>(set, arena);
  }
}

void enlist_threads() {
  auto lattice = std::make_shared<const Lattice>(paper_sized_box());
  const InstructionSet set = choose_instruction_set();
  const int all = int(std::thread::hardware_concurrency());
  for (const int threads : {1, 2, 4, 8, 16}) {
    if (threads > all) break;
    auto* entry = benchmark::RegisterBenchmark(
        ("product_50000/float/" + std::string(name(set)) + "/cache/threads:" + std::to_string(threads)).c_str(),
        [lattice, set, threads](benchmark::State& state) {
          Elastic<float> elastic(*lattice, tissue(), 1, set);
          const auto u = displacements<float>(*lattice);
          std::vector<double> force(u.size()), scale(u.size() / 3);
          std::vector<float> y(u.size());
          elastic.evaluate(u, force, scale);
          elastic.linearize(PsdProjection::kClamp);
          tbb::task_arena workers(threads);
          workers.execute([&] {
            elastic.multiply(u, y);
            for (auto _ : state) elastic.multiply(u, y);
          });
          state.counters["cells"] = double(lattice->cell_nodes.size());
          state.counters["threads_used"] = threads;
        });
    entry->UseRealTime();
  }
}

}  // namespace lappet
