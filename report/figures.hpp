/// The figures of the calibration report, numbered as in the paper.
#pragma once

#include <string>
#include <vector>

#include "report/report_view.hpp"

namespace gyrotherm {

struct ReportFigure {
  std::string id;       ///< its file is "<id>.svg"
  std::string heading;  ///< "Figure 4"
  std::string caption;  ///< one or two sentences, plain text
  std::string svg;
};

/// Temperature program, block temperature and bias over time: Figure 4 on the rate run.
[[nodiscard]] ReportFigure temperature_figure(const ReportView& view, const RunView& run, const std::string& id,
                                              const std::string& heading);

/// |r| of every gradient with the bias as an array: Table 3.
[[nodiscard]] ReportFigure correlation_array(const ReportView& view);

/// The same as one curve per thermometer, whole and enlarged: Figure 5.
[[nodiscard]] ReportFigure correlation_curves(const ReportView& view);

/// One model on the rate run, before and after, and the error enlarged: Figures 6 and 7.
[[nodiscard]] std::vector<ReportFigure> rate_figures(const ReportView& view);

/// The random run, before and after, and the error of each model enlarged to one scale: Figure 8.
[[nodiscard]] ReportFigure random_figure(const ReportView& view);

/// The best fitness of each swarm, as the RMSE on held-out cycles, over the iterations.
[[nodiscard]] ReportFigure tuning_figure(const ReportView& view);

/// All of the above, in the order of the report.
[[nodiscard]] std::vector<ReportFigure> all_figures(const ReportView& view);

}  // namespace gyrotherm
