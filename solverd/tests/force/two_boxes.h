// Numbers at random, the same every time, and two boxes that may be moved into each other.
#pragma once
#include <functional>
#include <memory>
#include <random>

#include "force/self_contact/self_contact.h"
#include "grid_box.h"

namespace lappet {

class Random {
 public:
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Vec3 vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }

 private:
  std::mt19937 engine_{5};
};

// That every node may move.
inline const std::function<bool(Index)> kAllMove = [](Index) { return true; };

// Two boxes with surfaces of different triangles, one over the other, and displacements of theirs.
class TwoBoxes {
 public:
  explicit TwoBoxes(double gap, bool turned = false, double edge = 0.5, double friction = 0.0)
      : surface_(grid_box({0, 0, 0}, {4, 4, 2}, 1.0)) {
    Surface upper = grid_box({0, 0, 2 + gap}, {4, 4, 4 + gap}, edge);
    if (turned)
      for (Vec3& p : upper.points) p = Vec3(2, 2, 0) + Eigen::AngleAxisd(0.3, Vec3::UnitZ()) * (p - Vec3(2, 2, 0));
    append(surface_, upper);
    first_of_upper_ = to_index(grid_box({0, 0, 0}, {4, 4, 2}, 1.0).points.size());
    lattice_ = build_lattice(surface_, {});
    contact_ = std::make_unique<SelfContact>(lattice_, surface_, 50.0, friction);
    u_.assign(3 * lattice_.node_rest.size(), 0.0);
  }
  // Moves the nodes of the upper box, and all of them at random.
  void move(const Vec3& by, double noise = 0.0) {
    Random random;
    std::vector<std::uint8_t> is_upper(lattice_.node_rest.size(), 0);
    for (Index v = first_of_upper_; v < to_index(surface_.points.size()); ++v)
      for (const Index n : lattice_.cell_nodes[lattice_.surface_points[v].cell]) is_upper[n] = 1;
    for (std::size_t n = 0; n < is_upper.size(); ++n) {
      const Vec3 moved = (is_upper[n] ? by : Vec3(0, 0, 0)) + random.vector(noise);
      for (int i = 0; i < 3; ++i) u_[3 * n + i] = moved[i];
    }
  }
  SelfContactState evaluate() {
    gradient_.assign(u_.size(), 0.0);
    SelfContactState state;
    contact_->evaluate<double>(u_, gradient_, state);
    return state;
  }
  SelfContact& contact() { return *contact_; }
  const Surface& surface() const { return surface_; }
  const Lattice& lattice() const { return lattice_; }
  Index first_of_upper() const { return first_of_upper_; }
  std::vector<double>& u() { return u_; }
  const std::vector<double>& gradient() const { return gradient_; }

 private:
  Surface surface_;
  Index first_of_upper_ = 0;
  Lattice lattice_;
  std::unique_ptr<SelfContact> contact_;
  std::vector<double> u_, gradient_;
};

}  // namespace lappet
