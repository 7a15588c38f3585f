#include "force/elastic/elastic.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "force/kernels/projected_stiffness_kernel.h"
#include "force/kernels/state_kernel.h"
#include "force/materials/material_models.h"
#include "force/materials/prestretch.h"
#include "lattice/refused.h"
#include "math/features.h"
#include "math/parallel.h"

namespace lappet {

namespace {

SceneFeatures features_of(const CellMaterials& materials, int quadrature) {
  SceneFeatures features;
  features.model = MaterialModels::index(materials.table.at(0).model);
  if (features.model < 0)
    throw std::invalid_argument("there is no material model \"" + materials.table[0].model + "\"");
  features.one_point = quadrature == 1;
  for (const auto& material : materials.table) {
    if (material.model != materials.table[0].model)
      throw std::invalid_argument("the materials of one tissue must have the same model; \"" + material.model +
                                  "\" and \"" + materials.table[0].model + "\" are mixed");
    features.fibers = features.fibers || material.has_fibers() || material.has_muscle();
    features.prestretched = features.prestretched || material.has_prestretch();
  }
  features.shares = !materials.shares.empty();
  return features;
}

SceneFeatures without_shares(SceneFeatures features) {
  features.shares = false;
  return features;
}

std::vector<Index> further_parts(const CellMaterials& materials) {
  std::vector<Index> cells;
  for (std::size_t k = 1; k < materials.shares.size(); ++k)
    if (materials.shares[k].cell == materials.shares[k - 1].cell) cells.push_back(materials.shares[k].cell);
  return cells;
}

// The hourglass modes of a small part of a cell keep at least this much of the stabilization of a whole one, chosen:
// they alone hold the corners far from it.
constexpr double kMinHourglass = 0.25;

// What of the stabilization the hourglass modes xy, xz, yz, xyz of a part of a cell have. The modes are what bends a
// layer a cell thick: one of them, xz of the displacement along x, bends a part with the extents s along the axes like
// a beam if it holds E s_z^2 = 2 mu (1 + nu) s_z^2, where the stabilization gives 2 mu laplacian. It serves the
// displacement along z as well, so that the thinner of the two directions bends.
std::array<double, 4> hourglass_of_part(const MaterialShare& share, const MaterialParameters& material,
                                        double laplacian) {
  const Vec3 s = share.scale.cast<double>();
  if (s == Vec3::Ones()) return {1.0, 1.0, 1.0, 0.5};
  const auto of_pair = [&](Eigen::Index a, Eigen::Index b) {
    const double thin = std::min(s[a], s[b]);
    return std::clamp((1.0 + material.poissons_ratio) / laplacian * thin * thin, kMinHourglass, 1.0);
  };
  const double xy = of_pair(0, 1), xz = of_pair(0, 2), yz = of_pair(1, 2);
  return {xy, xz, yz, 0.5};
}

}  // namespace

template <class Real>
Elastic<Real>::Elastic(const Lattice& lattice, CellMaterials materials, int quadrature, InstructionSet set,
                       std::span<const std::uint8_t> still, const Interrupt& interrupt)
    : lattice_(lattice),
      materials_(std::move(materials)),
      features_(features_of(materials_, quadrature)),
      set_(set),
      kernels_(elastic_kernels<Real>(set, features_)),
      whole_kernels_(elastic_kernels<Real>(set, without_shares(features_))),
      part_cells_(further_parts(materials_)),
      layout_(lay_out_blocks(lattice, kernels_.lanes, still, part_cells_, interrupt)),
      quadrature_(quadrature_points(quadrature)),
      uniform_(materials_.of_cell.empty() && materials_.normal_of_cell.empty() &&
               materials_.direction_of_cell.empty() && materials_.stretch_of_cell.empty()),
      record_fields_(features_.prestretched ? kMaterialFields
                     : features_.fibers     ? kPrestretch
                                            : kFiberK1) {
  if (!kHasHeterogeneity && (!uniform_ || features_.shares))
    throw RefusedError(ErrorCode::kInvalidInput,
                       "this daemon was built without heterogeneity, and the tissue's cells differ");
  for (const auto& point : quadrature_) {
    for (const double g : point.gradient) gradients_.push_back(4.0 * g);
    for (const double x : point.position) positions_.push_back(2.0 * x - 1.0);
    weights_.push_back(point.weight);
  }
  const std::size_t slots = layout_.slots(), points = quadrature_.size();
  interrupt.check();
  volume_.assign(slots, Real(0));
  if (features_.one_point) stabilization_.assign(slots, Real(0));
  tangent_.assign(slots * points * kTangentFields, Real(0));
  sigma_.assign(slots * points * 3, Real(1));
  if (features_.fibers) fiber_tangent_.assign(slots * points * kFiberFields, Real(0));
  interrupt.check();
  fill_cells();
  arrays_.points = int(points);
  arrays_.spacing = lattice.settings.spacing;
  arrays_.gradients = gradients_.data();
  arrays_.positions = positions_.data();
  arrays_.weights = weights_.data();
  arrays_.nodes = layout_.nodes.data();
  arrays_.node_start = layout_.node_start.data();
  arrays_.volume = volume_.data();
  arrays_.stabilization = stabilization_.data();
  arrays_.material = material_.data();
  arrays_.material_stride = uniform_ ? 0 : std::int64_t(record_fields_) * layout_.lanes;
  arrays_.share = share_.empty() ? nullptr : share_.data();
  arrays_.tangent = tangent_.data();
  arrays_.sigma = sigma_.data();
  arrays_.fiber_tangent = fiber_tangent_.data();
}

template <class Real>
std::pair<MaterialParameters, double> Elastic<Real>::material_in(std::size_t material, std::size_t cell) const {
  std::pair<MaterialParameters, double> result{materials_.table[material], third_prestretch_[material]};
  auto& [m, third] = result;
  if (!materials_.normal_of_cell.empty()) m.fiber_direction = direction_in_plane(m, normal_of(cell));
  if (!materials_.direction_of_cell.empty() && !materials_.direction_of_cell[cell].isZero())
    m.fiber_direction = materials_.direction_of_cell[cell].template cast<double>();
  if (m.has_prestretch() && !materials_.stretch_of_cell.empty()) {
    const Eigen::Vector2f& stretch = materials_.stretch_of_cell[cell];
    m.prestretch = {double(stretch[0]), double(stretch[1])};
    third = free_prestretch(m);
  }
  return result;
}

template <class Real>
void Elastic<Real>::fill_record(Real* record, std::size_t stride, std::size_t material, std::size_t cell,
                                int family) const {
  const auto [m, third] = material_in(material, cell);
  const auto put = [&](int field, double value) { record[field * stride] = Real(value); };
  put(kMu, m.mu());
  put(kLambda, m.lambda());
  put(kMooney, m.mooney_ratio);
  if (record_fields_ == kFiberK1) return;
  put(kFiberK1, m.fiber_k1);
  put(kFiberK2, m.fiber_k2);
  put(kFiberDispersion, m.fiber_dispersion);
  put(kFiberThreshold, m.fiber_slack * m.fiber_slack - 1.0);
  put(kMuscle, muscle(material));
  const Vec3 direction = m.fiber_direction.normalized(), normal = normal_of(cell);
  const Vec3 own = direction_of_family(m, normal, family);
  for (int i = 0; i < 3; ++i) put(kFiberDirection + i, own[i]);
  if (!features_.prestretched) return;
  const bool upright = normal.cross(direction).norm() < 1e-3;
  const Eigen::Matrix3d a = prestretch_matrix(m, upright ? direction.unitOrthogonal() : normal, third);
  int k = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j, ++k) put(kPrestretch + k, a(i, j));
}

template <class Real>
void Elastic<Real>::fill_cells() {
  const std::size_t lanes = layout_.lanes;
  material_.assign((uniform_ ? 1 : layout_.slots() / lanes) * record_fields_ * lanes, Real(0));
  for (const auto& material : materials_.table) third_prestretch_.push_back(free_prestretch(material));
  if (uniform_)
    for (std::size_t lane = 0; lane < lanes; ++lane) fill_record(&material_[lane], lanes, 0, 0);
  double laplacian = 0.0;
  MaterialModels::with(features_.model, [&]<class Model>() { laplacian = Model::kLaplacian; });
  for_each_index(layout_.slots(), [&](std::size_t slot) {
    const Index cell = layout_.cell_of_slot[slot];
    const std::size_t c = std::max(cell, 0);
    if (!uniform_)
      fill_record(&material_[slot / lanes * record_fields_ * lanes + slot % lanes], lanes, material_of(c), c);
    if (cell >= 0) fill_volume(slot, c, material_of(c), laplacian, 1.0);
  });
  if (!materials_.shares.empty()) fill_shares(laplacian);
}

template <class Real>
void Elastic<Real>::fill_volume(std::size_t slot, std::size_t cell, std::size_t material, double laplacian,
                                double part) {
  const double h = lattice_.settings.spacing, volume = h * h * h * double(lattice_.cell_fill[cell]) * part;
  volume_[slot] = Real(volume);
  if (features_.one_point)
    stabilization_[slot] = Real(laplacian * materials_.table[material].mu() * volume * kHourglass[0] / (h * h));
}

template <class Real>
template <class Body>
void Elastic<Real>::for_each_share(const Body& body) const {
  const auto& shares = materials_.shares;
  for (std::size_t k = 0, part = 0; k < shares.size(); ++k) {
    const bool further = k > 0 && shares[k].cell == shares[k - 1].cell;
    const Index slot = further ? layout_.slot_of_part[part++] : layout_.slot_of_cell[shares[k].cell];
    if (slot >= 0) body(std::size_t(slot), shares[k], further);
  }
}

template <class Real>
void Elastic<Real>::fill_shares(double laplacian) {
  const std::size_t lanes = layout_.lanes;
  share_.assign(layout_.slots() * kShareFields, Real(0));
  const auto field = [&](std::size_t slot, std::size_t k) -> Real& {
    return share_[(slot / lanes * kShareFields + k) * lanes + slot % lanes];
  };
  for (std::size_t slot = 0; slot < layout_.slots(); ++slot) {
    for (std::size_t i = 0; i < 3; ++i) field(slot, kShareScale + i) = Real(1);
    for (std::size_t m = 0; m < 4; ++m) field(slot, kShareHourglass + m) = Real(m == 3 ? 0.5 : 1.0);
  }
  group_has_shares_.assign(layout_.groups, 0);
  for_each_share([&](std::size_t slot, const MaterialShare& share, bool) {
    group_has_shares_[slot / lanes / kBlockCells] = 1;
    for (Eigen::Index i = 0; i < 3; ++i) {
      field(slot, kShareCenter + i) = Real(share.center[i]);
      field(slot, kShareScale + i) = Real(share.scale[i]);
    }
    const auto hourglass = hourglass_of_part(share, materials_.table[share.material], laplacian);
    for (std::size_t m = 0; m < 4; ++m) field(slot, kShareHourglass + m) = Real(hourglass[m]);
    if (!uniform_)
      fill_record(&material_[slot / lanes * record_fields_ * lanes + slot % lanes], lanes, share.material, share.cell,
                  share.family);
    fill_volume(slot, share.cell, share.material, laplacian, double(share.volume));
  });
}

template <class Real>
void Elastic<Real>::set_activation(std::span<const double> activation) {
  if (!features_.fibers) return;
  activation_.assign(activation.begin(), activation.end());
  arrays_.active = false;
  for (std::size_t m = 0; m < materials_.table.size(); ++m) arrays_.active = arrays_.active || muscle(m) > 0.0;
  const std::size_t lanes = layout_.lanes;
  for (std::size_t slot = 0; slot < (uniform_ ? lanes : layout_.slots()); ++slot) {
    const std::size_t cell = std::max(layout_.cell_of_slot[slot], 0);
    material_[(slot / lanes * record_fields_ + kMuscle) * lanes + slot % lanes] =
        Real(muscle(uniform_ ? 0 : material_of(cell)));
  }
  if (uniform_) return;
  for_each_share([&](std::size_t slot, const MaterialShare& share, bool) {
    material_[(slot / lanes * record_fields_ + kMuscle) * lanes + slot % lanes] = Real(muscle(share.material));
  });
}

template <class Real>
ElasticState Elastic<Real>::evaluate(std::span<const Real> u, std::span<double> gradient,
                                     std::span<double> node_scale) {
  for_each_index(lattice_.node_rest.size(), [&](std::size_t n) {
    gradient[3 * n] = gradient[3 * n + 1] = gradient[3 * n + 2] = 0.0;
    node_scale[n] = 0.0;
  });
  std::vector<StateSums> sums(layout_.slabs());
  layout_.for_each_slab([&](std::size_t slab, std::int64_t begin, std::int64_t end) {
    for_each_run(begin, end, [&](const auto& kernels, std::int64_t from, std::int64_t to) {
      kernels.evaluate(arrays_, from, to, u.data(), gradient.data(), node_scale.data(), sums[slab]);
    });
  });
  ElasticState state;
  state.minimum_j = std::numeric_limits<double>::infinity();
  for (const auto& sum : sums) {
    state.energy += sum.energy;
    state.minimum_j = std::min(state.minimum_j, sum.minimum_j);
    state.inverted += sum.inverted;
  }
  return state;
}

template <class Real>
void Elastic<Real>::linearize(PsdProjection how) {
  layout_.for_each_slab(
      [&](std::size_t, std::int64_t begin, std::int64_t end) { kernels_.linearize(arrays_, begin, end, how); });
}

template <class Real>
void Elastic<Real>::multiply(std::span<const Real> x, std::span<Real> y) const {
  for_each_chunk(y.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    std::fill(y.begin() + begin, y.begin() + end, Real(0));
  });
  layout_.for_each_slab([&](std::size_t, std::int64_t begin, std::int64_t end) {
    for_each_run(begin, end, [&](const auto& kernels, std::int64_t from, std::int64_t to) {
      kernels.multiply(arrays_, from, to, x.data(), y.data());
    });
  });
}

template <class Real>
void Elastic<Real>::set_cell_quadratics(std::span<const Index> of_cell, std::span<const Real> matrices) {
  quadratic_of_.clear();
  quadratics_.clear();
  arrays_.quadratic_of = nullptr;
  if (of_cell.empty()) return;
  const std::size_t lanes = layout_.lanes;
  quadratic_of_.assign(layout_.slots() / lanes, -1);
  for (std::size_t slot = 0; slot < layout_.slots(); ++slot) {
    const Index cell = layout_.cell_of_slot[slot];
    if (cell < 0 || of_cell[cell] < 0) continue;
    auto& index = quadratic_of_[slot / lanes];
    if (index < 0) {
      index = to_index(quadratics_.size() / (36 * lanes));
      quadratics_.resize(quadratics_.size() + 36 * lanes, Real(0));
    }
    const Real* matrix = &matrices[offset_of(64, of_cell[cell])];
    Real* entry = &quadratics_[offset_of(36 * lanes, index) + slot % lanes];
    for (std::size_t a = 0; a < 8; ++a)
      for (std::size_t b = a; b < 8; ++b, entry += lanes) *entry = matrix[8 * a + b];
  }
  if (quadratics_.empty()) return;
  arrays_.quadratic_of = quadratic_of_.data();
  arrays_.quadratics = quadratics_.data();
}

template <class Real>
void Elastic<Real>::diagonal_blocks(std::span<Real> blocks) const {
  for_each_index(blocks.size(), [&](std::size_t i) { blocks[i] = Real(0); });
  layout_.for_each_slab([&](std::size_t, std::int64_t begin, std::int64_t end) {
    for_each_run(begin, end, [&](const auto& kernels, std::int64_t from, std::int64_t to) {
      kernels.diagonal(arrays_, from, to, blocks.data());
    });
  });
}

template <class Real>
void Elastic<Real>::add_projected_stiffness(std::span<const Index> cells, const Real* weights, const Real* arms,
                                            Real* blocks) const {
  std::array<std::int32_t, kProjectionLanes> slots;
  for (std::size_t lane = 0; lane < slots.size(); ++lane)
    // A cell that is not computed has no weight: any slot will do.
    slots[lane] = std::max(layout_.slot_of_cell[cells[std::min(lane, cells.size() - 1)]], 0);
  kernels_.project(arrays_, slots.data(), weights, arms, blocks);
  if (part_cells_.empty()) return;
  alignas(64) Real own[64 * kProjectionLanes];
  for (Index nth = 0;; ++nth) {  // the further parts of these cells, with the weights of those that have one
    std::copy_n(weights, 64 * kProjectionLanes, own);
    bool any = false;
    for (std::size_t lane = 0; lane < slots.size(); ++lane) {
      const auto parts = std::ranges::equal_range(part_cells_, lane < cells.size() ? cells[lane] : -1);
      const bool has = nth < std::ssize(parts) && layout_.slot_of_part[parts.begin() - part_cells_.begin() + nth] >= 0;
      any = any || has;
      if (has)
        slots[lane] = layout_.slot_of_part[parts.begin() - part_cells_.begin() + nth];
      else
        for (std::size_t k = 0; k < 64; ++k) own[k * kProjectionLanes + lane] = Real(0);
    }
    if (!any) return;
    kernels_.project(arrays_, slots.data(), own, arms, blocks);
  }
}

template <class Real>
CellMeasures Elastic<Real>::measures(Index cell, std::span<const Real> u) const {
  const Index slot = layout_.slot_of_cell[cell];
  const bool fixed = slot < 0;
  const int lanes = fixed ? 1 : layout_.lanes;
  const std::size_t place = fixed ? 0 : slot / lanes;
  const std::size_t lane = fixed ? 0 : slot % lanes;
  const std::size_t width = lanes;
  Real own[kMaterialFields] = {};
  const Real* material = own;
  if (fixed)
    fill_record(own, 1, material_of(cell), cell);
  else
    material = &material_[(uniform_ ? 0 : place) * record_fields_ * width + lane];

  double rotation_u[9], rotation_v[9], sigma[3], p_hat[3];
  if (!fixed && arrays_.points == 1 && !features_.fibers) {
    for (std::size_t i = 0; i < 3; ++i) sigma[i] = double(sigma_[(3 * place + i) * width + lane]);
  } else {
    double f[9];
    deformation_gradient(cell, u, f);
    if (features_.prestretched) {
      double a[9], unstretched[9];
      load_symmetric3<double>(material + kPrestretch * lanes, a, lanes);
      std::copy(std::begin(f), std::end(f), unstretched);
      multiply3(unstretched, a, f);
    }
    svd3(f, rotation_u, sigma, rotation_v);
  }
  MaterialModels::with(features_.model,
                       [&]<class Model>() { Model::p_hat(sigma, load_moduli<double>(material, lanes), p_hat); });
  // Cauchy stress in the frame of the decomposition: P F^T / J
  const double j = std::max(sigma[0] * sigma[1] * sigma[2], 1e-6);
  double principal[3];
  for (int i = 0; i < 3; ++i) principal[i] = sigma[i] * p_hat[i] / j;
  if (features_.fibers) {
    Eigen::Matrix3d stress = Eigen::Vector3d(principal[0], principal[1], principal[2]).asDiagonal();
    const auto shares = materials_.shares_of(cell);
    if (shares.empty() || shares[0].family == 0) {
      stress += fiber_stress(material, lanes, sigma, rotation_v);
    } else {
      for (const int family : {1, -1}) {
        Real record[kMaterialFields] = {};
        fill_record(record, 1, material_of(cell), cell, family);
        stress += 0.5 * fiber_stress(record, 1, sigma, rotation_v);
      }
    }
    const double packed[6] = {stress(0, 0), stress(0, 1), stress(0, 2), stress(1, 1), stress(1, 2), stress(2, 2)};
    double axes[9];
    symmetric_eigen3(packed, principal, axes);
  }
  const double d01 = principal[0] - principal[1], d12 = principal[1] - principal[2], d20 = principal[2] - principal[0];
  return {sigma[0], std::sqrt(0.5 * (d01 * d01 + d12 * d12 + d20 * d20)),
          std::max({principal[0], principal[1], principal[2]})};
}

template <class Real>
Eigen::Matrix3d Elastic<Real>::fiber_stress(const Real* record, int lanes, const double (&sigma)[3],
                                            const double (&rotation_v)[9]) const {
  const double j = std::max(sigma[0] * sigma[1] * sigma[2], 1e-6);
  const auto fiber = fiber_state(record, lanes, sigma, rotation_v);
  const auto response = fiber_response(fiber.i1, fiber.i4, fiber.j, load_fiber<double>(record, lanes, arrays_.active));
  Eigen::Matrix3d stress = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    stress(i, i) += (response.shear * sigma[i] + response.pressure * fiber.c[i]) * sigma[i] / j;
    for (int k = 0; k < 3; ++k) stress(i, k) += response.along * fiber.fa[i] * fiber.fa[k] / j;
  }
  return stress;
}

template <class Real>
void Elastic<Real>::deformation_gradient(Index cell, std::span<const Real> u, double* f) const {
  const auto shares = materials_.shares_of(cell);
  const Eigen::Vector3f at = shares.empty() ? Eigen::Vector3f::Zero() : shares[0].center;
  const QuadraturePoint center =
      quadrature_point(0.5 + 0.5 * double(at[0]), 0.5 + 0.5 * double(at[1]), 0.5 + 0.5 * double(at[2]), 1.0);
  const auto& nodes = lattice_.cell_nodes[cell];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      double sum = 0.0;
      for (std::size_t k = 0; k < 8; ++k) sum += double(u[offset_of(3, nodes[k]) + i]) * center.gradient[8 * j + k];
      f[3 * i + j] = sum / lattice_.settings.spacing + (i == j ? 1.0 : 0.0);
    }
}

template <class Real>
std::size_t Elastic<Real>::bytes() const {
  const std::size_t numbers = volume_.size() + stabilization_.size() + material_.size() + share_.size() +
                              tangent_.size() + sigma_.size() + fiber_tangent_.size() + quadratics_.size();
  return numbers * sizeof(Real) + 8 * layout_.node_start.size() +
         4 * (layout_.nodes.size() + layout_.cell_of_slot.size() + layout_.slot_of_cell.size() + quadratic_of_.size());
}

template class Elastic<float>;
template class Elastic<double>;

}  // namespace lappet
