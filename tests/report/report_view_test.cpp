#include "report/report_view.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "report/report_json.hpp"
#include "tests/report/synthetic_experiment.hpp"

namespace gyrotherm {
namespace {

using Json = nlohmann::json;

std::string good_report() {
  static const std::string text = report_json(SyntheticExperiment().input());
  return text;
}

TEST(ReportView, ReadsBackWhatWasWritten) {
  const SyntheticExperiment experiment;
  const auto view = read_report(good_report(), "report.json");
  ASSERT_TRUE(view.has_value()) << text(view.error());
  EXPECT_TRUE(view->simulated);
  EXPECT_TRUE(view->rate.in_sample);
  EXPECT_EQ(view->random.residual.multi_point_t.all.std, experiment.random.multi_point_t.compensated.std);
  EXPECT_EQ(view->rate.series.thermometers_c.front().first, "A");
  EXPECT_EQ(view->rate.series.cycles.size(), 4U);
  EXPECT_EQ(view->models.multi_point.support_vectors, 57);
  EXPECT_EQ(view->random.residual.multi_point_t.outside, 3);
  EXPECT_EQ(view->random.raw.effective.of_std, experiment.random.multi_point.raw.effective.of_std);
  EXPECT_EQ(view->rate.allan.holds.curve.size(), experiment.rate.noise.curve.size());
  EXPECT_EQ(view->rate.allan.compensated_holds.coefficients.size(), 5U);
  EXPECT_TRUE(view->methods.back().nested.has_value());
  EXPECT_FALSE(view->methods.front().nested.has_value());
}

TEST(ReportView, NamesLineAndColumnOfASyntaxError) {
  const auto view = read_report("{\n  \"schema\": ,\n}", "report.json");
  ASSERT_FALSE(view.has_value());
  EXPECT_EQ(view.error().kind, FaultKind::bad_file);
  EXPECT_EQ(view.error().where, "report.json:2:13");
}

TEST(ReportView, RefusesAnotherSchema) {
  const auto view = read_report(R"({"schema": "gyrotherm-report/2"})", "report.json");
  ASSERT_FALSE(view.has_value());
  EXPECT_EQ(view.error().kind, FaultKind::bad_file);
  EXPECT_EQ(view.error().where, "report.json: schema");
}

TEST(ReportView, NamesEachMissingKeyOfTheFirstLevel) {
  const Json whole = Json::parse(good_report());
  for (const auto& [key, value] : whole.items()) {
    const bool for_people_alone = key == "correlation_signed" || key == "noise_floor_deg_per_h";
    if (for_people_alone) continue;
    Json less = whole;
    less.erase(key);
    const auto view = read_report(less.dump(), "report.json");
    ASSERT_FALSE(view.has_value()) << key;
    EXPECT_EQ(view.error().kind, FaultKind::bad_file);
    EXPECT_EQ(view.error().where, "report.json: " + key);
  }
}

TEST(ReportView, NamesThePathOfAWrongType) {
  Json report = Json::parse(good_report());
  report["random"]["multi_point"]["ramps"]["std_deg_per_h"] = "small";
  const auto view = read_report(report.dump(), "report.json");
  ASSERT_FALSE(view.has_value());
  EXPECT_EQ(view.error().where, "report.json: random.multi_point.ramps.std_deg_per_h");
}

TEST(ReportView, RefusesAColumnOfAnotherLength) {
  Json report = Json::parse(good_report());
  report["series"]["rate"]["multi_point"].push_back(0.1);
  const auto view = read_report(report.dump(), "report.json");
  ASSERT_FALSE(view.has_value());
  EXPECT_EQ(view.error().where, "report.json: series.rate.multi_point");
}

TEST(ReportView, SurvivesDamagedBytes) {
  const std::string whole = good_report().substr(0, 6000);
  for (std::uint32_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::string damaged = whole;
    for (int k = 0; k < 5; ++k) damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
    const auto view = read_report(damaged, "report.json");
    ASSERT_FALSE(view.has_value());
    EXPECT_EQ(view.error().kind, FaultKind::bad_file);
  }
}

}  // namespace
}  // namespace gyrotherm
