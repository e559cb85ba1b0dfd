#include "report/html.hpp"

#include <gtest/gtest.h>

#include "report/report_json.hpp"
#include "tests/report/synthetic_experiment.hpp"
#include "tests/support/markup.hpp"

namespace gyrotherm {
namespace {

ReportView view_of(const ReportInput& input) {
  auto view = read_report(report_json(input), "report.json");
  EXPECT_TRUE(view.has_value()) << (view ? "" : text(view.error()));
  return view.value_or(ReportView{});
}

std::string page_of(const ReportInput& input) {
  const ReportView view = view_of(input);
  return html_of(view, all_figures(view));
}

TEST(HtmlReport, IsWellFormed) {
  const SyntheticExperiment experiment;
  EXPECT_EQ(markup_mistake(page_of(experiment.input())), "");
}

TEST(HtmlReport, IsTheSameBytesEachTime) {
  const SyntheticExperiment experiment;
  EXPECT_EQ(page_of(experiment.input()), page_of(experiment.input()));
}

TEST(HtmlReport, LoadsNothing) {
  const SyntheticExperiment experiment;
  const std::string page = page_of(experiment.input());
  constexpr const char* kNamespace = "http://www.w3.org/2000/svg";
  EXPECT_EQ(count_of(page, "http://"), count_of(page, kNamespace));
  for (const char* word : {"https:", "src=", "href=", "@import", "<script", "url(http", "url(//"})
    EXPECT_EQ(count_of(page, word), 0) << word;
}

TEST(HtmlReport, SaysSimulatedInTheBannerInPrintAndInEveryFigure) {
  const SyntheticExperiment experiment;
  const ReportView view = view_of(experiment.input());
  const auto figures = all_figures(view);
  for (const ReportFigure& figure : figures) EXPECT_GE(count_of(figure.svg, "SIMULATED"), 2) << figure.id;
  const std::string page = html_of(view, figures);
  EXPECT_EQ(count_of(page, "class=\"banner\"><b>SIMULATED"), 1);
  EXPECT_EQ(count_of(page, "@top-center { content: \"SIMULATED"), 1);
  EXPECT_EQ(count_of(page, "class=\"watermark\""), 1);
  EXPECT_EQ(count_of(page, "<title>SIMULATED"), 1 + static_cast<int>(figures.size()));
}

TEST(HtmlReport, OfARealRigNeverSaysSimulated) {
  const SyntheticExperiment experiment(1, false);
  EXPECT_EQ(count_of(page_of(experiment.input()), "SIMULATED"), 0);
}

TEST(HtmlReport, ShowsEveryFigureOfThePaper) {
  const SyntheticExperiment experiment;
  const std::string page = page_of(experiment.input());
  for (const char* id : {"figure-4", "table-3", "figure-5", "figure-6", "figure-7", "figure-7-with-temperature",
                         "figure-8", "allan", "tuning"}) {
    EXPECT_EQ(count_of(page, "<figure id=\"" + std::string(id) + "\""), 1) << id;
  }
}

TEST(HtmlReport, EveryFigureIsWellFormedAndSmall) {
  const SyntheticExperiment experiment(12);
  for (const ReportFigure& figure : all_figures(view_of(experiment.input()))) {
    EXPECT_EQ(markup_mistake(figure.svg), "") << figure.id;
    EXPECT_LT(figure.svg.size(), 150000U) << figure.id;
    EXPECT_EQ(count_of(figure.svg, "nan"), 0) << figure.id;
  }
}

TEST(HtmlReport, PrintsThePapersFiguresAsThePaperDoes) {
  SyntheticExperiment experiment;
  for (Verification* verification :
       {&experiment.rate.three_point, &experiment.rate.multi_point, &experiment.rate.multi_point_t}) {
    verification->raw.std = 0.0258;
  }
  experiment.rate.three_point.compensated.std = 0.0089;
  experiment.rate.multi_point.compensated.std = 0.0021;
  const std::string page = page_of(experiment.input());
  for (const char* cell :
       {">0.0258<", "<b>0.0089</b>", "<b>0.0021</b>", ">65.5 %<", ">91.9 %<", ">40.2 %<", ">76.4 %<"}) {
    EXPECT_GE(count_of(page, cell), 1) << cell;
  }
}

TEST(HtmlReport, SaysThatInSampleIsNotAVerification) {
  const SyntheticExperiment experiment;
  const std::string page = page_of(experiment.input());
  EXPECT_GE(count_of(page, "in-sample: the models were fitted to these data"), 1);
  EXPECT_GE(count_of(page, "They are not a verification."), 1);
}

TEST(HtmlReport, EscapesNamesFromFiles) {
  const SyntheticExperiment experiment;
  ReportInput input = experiment.input();
  input.rig.title = "<script>alert('x')</script> & co";
  input.warnings = {"a < b"};
  const std::string page = page_of(input);
  EXPECT_EQ(count_of(page, "<script"), 0);
  EXPECT_EQ(markup_mistake(page), "");
}

TEST(HtmlReport, PutsAnErrorBesideEachFigureOfMerit) {
  const SyntheticExperiment experiment;
  const std::string page = page_of(experiment.input());
  EXPECT_GE(count_of(page, "0.001870 ± 0.000060"), 2) << "the floor of both runs";
  EXPECT_GE(count_of(page, "n<sub>eff</sub>"), 2);
  EXPECT_GE(count_of(page, "such inputs are moved to the nearer end"), 1);
}

TEST(HtmlReport, ShowsNoiseThatWasNotSeenByItsLimit) {
  const std::string page = page_of(SyntheticExperiment().input());
  EXPECT_GE(count_of(page, "not seen, &lt;"), 1);
  EXPECT_GE(count_of(page, "<td>angle random walk</td>"), 1);
}

TEST(HtmlReport, CitesEachSourceOnce) {
  const std::string page = page_of(SyntheticExperiment().input());
  EXPECT_EQ(count_of(page, "A. Author, J. Tests 1 (2001) &lt;1&gt;"), 1);
  EXPECT_EQ(count_of(page, "Li et al., Sensors 15 (2015)"), 1) << "three models share it";
}

TEST(HtmlReport, OfARecordWithoutHoldsIsStillAReport) {
  SyntheticExperiment experiment;
  experiment.random.noise = noise_of_holds(Dataset{});
  const std::string page = page_of(experiment.input());
  EXPECT_EQ(markup_mistake(page), "");
  EXPECT_EQ(count_of(page, "nan"), count_of(page, "Provenance"));
  EXPECT_GE(count_of(page, "no hold has samples enough without a gap"), 1);
}

}  // namespace
}  // namespace gyrotherm
