// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/json.hpp"
#include "report/views.hpp"
#include "tests/report/synthetic_experiment.hpp"
#include "tests/support/markup.hpp"

namespace gyrotherm::report {
namespace {

/// Returns an image of three samples: two of glass, one of air.
plot::ThermalImage small_view() {
  return {.title = "Top face of the block",
          .x_title = "x, mm",
          .y_title = "y, mm",
          .x_mm = {0, 30},
          .y_mm = {0, 10},
          .celsius = {3, 1, {29.5, 32.25, kNotKnown}},
          .parts = {1, 1, 0},
          .colours_c = {29, 33},
          .marks = {{"A", 15, 5, 32.25}},
          .simulated = true};
}

ReportedThermal some_thermal() {
  return {.missing = {},
          .reason = {},
          .model = ReportedThermalModel{.gyro = "calibrated",
                                        .title = "A ring of 32 cm",
                                        .gyro_sha256 = std::string(64, '7'),
                                        .ballast_reading = "rate x volume",
                                        .materials = {{"zerodur", 2530, 800, 1.46}, {"air", 1.2, 1005, kNotKnown}},
                                        .sources = {{"gain_area", 0.588, 1.126e-6, 52.22e4}},
                                        .image = {.mesh = "coarse",
                                                  .elements = 22848,
                                                  .nodes = 98989,
                                                  .ambient_c = 20,
                                                  .film_w_per_m2_k = 8,
                                                  .difference_k = 3.515,
                                                  .view = small_view()}}};
}

std::string thermal_page(const Report& report) { return to_html(report, all_figures(report)); }

int times_in(const std::string& text, const std::string& part) { return tests::count_occurrences(text, part); }

TEST(ThermalView, ShowsTablesAndImageOfVirtualGyroAsSimulated) {
  Report report = SyntheticExperiment().report();
  report.thermal = some_thermal();
  const std::string page = thermal_page(report);
  EXPECT_EQ(tests::markup_error(page), "");
  EXPECT_EQ(times_in(page, "</b> Thermal parameters of the gyro’s materials – <b>SIMULATED</b>"), 1);
  EXPECT_EQ(times_in(page,
                     "<td>Zerodur glass ceramic</td><td class=\"n\">2530</td><td class=\"n\">800</td>"
                     "<td class=\"n\">1.46</td>"),
            1);
  EXPECT_EQ(times_in(page,
                     "<td>Air in the cabinet</td><td class=\"n\">1.2</td><td class=\"n\">1005</td>"
                     "<td class=\"n\">–</td>"),
            1);
  EXPECT_EQ(times_in(page, "</b> Heat sources of the gyro – <b>SIMULATED</b>"), 1);
  EXPECT_EQ(times_in(page,
                     "<td>Gain area, both arms</td><td class=\"n\">0.588</td><td class=\"n\">1.126</td>"
                     "<td class=\"n\">52.22</td>"),
            1);
  EXPECT_EQ(times_in(page, "<figure id=\"figure-1\""), 1);
  EXPECT_EQ(times_in(page, "on the coarse mesh of the finite-element model (22848 elements, 98989 nodes)"), 1);
  EXPECT_EQ(times_in(page, "at steady state"), 1);
  EXPECT_EQ(times_in(page, "not applicable"), 0);
  const auto figure = thermal_figure(report);
  ASSERT_TRUE(figure);
  EXPECT_GE(times_in(figure->svg, "SIMULATED"), 2);
  EXPECT_GE(times_in(figure->caption, "SIMULATED"), 1);
}

TEST(ThermalView, StatesReasonForRealGyro) {
  const SyntheticExperiment experiment(1, false);
  const Report report = experiment.report();
  const std::string page = thermal_page(report);
  EXPECT_EQ(times_in(page, "not applicable: no finite-element model of this gyro exists"), 3);
  for (const char* item : {"<td>Table 1</td>", "<td>Table 2</td>", "<td>Figure 1</td>"})
    EXPECT_EQ(times_in(page, item), 1);
  EXPECT_FALSE(thermal_figure(report));
  const auto written = nlohmann::json::parse(to_json(report))["thermal"];
  EXPECT_EQ(written["missing"], "not applicable");
  EXPECT_EQ(written["reason"], "no finite-element model of this gyro exists");
  EXPECT_TRUE(written["model"].is_null());
}

TEST(ThermalView, StatesReasonForMissingModelOfVirtualGyro) {
  Report report = SyntheticExperiment().report();
  report.thermal = not_available("the gyro file \"a<b\" is missing");
  EXPECT_EQ(times_in(thermal_page(report), "not available: the gyro file &quot;a&lt;b&quot; is missing"), 3);
}

TEST(ThermalView, ReadsBackFromReportFile) {
  Report report = SyntheticExperiment().report();
  report.thermal = some_thermal();
  const auto again = read_report(to_json(report), "report.json");
  ASSERT_TRUE(again) << text(again.error());
  EXPECT_EQ(thermal_page(*again), thermal_page(report));
}

TEST(ThermalView, StatesThatEarlierReportHasNoThermalModel) {
  auto written = nlohmann::json::parse(to_json(SyntheticExperiment().report()));
  written.erase("thermal");
  const auto report = read_report(written.dump(), "report.json");
  ASSERT_TRUE(report) << text(report.error());
  EXPECT_EQ(report->thermal.missing, "not available");
}

TEST(ThermalView, RefusesImageWithMissingSamples) {
  Report report = SyntheticExperiment().report();
  report.thermal = some_thermal();
  report.thermal.model->image.view.celsius.values.pop_back();
  const auto again = read_report(to_json(report), "report.json");
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, FaultKind::bad_file);
}

}  // namespace
}  // namespace gyrotherm::report
