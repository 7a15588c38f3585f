// How often the expensive things were done, and how long they took.
#pragma once
#include <chrono>
#include <cstdint>

namespace lappet {

struct Task {
  std::int64_t count = 0;
  double seconds = 0.0;  // on the clock of the wall, whatever the number of threads

  Task operator-(const Task& before) const { return {count - before.count, seconds - before.seconds}; }
};

struct Work {
  Task evaluations;     // energy and gradient at a state
  Task linearizations;  // the tangent there
  Task products;        // of the tangent and a vector

  Work operator-(const Work& before) const {
    return {evaluations - before.evaluations, linearizations - before.linearizations, products - before.products};
  }
};

// Counts what is done while it lives.
class Timed {
 public:
  explicit Timed(Task& task) : task_(task), start_(Clock::now()) {}
  ~Timed() {
    ++task_.count;
    task_.seconds += std::chrono::duration<double>(Clock::now() - start_).count();
  }
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  Task& task_;
  Clock::time_point start_;
};

}  // namespace lappet
