// SPDX-License-Identifier: Apache-2.0
/// The views of a report: its figures, a page of HTML, and the folder that holds them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "report/report.hpp"

namespace gyrotherm::report {

/// A figure of the calibration report, numbered as in the paper.
struct ReportFigure {
  std::string id;       ///< its file is "<id>.svg"
  std::string heading;  ///< "Figure 4"
  std::string caption;  ///< one or two sentences, plain text
  std::string svg;
};

/// All figures, in the order of the report: the thermal image where there is one (Figure 1), temperatures and bias of
/// both runs (Figure 4), |r| as an array (Table 3) and as curves (Figure 5), each model on the rate run (Figures 6 and
/// 7), all on the random run (Figure 8), the Allan deviation of both runs, and how each swarm went on.
[[nodiscard]] std::vector<ReportFigure> all_figures(const Report& report);

/// Returns the paper's Tables 1 and 2 as tables of the page, or for which reason they are not shown.
[[nodiscard]] std::string thermal_html(const Report& report);

/// Returns the thermal image of the gyro (Figure 1); nothing where the gyro has no finite-element model.
[[nodiscard]] std::optional<ReportFigure> thermal_figure(const Report& report);

/// The figures that a laboratory reports of the rate run's bias, before and after compensation, as tables of the page.
[[nodiscard]] std::string characterisation_html(const Report& report);

/// How uncertain the compensated bias is, and whether each model lasts: the budget of multi-point with temperature, and
/// a row for each method, as tables of the page.
[[nodiscard]] std::string uncertainty_html(const Report& report);

/// What the page of a report says, as HTML, without its head and foot. `figures` as all_figures(report) gives them.
[[nodiscard]] std::string body_of(const Report& report, const std::vector<ReportFigure>& figures);

/// The calibration report as one self-contained HTML page: no script, no network, figures inline, made to be printed
/// too. `figures` as all_figures(report) gives them.
[[nodiscard]] std::string html_of(const Report& report, const std::vector<ReportFigure>& figures);

/// Writes `folder`/report.json (the text as given), `folder`/report.html and `folder`/figures/*.svg, making the folders
/// if needed. Each file appears whole or not at all: it is written under a temporary name and renamed. Fails with
/// bad_file if the text is not a complete report (nothing is written then), or with storage.
[[nodiscard]] Result<void> write_report(const std::string& report_json_text, const std::string& folder);

/// The same from the report.json that is already in `folder`: `gyrotherm report DIR`. Fails also with storage if it
/// cannot be read.
[[nodiscard]] Result<void> rebuild_report(const std::string& folder);

}  // namespace gyrotherm::report
