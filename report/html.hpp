/// The calibration report as one self-contained HTML page: no script, no network, figures inline, made to be printed
/// too.
#pragma once

#include <string>
#include <vector>

#include "report/figures.hpp"
#include "report/report_view.hpp"

namespace gyrotherm {

/// `figures` as all_figures(view) gives them.
[[nodiscard]] std::string html_of(const ReportView& view, const std::vector<ReportFigure>& figures);

}  // namespace gyrotherm
