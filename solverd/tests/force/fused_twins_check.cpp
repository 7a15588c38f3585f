#include "fused_twins_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>
#include <random>

#include "force/kernels/cell_corners.h"
#include "force/kernels/quadrature.h"
#include "force/kernels/state_kernel.h"
#include "force/materials/fiber.h"
#include "math/index.h"

namespace lappet {

namespace {

constexpr double kSpacing = 0.7;
constexpr double kMaxK2 = 20.0;
constexpr int kBlocksX = 5, kBlocksY = 3, kBlocksZ = 2, kBlocks = kBlocksX * kBlocksY * kBlocksZ;

template <class T>
class AlignedArray {
 public:
  explicit AlignedArray(std::size_t size, T value = T(0)) : size_(size) {
    data_.reset(static_cast<T*>(::operator new(size * sizeof(T), kAlignment)));
    std::fill_n(data_.get(), size, value);
  }
  T* data() { return data_.get(); }
  T& operator[](std::size_t i) { return data_.get()[i]; }
  std::size_t size() const { return size_; }

 private:
  static constexpr std::align_val_t kAlignment{64};
  struct Free {
    void operator()(T* p) const { ::operator delete(p, kAlignment); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t size_;
};

// The scene without lanes: 30 blocks of a grid, a sixth of whose blocks have copies of half of their nodes, as at a
// wound, and a tenth of whose cells are missing. Those whose nodes are columns of the grid come first in `order`.
struct Blocks {
  std::vector<std::array<std::int32_t, kBlockNodes>> nodes;
  std::vector<std::array<double, 3>> rest;
  std::vector<std::array<double, kBlockCells>> volume;
  std::vector<std::array<double, kBlockCells * kMaterialFields>> material;
  std::vector<std::array<double, kBlockCells * kShareFields>> share;
  std::vector<std::array<double, 36>> quadratics;
  std::vector<std::size_t> order;
  std::size_t on_grid = 0;  // how many
  std::vector<std::array<std::int32_t, kBlockCells>> quadratic_of;
};

Blocks make_blocks(const FusedScene& scene) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Blocks b;
  const int ny = 2 * kBlocksY + 1, nz = 2 * kBlocksZ + 1;
  for (int x = 0; x <= 2 * kBlocksX; ++x)
    for (int y = 0; y < ny; ++y)
      for (int z = 0; z < nz; ++z) b.rest.push_back({kSpacing * x, kSpacing * y, kSpacing * z});
  const auto describe_cell = [&](double* m) {
    const double poisson = 0.1 + 0.35 * unit(random);
    m[kMu] = 1.0 + 10.0 * unit(random);
    m[kLambda] = 2 * m[kMu] * poisson / (1 - 2 * poisson);
    m[kMooney] = unit(random);
    if (scene.features.fibers) {
      m[kFiberK1] = 3.0 * unit(random);
      m[kFiberK2] = kMaxK2 * unit(random);
      m[kFiberDispersion] = unit(random) / 3;
      m[kFiberThreshold] = unit(random) < 0.5 ? 0.0 : 0.5 * unit(random);
      m[kMuscle] = 10.0 * unit(random);
    }
    const double angle = 6.3 * unit(random), height = 2 * unit(random) - 1, flat = std::sqrt(1 - height * height);
    m[kFiberDirection] = flat * std::cos(angle);
    m[kFiberDirection + 1] = flat * std::sin(angle);
    m[kFiberDirection + 2] = height;
    const double stretch[6] = {1.15, 0.05, -0.02, 0.9, 0.03, 1.0};
    for (std::size_t i = 0; i < 6; ++i)
      m[kPrestretch + i] = scene.features.prestretched ? stretch[i] + 0.05 * unit(random) : 0.0;
  };
  std::array<double, kMaterialFields> all{};
  describe_cell(all.data());
  for (int block = 0; block < kBlocks; ++block) {
    const int x = block / (kBlocksY * kBlocksZ), y = block / kBlocksZ % kBlocksY, z = block % kBlocksZ;
    std::array<std::int32_t, kBlockNodes> nodes{};
    for (int n = 0; n < kBlockNodes; ++n) nodes[n] = ((2 * x + n / 9) * ny + 2 * y + n / 3 % 3) * nz + 2 * z + n % 3;
    if (block % 6 == 1)
      for (auto& node : nodes) {
        if (unit(random) < 0.5) continue;
        b.rest.push_back(b.rest[node]);
        node = to_index(b.rest.size()) - 1;
      }
    std::array<double, kBlockCells> volume{};
    std::array<double, kBlockCells * kMaterialFields> material{};
    std::array<double, kBlockCells * kShareFields> share{};
    std::array<std::int32_t, kBlockCells> quadratic{};
    std::array<bool, kBlockNodes> used{};
    std::int32_t any = -1;
    for (int place = 0; place < kBlockCells; ++place) {
      const std::size_t p = place;
      quadratic[p] = -1;
      for (std::size_t k = 0; k < 3; ++k) {  // a part of the cell that reaches from one side to somewhere
        const double extent = unit(random) < 0.3 ? 1.0 : 0.1 + 0.9 * unit(random);
        share[p * kShareFields + kShareCenter + k] = (unit(random) < 0.5 ? -1.0 : 1.0) * (1.0 - extent);
        share[p * kShareFields + kShareScale + k] = extent;
      }
      for (std::size_t m = 0; m < 4; ++m) share[p * kShareFields + kShareHourglass + m] = unit(random);
      if (scene.mixed)
        describe_cell(&material[p * kMaterialFields]);
      else
        std::copy(all.begin(), all.end(), material.begin() + place * kMaterialFields);
      if (place > 0 && unit(random) < 0.1) continue;
      volume[p] = kSpacing * kSpacing * kSpacing * (0.1 + 0.9 * unit(random));
      for (int c = 0; c < 8; ++c) {
        const std::size_t n = block_node(place, c);
        used[n] = true;
        any = nodes[n];
      }
      if (unit(random) > 0.2) continue;
      quadratic[p] = to_index(b.quadratics.size());
      std::array<double, 36> matrix{};
      for (double& value : matrix) value = 2 * unit(random) - 1;
      b.quadratics.push_back(matrix);
    }
    for (std::size_t n = 0; n < kBlockNodes; ++n)
      if (!used[n]) nodes[n] = any;
    b.nodes.push_back(nodes);
    b.volume.push_back(volume);
    b.material.push_back(material);
    b.share.push_back(share);
    b.quadratic_of.push_back(quadratic);
  }
  const auto on_grid = [&](std::size_t block) {
    for (std::size_t n = 0; n < kBlockNodes; ++n)
      if (b.nodes[block][n] != b.nodes[block][n / 3 * 3] + to_index(n % 3)) return false;
    return true;
  };
  for (std::size_t block = 0; block < kBlocks; ++block) b.order.push_back(block);
  const auto mesh = std::stable_partition(b.order.begin(), b.order.end(), on_grid);
  b.on_grid = static_cast<std::size_t>(mesh - b.order.begin());
  return b;
}

// The blocks in lockstep as ElasticArrays; every number is rounded to Rounded first.
template <class Real, class Rounded>
class Lockstep {
 public:
  Lockstep(const FusedScene& scene, const Blocks& b, int lanes)
      : groups((kBlocks + lanes - 1) / lanes),
        nodes_(size(kBlockNodes, lanes)),
        node_start_{0},
        quadratic_of_(size(kBlockCells, 1), -1),
        volume_(size(kBlockCells, lanes)),
        stabilization_(size(kBlockCells, lanes)),
        material_(scene.mixed ? size(kBlockCells * kMaterialFields, lanes)
                              : static_cast<std::size_t>(kMaterialFields * lanes)),
        share_(scene.mixed ? size(kBlockCells * kShareFields, lanes) : 0),
        tangent_(size(kBlockCells * kTangentFields * scene.points, lanes)),
        sigma_(size(kBlockCells * 3 * scene.points, lanes)),
        fiber_tangent_(size(kBlockCells * kFiberFields * scene.points, lanes)),
        quadratics_(size(kBlockCells * 36, lanes)) {
    const std::size_t w = lanes;
    const auto round = [](double x) { return Real(Rounded(x)); };
    std::int32_t matrices = 0;
    for (std::size_t slot = 0; slot < static_cast<std::size_t>(groups) * w; ++slot) {
      const std::size_t group = slot / w, lane = slot % w;
      const bool spare = slot >= kBlocks;
      const std::size_t block = b.order[spare ? group * w : slot];
      const bool grid = std::min((group + 1) * w, std::size_t{kBlocks}) <= b.on_grid;
      if (lane == 0) node_start_.push_back(node_start_.back() + (grid ? kBlockColumns : kBlockNodes) * lanes);
      const std::size_t start = node_start_[group];
      if (grid)
        for (std::size_t c = 0; c < kBlockColumns; ++c) nodes_[start + c * w + lane] = b.nodes[block][3 * c];
      else
        for (std::size_t n = 0; n < kBlockNodes; ++n) nodes_[start + n * w + lane] = b.nodes[block][n];
      for (std::size_t p = 0; p < kBlockCells; ++p) {
        const std::size_t place = group * kBlockCells + p;
        const double* material = &b.material[block][p * kMaterialFields];
        if (scene.mixed || slot < w)
          for (std::size_t f = 0; f < kMaterialFields; ++f)
            material_[((scene.mixed ? place : 0) * kMaterialFields + f) * w + lane] = round(material[f]);
        for (std::size_t f = 0; scene.mixed && f < kShareFields; ++f)
          share_[(place * kShareFields + f) * w + lane] = round(b.share[block][p * kShareFields + f]);
        if (spare) continue;
        volume_[place * w + lane] = round(b.volume[block][p]);
        stabilization_[place * w + lane] =
            round(material[kMu] * b.volume[block][p] * kHourglass[0] / (kSpacing * kSpacing));
        const std::int32_t matrix = b.quadratic_of[block][p];
        if (matrix < 0) continue;
        if (quadratic_of_[place] < 0) quadratic_of_[place] = matrices++;
        for (std::size_t e = 0; e < 36; ++e)
          quadratics_[(static_cast<std::size_t>(quadratic_of_[place]) * 36 + e) * w + lane] =
              round(b.quadratics[matrix][e]);
      }
    }
    for (const auto& point : quadrature_points(scene.points)) {
      for (const double g : point.gradient) gradients_.push_back(4.0 * g);
      for (const double x : point.position) positions_.push_back(2.0 * x - 1.0);
      weights_.push_back(point.weight);
    }
    arrays.points = scene.points;
    arrays.spacing = kSpacing;
    arrays.gradients = gradients_.data();
    arrays.positions = positions_.data();
    arrays.weights = weights_.data();
    arrays.nodes = nodes_.data();
    arrays.node_start = node_start_.data();
    arrays.volume = volume_.data();
    arrays.stabilization = stabilization_.data();
    arrays.material = material_.data();
    arrays.material_stride = scene.mixed ? std::int64_t{kMaterialFields} * lanes : 0;
    arrays.share = scene.mixed ? share_.data() : nullptr;
    arrays.tangent = tangent_.data();
    arrays.sigma = sigma_.data();
    arrays.fiber_tangent = fiber_tangent_.data();
    arrays.quadratic_of = quadratic_of_.data();
    arrays.quadratics = quadratics_.data();
  }
  Lockstep(const Lockstep&) = delete;
  Lockstep& operator=(const Lockstep&) = delete;

  std::int64_t groups;
  ElasticArrays<Real> arrays;
  AlignedArray<Real>& sigma() { return sigma_; }

 private:
  std::size_t size(int fields, int lanes) const {
    return static_cast<std::size_t>(groups) * static_cast<std::size_t>(fields) * static_cast<std::size_t>(lanes);
  }
  AlignedArray<std::int32_t> nodes_;
  std::vector<std::int64_t> node_start_;
  AlignedArray<std::int32_t> quadratic_of_;
  AlignedArray<Real> volume_, stabilization_, material_, share_, tangent_, sigma_, fiber_tangent_, quadratics_;
  std::vector<double> gradients_, positions_, weights_;
};

struct State {
  const char* name;
  bool generic;  // J keeps away from 0, so that inverted cells can be counted
  std::vector<double> u;
  bool at_rest = false;
};

std::vector<State> states_of(const Blocks& b, bool needles) {
  std::vector<State> states;
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto noise = [&](double amplitude) {
    std::vector<double> u(3 * b.rest.size());
    for (double& value : u) value = amplitude * uniform(random);
    return u;
  };
  const auto mapped = [&](const std::array<double, 9>& m) {
    std::vector<double> u;
    for (const auto& x : b.rest)
      for (std::size_t i = 0; i < 3; ++i)
        u.push_back(m[3 * i] * x[0] + m[3 * i + 1] * x[1] + m[3 * i + 2] * x[2] - x[i]);
    return u;
  };
  states.push_back({"rest", true, noise(0.0), true});
  states.push_back({"tiny", true, noise(1e-5), true});
  states.push_back({"random", true, noise(0.15)});
  states.push_back({"inverted", false, noise(1.2)});
  states.push_back({"swollen", true, mapped({1.7, 0, 0, 0, 1.7, 0, 0, 0, 1.7})});
  const double c = std::cos(2.0), s = std::sin(2.0);
  states.push_back({"turned", true, mapped({c, -1.3 * s, 0, s, 1.3 * c, 0, 0, 0, 1.3})});
  states.push_back({"flat", false, mapped({1, 0, 0, 0, 1, 0, 0, 0, 0})});
  states.push_back({"nearly flat", false, mapped({1.1, 0.2, 0, 0, 1, 0.1, 0, 0, 1e-5})});
  states.push_back({"mirrored", true, mapped({1, 0.1, 0, 0, 1.2, 0.3, 0, 0, -0.8})});
  if (needles) states.push_back({"needle", false, mapped({1, 0, 0, 0, 0, 0, 0, 0, 0})});
  return states;
}

double largest(const std::vector<double>& values) {
  double most = 0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}
template <class Real>
double largest_difference(const std::vector<Real>& got, const std::vector<double>& expected) {
  double most = 0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    const double difference = std::abs(double(got[i]) - expected[i]);
    if (!(difference <= most)) most = difference;  // NaN stays
  }
  return most;
}

class Worst {
 public:
  Worst(const char* kernel, double tolerance) { result.kernel = kernel, result.tolerance = tolerance; }
  void add(double error, const std::string& where) {
    ++result.samples;
    if (error <= result.worst) return;
    result.worst = error == error ? error : std::numeric_limits<double>::infinity();
    result.where = where;
  }
  TwinResult result;
};

}  // namespace

std::vector<FusedScene> fused_scenes() {
  std::vector<FusedScene> scenes;
  for (int model = 0; model < MaterialModels::kCount; ++model)
    for (const int points : {1, 4, 8})
      for (int flags = 0; flags < 8; ++flags)
        scenes.push_back({{model, points == 1, (flags & 1) != 0, (flags & 2) != 0}, points, (flags & 4) != 0});
  return scenes;
}

std::string describe(const FusedScene& scene) {
  return std::string(MaterialModels::kNames[scene.features.model]) + ", " + std::to_string(scene.points) + " points" +
         (scene.features.fibers ? ", fibers and muscle" : "") + (scene.features.prestretched ? ", prestretch" : "") +
         (scene.mixed ? ", mixed" : "");
}

template <class Real>
std::vector<TwinResult> compare_fused_twins(const FusedScene& scene, const ElasticKernels<Real>& kernels,
                                            const ElasticKernels<double>& reference) {
  const Blocks blocks = make_blocks(scene);
  Lockstep<Real, Real> ours(scene, blocks, kernels.lanes);
  Lockstep<double, Real> exact(scene, blocks, reference.lanes);
  const std::size_t count = blocks.rest.size(), size = 3 * count;
  // See fiber_condition in kernel_twins_check.cpp: the property of the exponential, not of the arithmetic.
  const double fibers =
      scene.features.fibers ? std::max(1.0, 2.0 * std::sqrt(fiber_detail::kMaxExponent * kMaxK2)) : 1.0;
  const double tolerance = kTwinTolerance<Real> * fibers;
  Worst forces("forces and energies", kTwinTolerance<double> * fibers), product("tangent product", tolerance),
      diagonal("diagonal blocks", tolerance);
  for (const auto& state : states_of(blocks, scene.features.model != MaterialModels::index(Corotated::kName))) {
    std::vector<Real> u(size), x(size);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (std::size_t i = 0; i < size; ++i) u[i] = Real(state.u[i]);
    for (auto& value : x) value = Real(uniform(random));
    const std::vector<double> exact_u(u.begin(), u.end()), exact_x(x.begin(), x.end());

    std::vector<double> expected(size), expected_magnitude(count);
    StateSums expected_sums;
    reference.evaluate(exact.arrays, 0, exact.groups, exact_u.data(), expected.data(), expected_magnitude.data(),
                       expected_sums);
    double greatest = 1.0, condition = 1.0;
    for (std::size_t i = 0; i + 2 < exact.sigma().size(); i += 3) {
      const double* s = &exact.sigma()[i];
      greatest = std::max(greatest, s[0]);
      // The corotated energy has no second derivative where the two smallest stretches cancel.
      if (scene.features.model == MaterialModels::index(Corotated::kName))
        condition = std::max(condition, s[0] / std::max(s[1] + s[2], 1e-6));
    }
    // Forces are the difference of terms as large as the tangent times the size of the cell.
    std::vector<double> expected_blocks(6 * count);
    reference.linearize(exact.arrays, 0, exact.groups, PsdProjection::kExact);
    reference.diagonal(exact.arrays, 0, exact.groups, expected_blocks.data());
    const double force = std::max(largest(expected_blocks) * kSpacing * greatest, largest(expected_magnitude));
    const double energy = force * kSpacing * greatest * kBlocks;
    std::vector<double> gradient(size), magnitude(count);
    StateSums sums;
    kernels.evaluate(ours.arrays, 0, ours.groups, u.data(), gradient.data(), magnitude.data(), sums);
    forces.add(largest_difference(gradient, expected) / force, state.name);
    forces.add(largest_difference(magnitude, expected_magnitude) / force, state.name);
    forces.add(std::abs(sums.energy - expected_sums.energy) / energy, state.name);
    forces.add(std::abs(sums.minimum_j - expected_sums.minimum_j) / (greatest * greatest * greatest), state.name);
    if (state.generic) forces.add(std::abs(sums.inverted - expected_sums.inverted), state.name);
    // At rest fibers are about to become slack: which of their two stiffnesses holds turns on a rounding.
    if (state.at_rest && scene.features.fibers && !scene.features.prestretched) continue;
    for (const auto how : {PsdProjection::kExact, PsdProjection::kClamp, PsdProjection::kAbsolute}) {
      std::vector<Real> y(size), got_blocks(6 * count);
      std::vector<double> expected_y(size);
      std::fill(expected_blocks.begin(), expected_blocks.end(), 0.0);
      reference.linearize(exact.arrays, 0, exact.groups, how);
      reference.multiply(exact.arrays, 0, exact.groups, exact_x.data(), expected_y.data());
      reference.diagonal(exact.arrays, 0, exact.groups, expected_blocks.data());
      kernels.linearize(ours.arrays, 0, ours.groups, how);
      kernels.multiply(ours.arrays, 0, ours.groups, x.data(), y.data());
      kernels.diagonal(ours.arrays, 0, ours.groups, got_blocks.data());
      const std::string where = std::string(state.name) + (how == PsdProjection::kExact   ? ", exact"
                                                           : how == PsdProjection::kClamp ? ", clamp"
                                                                                          : ", absolute");
      product.add(largest_difference(y, expected_y) / (largest(expected_y) * condition), where);
      diagonal.add(largest_difference(got_blocks, expected_blocks) / (largest(expected_blocks) * condition), where);
    }
  }
  return {forces.result, product.result, diagonal.result};
}

template std::vector<TwinResult> compare_fused_twins(const FusedScene&, const ElasticKernels<float>&,
                                                     const ElasticKernels<double>&);
template std::vector<TwinResult> compare_fused_twins(const FusedScene&, const ElasticKernels<double>&,
                                                     const ElasticKernels<double>&);

}  // namespace lappet
