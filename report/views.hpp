// SPDX-License-Identifier: Apache-2.0
/// Views of a report: its figures, its HTML page, and the folder that contains them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "report/report.hpp"

namespace gyrotherm::report {

/// A figure of the qualification report. Figures are numbered in the order in which the page shows them.
struct ReportFigure {
  std::string id;       ///< file name: "<id>.svg"
  std::string caption;  ///< one or two sentences, plain text
  std::string svg;
};

/// Returns all figures: the thermal image if there is one, temperatures and bias of both runs, |r| as an array and as
/// curves, each model on the ramp run, all models on the random run, the Allan deviation of both runs, and the
/// convergence of each swarm. The ids come from the paper's figures.
[[nodiscard]] std::vector<ReportFigure> all_figures(const Report& report);

/// Returns the paper's Tables 1 and 2 as HTML, or the reason why they are missing.
[[nodiscard]] std::string thermal_html(const Report& report);

/// Returns the thermal image of the gyro; nothing if the gyro has no finite-element model.
[[nodiscard]] std::optional<ReportFigure> thermal_figure(const Report& report);

/// Returns the characteristic values of the ramp run's bias, before and after compensation, as HTML tables.
[[nodiscard]] std::string characterisation_html(const Report& report);

/// Returns the uncertainty of the compensated bias and the validity of each model over time as HTML tables: the budget
/// of multi-point with temperature, and a row per method.
[[nodiscard]] std::string uncertainty_html(const Report& report);

/// Returns the contents of the page as HTML without its head and footer. `figures` is the result of
/// all_figures(report).
[[nodiscard]] std::string body_html(const Report& report, const std::vector<ReportFigure>& figures);

/// Returns the qualification report as a self-contained HTML page for screen and print: no script, no network access,
/// figures inline. `figures` is the result of all_figures(report).
[[nodiscard]] std::string to_html(const Report& report, const std::vector<ReportFigure>& figures);

/// Writes `folder`/report.json (the given text), `folder`/report.html and `folder`/figures/*.svg. Creates the folders
/// if needed. Each file is written under a temporary name and then renamed; it therefore appears completely or not at
/// all. Fails with bad_file, before writing, if the text is not a complete report; fails with storage.
[[nodiscard]] Result<void> write_report(const std::string& report_json_text, const std::string& folder);

/// Writes the views from the report.json in `folder` (`gyrotherm report DIR`). Fails like write_report(), and with
/// storage if report.json cannot be read.
[[nodiscard]] Result<void> rebuild_report(const std::string& folder);

}  // namespace gyrotherm::report
