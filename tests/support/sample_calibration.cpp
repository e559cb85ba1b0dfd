// SPDX-License-Identifier: Apache-2.0
#include "tests/support/sample_calibration.hpp"

#include <cmath>
#include <string>
#include <utility>

namespace gyrotherm::report {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
const std::string kRun = "3f7c1a6be0f84c0d9b5e2d417a9c8e11";

ReportedValue exact(double value) { return {.value = value}; }

Column column(std::string quantity, std::string unit, std::vector<ReportedValue> values) {
  return {.quantity = std::move(quantity), .unit = std::move(unit), .values = std::move(values)};
}

ResultTable table(Group group, std::string key, const std::string& axis, Stage stage, std::vector<Column> columns) {
  return {
      .group = group, .key = std::move(key), .axis = axis, .stage = stage, .run = kRun, .columns = std::move(columns)};
}

std::vector<ReportedValue> set_points() { return {exact(20), exact(-40), exact(60)}; }

void add_behaviour(std::vector<ResultTable>& results, const std::string& axis, Stage stage, double size) {
  const auto value = [&](double number, double u, double freedom) {
    return value_with_uncertainty(number * size, u, freedom);
  };
  results.push_back(table(Group::turn_on, "turn_on_repeatability", axis, stage,
                          {column("set_point", "°C", {exact(20)}), column("starts", "1", {exact(5)}),
                           column("std_of_bias", "°/h", {value(0.0021, 0.00074, 4)})}));
  results.push_back(table(Group::warm_up, "warm_up", axis, stage,
                          {column("set_point", "°C", {exact(20)}), column("within", "°/h", {exact(0.0005)}),
                           column("duration", "s", {exact(5400)})}));
  results.push_back(table(
      Group::bias, "stabilised_bias", axis, stage,
      {column("set_point", "°C", set_points()),
       column("temperature", "°C",
              {value_with_uncertainty(25.31, 0.012, kInfinite), value_with_uncertainty(-33.9, 0.02, kInfinite),
               value_with_uncertainty(65.2, 0.02, kInfinite)}),
       column("bias", "°/h", {value(0.00214, 0.00003, 35), value(-0.1241, 0.00031, 35), value(0.2034, 0.0004, 35)})}));
  results.push_back(
      table(Group::bias, "retrace", axis, stage,
            {column("set_point", "°C", {exact(20)}), column("change", "°/h", {value(-0.0004, 0.00011, 60)})}));
  results.push_back(table(Group::sensitivity, "temperature_sensitivity", axis, stage,
                          {column("temperature_sensitivity", "°/h/K", {value(0.00331, 0.000041, 12.4)})}));
  ResultTable gradient = table(Group::sensitivity, "gradient_sensitivity", axis, stage,
                               {column("gradient_sensitivity", "°/h/K", {value(0.0511, 0.0021, 30)})});
  gradient.detail = "A-D";
  results.push_back(std::move(gradient));
  results.push_back(table(Group::hysteresis, "hysteresis", axis, stage,
                          {column("temperature", "°C", {exact(0), exact(10)}),
                           column("width", "°/h", {value(0.0121, 0.0004, 50), value(0.0133, 0.0005, 50)})}));
  results.push_back(table(Group::random_drift, "angle_random_walk", axis, stage,
                          {column("angle_random_walk", "°/√h", {value_with_uncertainty(0.00031, 0.000006, 900)})}));
  results.push_back(
      table(Group::compensation, "whole_run", axis, stage,
            {column("mean", "°/h", {value(0.0118, 0.0009, 40)}), column("std", "°/h", {value(0.0782, 0.0051, 118)}),
             column("rmse", "°/h", {value(0.0791, 0.0052, 118)}), column("largest", "°/h", {exact(0.31 * size)})}));
}

void add_compensated_mean(std::vector<ResultTable>& results, const std::string& axis, Stage stage, double mean,
                          double u) {
  results.push_back(table(Group::compensation, "compensated_mean", axis, stage,
                          {column("compensated_bias", "°/h", {value_with_uncertainty(mean, u, 41.7)})}));
}

ReportedBudget budget(const std::string& axis, Stage stage) {
  return {.axis = axis,
          .stage = stage,
          .run = kRun,
          .budget = {.averaging_s = 3600,
                     .rows = {{.source = model::Source::angle_random_walk,
                               .evaluation = model::Evaluation::a,
                               .standard_uncertainty = 0.0003,
                               .degrees_of_freedom = 900},
                              {.source = model::Source::hysteresis,
                               .evaluation = model::Evaluation::b,
                               .distribution = model::ErrorDistribution::rectangular,
                               .standard_uncertainty = 0.0002},
                              {.source = model::Source::thermometer_drift,
                               .of = "A",
                               .evaluation = model::Evaluation::b,
                               .standard_uncertainty = 0.05,
                               .sensitivity = 0.004,
                               .assumed = true},
                              {.source = model::Source::azimuth,
                               .evaluation = model::Evaluation::b,
                               .standard_uncertainty = 0.1,
                               .sensitivity = 0.013}}}};
}

std::vector<double> series(int count, double scale, double shift) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(scale * std::sin(0.05 * i) + shift);
  return values;
}

std::vector<double> hours(int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(i / 36.0);
  return values;
}

void add_figures(std::vector<FigureData>& figures, const std::string& axis) {
  constexpr int kPoints = 400;
  figures.push_back(
      {.key = "temperatures",
       .axis = axis,
       .run = kRun,
       .x_key = "time",
       .x_unit = "h",
       .y_key = "temperature",
       .y_unit = "°C",
       .lines = {{.key = "set_point", .x = hours(kPoints), .y = series(kPoints, 50, 10)},
                 {.key = "temperature", .detail = "A", .x = hours(kPoints), .y = series(kPoints, 45, 15)},
                 {.key = "temperature", .detail = "B", .x = hours(kPoints), .y = series(kPoints, 44, 16)}}});
  figures.push_back(
      {.key = "bias_course",
       .axis = axis,
       .run = kRun,
       .x_key = "time",
       .x_unit = "h",
       .y_key = "bias",
       .y_unit = "°/h",
       .lines = {{.key = "bias", .x = hours(kPoints), .y = series(kPoints, 0.2, 0.05)},
                 {.key = "bias", .stage = Stage::as_left, .x = hours(kPoints), .y = series(kPoints, 0.004, 0)}}});
  figures.push_back(
      {.key = "allan_deviation",
       .axis = axis,
       .run = kRun,
       .x_key = "averaging_time",
       .x_unit = "s",
       .y_key = "allan_deviation",
       .y_unit = "°/h",
       .logarithmic = true,
       .lines = {{.key = "bias",
                  .x = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024},
                  .y = {0.04, 0.02, 0.01, 0.006, 0.004, 0.0029, 0.0021, 0.0015, 0.0011, 0.0009, 0.0008},
                  .error = {0.0001, 0.0001, 0.0001, 0.0001, 0.0001, 0.0001, 0.0001, 0.0001, 0.0002, 0.0003, 0.0004}}}});
}

void apply_limits(CalibrationReport& report, const std::string& axis, Stage stage, ReportedValue value, double limit) {
  Conformity one = compare_with_limits(value, limit, report.rule);
  one.quantity = "compensated_mean.compensated_bias";
  one.axis = axis;
  one.stage = stage;
  one.run = kRun;
  one.unit = "°/h";
  report.conformity.push_back(std::move(one));
}

void add_results(CalibrationReport& report) {
  for (const std::string& axis : report.item.axes) {
    add_behaviour(report.results, axis, Stage::uncompensated, 1);
    add_behaviour(report.results, axis, Stage::as_found, 0.2);
    add_behaviour(report.results, axis, Stage::as_left, 0.05);
    add_compensated_mean(report.results, axis, Stage::as_found, 0.0131, 0.0019);
    add_compensated_mean(report.results, axis, Stage::as_left, 0.002, 0.00003);
    report.budgets.push_back(budget(axis, Stage::as_found));
    report.budgets.push_back(budget(axis, Stage::as_left));
    apply_limits(report, axis, Stage::as_found, value_with_uncertainty(0.0131, 0.0019, 41.7), 0.01);
    apply_limits(report, axis, Stage::as_left, value_with_uncertainty(0.002, 0.00003, 41.7), 0.01);
    add_figures(report.figures, axis);
    for (const Stage stage : {Stage::as_found, Stage::as_left})
      report.verifications.push_back({.axis = axis,
                                      .stage = stage,
                                      .run = kRun,
                                      .verdict = {.gain = model::Gain::improves,
                                                  .statement = "std 0.0782 → 0.0041 °/h",
                                                  .std_deg_per_h = {0.0741, 0.0012},
                                                  .effective = 118,
                                                  .intervals_hold = true},
                                      .clusters = 4320,
                                      .coverage = model::Coverage{.nominal = 0.95,
                                                                  .seen = 0.957,
                                                                  .clusters = 4320,
                                                                  .effective = 118,
                                                                  .mean_half_width_deg_per_h = 0.0083}});
    report.compared.push_back({.axis = axis,
                               .inputs = "multi-point-t",
                               .method = "svr",
                               .rmse_deg_per_h = 0.0042,
                               .std_deg_per_h = 0.0041,
                               .expanded_deg_per_h = 0.0029,
                               .left = true});
    report.compared.push_back({.axis = axis,
                               .inputs = "seven-point,A",
                               .method = "ridge-u",
                               .rmse_deg_per_h = 0.0038,
                               .std_deg_per_h = 0.0037,
                               .expanded_deg_per_h = 0.0021,
                               .recommended = true,
                               .simple = true});
  }
}

}  // namespace

CalibrationReport sample_calibration() {
  CalibrationReport report;
  report.number = "C-2026-0042";
  report.state = ReportState::authorised;
  report.authorised = Authorisation{"A. Metrologist", "2026-11-20T09:12:00Z"};
  report.replaces = OtherReport{"C-2026-0040", std::string(64, 'a'), {"wrong customer", "falscher Kunde"}};
  report.simulated = true;
  report.laboratory = {.name = "Inertial Laboratory",
                       .address = {"1 Gyro Street"},
                       .postal_code = "10115",
                       .city = "Berlin",
                       .country = "DE",
                       .email = "lab@example.org",
                       .phone = "+49 30 000000"};
  report.customer = {.name = "Navigation Works", .address = {"2 Quay"}, .city = "Hamburg", .country = "DE"};
  report.people = {{"O. Perator", "operator", ""}, {"A. Metrologist", "authorising", "a@example.org"}};
  report.item = {.name = "u1",
                 .description = {"Ring laser gyro, two axes", "Ringlaserkreisel, zwei Achsen"},
                 .manufacturer = "ACME",
                 .model = "RLG-1",
                 .serial_number = "0042",
                 .customers_number = "NW-7",
                 .condition = {"no damage seen", "kein Schaden zu sehen"},
                 .axes = {"u1.x", "u1.y"}};
  report.received = "2026-11-02";
  report.begun = "2026-11-10";
  report.ended = "2026-11-14";
  report.issued = "2026-11-20";
  report.place_kind = "laboratory";
  report.place = {"Room 3", "Raum 3"};
  report.method = {"Temperature program with ramps and soaks", "Temperaturprogramm mit Rampen und Haltezeiten"};
  report.traceability = {"Temperatures are traceable to the SI by the certificates named below.",
                         "Temperaturen sind durch die unten genannten Scheine auf das SI rückgeführt."};
  report.remarks = {"None.", "Keine."};
  report.influences = {{.key = "air_temperature", .unit = "°C", .low = -40.2, .high = 60.3},
                       {.name = {"relative humidity", "relative Feuchte"}, .unit = "%", .low = 35, .high = 45}};
  report.equipment = {{.role = "thermometer",
                       .channel = "A",
                       .name = "Lake Shore 218",
                       .serial_number = "LS-1",
                       .certificate = "2026-0123",
                       .calibrated = "2026-03-01",
                       .due = "2027-03-01",
                       .standard_uncertainty_k = 0.012,
                       .drift_k_in_a_year = 0.02},
                      {.role = "chamber", .name = "F4T", .overdue = true}};
  report.deviations = {
      {.utc = "2026-11-11T03:00:12Z", .run = kRun, .kind = "gap", .text = "silent line", .seconds = 12},
      {.utc = "2026-11-12T08:00:00Z", .run = kRun, .kind = "paused", .text = "door \"open\" <b>"}};
  report.bias_zero = "earth rate removed";
  report.cluster_length_s = 100;
  report.trained_ranges = {{"u1.x", Stage::as_left, model::BlockRange{-17.6, 58.4, {"A", "B"}}}};
  report.rule = DecisionRule::guard_band;
  add_results(report);
  report.files = {{.role = "record",
                   .name = "rate.db",
                   .id = kRun,
                   .sha256 = std::string(64, 'b'),
                   .program_version = "0.1.0",
                   .started_utc = "2026-11-10T08:00:00Z",
                   .chain_verified = true},
                  {.role = "model_left", .name = "model.json", .sha256 = std::string(64, 'c')}};
  report.program_version = "0.1.0";
  return report;
}

}  // namespace gyrotherm::report
