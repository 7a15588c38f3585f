// So many events a second, and as many again at once after a pause.
#pragma once
#include <algorithm>
#include <chrono>

namespace lappet {

class TokenBucket {
 public:
  using Clock = std::chrono::steady_clock;
  TokenBucket(double per_second, double most, Clock::time_point now)
      : per_second_(per_second), most_(most), left_(most), at_(now) {}

  // Takes one, if there is one.
  bool take(Clock::time_point now) {
    fill(now);
    if (left_ < 1.0) return false;
    left_ -= 1.0;
    return true;
  }
  bool empty(Clock::time_point now) {
    fill(now);
    return left_ < 1.0;
  }
  // Nothing was taken for so long that a new one would be the same.
  bool full(Clock::time_point now) const {
    const std::chrono::duration<double> passed = now - at_;
    return left_ + per_second_ * passed.count() >= most_;
  }

 private:
  void fill(Clock::time_point now) {
    const std::chrono::duration<double> passed = now - at_;
    left_ = std::min(most_, left_ + per_second_ * passed.count());
    at_ = now;
  }
  double per_second_, most_, left_;
  Clock::time_point at_;
};

}  // namespace lappet
