/// The parts of the HTML report that are figures of merit, each as a piece of HTML.
#pragma once

#include <string>

#include "report/report_view.hpp"

namespace gyrotherm {

/// Q, N, B, K and R of both runs with their standard errors, and how they were read.
[[nodiscard]] std::string noise_section(const ReportView& view);
/// Tables 4 and 5: `run` before and after, the improvement said both ways, and the noise floor.
[[nodiscard]] std::string result_table(const RunView& run, const std::string& heading);
/// Ramps, holds and the ten minutes after each corner, apart, with what each figure is worth.
[[nodiscard]] std::string parts_table(const RunView& run);
/// In-sample, leave-one-cycle-out, nested and random, for every method, with its size and its source.
[[nodiscard]] std::string methods_section(const ReportView& view);

}  // namespace gyrotherm
