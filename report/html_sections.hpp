/// The parts of the HTML report that are words and tables, each as a piece of HTML.
#pragma once

#include <string>

#include "report/report_view.hpp"

namespace gyrotherm {

/// Rig, gyro, profiles, runs and version.
[[nodiscard]] std::string identity_section(const ReportView& view);
/// The result in words, with its key numbers and the verdict.
[[nodiscard]] std::string summary_section(const ReportView& view);
/// Which gradients were selected, and what else the bias follows.
[[nodiscard]] std::string selection_section(const ReportView& view);
/// What each model is, was trained on, how it was tuned, and its certificate.
[[nodiscard]] std::string models_section(const ReportView& view);
[[nodiscard]] std::string warnings_section(const ReportView& view);
[[nodiscard]] std::string segments_table(const ReportView& view);
/// Who read each channel, and its calibration; empty if the report does not say.
[[nodiscard]] std::string thermometers_section(const ReportView& view);
/// Run ids and SHA-256 of everything that went in.
[[nodiscard]] std::string provenance_section(const ReportView& view);

}  // namespace gyrotherm
