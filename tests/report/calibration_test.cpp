// SPDX-License-Identifier: Apache-2.0
#include "report/calibration.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string_view>

#include "report/words.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

TEST(Calibration, ReadsBackToEqualBytes) {
  const std::string json = to_json(sample_calibration());
  const auto read = calibration_from_json(json, "calibration.json");
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_EQ(to_json(*read), json);
}

TEST(Calibration, RefusesOtherSchema) {
  std::string json = to_json(sample_calibration());
  json.replace(json.find(kCalibrationSchema), std::string(kCalibrationSchema).size(), "gyrotherm-calibration/9");
  const auto read = calibration_from_json(json, "calibration.json");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().kind, FaultKind::bad_file);
}

TEST(Calibration, RefusesColumnsOfUnequalLength) {
  CalibrationReport report = sample_calibration();
  report.results[0].columns[0].values.push_back({.value = 1});
  const auto read = calibration_from_json(to_json(report), "calibration.json");
  ASSERT_FALSE(read);
  EXPECT_NE(text(read.error()).find("columns of equal length"), std::string::npos) << text(read.error());
}

TEST(Decision, PassesUpToLimitBySimpleRule) {
  const auto at = [](double value) {
    return compare_with_limits(value_with_uncertainty(value, 0.05, 1e9), 1, DecisionRule::simple).verdict;
  };
  EXPECT_EQ(at(0.99), Verdict::pass);
  EXPECT_EQ(at(-1), Verdict::pass);
  EXPECT_EQ(at(1.01), Verdict::fail);
}

TEST(Decision, IsConditionalWithinUncertaintyOfLimitByGuardBand) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const auto at = [](double value) {
    return compare_with_limits(value_with_uncertainty(value, 0.05, kInfinite), 1, DecisionRule::guard_band).verdict;
  };
  EXPECT_EQ(at(-0.9), Verdict::pass);  // U is 0.098
  EXPECT_EQ(at(0.91), Verdict::conditional_pass);
  EXPECT_EQ(at(1.05), Verdict::conditional_fail);
  EXPECT_EQ(at(-1.1), Verdict::fail);
  EXPECT_EQ(compare_with_limits({.value = 0.5}, 1, DecisionRule::guard_band).verdict, Verdict::not_known);
}

TEST(Decision, ReturnsProbabilityThatTrueValueIsWithinLimit) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  EXPECT_NEAR(compare_with_limits(value_with_uncertainty(1, 0.05, kInfinite), 1, DecisionRule::simple).probability, 0.5,
              1e-9);
  EXPECT_NEAR(compare_with_limits(value_with_uncertainty(0.95, 0.05, kInfinite), 1, DecisionRule::simple).probability,
              0.841344746, 1e-8);
  // Cauchy distribution, excluding the part below −1.
  EXPECT_NEAR(compare_with_limits(value_with_uncertainty(0.95, 0.05, 1), 1, DecisionRule::simple).probability,
              0.75 - 0.00816, 1e-4);
}

TEST(Decision, HasCoverageFactorOfWholeDegreesOfFreedom) {
  const auto factor = [](double degrees) { return value_with_uncertainty(1, 0.1, degrees).coverage_factor; };
  for (const double whole : {1.0, 3.0, 99.0}) {
    EXPECT_EQ(factor(std::nextafter(whole, 0)), factor(whole)) << whole;
    EXPECT_EQ(factor(whole + 0.9), factor(whole)) << whole;
  }
  EXPECT_GT(factor(98.9), factor(99));
  EXPECT_EQ(factor(0.4), factor(1));
}

// If U equals the limit, the true value of a passed result may be outside the limit on either side.
TEST(Decision, HasStatedErrorProbabilityByGuardBand) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const ReportedValue nothing = value_with_uncertainty(0, 0.5, kInfinite),
                      great = value_with_uncertainty(9, 0.5, kInfinite);
  const Conformity found = compare_with_limits(nothing, nothing.expanded(), DecisionRule::guard_band);
  EXPECT_EQ(found.verdict, Verdict::pass);
  EXPECT_NEAR(1 - found.probability, 0.05, 1e-9);
  EXPECT_NEAR(1 - compare_with_limits(great, 9 + great.expanded(), DecisionRule::guard_band).probability, 0.025, 1e-9);
  EXPECT_NE(translate(Language::english, "say.rule_guard_band").find("at most 5 % together"), std::string_view::npos);
  EXPECT_NE(translate(Language::german, "say.rule_guard_band").find("zusammen höchstens 5 %"), std::string_view::npos);
}

TEST(Decision, OverallIsWorst) {
  CalibrationReport report = sample_calibration();
  EXPECT_EQ(overall_verdict(report), Verdict::conditional_fail);
  report.conformity[0].verdict = Verdict::fail;
  report.conformity[1].verdict = Verdict::not_known;
  EXPECT_EQ(overall_verdict(report), Verdict::fail) << "a missing result does not change a failure";
  report.conformity.clear();
  EXPECT_FALSE(overall_verdict(report));
}

}  // namespace
}  // namespace gyrotherm::report
