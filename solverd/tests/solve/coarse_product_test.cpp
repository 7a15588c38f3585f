// The product of a matrix of rigid modes with a vector, against one written out in double.
#include "solve/multigrid/coarse_product.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace lappet {
namespace {

// Rows of a chain with some longer couplings, upper triangle.
template <class Real>
struct Chain {
  std::vector<std::int32_t> start{0}, column, left_start{0};
  std::vector<LeftBlock> left;
  std::vector<Real> blocks, x;
  std::vector<double> expected;

  explicit Chain(std::int32_t rows) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> draw(-1.0, 1.0);
    std::vector<std::vector<LeftBlock>> lefts(static_cast<std::size_t>(rows));
    for (std::int32_t n = 0; n < rows; ++n) {
      for (const std::int32_t step : {0, 1, 3, 7})
        if (n + step < rows) {
          if (step > 0) lefts[n + step].push_back({n, to_index(column.size())});
          column.push_back(n + step);
        }
      start.push_back(to_index(column.size()));
    }
    for (const auto& list : lefts) {
      left.insert(left.end(), list.begin(), list.end());
      left_start.push_back(to_index(left.size()));
    }
    for (std::size_t i = 0; i < 36 * column.size(); ++i) blocks.push_back(Real(draw(random)));
    // What belongs to no block must not matter.
    for (std::size_t i = 0; i < kCoarsePadding; ++i) blocks.push_back(Real(NAN));
    for (std::int32_t i = 0; i < 6 * rows; ++i) x.push_back(Real(draw(random)));
    expected.assign(x.size(), 0.0);
    for (std::size_t n = 0; n + 1 < start.size(); ++n)
      for (std::size_t s = start[n]; s < static_cast<std::size_t>(start[n + 1]); ++s) {
        const std::size_t m = column[s];
        for (std::size_t i = 0; i < 6; ++i)
          for (std::size_t j = 0; j < 6; ++j) {
            const auto entry = double(blocks[36 * s + 6 * i + j]);
            expected[6 * n + i] += entry * double(x[6 * m + j]);
            if (m != n) expected[6 * m + j] += entry * double(x[6 * n + i]);
          }
      }
  }
  CoarseRows<Real> rows() const {
    return {start.size() - 1, start.data(), column.data(), left_start.data(), left.data(), blocks.data()};
  }
};

template <class Real>
void expect_the_product_on_every_set() {
  const Chain<Real> chain(23);
  for (const InstructionSet set : available_instruction_sets()) {
    SCOPED_TRACE(name(set));
    std::vector<Real> y(chain.x.size(), Real(-7));
    const auto product = coarse_product<Real>(set);
    product(chain.rows(), 0, 10, chain.x.data(), y.data());
    product(chain.rows(), 10, 23, chain.x.data(), y.data());
    for (std::size_t i = 0; i < y.size(); ++i)
      EXPECT_NEAR(double(y[i]), chain.expected[i], 60 * std::numeric_limits<Real>::epsilon()) << i;
  }
}

TEST(CoarseProduct, IsTheProductWithTheWholeSymmetricMatrixOnEveryInstructionSet) {
  expect_the_product_on_every_set<float>();
  expect_the_product_on_every_set<double>();
}

}  // namespace
}  // namespace lappet
