/// The Allan deviation of both runs, as a figure of the report.
#pragma once

#include "report/figures.hpp"
#include "report/report_view.hpp"

namespace gyrotherm {

/// On two logarithmic axes, a panel per run: the holds with error bars, the fit and its terms, and the whole run before
/// and after compensation.
[[nodiscard]] ReportFigure allan_figure(const ReportView& view);

}  // namespace gyrotherm
