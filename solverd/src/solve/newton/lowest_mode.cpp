#include "solve/newton/lowest_mode.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

namespace lappet {

namespace {

// A vector v with N v and C v.
template <class Real>
struct Direction {
  explicit Direction(std::size_t size) : shape(size), softening(size), stiffness(size) {}
  std::vector<Real> shape, softening, stiffness;
};

template <class Real>
class ModeSearch {
 public:
  ModeSearch(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<const Real> u, const Evaluation& at)
      : system_(system),
        preconditioner_(preconditioner),
        u_(u),
        at_(at),
        size_(u.size()),
        mode_(size_),
        other_(size_) {}

  LowestMode<Real> run(const LowestModeSearch& search) {
    set_noise(other_.shape);
    measure(other_);
    if (!(dot<Real>(other_.shape, other_.softening) > 0.0)) return {};
    linearize(PsdProjection::kClamp);
    preconditioner_.refresh(u_);
    if (!preconditioner_.is_smoother_only()) add_coarse_noise();
    // The first step is one of the power method: the noise itself says nothing.
    precondition(other_.softening, mode_.shape);
    measure(mode_);
    LowestMode<Real> found;
    double now = share();
    bool ends = kFirstStep * now < 1.0 - search.soft;
    for (found.steps = 1; !ends && found.steps < search.max_steps; ++found.steps) {
      const double change = climb(now) - now;
      now += change;
      ends = change < search.tolerance || now + change < 1.0 - search.soft;
    }
    found.stiffness = 1.0 - now;
    found.shape = std::move(mode_.shape);
    normalize(found.shape);
    return found;
  }

 private:
  // Chosen: more than this many times the share that the first step finds is not expected.
  static constexpr double kFirstStep = 5.0;
  static constexpr double kParallel = 1e-10;

  double share() const {
    const double stiff = dot<Real>(mode_.shape, mode_.stiffness);
    return stiff > 0.0 ? dot<Real>(mode_.shape, mode_.softening) / stiff : 0.0;
  }

  // Noise on free nodes that their numbers decide.
  void set_noise(std::vector<Real>& shape) const {
    for_each_index(system_.nodes(), [&](std::size_t n) {
      for (std::size_t i = 3 * n; i < 3 * n + 3; ++i) shape[i] = system_.is_free(n) ? noise(i) : Real(0);
    });
  }
  // In [-0.5, 0.5), by a number.
  static Real noise(std::size_t i) {
    std::uint32_t hash = static_cast<std::uint32_t>(i) * 2654435761U;
    hash = (hash ^ (hash >> 15)) * 2246822519U;
    hash ^= hash >> 13;
    return static_cast<Real>(hash >> 8) / static_cast<Real>(1U << 24) - Real(0.5);
  }

  // Adds what N makes of noise on the rigid modes of the coarse level: long waves have too small a part in the other.
  void add_coarse_noise() {
    auto& modes = preconditioner_.modes();
    std::vector<Real> amplitudes(modes.unknowns());
    for_each_index(amplitudes.size(), [&](std::size_t i) { amplitudes[i] = noise(i); });
    modes.prolong(amplitudes, mode_.shape);
    measure(mode_);
    add<Real>(Real(1), mode_.softening, other_.softening);
  }

  // A tangent costs as much as two products: what needs the present one comes first.
  void linearize(PsdProjection how) {
    if (tangent_ == how) return;
    // Compression alone counts: what slides around a corner that presses on it has its own negative stiffness.
    system_.linearize(at_, how, PsdProjection::kClamp);
    tangent_ = how;
  }
  void precondition(std::span<const Real> b, std::span<Real> x) {
    linearize(PsdProjection::kClamp);
    preconditioner_.apply(b, x);
  }

  void measure(Direction<Real>& x) {
    const bool clamped = tangent_ == PsdProjection::kClamp;
    linearize(clamped ? PsdProjection::kClamp : PsdProjection::kExact);
    system_.multiply(x.shape, clamped ? x.stiffness : x.softening);
    linearize(clamped ? PsdProjection::kExact : PsdProjection::kClamp);
    system_.multiply(x.shape, clamped ? x.softening : x.stiffness);
    combine<Real>(Real(-1), Real(1), x.stiffness, x.softening);
  }

  // One step along the preconditioned gradient of the quotient.
  double climb(double now) {
    for_each_index(size_, [&, s = static_cast<Real>(now)](std::size_t i) {
      other_.softening[i] = mode_.softening[i] - s * mode_.stiffness[i];
    });
    precondition(other_.softening, other_.shape);
    return take_in_other();
  }

  // Rayleigh and Ritz in the span of the mode and the other direction; the best becomes the mode.
  double take_in_other() {
    const double length = largest<Real>(other_.shape), wanted = largest<Real>(mode_.shape);
    if (!(length > 0.0)) return share();
    scale(other_.shape, wanted / length);
    measure(other_);
    const auto form = [](const Direction<Real>& a, const Direction<Real>& b) {
      return std::pair(dot<Real>(a.shape, b.softening), dot<Real>(a.shape, b.stiffness));
    };
    const auto [n00, c00] = form(mode_, mode_);
    const auto [n01, c01] = form(mode_, other_);
    const auto [n11, c11] = form(other_, other_);
    Eigen::Matrix2d n, c;
    n << n00, n01, n01, n11;
    c << c00, c01, c01, c11;
    const Eigen::Vector2d unit = c.diagonal().cwiseSqrt().cwiseInverse();
    n = (unit.asDiagonal() * n * unit.asDiagonal()).eval();
    c = (unit.asDiagonal() * c * unit.asDiagonal()).eval();
    if (!n.allFinite() || !c.allFinite() || !(c.determinant() > kParallel)) return share();
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> solver(n, c);
    const Eigen::Vector2d best = unit.asDiagonal() * solver.eigenvectors().col(1) / unit[0];
    const auto mix = [&](std::vector<Real>& x, const std::vector<Real>& y) {
      combine<Real>(static_cast<Real>(best[0]), static_cast<Real>(best[1]), y, x);
    };
    mix(mode_.shape, other_.shape);
    mix(mode_.softening, other_.softening);
    mix(mode_.stiffness, other_.stiffness);
    return share();
  }

  void normalize(std::vector<Real>& shape) const {
    const double length = largest<Real>(shape);
    if (length > 0.0) scale(shape, 1.0 / length);
  }
  static void scale(std::vector<Real>& x, double by) {
    for_each_index(x.size(), [&, s = static_cast<Real>(by)](std::size_t i) { x[i] *= s; });
  }

  System<Real>& system_;
  TwoLevel<Real>& preconditioner_;
  std::span<const Real> u_;
  const Evaluation& at_;
  std::size_t size_;
  Direction<Real> mode_, other_;
  std::optional<PsdProjection> tangent_;  // which the system has now; none: nobody knows
};

}  // namespace

template <class Real>
LowestMode<Real> find_lowest_mode(System<Real>& system, TwoLevel<Real>& preconditioner, std::span<const Real> u,
                                  const Evaluation& at, const LowestModeSearch& search) {
  return ModeSearch<Real>(system, preconditioner, u, at).run(search);
}

template LowestMode<float> find_lowest_mode(System<float>&, TwoLevel<float>&, std::span<const float>, const Evaluation&,
                                            const LowestModeSearch&);
template LowestMode<double> find_lowest_mode(System<double>&, TwoLevel<double>&, std::span<const double>,
                                             const Evaluation&, const LowestModeSearch&);

}  // namespace lappet
