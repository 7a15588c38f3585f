#include "force/elastic.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <limits>

#include "math/parallel.h"
#include "math/svd3.h"

namespace lappet {

namespace {

// out = a b, a^T b, a b^T for row-major 3x3
template <class Number>
void multiply(const Number* a, const Number* b, Number* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}
template <class Number>
void multiply_transposed_left(const Number* a, const Number* b, Number* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out[3 * i + j] = a[i] * b[j] + a[3 + i] * b[3 + j] + a[6 + i] * b[6 + j];
}
template <class Number>
void multiply_transposed_right(const Number* a, const Number* b, Number* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out[3 * i + j] = a[3 * i] * b[3 * j] + a[3 * i + 1] * b[3 * j + 1] + a[3 * i + 2] * b[3 * j + 2];
}

}  // namespace

template <class Real>
Elastic<Real>::Elastic(const Lattice& lattice, const MaterialParameters& material, int quadrature)
    : lattice_(lattice),
      material_(material),
      mu_(material.mu()),
      lambda_(material.lambda()),
      laplacian_(quadrature == 1 ? (material.model == "corotated" ? Corotated::kLaplacian : NeoHookean::kLaplacian)
                                 : 0.0),
      quadrature_(quadrature_points(quadrature)) {
  const std::size_t cells = lattice.cell_nodes.size(), nodes = lattice.node_rest.size();
  const double inverse_h = 1.0 / lattice.settings.spacing;
  for (const auto& point : quadrature_)
    for (const double g : point.gradient) gradients_.push_back(static_cast<Real>(g * inverse_h));
  points_.resize(cells * quadrature_.size());
  sigma_.resize(cells * quadrature_.size());
  cell_gradient_.resize(24 * cells);
  cell_product_.resize(24 * cells);
  incidence_start_.assign(nodes + 1, 0);
  for (const auto& corners : lattice.cell_nodes)
    for (const std::int32_t n : corners) ++incidence_start_[static_cast<std::size_t>(n) + 1];
  for (std::size_t n = 0; n < nodes; ++n) incidence_start_[n + 1] += incidence_start_[n];
  incidence_.resize(8 * cells);
  std::vector<std::int32_t> next(incidence_start_.begin(), incidence_start_.end() - 1);
  for (std::size_t c = 0; c < cells; ++c)
    for (int k = 0; k < 8; ++k)
      incidence_[static_cast<std::size_t>(next[static_cast<std::size_t>(lattice.cell_nodes[c][k])]++)] =
          static_cast<std::int32_t>(8 * c) + k;
}

template <class Real>
double Elastic<Real>::cell_volume(std::size_t cell) const {
  const double h = lattice_.settings.spacing;
  return h * h * h * static_cast<double>(lattice_.cell_fill[cell]);
}

template <class Real>
template <class Model>
ElasticState Elastic<Real>::evaluate_cells(std::span<const Real> u) {
  const std::size_t cells = lattice_.cell_nodes.size(), point_count = quadrature_.size();
  const double h = lattice_.settings.spacing, inverse_h = 1.0 / h;
  std::vector<ElasticState> partial((cells + kChunk - 1) / kChunk);
  for_each_chunk(cells, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    ElasticState state;
    state.minimum_j = std::numeric_limits<double>::infinity();
    for (std::size_t c = begin; c < end; ++c) {
      const double volume = cell_volume(c);
      double x[24];  // displacements, component-major for the sums below
      for (int k = 0; k < 8; ++k)
        for (int i = 0; i < 3; ++i)
          x[8 * i + k] = static_cast<double>(u[3 * static_cast<std::size_t>(lattice_.cell_nodes[c][k]) + i]);
      double* out = &cell_gradient_[24 * c];
      std::fill_n(out, 24, 0.0);
      bool inverted = false;
      for (std::size_t q = 0; q < point_count; ++q) {
        const auto& point = quadrature_[q];
        double f[9], rotation_u[9], rotation_v[9], p_hat[3];
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) {
            double sum = 0.0;
            for (int k = 0; k < 8; ++k) sum += x[8 * i + k] * point.gradient[static_cast<std::size_t>(8 * j + k)];
            f[3 * i + j] = sum * inverse_h + (i == j ? 1.0 : 0.0);
          }
        double sigma[3];
        svd3(f, rotation_u, sigma, rotation_v);
        Model::p_hat(sigma, Moduli<double>{mu_, lambda_, 0.0}, p_hat);
        const double j = sigma[0] * sigma[1] * sigma[2];
        state.minimum_j = std::min(state.minimum_j, j);
        inverted = inverted || !(j > 0.0);
        state.energy += volume * point.weight * Model::energy(sigma, Moduli<double>{mu_, lambda_, 0.0});
        auto& stored = points_[c * point_count + q];
        for (int i = 0; i < 9; ++i) {
          stored.u[i] = static_cast<Real>(rotation_u[i]);
          stored.v[i] = static_cast<Real>(rotation_v[i]);
        }
        sigma_[c * point_count + q] = {sigma[0], sigma[1], sigma[2]};
        const double scale = volume * point.weight * inverse_h;
        for (int i = 0; i < 3; ++i) {
          double p[3];
          for (int jj = 0; jj < 3; ++jj)
            p[jj] = scale * (rotation_u[3 * i] * p_hat[0] * rotation_v[3 * jj] +
                             rotation_u[3 * i + 1] * p_hat[1] * rotation_v[3 * jj + 1] +
                             rotation_u[3 * i + 2] * p_hat[2] * rotation_v[3 * jj + 2]);
          for (int k = 0; k < 8; ++k) {
            const auto kk = static_cast<std::size_t>(k);
            out[3 * k + i] +=
                p[0] * point.gradient[kk] + p[1] * point.gradient[8 + kk] + p[2] * point.gradient[16 + kk];
          }
        }
      }
      if (laplacian_ != 0.0) {
        const double coefficient = laplacian_ * mu_ * volume * inverse_h * inverse_h;
        for (std::size_t m = 0; m < 4; ++m)
          for (int i = 0; i < 3; ++i) {
            double amplitude = 0.0;
            for (int k = 0; k < 8; ++k) amplitude += kHourglassModes[m][static_cast<std::size_t>(k)] * x[8 * i + k];
            const double force = coefficient * kHourglass[m] * amplitude;
            state.energy += 0.5 * force * amplitude;
            for (int k = 0; k < 8; ++k) out[3 * k + i] += force * kHourglassModes[m][static_cast<std::size_t>(k)];
          }
      }
      state.inverted += inverted ? 1 : 0;
    }
    partial[chunk] = state;
  });
  ElasticState total;
  total.minimum_j = std::numeric_limits<double>::infinity();
  for (const auto& state : partial) {
    total.energy += state.energy;
    total.minimum_j = std::min(total.minimum_j, state.minimum_j);
    total.inverted += state.inverted;
  }
  return total;
}

template <class Real>
ElasticState Elastic<Real>::evaluate(std::span<const Real> u, std::span<double> gradient,
                                     std::span<double> node_scale) {
  const ElasticState state =
      material_.model == "corotated" ? evaluate_cells<Corotated>(u) : evaluate_cells<NeoHookean>(u);
  for_each_index(lattice_.node_rest.size(), [&](std::size_t n) {
    double sum[3] = {0, 0, 0}, scale = 0.0;
    for (auto k = incidence_start_[n]; k < incidence_start_[n + 1]; ++k) {
      const double* g = &cell_gradient_[3 * static_cast<std::size_t>(incidence_[static_cast<std::size_t>(k)])];
      for (int i = 0; i < 3; ++i) sum[i] += g[i];
      scale += std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    }
    for (std::size_t i = 0; i < 3; ++i) gradient[3 * n + i] = sum[i];
    node_scale[n] = scale;
  });
  return state;
}

template <class Real>
template <class Model>
void Elastic<Real>::linearize_cells(Definiteness how) {
  const double floor = 1e-4 * mu_;
  for_each_index(points_.size(), [&](std::size_t p) {
    TangentHat<double> t;
    const double sigma[3] = {sigma_[p][0], sigma_[p][1], sigma_[p][2]};
    Model::dpdf_hat(sigma, Moduli<double>{mu_, lambda_, 0.0}, t);
    make_definite(t, floor, how);
    auto& stored = points_[p];
    const double weight = cell_volume(p / quadrature_.size()) * quadrature_[p % quadrature_.size()].weight;
    for (int i = 0; i < 6; ++i) stored.hessian[i] = static_cast<Real>(weight * t.hessian[i]);
    for (int k = 0; k < 3; ++k) {
      stored.same[k] = static_cast<Real>(0.5 * weight * (t.stretch[k] + t.rotation[k]));
      stored.cross[k] = static_cast<Real>(0.5 * weight * (t.stretch[k] - t.rotation[k]));
    }
  });
}

template <class Real>
void Elastic<Real>::linearize(Definiteness how) {
  if (material_.model == "corotated")
    linearize_cells<Corotated>(how);
  else
    linearize_cells<NeoHookean>(how);
}

template <class Real>
void Elastic<Real>::multiply(std::span<const Real> x, std::span<Real> y) const {
  const std::size_t point_count = quadrature_.size();
  const double h = lattice_.settings.spacing;
  const Real stabilization = static_cast<Real>(laplacian_ * mu_ * h);
  for_each_index(lattice_.cell_nodes.size(), [&](std::size_t c) {
    const auto& nodes = lattice_.cell_nodes[c];
    Real w[24];
    for (int k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i)
        w[8 * i + k] = x[3 * static_cast<std::size_t>(nodes[static_cast<std::size_t>(k)]) + i];
    Real out[24] = {};  // component-major
    for (std::size_t q = 0; q < point_count; ++q) {
      const Real* g = &gradients_[24 * q];
      const Point& t = points_[c * point_count + q];
      Real df[9], rotated[9], hat[9], dp[9];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          Real sum = 0;
          for (int k = 0; k < 8; ++k) sum += w[8 * i + k] * g[8 * j + k];
          df[3 * i + j] = sum;
        }
      multiply_transposed_left(t.u, df, rotated);
      lappet::multiply(rotated, t.v, hat);
      const Real d0 = hat[0], d1 = hat[4], d2 = hat[8];
      dp[0] = t.hessian[0] * d0 + t.hessian[1] * d1 + t.hessian[2] * d2;
      dp[4] = t.hessian[1] * d0 + t.hessian[3] * d1 + t.hessian[4] * d2;
      dp[8] = t.hessian[2] * d0 + t.hessian[4] * d1 + t.hessian[5] * d2;
      for (int k = 0; k < 3; ++k) {
        const int ij = 3 * kTangentPairs[k][0] + kTangentPairs[k][1],
                  ji = 3 * kTangentPairs[k][1] + kTangentPairs[k][0];
        dp[ij] = t.same[k] * hat[ij] + t.cross[k] * hat[ji];
        dp[ji] = t.same[k] * hat[ji] + t.cross[k] * hat[ij];
      }
      lappet::multiply(t.u, dp, rotated);
      multiply_transposed_right(rotated, t.v, dp);
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 8; ++k)
          out[8 * i + k] += dp[3 * i] * g[k] + dp[3 * i + 1] * g[8 + k] + dp[3 * i + 2] * g[16 + k];
    }
    if (stabilization != Real(0)) {
      const Real coefficient = stabilization * static_cast<Real>(lattice_.cell_fill[c]);
      for (std::size_t m = 0; m < 4; ++m) {
        const Real scaled = coefficient * static_cast<Real>(kHourglass[m]);
        for (int i = 0; i < 3; ++i) {
          Real amplitude = 0;
          for (int k = 0; k < 8; ++k)
            amplitude += static_cast<Real>(kHourglassModes[m][static_cast<std::size_t>(k)]) * w[8 * i + k];
          amplitude *= scaled;
          for (int k = 0; k < 8; ++k)
            out[8 * i + k] += static_cast<Real>(kHourglassModes[m][static_cast<std::size_t>(k)]) * amplitude;
        }
      }
    }
    if (!quadratic_of_cell_.empty() && quadratic_of_cell_[c] >= 0) {
      const Real* matrix = &quadratics_[64 * static_cast<std::size_t>(quadratic_of_cell_[c])];
      for (int i = 0; i < 3; ++i)
        for (int a = 0; a < 8; ++a) {
          Real sum = 0;
          for (int b = 0; b < 8; ++b) sum += matrix[8 * a + b] * w[8 * i + b];
          out[8 * i + a] += sum;
        }
    }
    Real* result = &cell_product_[24 * c];
    for (int k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i) result[3 * k + i] = out[8 * i + k];
  });
  for_each_index(lattice_.node_rest.size(), [&](std::size_t n) {
    Real sum[3] = {0, 0, 0};
    for (auto k = incidence_start_[n]; k < incidence_start_[n + 1]; ++k) {
      const Real* g = &cell_product_[3 * static_cast<std::size_t>(incidence_[static_cast<std::size_t>(k)])];
      for (int i = 0; i < 3; ++i) sum[i] += g[i];
    }
    for (std::size_t i = 0; i < 3; ++i) y[3 * n + i] = sum[i];
  });
}

template <class Real>
void Elastic<Real>::set_cell_quadratics(std::vector<std::int32_t> of_cell, std::vector<Real> matrices) {
  quadratic_of_cell_ = std::move(of_cell);
  quadratics_ = std::move(matrices);
}

template <class Real>
CellMeasures Elastic<Real>::measures(std::int32_t cell, std::span<const Real> u) const {
  const auto& nodes = lattice_.cell_nodes[static_cast<std::size_t>(cell)];
  static const QuadraturePoint centre = quadrature_point(0.5, 0.5, 0.5, 1.0);
  const double inverse_h = 1.0 / lattice_.settings.spacing;
  double f[9], rotation_u[9], rotation_v[9], sigma[3], p[3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      double sum = 0.0;
      for (std::size_t k = 0; k < 8; ++k)
        sum += double(u[3 * static_cast<std::size_t>(nodes[k]) + static_cast<std::size_t>(i)]) *
               centre.gradient[static_cast<std::size_t>(8 * j) + k];
      f[3 * i + j] = sum * inverse_h + (i == j ? 1.0 : 0.0);
    }
  svd3(f, rotation_u, sigma, rotation_v);
  if (material_.model == "corotated")
    Corotated::p_hat(sigma, Moduli<double>{mu_, lambda_, 0.0}, p);
  else
    NeoHookean::p_hat(sigma, Moduli<double>{mu_, lambda_, 0.0}, p);
  // Cauchy stress in the principal frame: sigma_i P_i / J
  const double j = std::max(sigma[0] * sigma[1] * sigma[2], 1e-6);
  const double s0 = sigma[0] * p[0] / j, s1 = sigma[1] * p[1] / j, s2 = sigma[2] * p[2] / j;
  const double deviatoric = (s0 - s1) * (s0 - s1) + (s1 - s2) * (s1 - s2) + (s2 - s0) * (s2 - s0);
  return {sigma[0], std::sqrt(0.5 * deviatoric), std::max({s0, s1, s2})};
}

template <class Real>
std::size_t Elastic<Real>::bytes() const {
  return points_.size() * sizeof(Point) + sigma_.size() * sizeof(sigma_[0]) + cell_gradient_.size() * sizeof(double) +
         cell_product_.size() * sizeof(Real) + incidence_.size() * 4 + incidence_start_.size() * 4 +
         quadratics_.size() * sizeof(Real);
}

template class Elastic<float>;
template class Elastic<double>;

}  // namespace lappet
