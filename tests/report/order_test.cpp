// SPDX-License-Identifier: Apache-2.0
#include "report/order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/report/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

constexpr const char* kLaboratory = R"(schema = "gyrotherm-laboratory/1"
name = "Inertial Laboratory"
city = "Berlin"
country = "DE"
traceability = { en = "To the SI.", de = "Auf das SI." }
[[person]]
name = "A. Metrologist"
role = "authorising"
)";

constexpr const char* kOrder = R"(schema = "gyrotherm-order/1"
number = "C-1"
received = "2026-11-02"
issued = "2026-11-25"
method = "Ramps and soaks"
decision_rule = "guard_band"
[customer]
name = "Navigation <script>alert(1)</script> \"Works\" 航海"
city = "Hamburg"
[[unit]]
model = "RLG-1"
serial_number = "0042"
condition = "no damage"
[[person]]
name = "O. Perator"
role = "operator"
[[limit]]
quantity = "compensated_mean.compensated_bias"
stage = "as_left"
at_most = 0.01
)";

CalibrationReport of_a_record() {
  CalibrationReport report = sample_calibration();
  report.state = ReportState::draft;
  report.item.name = "gyro";
  report.people.clear();
  report.conformity.clear();
  report.traceability = {};
  report.missing.clear();
  return report;
}

TEST(Order, MakesAReportThatLacksNothing) {
  const auto laboratory = parse_laboratory(kLaboratory, "laboratory.toml");
  const auto order = parse_order(kOrder, "order.toml");
  ASSERT_TRUE(laboratory) << text(laboratory.error());
  ASSERT_TRUE(order) << text(order.error());
  CalibrationReport report = of_a_record();
  add_order(report, *laboratory, *order);
  EXPECT_TRUE(report.missing.empty()) << report.missing.front();
  EXPECT_EQ(report.number, "C-1");
  EXPECT_EQ(report.customer.name, "Navigation <script>alert(1)</script> \"Works\" 航海");
  EXPECT_EQ(report.traceability.de, "Auf das SI.");
  EXPECT_EQ(report.method.de, "Ramps and soaks");
  ASSERT_EQ(report.conformity.size(), 2u) << "each axis as left";
  EXPECT_EQ(report.conformity[0].verdict, Verdict::pass);
}

TEST(Order, NamesEachFieldThatIsMissing) {
  std::string without = kOrder;
  without.erase(without.find("issued = \"2026-11-25\"\n"), 22);
  const auto order = parse_order(without, "order.toml");
  ASSERT_TRUE(order);
  CalibrationReport report = of_a_record();
  add_order(report, std::nullopt, *order);
  const auto lacks = [&](const char* what) { return std::ranges::find(report.missing, what) != report.missing.end(); };
  EXPECT_TRUE(lacks("order.toml: issued"));
  EXPECT_TRUE(lacks("laboratory.toml: traceability"));
  EXPECT_FALSE(lacks("order.toml: customer.name"));
}

TEST(Order, IsRefusedWithEachMistakeAndItsPlace) {
  std::string wrong = kOrder;
  wrong.replace(wrong.find("2026-11-02"), 10, "2026-13-02");
  wrong.replace(wrong.find("at_most = 0.01"), 14, "at_most = -1.0");
  const auto order = parse_order(wrong, "order.toml");
  ASSERT_FALSE(order);
  const std::string said = text(order.error());
  EXPECT_NE(said.find("order.toml:3:"), std::string::npos) << said;
  EXPECT_NE(said.find("is no day"), std::string::npos) << said;
  EXPECT_NE(said.find("above 0"), std::string::npos) << said;
}

TEST(Order, HoldsNothingAgainstALimitThatTheModelHasLearnt) {
  CalibrationReport report = of_a_record();
  for (ResultTable& table : report.results) table.in_sample = table.stage == Stage::as_left;
  hold_against(report, {{.quantity = "compensated_mean.compensated_bias", .stage = Stage::as_left, .at_most = 0.01}},
               DecisionRule::simple);
  ASSERT_EQ(report.conformity.size(), 1u);
  EXPECT_EQ(report.conformity[0].verdict, Verdict::not_known);
  add_order(report, std::nullopt, std::nullopt);
  EXPECT_NE(std::ranges::find(report.missing, "records: one that the model has not seen"), report.missing.end());
}

TEST(Order, HasEachAxisVerifiedByARecordOfItsOwn) {
  CalibrationReport report = of_a_record();
  for (ResultTable& table : report.results) table.in_sample = table.axis == "u1.y" && table.stage == Stage::as_left;
  add_order(report, std::nullopt, std::nullopt);
  EXPECT_NE(std::ranges::find(report.missing, "records: one that the model has not seen"), report.missing.end());
}

TEST(Laboratory, TakesALogoThatIsOneOnly) {
  const auto missing =
      parse_laboratory(std::string(kLaboratory).insert(34, "logo = \"none.svg\"\n"), "laboratory.toml");
  ASSERT_FALSE(missing);
  EXPECT_NE(text(missing.error()).find("none.svg"), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::report
