// SPDX-License-Identifier: Apache-2.0
/// Tests the page, the table and the schema of a calibration report.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <regex>
#include <string>
#include <vector>

#include "report/calibration.hpp"
#include "report/document.hpp"
#include "report/document_chart.hpp"
#include "report/plot/svg.hpp"
#include "tests/support/markup.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

using tests::count_occurrences;

std::string page_of(const CalibrationReport& report, Language language = Language::english) {
  return to_html(make_document(report, language));
}

/// Returns the markup without the contents of its scripts.
std::string without_scripts(std::string html) {
  for (auto from = html.find("<script"); from != std::string::npos; from = html.find("<script", from + 1)) {
    from = html.find('>', from) + 1;
    html.erase(from, html.find("</script>", from) - from);
  }
  return html;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Returns a report with hostile text in every field that users fill in.
CalibrationReport hostile_report() {
  const std::string hostile = "</style></script><script>alert(1)</script> \"q\" 'x' & 惯性 {} " + std::string(300, 'W');
  CalibrationReport report = sample_calibration();
  report.number = hostile;
  report.laboratory.name = hostile;
  report.customer.name = hostile;
  report.item.description = {hostile, hostile};
  report.item.serial_number = hostile;
  report.place = {hostile, hostile};
  report.statements = {{hostile, hostile}};
  report.deviations[0].text = hostile;
  report.figures[0].lines[1].detail = hostile;
  report.figures[0].y_unit = hostile;
  report.results[0].detail = hostile;
  report.files[0].name = hostile;
  report.logo = Logo{"image/png", "\" onload=\"alert(1)"};
  report.missing = {hostile};
  report.replaced_by = OtherReport{.number = hostile};
  return report;
}

TEST(CalibrationPage, IsWellFormed) {
  for (const Language language : {Language::english, Language::german})
    EXPECT_EQ(tests::markup_error(without_scripts(page_of(sample_calibration(), language))), "");
}

TEST(CalibrationPage, StatesItsLanguage) {
  EXPECT_TRUE(contains(page_of(sample_calibration()), "<html lang=\"en\">"));
  EXPECT_TRUE(contains(page_of(sample_calibration(), Language::german), "<html lang=\"de\">"));
}

TEST(CalibrationPage, HasEveryValueWithItsUncertainty) {
  const CalibrationReport report = sample_calibration();
  for (const Language language : {Language::english, Language::german}) {
    const std::string page = page_of(report, language);
    for (const ResultTable& table : report.results)
      for (const Column& column : table.columns)
        for (const ReportedValue& value : column.values)
          EXPECT_TRUE(contains(page, ">" + format(language, value) + "<") ||
                      contains(page, ">" + format_result(language, value) + "<"))
              << table.key << " " << column.quantity;
  }
}

TEST(CalibrationPage, EscapesHostileTexts) {
  for (const Language language : {Language::english, Language::german}) {
    const std::string page = page_of(hostile_report(), language);
    EXPECT_EQ(tests::markup_error(without_scripts(page)), "");
    EXPECT_FALSE(contains(page, "<script>alert"));
    EXPECT_FALSE(contains(page, "onload=\"alert"));
    EXPECT_EQ(count_occurrences(page, "</style>"), 1);
    EXPECT_EQ(count_occurrences(page, "<script"), count_occurrences(page, "</script>"));
    EXPECT_TRUE(contains(page, plot::escaped("<script>alert(1)</script> \"q\" 'x' & 惯性 {} WWW")));
  }
}

TEST(CalibrationPage, NeedsNoNetwork) {
  const std::string page = without_scripts(page_of(sample_calibration()));
  const std::regex outside(R"re((src|href)="(?!#|data:)|@import|url\((?!#))re");
  std::smatch found;
  EXPECT_FALSE(std::regex_search(page, found, outside)) << found.str();
  EXPECT_FALSE(contains(page_of(sample_calibration()), "sourceMappingURL"));
}

TEST(CalibrationPage, HasLinkedHeadingsInOrder) {
  const std::string page = page_of(sample_calibration());
  EXPECT_EQ(count_occurrences(page, "<h1>"), 1);
  EXPECT_EQ(count_occurrences(page, "<section"), 10);
  EXPECT_TRUE(contains(page, "<a href=\"#results\"><span class=\"number\">5</span>Results</a>"));
  EXPECT_TRUE(contains(page, "<h2 id=\"results\"><span class=\"number\">5</span>Results</h2>"));
  EXPECT_TRUE(contains(page, "<span class=\"number\">5.2</span>Axis u1.y</h3>"));
  const std::regex id("id=\"([^\"]+)\"");
  std::vector<std::string> ids;
  for (std::sregex_iterator at(page.begin(), page.end(), id), end; at != end; ++at) ids.push_back((*at)[1]);
  for (const std::string& one : ids) EXPECT_EQ(std::ranges::count(ids, one), 1) << one;
}

TEST(CalibrationPage, HasTablesWithScopedHeaders) {
  const std::string page = page_of(sample_calibration());
  EXPECT_GT(count_occurrences(page, "<th scope=\"row\""), 20);
  EXPECT_EQ(count_occurrences(page, "<th>"), 0);
  EXPECT_EQ(count_occurrences(page, "<table>"), count_occurrences(page, "<caption>"));
}

TEST(CalibrationPage, ShowsMarkAboveContentAndOnEverySheet) {
  CalibrationReport report = sample_calibration();
  report.state = ReportState::draft;
  const std::string page = page_of(report);
  EXPECT_TRUE(contains(page, "<header class=\"banner\">DRAFT · SIMULATED</header>"));
  EXPECT_TRUE(contains(page, "<div class=\"watermark\""));
  EXPECT_TRUE(contains(page, "@top-right"));
  EXPECT_TRUE(contains(page, "<title>DRAFT · SIMULATED – Calibration report (draft)"));
  report.state = ReportState::authorised;
  report.simulated = false;
  const std::string plain = page_of(report);
  EXPECT_FALSE(contains(plain, "<header class=\"banner\""));
  EXPECT_FALSE(contains(plain, "@top-right"));
}

TEST(CalibrationPage, ShowsVerdictsByColourAndSign) {
  const std::string page = page_of(sample_calibration());
  EXPECT_TRUE(contains(page, "<span class=\"sign\" aria-hidden=\"true\">✓</span>Pass"));
  EXPECT_TRUE(contains(page, "<span class=\"sign\" aria-hidden=\"true\">▲</span>Conditional fail"));
}

TEST(CalibrationPage, ShowsFiguresWithoutScripts) {
  const std::string page = page_of(sample_calibration());
  EXPECT_EQ(count_occurrences(page, "<figure "), 6);
  EXPECT_EQ(count_occurrences(page, "<div class=\"static\" role=\"group\" tabindex=\"0\""), 4);
  EXPECT_EQ(count_occurrences(page, "<div class=\"static wide\" role=\"group\" tabindex=\"0\""), 2)
      << "two have a second drawing for narrow screens";
  EXPECT_EQ(count_occurrences(page, "class=\"enlargeable\""), 4) << "the two logarithmic plots cannot be enlarged";
}

TEST(CalibrationPage, HasNoScriptWithoutFigures) {
  CalibrationReport report = sample_calibration();
  report.figures.clear();
  EXPECT_FALSE(contains(page_of(report), "<script"));
}

TEST(CalibrationPage, StaysSmallForWeekOfSeconds) {
  CalibrationReport report = sample_calibration();
  for (FigureData& figure : report.figures)
    for (FigureLine& line : figure.lines) {
      if (figure.logarithmic) continue;
      constexpr int kSeconds = 200'000;
      line.x.resize(kSeconds);
      line.y.resize(kSeconds);
      for (int k = 0; k < kSeconds; ++k) {
        line.x[k] = k / 3600.0;
        line.y[k] = std::sin(1e-3 * k) + 0.01 * (k * 7919 % 13);
      }
    }
  EXPECT_LT(page_of(report).size(), 5'000'000u);
}

TEST(ChartData, IsThinnedAndDoesNotEndScript) {
  FigureData figure = sample_calibration().figures[0];
  figure.lines[0].y[7] = std::numeric_limits<double>::quiet_NaN();
  figure.lines[1].detail = "</script>";
  const std::string data = chart_data(figure, Language::english, 100, "</b>");
  EXPECT_FALSE(contains(data, "<"));
  EXPECT_TRUE(contains(data, "null"));
  EXPECT_LT(count_occurrences(data, ","), 3 * 2 * 105 + 20);
}

TEST(ChartData, HasUnitAndDecimalsOfEachAxis) {
  FigureData figure = sample_calibration().figures[0];
  figure.lines.resize(1);
  const auto data = [&](double x, double low, double high, const char* unit) {
    figure.lines[0].x = {0, x};
    figure.lines[0].y = {low, high};
    figure.y_unit = unit;
    return chart_data(figure, Language::english, 100, "");
  };
  EXPECT_TRUE(
      contains(data(97, -40, 61.5, "°C"), "\"x_axis\":{\"unit\":\"\u00a0h\",\"decimals\":2,\"low\":0,\"high\":97}"));
  EXPECT_TRUE(contains(data(97, -40, 61.5, "°C"), "\"y_axis\":{\"unit\":\"\u00a0°C\",\"decimals\":1,\"low\":-40,"));
  EXPECT_TRUE(contains(data(97, 0.01, 0.05, "°/h"), "\"unit\":\"\u00a0°/\u2060h\",\"decimals\":5,"));
  EXPECT_TRUE(contains(data(97, 0, 25000, "1"), "\"unit\":\"\",\"decimals\":0,"));
  EXPECT_TRUE(contains(data(97, 5, 5, "K"), "\"decimals\":3,\"low\":5,\"high\":5}")) << "a constant";
  figure.lines[0].y = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  EXPECT_TRUE(contains(chart_data(figure, Language::english, 100, ""), "\"low\":0,\"high\":0}"));
}

TEST(CalibrationPage, WrapsLetterheadInsteadOfTitle) {
  EXPECT_TRUE(contains(page_of(sample_calibration()), ".letterhead { display: flex; flex-wrap: wrap;"));
}

TEST(CalibrationPage, ReservesWidthOfValuesInLegend) {
  const std::string page = page_of(sample_calibration());
  EXPECT_TRUE(contains(page, "box.style.minWidth"));
  EXPECT_TRUE(contains(page, "valueFormatter: written_by(data.y_axis)"));
}

TEST(ChartData, HasMarkOfSimulatedData) {
  const FigureData figure = sample_calibration().figures[0];
  EXPECT_TRUE(contains(chart_data(figure, Language::english, 100, "SIMULATED"), "\"mark\":\"SIMULATED\""));
  EXPECT_TRUE(contains(chart_data(figure, Language::english, 100, ""), "\"mark\":\"\""));
}

TEST(CalibrationPage, HasNarrowFigureWhereZoomIsMissing) {
  const CalibrationReport report = sample_calibration();
  const std::string page = page_of(report);
  const auto plain = std::ranges::count_if(report.figures, [](const auto& figure) { return !can_be_enlarged(figure); });
  ASSERT_GT(plain, 0);
  EXPECT_EQ(count_occurrences(page, "<div class=\"narrow\">"), plain);
  EXPECT_EQ(count_occurrences(page, "<div class=\"static wide\""), plain);
}

TEST(ChartData, IsOmittedWhenXReverses) {
  FigureData figure = sample_calibration().figures[0];
  EXPECT_TRUE(can_be_enlarged(figure));
  std::swap(figure.lines[0].x[3], figure.lines[0].x[4]);
  EXPECT_FALSE(can_be_enlarged(figure));
  EXPECT_FALSE(can_be_enlarged(sample_calibration().figures[2]));
}

TEST(CalibrationTable, HasLinePerValue) {
  const CalibrationReport report = sample_calibration();
  int values = 0;
  for (const ResultTable& table : report.results)
    for (const Column& column : table.columns) values += static_cast<int>(column.values.size());
  const std::string csv = results_to_csv(report);
  EXPECT_EQ(count_occurrences(csv, "\r\n"), values + 1);
  EXPECT_TRUE(csv.starts_with("mark,report,axis,stage,group,result,detail,run,in_sample,row,quantity,value,u,k,U,"));
  EXPECT_TRUE(contains(csv, "\r\nSIMULATED,C-2026-0042,u1.x,uncompensated,turn_on,turn_on_repeatability,,"));
  EXPECT_TRUE(contains(csv, ",no,1,compensated_bias,0.002,3e-05,2.01954")) << csv.substr(csv.size() - 500);
  EXPECT_TRUE(contains(csv, ",41.7,°/h\r\n"));
  EXPECT_TRUE(contains(csv, ",no,1,set_point,20,,,,,°C\r\n"));
}

TEST(CalibrationTable, QuotesFieldsByRfc4180) {
  CalibrationReport report = sample_calibration();
  report.results.resize(1);
  report.results[0].detail = "a, \"b\"\nc";
  report.results[0].axis = "=1+1";
  const std::string csv = results_to_csv(report);
  EXPECT_TRUE(contains(csv, ",\"a, \"\"b\"\"\nc\","));
  EXPECT_TRUE(contains(csv, ",'=1+1,")) << "the quote keeps spreadsheets from executing it";
}

TEST(CalibrationSchema, AcceptsWrittenReport) {
  const std::string root = GYROTHERM_SOURCE_DIR;
  const auto json = std::filesystem::temp_directory_path() /
                    fmt::format("gyrotherm-calibration-{}.json", static_cast<long>(::getpid()));
  std::ofstream(json) << to_json(sample_calibration());
  const std::string command = "python3 " + root + "/tests/report/validate_calibration.py " + root +
                              "/report/calibration.schema.json " + json.string();
  const int status = std::system(command.c_str());
  std::filesystem::remove(json);
  if (!WIFEXITED(status) || WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 127)
    GTEST_SKIP() << "python3 with python3-jsonschema is not installed";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace gyrotherm::report
