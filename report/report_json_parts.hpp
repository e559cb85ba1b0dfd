/// The long parts of report.json, each the value of one key of its first level, as JSON text. For report_json.cpp
/// alone.
#pragma once

#include <array>
#include <string>
#include <utility>

#include "report/report_json.hpp"

namespace gyrotherm {

/// A Verification or a Model of each kind, by the key of the report.
template <class Run>
auto by_key(const Run& run) {
  return std::array{std::pair{"three_point", &run.three_point}, std::pair{"multi_point", &run.multi_point},
                    std::pair{"multi_point_t", &run.multi_point_t}};
}

/// "rate", "random": what a record is, its floor and noise, and how each model does on it.
[[nodiscard]] std::string run_json(const ReportedRun& run);
/// "segments": each of both runs, with the residual of each model.
[[nodiscard]] std::string segments_json(const ReportInput& input);
/// "series": what the figures draw.
[[nodiscard]] std::string series_json(const ReportInput& input);

/// "rate_leave_cycle_out", and the same with the parameters chosen without the held-out cycle too, null where that was
/// not done.
[[nodiscard]] std::string leave_cycle_out_json(const ReportedModels& models);
[[nodiscard]] std::string nested_leave_cycle_out_json(const ReportedModels& models);
/// "models": what each takes in, was trained on, and how large it is.
[[nodiscard]] std::string models_json(const ReportedModels& models);
/// "tuning": how the swarm found its parameters, and the certificate of the result.
[[nodiscard]] std::string tuning_json(const ReportedModels& models);
/// "methods": the three models and all that are compared with them, one row each.
[[nodiscard]] std::string methods_json(const ReportInput& input);

}  // namespace gyrotherm
