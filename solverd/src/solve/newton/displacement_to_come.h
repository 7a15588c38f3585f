// How far the nodes still have to go: the largest length of a node's part of K^-1 residual, as a share of what may be
// left at that node (1: just near enough). Newton-Raphson asks it of the linear solves that it makes anyway.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "math/parallel.h"
#include "solve/system/system.h"

namespace lappet {

// What may be left, mm: of a node, and as a share of the largest displacement of its fragment, but never less than
// `least`.
struct DisplacementTolerance {
  double at_most = 0.0, share = 0.0, least = 0.0;
};

// The tolerance where the displacements are u. Refers to the system.
template <class Real>
class DisplacementLimits {
 public:
  DisplacementLimits(const System<Real>& system, std::span<const Real> u, const DisplacementTolerance& tolerance)
      : fragment_of_node_(system.fragment_of_node()), limit_(fragment_of_node_.empty() ? 1 : u.size() / 3, 0.0) {
    if (fragment_of_node_.empty()) {
      limit_[0] = largest_length(u);
    } else {
      for (std::size_t n = 0; n < u.size() / 3; ++n) {
        double& most = limit_[static_cast<std::size_t>(fragment_of_node_[n])];
        most = std::max(most, length(u, n));
      }
    }
    for (double& limit : limit_)
      limit = std::clamp(tolerance.share * limit, std::min(tolerance.least, tolerance.at_most), tolerance.at_most);
  }

  // The largest quotient of a node's displacement and its limit.
  double share(std::span<const Real> x) const {
    if (fragment_of_node_.empty()) return largest_length(x) / limit_[0];
    return largest_of(x.size() / 3, [&](std::size_t n) {
      return length(x, n) / limit_[static_cast<std::size_t>(fragment_of_node_[n])];
    });
  }
  // mm
  static double largest_length(std::span<const Real> x) {
    return largest_of(x.size() / 3, [x](std::size_t n) { return length(x, n); });
  }

 private:
  static double length(std::span<const Real> x, std::size_t n) {
    const auto a = double(x[3 * n]), b = double(x[3 * n + 1]), c = double(x[3 * n + 2]);
    return std::sqrt(a * a + b * b + c * c);
  }
  template <class Value>
  static double largest_of(std::size_t count, const Value& value) {
    std::vector<double> most((count + kChunk - 1) / kChunk, 0.0);
    for_each_chunk(count, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) most[chunk] = std::max(most[chunk], value(n));
    });
    return most.empty() ? 0.0 : *std::ranges::max_element(most);
  }

  std::span<const std::int32_t> fragment_of_node_;
  std::vector<double> limit_;  // per fragment, at its lowest node
};

// What the iterations of a linear solve tell about its solution: conjugate gradients add ever smaller pieces to it, and
// those that are still to come are estimated as a geometric series.
class SeriesEstimate {
 public:
  // After an iteration: the size of the piece that it added.
  void add(double piece) { pieces_[static_cast<std::size_t>(count_++ % kHistory)] = piece; }
  // Size of the pieces that are still to come; infinite while too few are known.
  double left() const {
    if (count_ < 2) return std::numeric_limits<double>::infinity();
    const auto piece = [this](int back) { return pieces_[static_cast<std::size_t>((count_ - 1 - back) % kHistory)]; };
    if (!(piece(0) > 0.0)) return 0.0;
    const double rate = piece(0) / piece(1);
    if (count_ == 2) return series(piece(0), rate);
    return series(piece(0), std::max(std::sqrt(piece(0) / piece(2)), rate));
  }

 private:
  static constexpr int kHistory = 3;
  static constexpr double kMinRate = 0.3, kMaxRate = 0.95;

  static double series(double last, double rate) {
    const double clamped = std::clamp(rate, kMinRate, kMaxRate);
    return last * clamped / (1.0 - clamped);
  }

  std::array<double, kHistory> pieces_{};
  int count_ = 0;
};

}  // namespace lappet
