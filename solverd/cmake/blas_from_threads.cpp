// Factors one matrix many times from several threads, as sessions do side by side, with the LAPACK that CHOLMOD has
// loaded. Every factor must have the bits of the first. Exit status: 0 so it is, 1 some differ.
#include <cholmod.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <utility>
#include <vector>

#include "solve/multigrid/serial_blas.h"

namespace {

// A supernode of CHOLMOD's size. Sixteen threads on any machine: where there are fewer cores, one is stopped inside
// the routine more often. Debian's serial OpenBLAS 0.3.21 got 72 to 165 of these wrong in each of five runs.
constexpr int kSize = 120, kThreads = 16, kFactors = 80'000;

using Factorize = void (*)(const char* triangle, const int* size, double* matrix, const int* stride, int* info);

}  // namespace

int main() {
  cholmod_common common;
  cholmod_start(&common);
  cholmod_finish(&common);
  // So that the linker keeps CHOLMOD's factorization, also of a static library, and with it LAPACK.
  [[maybe_unused]] const volatile auto kept = &cholmod_super_numeric;
  lappet::keep_blas_serial();
  const auto factorize = reinterpret_cast<Factorize>(lappet::loaded_function("dpotrf_"));
  if (factorize == nullptr) {
    std::puts("CHOLMOD has loaded no LAPACK.");
    return 1;
  }
  std::vector<double> matrix(kSize * kSize);
  for (int i = 0; i < kSize; ++i)
    for (int j = 0; j < kSize; ++j) matrix[i * kSize + j] = (i == j ? 2.0 : 0.0) + 1.0 / (1 + std::abs(i - j));
  const auto factor = [&](std::vector<double>& into) {
    std::ranges::copy(matrix, into.begin());
    int info = 0;
    factorize("L", &kSize, into.data(), &kSize, &info);
    return info == 0;
  };
  std::vector<double> first = matrix;
  if (!factor(first)) return 1;
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&] {
      std::vector<double> own = matrix;
      for (int k = 0; k < kFactors / kThreads; ++k)
        if (!factor(own) || std::memcmp(own.data(), first.data(), own.size() * sizeof(double)) != 0) ++wrong;
    });
  for (std::thread& thread : threads) thread.join();
  std::printf("%d of %d Cholesky factors from %d threads are wrong.\n", wrong.load(), kFactors, kThreads);
  return wrong.load() == 0 ? 0 : 1;
}
