#include "report/html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "plot/svg.hpp"
#include "report/html_results.hpp"
#include "report/html_sections.hpp"
#include "report/style_sheet.hpp"

namespace gyrotherm {
namespace {

constexpr const char* kSimulatedBanner =
    "<div class=\"banner\"><b>SIMULATED</b>virtual instruments: every number below describes the simulation, no real "
    "gyro</div>\n"
    "<div class=\"watermark\" aria-hidden=\"true\">SIMULATED</div>\n";

constexpr const char* kMeaning =
    "<p>Figures of the rate program are <b>in-sample</b>: the models were fitted to these very data, so they say how "
    "well a model can "
    "describe the record, not how well it will compensate. They are not a verification. Leave-cycle-out predicts each "
    "cycle by a model "
    "refitted without it. Only the random program, never used for selection, scaling, tuning or fitting, verifies a "
    "model.</p>\n";

constexpr const char* kNumbersMeaning =
    "<p class=\"note\">STD is the sample standard deviation of the cluster means (eq. 11). The noise floor comes from "
    "differences of "
    "neighbouring means within the last hour of each hold; it does not see bias instability slower than some minutes. "
    "The paper’s "
    "“improvement from traditional method” is a ratio of two percentages; the reduction of the three-point residual is "
    "what a user "
    "gains.</p>\n";

constexpr const char* kNoiseMeaning =
    "<p>The bias in the last hour of each hold shows the gyro’s own noise, which no compensation removes. Over longer "
    "times the whole run shows what temperature does, and what is left of it after compensation.</p>\n";

/// The page as it grows: sections are numbered as they come.
class Page {
 public:
  explicit Page(const std::vector<ReportFigure>& figures) : figures_(figures) {}

  void section(const std::string& title) {
    html_ += fmt::format("<h2><span class=\"number\">{}</span>{}</h2>\n", ++sections_, title);
  }
  void add(const std::string& html) { html_ += html; }
  void figure(const std::string& id, const char* style = "") {
    const auto found = std::ranges::find(figures_, id, &ReportFigure::id);
    assert(found != figures_.end());
    html_ += fmt::format("<figure id=\"{}\" class=\"{}\">\n{}<figcaption><b>{}</b> {}</figcaption>\n</figure>\n", id,
                         style, found->svg, escaped(found->heading), escaped(found->caption));
  }
  [[nodiscard]] const std::string& html() const { return html_; }

 private:
  const std::vector<ReportFigure>& figures_;
  std::string html_;
  int sections_ = 0;
};

void add_experiment(Page& page, const ReportView& view) {
  page.section("Experiment");
  page.add(
      "<p>The chamber follows the program; thermometers and gyro are read once a second, and everything below works on "
      "means over " +
      decimal(view.cluster_length_s, 0) + "&nbsp;s.</p>\n");
  page.figure("figure-4");
  page.section("Noise of the gyro");
  page.add(kNoiseMeaning);
  page.add(noise_section(view));
  page.figure("allan");
  page.section("Which gradients matter");
  page.figure("table-3", "narrow");
  page.figure("figure-5");
  page.add(selection_section(view));
}

void add_results(Page& page, const ReportView& view) {
  page.section("Compensation on the rate program");
  page.add(kMeaning);
  page.add(result_table(view.rate, "Table 4"));
  page.add(kNumbersMeaning);
  page.add(parts_table(view.rate));
  for (const char* id : {"figure-6", "figure-7", "figure-7-with-temperature"}) page.figure(id);
  page.section("Verification on the random program");
  page.add(result_table(view.random, "Table 5"));
  page.add(parts_table(view.random));
  page.figure("figure-8");
  page.figure("figure-8-program");
  page.section("Methods side by side");
  page.add(methods_section(view));
}

void add_appendix(Page& page, const ReportView& view) {
  page.section("Models and tuning");
  page.add(models_section(view));
  page.figure("tuning");
  page.section("Warnings");
  page.add(warnings_section(view));
  if (const auto thermometers = thermometers_section(view); !thermometers.empty()) {
    page.section("Thermometers");
    page.add(thermometers);
  }
  page.section("Provenance");
  page.add(provenance_section(view));
  page.section("Segments");
  page.add(segments_table(view));
}

}  // namespace

std::string html_of(const ReportView& view, const std::vector<ReportFigure>& figures) {
  Page page(figures);
  page.add("<p class=\"kind\">Calibration report</p>\n<h1>Temperature compensation of gyro bias</h1>\n");
  page.add(fmt::format("<p class=\"subtitle\">{}</p>\n", escaped(view.rig_title)));
  page.add(identity_section(view));
  page.section("Result");
  page.add(summary_section(view));
  add_experiment(page, view);
  add_results(page, view);
  add_appendix(page, view);
  const std::string title =
      fmt::format("{}Calibration report – {}", view.simulated ? "SIMULATED – " : "", escaped(view.rig_title));
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\"/>\n<title>{}</title>\n<style>{}</style>\n"
      "</head>\n<body>\n{}<main>\n{}<footer>gyrotherm {} · made from report.json "
      "alone</footer>\n</main>\n</body>\n</html>\n",
      title, style_sheet(view.simulated), view.simulated ? kSimulatedBanner : "", page.html(),
      escaped(view.program_version));
}

}  // namespace gyrotherm
