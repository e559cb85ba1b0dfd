// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "report/calibration.hpp"

namespace gyrotherm::report {
namespace {

constexpr const char* kHeader =
    "mark,report,axis,stage,group,result,detail,run,in_sample,row,quantity,value,u,k,U,degrees_of_freedom,unit\r\n";

std::string csv_field(std::string_view text) {
  std::string value(text);
  if (!value.empty() && std::string_view("=+-@\t\r").find(value.front()) != std::string_view::npos)
    value.insert(0, 1, '\'');
  if (value.find_first_of(",\"\r\n") == std::string::npos) return value;
  std::string quoted = "\"";
  for (const char c : value) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::string csv_mark(const CalibrationReport& report) {
  std::string mark = report.state == ReportState::draft ? "DRAFT" : "";
  if (report.state == ReportState::superseded) mark = "SUPERSEDED";
  if (report.simulated) mark += mark.empty() ? "SIMULATED" : " SIMULATED";
  return mark;
}

std::string csv_value(const ReportedValue& value) {
  const bool has_u = std::isfinite(value.standard_uncertainty);
  return fmt::format("{},{},{},{},{}", csv_number(value.value), csv_number(value.standard_uncertainty),
                     has_u ? csv_number(value.coverage_factor) : "", csv_number(value.expanded()),
                     has_u ? csv_number(value.degrees_of_freedom) : "");
}

}  // namespace

std::string results_to_csv(const CalibrationReport& report) {
  std::string csv = kHeader;
  for (const ResultTable& table : report.results) {
    const std::string of =
        fmt::format("{},{},{},{},{},{},{},{},{}", csv_mark(report), csv_field(report.number), csv_field(table.axis),
                    name(table.stage), name(table.group), csv_field(table.key), csv_field(table.detail),
                    csv_field(table.run), table.in_sample ? "yes" : "no");
    for (const Column& column : table.columns)
      for (std::size_t row = 0; row < column.values.size(); ++row)
        csv += fmt::format("{},{},{},{},{}\r\n", of, row + 1, csv_field(column.quantity), csv_value(column.values[row]),
                           csv_field(column.unit));
  }
  return csv;
}

}  // namespace gyrotherm::report
