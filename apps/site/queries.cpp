// SPDX-License-Identifier: Apache-2.0
#include "apps/site/queries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/json.hpp"
#include "core/text.hpp"

namespace gyrotherm::site {
namespace {

constexpr std::array kQueries{
    StoreQuery{
        "drift", "v1_drift",
        "serial_number, axis, stage, quantity, condition, calibrated, value, expanded_uncertainty AS \"U\", unit, "
        "change, e_n, change_per_year, simulated",
        "NOT simulated AND e_n IS NOT NULL", "abs(e_n) DESC NULLS LAST, serial_number, quantity, calibrated",
        "Lists changes of units between consecutive calibrations, with U and E_n; largest E_n first."},
    StoreQuery{
        "outliers", "v1_outlier",
        "serial_number, model, axis, stage, quantity, condition, value, unit, median, robust_z, units, simulated",
        "NOT simulated", "abs(robust_z) DESC, serial_number", "Lists outliers among the units of a model."},
    StoreQuery{"units", "v1_unit",
               "serial_number, model, order_number, rig, position, profile, started, state, simulated, run",
               "NOT simulated", "serial_number, started DESC",
               "Lists the runs of each unit, with its order, its rig and its position."},
    StoreQuery{"yield", "v1_yield", "model, quantity, units, passed, undecided, yield, low, high, simulated",
               "NOT simulated", "model, quantity <> 'all limits', quantity",
               "Lists the yield of each model: the part of its units within their limits, with its 95 % interval."},
    StoreQuery{
        "capability", "v1_capability",
        "model, axis, stage, quantity, condition, units, mean, s, \"limit\", unit, cpk, low, high, simulated",
        "NOT simulated", "cpk NULLS FIRST, model, quantity, condition",
        "Lists Cpk of each result with a limit over the units of a model, with its 95 % interval; smallest first."},
    StoreQuery{"recalibration", "v1_recalibration",
               "serial_number, model, axis, stage, quantity, condition, calibrations, calibrated, value, "
               "drift_per_year, \"limit\", unit, due, note, simulated",
               "NOT simulated", "due NULLS LAST, serial_number, quantity, condition",
               "Predicts the date until which each result remains within its limit with a probability of 95 %, from "
               "the drift so far; earliest first."},
    StoreQuery{"standards", "v1_check_standard",
               "rig, serial_numbers, profile, last_verdict, last_run, days_since, runs, open_runs, cause, "
               "cause_probability, simulated",
               "NOT simulated", "open_runs DESC, rig, last_run DESC",
               "Lists the check standard of each rig: verdict of the last check run, open runs, probable cause."},
    StoreQuery{"charts", "v1_check_chart",
               "rig, result, started, value, unit, centre, low, high, q, ewma, verdict, simulated",
               "NOT simulated AND is_last", "rig, started DESC, abs(q) DESC NULLS LAST, chart",
               "Lists the control charts: each result of the last check run of each rig with its limits."},
    StoreQuery{"thermometers", "v1_thermometer", "rig, name, instrument, certificate, due, days_left, last_used",
               "days_left <= 90 OR due IS NULL", "due NULLS FIRST, rig, name",
               "Lists thermometers whose calibration is due within 90 days or unknown."},
    StoreQuery{"utilisation", "v1_utilisation",
               "rig, week, runs, round(hours, 2) AS hours, round(percent, 1) AS percent, simulated", "NOT simulated",
               "week DESC, rig, simulated", "Lists operating hours of each rig by week."},
    StoreQuery{"attention", "v1_attention", "rig, started, profile, what, detail, simulated, run", "NOT simulated",
               "started DESC, what", "Lists runs that need attention: aborted, with alarms, with gaps, silent."},
    StoreQuery{"alarms", "v1_alarm_month",
               "month, rig, round(hours, 2) AS hours, alarms, high, medium, low, round(per_10_min, 2) AS per_10_min, "
               "most_in_10_min, round(flood_percent, 1) AS flood_percent, most_frequent, "
               "round(most_frequent_percent) AS most_frequent_percent, stale, chattering, acknowledged_after_s, "
               "suppressed, shelved, shelvings, outside_isa_18_2, simulated",
               "NOT simulated", "month DESC, rig, simulated",
               "Lists the alarms of each rig by month, with the figures of ISA-18.2 that are outside their targets."},
    StoreQuery{
        "frequent-alarms", "v1_alarm_rank",
        "month, rig, rank, alarm, priority, alarms, round(percent, 1) AS percent, chatters, longest_s, simulated",
        "NOT simulated AND rank <= 10", "month DESC, rig, simulated, rank, alarm",
        "Lists the ten most frequent alarms of each rig by month."},
    StoreQuery{"rigs", "v1_rig", "rig, state, profile, started, last_row, units, runs, simulated",
               "simulated IS NOT TRUE", "rig", "Lists rigs and the latest run of each."},
    StoreQuery{"live", "v1_live",
               "rig, state, cause, profile, segment, chamber_air_c, set_point_c, alarms, age_s, simulated", "", "rig",
               "Lists the present state of each rig: air and set point of the last sample, age of that sample, and "
               "unacknowledged alarms."}};

/// PostgreSQL's numbers (OIDs) of the type bool and of its numeric types: int8, int2, int4, float4, float8, numeric.
constexpr unsigned kBoolType = 16;
constexpr std::array<unsigned, 6> kNumberTypes{20, 21, 23, 700, 701, 1700};

bool is_number(const QueryResult& answer, int column) {
  return std::ranges::find(kNumberTypes, answer.type(column)) != kNumberTypes.end();
}

/// Formats a cell. The column `simulated` has the mark SIMULATED, or is empty.
std::string format_cell(const QueryResult& answer, int row, int column) {
  const bool is_bool = answer.type(column) == kBoolType;
  if (is_bool && answer.name(column) == "simulated") return answer.text(row, column) == "t" ? "SIMULATED" : "";
  if (answer.null(row, column)) return "–";
  if (is_bool) return answer.text(row, column) == "t" ? "yes" : "no";
  constexpr unsigned kFloat8 = 701;
  const auto text = answer.text(row, column);
  if (answer.type(column) != kFloat8) return plain(text);
  return fmt::format("{:.4g}", std::strtod(std::string(text).c_str(), nullptr));
}

std::size_t count_columns(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](unsigned char c) { return (c & 0xC0) != 0x80; }));
}

void append_padded(std::string& line, const std::string& cell, std::size_t width, bool right) {
  const std::string blanks(width - count_columns(cell), ' ');
  line += right ? blanks + cell : cell + blanks;
}

}  // namespace

std::span<const StoreQuery> queries() { return kQueries; }

bool has_units(const StoreQuery& query) { return std::string_view(query.columns).starts_with("serial_number,"); }

Result<QueryResult> run_query(Postgres& store, const StoreQuery& query, const QueryOptions& options) {
  std::vector<std::string> conditions;
  std::vector<Parameter> parameters;
  if (!options.all && !std::string_view(query.condition).empty()) conditions.emplace_back(query.condition);
  if (!options.unit.empty()) {
    conditions.emplace_back("serial_number = $1");
    parameters.emplace_back(options.unit);
  }
  auto sql = fmt::format("SELECT {} FROM gyrotherm.{}", query.columns, query.view);
  for (std::size_t i = 0; i < conditions.size(); ++i)
    sql += fmt::format(" {} ({})", i == 0 ? "WHERE" : "AND", conditions[i]);
  sql += fmt::format(" ORDER BY {}", query.order);
  if (options.most > 0) sql += fmt::format(" LIMIT {}", options.most);
  return store.query(sql, parameters);
}

std::string format_table(const QueryResult& answer) {
  if (answer.rows() == 0) return {};
  std::vector<std::string> lines(static_cast<std::size_t>(answer.rows()) + 1);
  for (int column = 0; column < answer.columns(); ++column) {
    std::vector<std::string> cells{answer.name(column)};
    for (int row = 0; row < answer.rows(); ++row) cells.push_back(format_cell(answer, row, column));
    std::size_t width = 0;
    for (const auto& cell : cells) width = std::max(width, count_columns(cell));
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (column > 0) lines[i] += "  ";
      append_padded(lines[i], cells[i], width, is_number(answer, column));
    }
  }
  std::string table;
  for (auto& line : lines) {
    line.erase(line.find_last_not_of(' ') + 1);
    table += line + "\n";
  }
  return table;
}

std::string format_rows_as_json(const QueryResult& answer) {
  Json rows = Json::array();
  for (int row = 0; row < answer.rows(); ++row) {
    Json object = Json::object();
    for (int column = 0; column < answer.columns(); ++column) {
      auto& value = object[answer.name(column)];
      const std::string text(answer.text(row, column));
      if (answer.null(row, column)) continue;
      if (answer.type(column) == kBoolType)
        value = text == "t";
      else if (is_number(answer, column))
        value = Json::parse(text, nullptr, false).is_number() ? Json::parse(text) : Json(text);
      else
        value = text;
    }
    rows.push_back(std::move(object));
  }
  return json_text(rows) + "\n";
}

}  // namespace gyrotherm::site
