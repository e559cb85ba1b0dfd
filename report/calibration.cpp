// SPDX-License-Identifier: Apache-2.0
#include "report/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/data/dataset.hpp"
#include "analysis/data/distributions.hpp"
#include "core/json.hpp"
#include "report/words.hpp"

namespace gyrotherm::report {

const char* name(Stage stage) {
  switch (stage) {
    case Stage::uncompensated: return "uncompensated";
    case Stage::as_found: return "as_found";
    case Stage::as_left: return "as_left";
  }
  return "";
}

const char* name(Group group) {
  switch (group) {
    case Group::turn_on: return "turn_on";
    case Group::warm_up: return "warm_up";
    case Group::bias: return "bias";
    case Group::sensitivity: return "sensitivity";
    case Group::hysteresis: return "hysteresis";
    case Group::random_drift: return "random_drift";
    case Group::compensation: return "compensation";
  }
  return "";
}

const char* name(DecisionRule rule) { return rule == DecisionRule::simple ? "simple" : "guard_band"; }

const char* name(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass: return "pass";
    case Verdict::conditional_pass: return "conditional_pass";
    case Verdict::conditional_fail: return "conditional_fail";
    case Verdict::fail: return "fail";
    case Verdict::not_known: return "not_known";
  }
  return "";
}

const char* name(ReportState state) {
  switch (state) {
    case ReportState::draft: return "draft";
    case ReportState::authorised: return "authorised";
    case ReportState::superseded: return "superseded";
  }
  return "";
}

/// Reports an error unless `key` is a key of words.hpp, or empty if that is permitted.
void expect_known_key(auto& form, const char* at, std::string_view key, bool may_be_empty = false) {
  form.expect(at, (may_be_empty && key.empty()) || has_text(key), "unknown, expected a key of the table of texts");
}

/// Returns true for "KEY" or "KEY.QUANTITY" with keys of words.hpp.
bool is_result_quantity(std::string_view quantity) {
  const auto dot = quantity.find('.');
  return has_text(quantity.substr(0, dot)) && (dot == std::string_view::npos || has_text(quantity.substr(dot + 1)));
}

void describe(auto& form, Like<Texts> auto& texts) {
  form("en", texts.en);
  form("de", texts.de);
}

void describe(auto& form, Like<Party> auto& party) {
  form("name", party.name);
  form("address", party.address);
  form("postal_code", party.postal_code);
  form("city", party.city);
  form("country", party.country);
  form("email", party.email);
  form("phone", party.phone);
}

void describe(auto& form, Like<Logo> auto& logo) {
  form("media_type", logo.media_type);
  form("base64", logo.base64);
  form.expect("media_type", logo.media_type == "image/svg+xml" || logo.media_type == "image/png",
              "expected \"image/svg+xml\" or \"image/png\"");
}

void describe(auto& form, Like<Person> auto& person) {
  form("name", person.name);
  form("role", person.role);
  expect_known_key(form, "role", person.role);
  form("email", person.email);
}

void describe(auto& form, Like<CalibratedItem> auto& item) {
  form("name", item.name);
  form("description", item.description);
  form("manufacturer", item.manufacturer);
  form("model", item.model);
  form("serial_number", item.serial_number);
  form("customers_number", item.customers_number);
  form("condition", item.condition);
  form("axes", item.axes);
}

void describe(auto& form, Like<Equipment> auto& equipment) {
  form("role", equipment.role);
  expect_known_key(form, "role", equipment.role);
  form("channel", equipment.channel);
  form("name", equipment.name);
  form.if_present("names", !equipment.names.empty(), equipment.names);
  form("serial_number", equipment.serial_number);
  form("certificate", equipment.certificate);
  form.if_present("certificate_sha256", !equipment.certificate_sha256.empty(), equipment.certificate_sha256);
  form("calibrated", equipment.calibrated);
  form("due", equipment.due);
  form("standard_uncertainty_k", equipment.standard_uncertainty_k);
  form("drift_k_in_a_year", equipment.drift_k_in_a_year);
  form("overdue", equipment.overdue);
}

void describe(auto& form, Like<Influence> auto& influence) {
  form("key", influence.key);
  expect_known_key(form, "key", influence.key, true);
  form("name", influence.name);
  form("unit", influence.unit);
  form("low", influence.low);
  form("high", influence.high);
}

void describe(auto& form, Like<Deviation> auto& deviation) {
  form("utc", deviation.utc);
  form("run", deviation.run);
  form("kind", deviation.kind);
  expect_known_key(form, "kind", deviation.kind);
  form("text", deviation.text);
  form.if_present("translations", !deviation.translations.empty(), deviation.translations);
  form("seconds", deviation.seconds);
}

void describe(auto& form, Like<UsedFile> auto& file) {
  form("role", file.role);
  expect_known_key(form, "role", file.role);
  form("name", file.name);
  form("id", file.id);
  form("sha256", file.sha256);
  form("program_version", file.program_version);
  form("profile", file.profile);
  form("started_utc", file.started_utc);
  form("chain_verified", file.chain_verified);
  form.if_present("stopped_in_segment", file.stopped_in_segment > 0, file.stopped_in_segment);  // since 0.2.0
  form.if_present("segments", file.stopped_in_segment > 0, file.segments);
}

void describe(auto& form, Like<ReportedValue> auto& value) {
  form("value", value.value);
  const bool is_uncertain = std::isfinite(value.standard_uncertainty);
  form.if_present("u", is_uncertain, value.standard_uncertainty);
  form.if_present("k", is_uncertain, value.coverage_factor);
  if (is_uncertain) form.derived("U", value.expanded());
  form.if_present("degrees_of_freedom", std::isfinite(value.degrees_of_freedom), positive(value.degrees_of_freedom));
}

void describe(auto& form, Like<Column> auto& column) {
  form("quantity", column.quantity);
  expect_known_key(form, "quantity", column.quantity);
  form("unit", column.unit);
  form("values", column.values);
}

void describe(auto& form, Like<ResultTable> auto& table) {
  form("group", one_of(table.group, {Group::turn_on, Group::warm_up, Group::bias, Group::sensitivity, Group::hysteresis,
                                     Group::random_drift, Group::compensation}));
  form("key", table.key);
  expect_known_key(form, "key", table.key);
  form("axis", table.axis);
  form("stage", one_of(table.stage, {Stage::uncompensated, Stage::as_found, Stage::as_left}));
  form("run", table.run);
  form("in_sample", table.in_sample);
  form("detail", table.detail);
  form("columns", table.columns);
  const auto as_long = [&](const Column& column) {
    return column.values.size() == table.columns.front().values.size();
  };
  form.expect("columns", std::ranges::all_of(table.columns, as_long), "wrong length, expected columns of equal length");
}

void describe(auto& form, Like<ReportedBudget> auto& budget) {
  form("axis", budget.axis);
  form("stage", one_of(budget.stage, {Stage::uncompensated, Stage::as_found, Stage::as_left}));
  form.if_present("run", !budget.run.empty(), budget.run);
  form("averaging_s", positive(budget.budget.averaging_s));
  form.derived("combined", combined(budget.budget.rows));
  form("rows", budget.budget.rows);
}

void describe(auto& form, Like<Conformity> auto& conformity) {
  form("quantity", conformity.quantity);
  form.expect("quantity", is_result_quantity(conformity.quantity),
              "unknown, expected KEY.QUANTITY with keys of the table of texts");
  form("axis", conformity.axis);
  form("stage", one_of(conformity.stage, {Stage::uncompensated, Stage::as_found, Stage::as_left}));
  form("run", conformity.run);
  form("unit", conformity.unit);
  form("value", conformity.value);
  form("limit", conformity.limit);
  form("rule", one_of(conformity.rule, {DecisionRule::simple, DecisionRule::guard_band}));
  form("verdict", one_of(conformity.verdict, {Verdict::pass, Verdict::conditional_pass, Verdict::conditional_fail,
                                              Verdict::fail, Verdict::not_known}));
  form("probability", conformity.probability);
}

void describe(auto& form, Like<ComparedModel> auto& model) {
  form("axis", model.axis);
  form("inputs", model.inputs);
  form("method", model.method);
  form("rmse_deg_per_h", model.rmse_deg_per_h);
  form("std_deg_per_h", model.std_deg_per_h);
  form("U_deg_per_h", model.expanded_deg_per_h);
  form("left", model.left);
  form("recommended", model.recommended);
  form("simple", model.simple);
}

void describe(auto& form, Like<FigureLine> auto& line) {
  form("key", line.key);
  expect_known_key(form, "key", line.key);
  form("detail", line.detail);
  form("stage", one_of(line.stage, {Stage::uncompensated, Stage::as_found, Stage::as_left}));
  form("x", line.x);
  form("y", line.y);
  form.expect("y", line.y.size() == line.x.size(), "wrong length, expected one value for each x");
  form("error", line.error);
  form.expect("error", line.error.empty() || line.error.size() == line.x.size(),
              "wrong length, expected one value for each x, or none");
}

void describe(auto& form, Like<FigureData> auto& figure) {
  form("key", figure.key);
  expect_known_key(form, "key", figure.key);
  form("axis", figure.axis);
  form("run", figure.run);
  form("x", figure.x_key);
  expect_known_key(form, "x", figure.x_key);
  form("x_unit", figure.x_unit);
  form("y", figure.y_key);
  expect_known_key(form, "y", figure.y_key);
  form("y_unit", figure.y_unit);
  form("logarithmic", figure.logarithmic);
  form("lines", figure.lines);
}

void describe(auto& form, Like<Authorisation> auto& authorisation) {
  form("name", authorisation.name);
  form("utc", authorisation.utc);
}

void describe(auto& form, Like<OtherReport> auto& other) {
  form("number", other.number);
  form("sha256", other.sha256);
  form("reason", other.reason);
}

void describe(auto& form, Like<BiasReference> auto& of) {
  form("axis", of.axis);
  form("run", of.run);
  form("zero", of.zero);
  expect_known_key(form, "zero", of.zero);
}

void describe(auto& form, Like<TrainedRange> auto& range) {
  form("axis", range.axis);
  form("stage", one_of(range.stage, {Stage::as_found, Stage::as_left}));
  form("block", range.block);
}

void describe(auto& form, Like<ModelVerification> auto& verification) {
  form("axis", verification.axis);
  form("stage", one_of(verification.stage, {Stage::as_found, Stage::as_left}));
  form("run", verification.run);
  form("verdict", verification.verdict);
  form("clusters", verification.clusters);
  form("outside_trained_range", verification.outside);
  form("farthest_term", verification.farthest_term);
  form("farthest", verification.farthest);
  form("coverage", verification.coverage);
}

void describe(auto& form, Like<CalibrationReport> auto& report) {
  form("number", report.number);
  form("state", one_of(report.state, {ReportState::draft, ReportState::authorised, ReportState::superseded}));
  form("authorised", report.authorised);
  form("replaces", report.replaces);
  form("replaced_by", report.replaced_by);
  form("simulated", report.simulated);
  form("missing", report.missing);
  form("title", report.title);
  form("laboratory", report.laboratory);
  form("logo", report.logo);
  form("customer", report.customer);
  form("people", report.people);
  form("item", report.item);
  form("received", report.received);
  form("begun", report.begun);
  form("ended", report.ended);
  form("issued", report.issued);
  form("place_kind", report.place_kind);
  expect_known_key(form, "place_kind", report.place_kind, true);
  form("place", report.place);
  form("method", report.method);
  form("traceability", report.traceability);
  form("remarks", report.remarks);
  form("statements", report.statements);
  form("influences", report.influences);
  form("equipment", report.equipment);
  form("deviations", report.deviations);
  form("bias_zero", report.bias_zero);
  expect_known_key(form, "bias_zero", report.bias_zero, true);
  form.if_present("bias_zeros", !report.bias_zeros.empty(), report.bias_zeros);
  form("cluster_length_s", positive(report.cluster_length_s));
  form.if_present("trained_ranges", !report.trained_ranges.empty(), report.trained_ranges);
  form.if_present("verifications", !report.verifications.empty(), report.verifications);
  form.if_present("block_thermometers", !report.block_thermometers.empty(), report.block_thermometers);
  form.derived("coverage", model::kCoverage);
  form("results", report.results);
  form("budgets", report.budgets);
  form("decision_rule", one_of(report.rule, {DecisionRule::simple, DecisionRule::guard_band}));
  form("conformity", report.conformity);
  form("compared", report.compared);
  form("figures", report.figures);
  form("files", report.files);
  form("program_version", report.program_version);
}

ReportedValue value_with_uncertainty(double value, double standard_uncertainty, double degrees_of_freedom) {
  return {.value = value,
          .standard_uncertainty = standard_uncertainty,
          .coverage_factor = data::coverage_factor(model::kCoverage, model::whole_degrees(degrees_of_freedom)),
          .degrees_of_freedom = degrees_of_freedom};
}

namespace {

/// Returns P(|true magnitude| ≤ limit).
double probability_within(const ReportedValue& value, double limit) {
  const double u = value.standard_uncertainty;
  if (!(u > 0)) return std::numeric_limits<double>::quiet_NaN();
  const double freedom = value.degrees_of_freedom;
  return data::students_t_probability((limit - value.value) / u, freedom) -
         data::students_t_probability((-limit - value.value) / u, freedom);
}

Verdict apply_guard_band(double magnitude, double expanded, double limit) {
  if (!std::isfinite(expanded)) return Verdict::not_known;
  if (magnitude <= limit - expanded) return Verdict::pass;
  if (magnitude <= limit) return Verdict::conditional_pass;
  return magnitude <= limit + expanded ? Verdict::conditional_fail : Verdict::fail;
}

}  // namespace

Conformity compare_with_limits(const ReportedValue& value, double limit, DecisionRule rule) {
  Conformity found{.value = value, .limit = limit, .rule = rule, .verdict = Verdict::not_known};
  if (!std::isfinite(value.value)) return found;
  found.probability = probability_within(value, limit);
  const double magnitude = std::abs(value.value);
  found.verdict = rule == DecisionRule::guard_band ? apply_guard_band(magnitude, value.expanded(), limit)
                  : magnitude <= limit             ? Verdict::pass
                                                   : Verdict::fail;
  return found;
}

bool depends_on_bias_reference(std::string_view quantity) {
  return std::ranges::find(kReferenceDependent, quantity) != kReferenceDependent.end();
}

const std::string& find_bias_reference(const CalibrationReport& report, const ResultTable& table) {
  const auto own = std::ranges::find_if(
      report.bias_zeros, [&](const BiasReference& one) { return one.axis == table.axis && one.run == table.run; });
  return own == report.bias_zeros.end() ? report.bias_zero : own->zero;
}

bool has_unknown_zero(const CalibrationReport& report, const ResultTable& table, std::string_view quantity) {
  return depends_on_bias_reference(quantity) && find_bias_reference(report, table) == data::kOwnReference;
}

bool has_unknown_zero(const CalibrationReport& report) {
  return std::ranges::any_of(report.results, [&](const ResultTable& table) {
    return std::ranges::any_of(table.columns,
                               [&](const Column& one) { return has_unknown_zero(report, table, one.quantity); });
  });
}

std::optional<Verdict> overall_verdict(const CalibrationReport& report) {
  std::optional<Verdict> worst;
  for (const Conformity& one : report.conformity) worst = std::max(worst.value_or(Verdict::pass), one.verdict);
  return worst;
}

std::vector<const ResultTable*> results_in_group(const CalibrationReport& report, Group group) {
  std::vector<const ResultTable*> found;
  for (const ResultTable& table : report.results)
    if (table.group == group) found.push_back(&table);
  return found;
}

std::vector<std::string> find_uncertified_thermometers(const CalibrationReport& report) {
  const auto is_certified = [&](const std::string& channel) {
    return std::ranges::any_of(report.equipment, [&](const Equipment& one) {
      return one.role == "thermometer" && (one.channel.empty() || one.channel == channel) &&
             !(one.certificate.empty() && one.certificate_sha256.empty());
    });
  };
  auto channels = report.block_thermometers;
  if (channels.empty())
    for (const Equipment& one : report.equipment)
      if (one.role == "thermometer") channels.push_back(one.channel);
  if (channels.empty()) channels.emplace_back();  // not even listed
  std::erase_if(channels, is_certified);
  return channels;
}

bool has_overdue_thermometer(const CalibrationReport& report) {
  return std::ranges::any_of(report.equipment,
                             [](const Equipment& one) { return one.role == "thermometer" && one.overdue; });
}

const char* scope_key(const CalibrationReport& report) {
  const bool is_left = std::ranges::find(report.results, Stage::as_left, &ResultTable::stage) != report.results.end();
  return is_left ? "say.as_left_item" : "say.only_this_item";
}

const Column* find_column(const ResultTable& table, std::string_view quantity) {
  const auto found = std::ranges::find(table.columns, quantity, &Column::quantity);
  return found == table.columns.end() ? nullptr : &*found;
}

std::string to_json(const CalibrationReport& report) {
  Json json{{"schema", kCalibrationSchema}};
  json.update(make_json(report));
  return json_text(json, 1) + "\n";
}

Result<CalibrationReport> calibration_from_json(std::string_view json, const std::string& file) {
  const auto place = JsonNode::parse(json, file);
  if (!place) return failure(place.error());
  if (const std::string schema = (*place)["schema"].text(); schema != kCalibrationSchema)
    (*place)["schema"].note_error(fmt::format("\"{}\", expected \"{}\"", schema, kCalibrationSchema));
  CalibrationReport report;
  read_json(*place, report);
  if (auto verdict = place->verdict(); !verdict) return failure(verdict.error());
  return report;
}

}  // namespace gyrotherm::report
