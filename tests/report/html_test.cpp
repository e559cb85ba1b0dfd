// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "report/views.hpp"
#include "tests/report/synthetic_experiment.hpp"
#include "tests/support/markup.hpp"

namespace gyrotherm::report {
namespace {

std::string page_of(const Report& report) { return to_html(report, all_figures(report)); }

TEST(HtmlReport, IsWellFormed) {
  const SyntheticExperiment experiment;
  EXPECT_EQ(tests::markup_error(page_of(experiment.report())), "");
}

TEST(HtmlReport, GivesEqualBytesEachTime) {
  const SyntheticExperiment experiment;
  EXPECT_EQ(page_of(experiment.report()), page_of(experiment.report()));
}

TEST(HtmlReport, LoadsNothing) {
  const SyntheticExperiment experiment;
  const std::string page = page_of(experiment.report());
  constexpr const char* kNamespace = "http://www.w3.org/2000/svg";
  EXPECT_EQ(tests::count_occurrences(page, "http://"), tests::count_occurrences(page, kNamespace));
  for (const char* word : {"https:", "src=", "href=", "@import", "<script", "url(http", "url(//"})
    EXPECT_EQ(tests::count_occurrences(page, word), 0) << word;
}

TEST(HtmlReport, ShowsSimulatedInBannerPrintAndEveryFigure) {
  const SyntheticExperiment experiment;
  const Report report = experiment.report();
  const auto figures = all_figures(report);
  for (const ReportFigure& figure : figures)
    EXPECT_GE(tests::count_occurrences(figure.svg, "SIMULATED"), 2) << figure.id;
  const std::string page = to_html(report, figures);
  EXPECT_EQ(tests::count_occurrences(page, "class=\"banner\"><b>SIMULATED"), 1);
  EXPECT_EQ(tests::count_occurrences(page, "@top-center { content: \"SIMULATED"), 1);
  EXPECT_EQ(tests::count_occurrences(page, "class=\"watermark\""), 1);
  EXPECT_EQ(tests::count_occurrences(page, "<title>SIMULATED"), 1 + static_cast<int>(figures.size()));
}

TEST(HtmlReport, LabelsDigestsOfRecords) {
  Report report = SyntheticExperiment().report();
  report.rate.record_file_sha256 = std::string(64, '7');
  report.rate.record_sha256 = std::string(64, '8');
  report.random.record_file_sha256.clear();
  const std::string page = page_of(report);
  const auto row = [&](const std::string& name, const std::string& digest) {
    const auto at = page.find(name + "</td>"), end = page.find("</tr>", at);
    return at != std::string::npos && page.substr(at, end - at).find(digest) != std::string::npos;
  };
  EXPECT_TRUE(row("Ramp record, file", report.rate.record_file_sha256));
  EXPECT_TRUE(row("Ramp record, rows as exported", report.rate.record_sha256));
  EXPECT_TRUE(row("Random record, rows as exported", report.random.record_sha256));
  EXPECT_EQ(page.find("Random record, file"), std::string::npos) << "the digest of the file is unknown";
}

TEST(HtmlReport, ShowsThatNarrowTablesAndFiguresContinue) {
  const SyntheticExperiment experiment;
  const std::string page = page_of(experiment.report());
  const auto narrow = page.find("@media screen and (max-width: 760px)");
  ASSERT_NE(narrow, std::string::npos);
  EXPECT_NE(page.find("table, figure { background: linear-gradient", narrow), std::string::npos);
  EXPECT_NE(page.find("caption span { display: block; position: sticky;"), std::string::npos);
  EXPECT_EQ(tests::count_occurrences(page, "<caption>"), tests::count_occurrences(page, "<caption><span>"))
      << "captions remain in view while a table is scrolled";
}

TEST(HtmlReport, RoundsTemperaturesInNamesOfSegments) {
  const SyntheticExperiment experiment;
  Report report = experiment.report();
  ASSERT_GE(report.segments.size(), 3U);
  report.segments[0].name = "ramp to -10.1315 °C";
  report.segments[1].name = "hold -40 °C";
  report.segments[2].name = "check 7.1315 of <x>";
  const std::string page = page_of(report);
  for (const char* name : {">ramp to −10.1 °C<", ">hold −40 °C<", ">check 7.1315 of &lt;x&gt;<", ">Kind<"})
    EXPECT_NE(page.find(name), std::string::npos) << name;
}

TEST(HtmlReport, OmitsSimulatedForRealRig) {
  const SyntheticExperiment experiment(1, false);
  EXPECT_EQ(tests::count_occurrences(page_of(experiment.report()), "SIMULATED"), 0);
}

TEST(HtmlReport, ShowsEveryFigureOfPaper) {
  const SyntheticExperiment experiment;
  const std::string page = page_of(experiment.report());
  for (const char* id : {"figure-4", "table-3", "figure-5", "figure-6", "figure-7", "figure-7-with-temperature",
                         "figure-8", "allan", "tuning"}) {
    EXPECT_EQ(tests::count_occurrences(page, "<figure id=\"" + std::string(id) + "\""), 1) << id;
  }
}

TEST(HtmlReport, IsHeadedQualificationReport) {
  const SyntheticExperiment experiment;
  const std::string page = page_of(experiment.report());
  EXPECT_EQ(tests::count_occurrences(page, "<p class=\"kind\">Qualification report</p>"), 1);
  EXPECT_EQ(tests::count_occurrences(page, "Calibration report"), 0);
}

/// Returns the numbers after each occurrence of `label`, in order: {1, 2} for "<b>Table 1</b> … <b>Table 2</b>".
std::vector<int> numbers_after(const std::string& page, const std::string& label) {
  std::vector<int> numbers;
  for (auto at = page.find(label); at != std::string::npos; at = page.find(label, at + 1))
    numbers.push_back(std::stoi(page.substr(at + label.size())));
  return numbers;
}

TEST(HtmlReport, NumbersCaptionsFromOneWithoutGaps) {
  const SyntheticExperiment experiment;
  const std::string page = page_of(experiment.report());
  for (const auto& [label, captions] :
       {std::pair{"<caption><span><b>Table ", "<caption>"}, {"<figcaption><b>Figure ", "<figcaption>"}}) {
    std::vector<int> expected(static_cast<std::size_t>(tests::count_occurrences(page, captions)));
    std::iota(expected.begin(), expected.end(), 1);
    EXPECT_GT(expected.size(), 8u) << label;
    EXPECT_EQ(numbers_after(page, label), expected) << label;
  }
}

TEST(HtmlReport, HasSmallWellFormedFigures) {
  const SyntheticExperiment experiment(12);
  const auto figures = all_figures(experiment.report());
  EXPECT_GE(figures.size(), 7u);
  for (const ReportFigure& figure : figures) {
    EXPECT_EQ(tests::markup_error(figure.svg), "") << figure.id;
    EXPECT_LT(figure.svg.size(), 150000U) << figure.id;
    EXPECT_EQ(tests::count_occurrences(figure.svg, "nan"), 0) << figure.id;
  }
}

/// Returns the path of the first curve of a figure. Skips the clip paths before it.
std::string first_path(const std::string& svg) {
  const auto begin = svg.find("<path d=\"");
  return svg.substr(begin, svg.find("\" fill", begin) - begin);
}

TEST(HtmlReport, BreaksLineAtGap) {
  const SyntheticExperiment experiment;
  Report report = experiment.report();
  const auto lines_of = [&](const char* id) {
    const auto figures = all_figures(report);
    return tests::count_occurrences(first_path(std::ranges::find(figures, id, &ReportFigure::id)->svg), "M");
  };
  EXPECT_EQ(lines_of("figure-6"), 1);
  std::vector<double>& time_s = report.rate.series.time_s;
  for (std::size_t k = time_s.size() / 2; k < time_s.size(); ++k) time_s[k] += 3 * report.cluster_length_s;
  for (const char* id : {"figure-4", "figure-6", "figure-7"}) EXPECT_EQ(lines_of(id), 2) << id;
}

TEST(HtmlReport, PrintsValuesLikePaper) {
  SyntheticExperiment experiment;
  auto& models = experiment.qualification.models;
  for_each_model(models, [](const char*, model::TrainedModel& trained) { trained.rate.raw.std = 0.0258; });
  models.three_point.rate.compensated.std = 0.0089;
  models.multi_point.rate.compensated.std = 0.0021;
  const std::string page = page_of(experiment.report());
  for (const char* cell :
       {">0.0258<", "<b>0.0089</b>", "<b>0.0021</b>", ">65.5 %<", ">91.9 %<", ">40.2 %<", ">76.4 %<"}) {
    EXPECT_GE(tests::count_occurrences(page, cell), 1) << cell;
  }
}

TEST(HtmlReport, MarksInSampleResults) {
  const SyntheticExperiment experiment;
  const std::string page = page_of(experiment.report());
  EXPECT_GE(tests::count_occurrences(page, "in-sample: the models were fitted to these data"), 1);
  EXPECT_GE(tests::count_occurrences(page, "They are not a verification."), 1);
}

TEST(HtmlReport, EscapesNamesFromFiles) {
  const SyntheticExperiment experiment;
  Report report = experiment.report();
  report.rig.title = "<script>alert('x')</script> & co";
  report.warnings = {"a < b"};
  const std::string page = page_of(report);
  EXPECT_EQ(tests::count_occurrences(page, "<script"), 0);
  EXPECT_EQ(tests::markup_error(page), "");
}

TEST(HtmlReport, ShowsStandardErrorInEachTile) {
  const SyntheticExperiment experiment;
  const Report report = experiment.report();
  const std::string page = page_of(report);
  const auto begin = page.find("<div class=\"keys\">"), end = page.find("</p>", begin);
  ASSERT_NE(begin, std::string::npos);
  EXPECT_EQ(tests::count_occurrences(page.substr(begin, end - begin), ", standard error "),
            std::isfinite(report.random.floor.error_deg_per_h) ? 5 : 4);
}

TEST(HtmlReport, MarksTilesOfLeastResidual) {
  Report report = SyntheticExperiment().report();
  const auto marked = [&](double three_point, double multi_point, double with_temperature) {
    report.random.raw.std = 1;
    report.random.residual.three_point.all.std = three_point;
    report.random.residual.multi_point.all.std = multi_point;
    report.random.residual.multi_point_t.all.std = with_temperature;
    const std::string page = page_of(report);
    std::string found;
    const std::string begin = "<div class=\"key ";
    for (auto at = page.find(begin); at != std::string::npos; at = page.find(begin, at + 1))
      found += page.substr(at + begin.size(), 4) == "best" ? '1' : '0';
    return found.substr(0, 4);  // raw, three-point, multi-point, with temperature
  };
  EXPECT_EQ(marked(0.5, 0.3, 0.1), "0001");
  EXPECT_EQ(marked(0.5, 0.0025, 0.0026), "0010");
  EXPECT_EQ(marked(0.5, 0.3, 0.3), "0011") << "equal as printed";
  EXPECT_EQ(marked(1.5, 1.3, 1.1), "0000") << "no model reduces the bias";
}

TEST(HtmlReport, HasMinusSignsInWarnings) {
  Report report = SyntheticExperiment().report();
  report.warnings = {"the mean is -0.02801 °/h over A-B"};
  const std::string page = page_of(report);
  EXPECT_NE(page.find("the mean is −0.02801 °/h over A-B"), std::string::npos);
}

TEST(HtmlReport, ShowsErrorOfEachFigureOfMerit) {
  const SyntheticExperiment experiment;
  const std::string page = page_of(experiment.report());
  EXPECT_GE(tests::count_occurrences(page, "0.001870 ± 0.000060"), 2) << "noise floor of both runs";
  EXPECT_GE(tests::count_occurrences(page, "n<sub>eff</sub>"), 2);
  EXPECT_GE(tests::count_occurrences(page, "the linear part of a model continues there"), 1);
}

TEST(HtmlReport, ShowsLimitOfUndetectedNoise) {
  const std::string page = page_of(SyntheticExperiment().report());
  EXPECT_GE(tests::count_occurrences(page, "not significant, &lt;"), 1);
  EXPECT_GE(tests::count_occurrences(page, "<td>angle random walk</td>"), 1);
}

TEST(HtmlReport, CitesEachSourceOnce) {
  Report report = SyntheticExperiment().report();
  report.methods.back().citation = "A. Author, J. Tests 1 (2001) <1>";
  const std::string page = page_of(report);
  EXPECT_EQ(tests::count_occurrences(page, "A. Author, J. Tests 1 (2001) &lt;1&gt;"), 1);
  EXPECT_EQ(tests::count_occurrences(page, "Li et al., Sensors 15 (2015)"), 1) << "three models share this source";
}

TEST(HtmlReport, StatesRuleOfRecommendation) {
  Report report = SyntheticExperiment().report();
  EXPECT_GE(tests::count_occurrences(page_of(report),
                                     "Recommended by rule: <b>linear-seven-point</b>, the fewest stored parameters"),
            1);
  report.recommendation = model::recommend({});
  EXPECT_GE(
      tests::count_occurrences(page_of(report), "Recommended by rule: none: no independent record for the choice"), 1);
}

TEST(HtmlReport, CharacterisesBiasBeforeAndAfterCompensation) {
  Report report = SyntheticExperiment().report();
  model::Characterisation& result = report.rate.characterisation;
  result.ramp = {.before = {0.00214, 0.00006}, .after = {0.00012, 0.00006}};
  result.temperature = {};
  result.stabilised = {{.segment = 4,
                        .set_point_c = 20,
                        .temperature_c = 20.65,
                        .clusters = 36,
                        .bias = {.before = {0.0131, 0.0003}, .after = {0.0002, 0.0003}}}};
  result.two_position = {{.set_point_c = 20,
                          .as_mounted = 2,
                          .turned = 1,
                          .bias = {.before = {0.0129, 0.0002}, .after = {0.0001, 0.0002}},
                          .earth_rate = {.before = {10.6354, 0.0002}, .after = {10.6355, 0.0002}},
                          .stated_earth_rate_deg_per_h = 10.63564}};
  result.warm_ups = {{.segment = 5, .set_point_c = -40, .within = {}, .seconds = {}}};
  const std::string page = page_of(report);
  EXPECT_EQ(tests::markup_error(page), "");
  EXPECT_GE(tests::count_occurrences(page, "0.002140 ± 0.000060") + tests::count_occurrences(page, "0.00214 ± 0.00006"),
            1);
  EXPECT_GE(tests::count_occurrences(page, "Hold bias at each temperature"), 1);
  EXPECT_GE(tests::count_occurrences(page, "Bias and Earth rate, separated by turning the gyro around"), 1);
  EXPECT_GE(tests::count_occurrences(page, "by the rig file 10.63564 °/h"), 1);
  EXPECT_GE(tests::count_occurrences(page, "if the gyro was switched on in segment 6"), 1);
  EXPECT_GE(tests::count_occurrences(page,
                                     "Temperature, linear fit to the hold biases</td><td>°/h/K</td><td "
                                     "class=\"n\">–</td>"),
            1)
      << "an unknown value is shown as a dash";
}

TEST(HtmlReport, ShowsBudgetAndResultsOfLaterRuns) {
  const SyntheticExperiment experiment;
  const Report report = experiment.report();
  const std::string html = to_html(report, all_figures(report));
  EXPECT_NE(html.find("Thermometer drift A"), std::string::npos);
  EXPECT_NE(html.find("<b>assumed</b>"), std::string::npos);
  EXPECT_NE(html.find("30 days later: RMSE"), std::string::npos);
  EXPECT_NE(html.find("Combined: U ="), std::string::npos);
}

TEST(HtmlReport, IsCompleteForRecordWithoutHolds) {
  Report report = SyntheticExperiment().report();
  report.random.noise.holds = report.random.noise.compensated_holds = measure_hold_noise(data::Dataset{});
  const std::string page = page_of(report);
  EXPECT_EQ(tests::markup_error(page), "");
  EXPECT_EQ(tests::count_occurrences(page, "nan"), tests::count_occurrences(page, "Provenance"));
  EXPECT_GE(tests::count_occurrences(page, "the record has no hold"), 1);
}

}  // namespace
}  // namespace gyrotherm::report
