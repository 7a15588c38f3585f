// Materials at their limits through a Session: each state is reached or refused with a reason, and is finite.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <string>

#include "environment.h"
#include "lattice/refused.h"
#include "material_formulas.h"
#include "math/instruction_set.h"
#include "pulled_bar.h"

namespace lappet {
namespace {

// Has a value while it lives, and after that the one from before.
class EnvironmentVariable {
 public:
  EnvironmentVariable(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    set_variable(name, value.c_str());
  }
  ~EnvironmentVariable() { set_variable(name_, before_ ? before_->c_str() : nullptr); }
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

// What came back holds no NaN; says whether it converged.
bool reached(const FrameOutput& out) {
  EXPECT_NE(out.converged, !out.failure.message.empty());
  for (const auto& array : {out.points, out.strain, out.stress, out.tension})
    for (const float value : array) EXPECT_TRUE(std::isfinite(value));
  EXPECT_TRUE(std::isfinite(out.energy));
  EXPECT_EQ(out.failure.message.find("nan"), std::string::npos) << out.failure.message;
  return out.converged;
}

FrameOutput move(Session& session, double elongation) {
  return session.solve(pulled({Vec3(elongation, 0, 0)}), {}, kNever);
}

SessionSettings sharply_stiffening() {
  SessionSettings s;
  s.retractors = 1;
  s.threads = 2;
  s.materials[0].fiber_k1 = 20;
  s.materials[0].fiber_k2 = 50;
  s.materials[0].fiber_dispersion = 0.1;
  return s;
}

TEST(MaterialRobustness, FibersThatStiffenSharplyAreStretchedFarInAFewFrames) {
  const SessionSettings s = sharply_stiffening();
  const Bar bar;
  Session session(s);
  session.set_epoch(bar_epoch(bar));
  for (const double elongation : {4.0, 8.0, 12.0, 16.0}) {
    const FrameOutput out = move(session, elongation);
    ASSERT_TRUE(reached(out)) << elongation << ": " << out.failure.message;
  }
}

TEST(MaterialRobustness, FibersThatStiffenSharplyAreStretchedToThreeTimesTheirLengthInOneFrame) {
  for (const char* precision : {"float", "double"})
    for (const double elongation : {8.0, 20.0, 40.0}) {
      SessionSettings s = sharply_stiffening();
      s.precision = precision;
      Session session(s);
      session.set_epoch(bar_epoch(Bar{20, 4, 4}));
      const FrameOutput out = move(session, elongation);
      EXPECT_TRUE(reached(out)) << precision << " " << elongation << ": " << out.failure.message;
    }
}

// Rounding decides which of many neighboring states a bar of such fibers comes to: each instruction set, each precision
// and each length is another draw. All are reached at the first attempt, with iterations to spare.
TEST(MaterialRobustness, HowNumbersAreRoundedDoesNotDecideWhetherFibersThatStiffenSharplyAreStretched) {
  for (const InstructionSet set : available_instruction_sets()) {
    const EnvironmentVariable chosen("LAPPET_ISA", std::string(name(set)));
    for (const char* precision : {"float", "double"})
      for (const double elongation : {8.0, 12.0, 20.0, 30.0, 40.0}) {
        SessionSettings s = sharply_stiffening();
        s.precision = precision;
        Session session(s);
        session.set_epoch(bar_epoch(Bar{20, 4, 4}));
        const FrameOutput out = move(session, elongation);
        const std::string what = fmt::format("{} {} {}", name(set), precision, elongation);
        EXPECT_TRUE(reached(out)) << what << ": " << out.failure.message;
        EXPECT_EQ(out.load_steps, 1) << what;
        EXPECT_LT(out.newton_iterations, 80) << what;
      }
  }
}

// Up to k2 E^2 = 10 the response is the published one; a change of the stretch by 1e-4 changes it by up to 1 %.
TEST(MaterialRobustness, FibersThatStiffenSharplyPullAsPublished) {
  SessionSettings s = sharply_stiffening();
  s.precision = "double";
  s.tolerance = 1e-6;
  const Bar bar;
  Session session(s);
  session.set_epoch(bar_epoch(bar));
  const Piola piola = [&](const Matrix3& f) { return full_piola(s.materials[0], f); };
  for (const double elongation : {4.0, 7.0}) {
    const Matrix3 f = free_sides(piola, read_gauge(pull(session, elongation), bar).axial);
    const double expected = piola(f)(0, 0) * bar.area();
    EXPECT_NEAR(pulling_force(session, elongation, 0.02), expected, 0.02 * expected) << elongation;
  }
}

TEST(MaterialRobustness, AMooneyRivlinBlockIsSqueezedToHalfItsHeight) {
  for (const double ratio : {0.0, 0.5, 2.0})
    for (const double poisson : {0.3, 0.45, 0.49}) {
      SessionSettings s;
      s.retractors = 1;
      s.threads = 2;
      s.materials[0].model = "mooneyRivlin";
      s.materials[0].mooney_ratio = ratio;
      s.materials[0].poissons_ratio = poisson;
      Session session(s);
      session.set_epoch(bar_epoch(Bar{6, 8, 8}));
      for (const double elongation : {-1.0, -2.0, -3.0}) {
        const FrameOutput out = move(session, elongation);
        EXPECT_TRUE(reached(out)) << ratio << " " << poisson << " " << elongation << ": " << out.failure.message;
        EXPECT_GT(out.minimum_j, 0.3);
      }
    }
}

TEST(MaterialRobustness, MaterialsOfTwoModelsAndPrestretchWithoutAThicknessAreRefusedBySentences) {
  const auto refusal = [](const SessionSettings& s) {
    try {
      Session session(s);
    } catch (const RefusedError& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidInput);
      return std::string(error.what());
    }
    return std::string();
  };
  SessionSettings mixed;
  mixed.materials.resize(2);
  mixed.materials[1].model = "corotated";
  EXPECT_NE(refusal(mixed).find("'corotated'"), std::string::npos);
  SessionSettings flat;
  flat.materials[0].model = "corotated";
  flat.materials[0].poissons_ratio = 0.49;
  flat.materials[0].prestretch = {2, 2};
  EXPECT_NE(refusal(flat).find("material 0: tissue of the model 'corotated' has no thickness"), std::string::npos);
}

}  // namespace
}  // namespace lappet
