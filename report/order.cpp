// SPDX-License-Identifier: Apache-2.0
#include "report/order.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <regex>
#include <set>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "analysis/data/dataset.hpp"
#include "core/file.hpp"
#include "core/serial_number.hpp"
#include "core/text.hpp"
#include "core/toml_reader.hpp"
#include "report/plot/png.hpp"

namespace gyrotherm::report {
namespace {

constexpr const char *kSerialNumber = "serial_number", *kSerialNumbers = "serial_numbers";
constexpr std::size_t kLargestLogo = 1'000'000;
constexpr Vocabulary<DecisionRule, 2> kRules{
    {{"simple", DecisionRule::simple}, {"guard_band", DecisionRule::guard_band}}};
constexpr Vocabulary<Stage, 3> kStages{
    {{"uncompensated", Stage::uncompensated}, {"as_found", Stage::as_found}, {"as_left", Stage::as_left}}};

/// Reads a text, or a table of texts by language.
Texts texts(const TomlTable& table, const char* key) {
  if (!table.has(key)) return {};
  if (!table.is_table(key)) {
    const std::string text = table.text(key);
    return {text, text};
  }
  const TomlTable languages = table.table(key);
  return {languages.text("en", ""), languages.text("de", "")};
}

/// Reads a required text and, if it is a table, its texts by language. The text is then the English one, or the German
/// one if that is missing.
std::pair<std::string, Texts> read_translated(const TomlTable& table, const char* key) {
  if (!table.has(key) || !table.is_table(key)) return {table.text(key), {}};
  const Texts all = texts(table, key);
  if (all.empty()) table.note_error(key, "missing, expected a text in \"en\" or \"de\"");
  return {all.en.empty() ? all.de : all.en, all};
}

std::string day(const TomlTable& table, const char* key) {
  std::string text = table.text(key, "");
  if (!text.empty() && !record::parse_day(text))
    table.note_error(key, fmt::format("\"{}\" is not a date, expected one like \"2026-11-25\"", text));
  return text;
}

std::string country(const TomlTable& table) {
  std::string code = table.text("country", "");
  const bool is_code = code.size() == 2 && std::ranges::all_of(code, [](char c) { return c >= 'A' && c <= 'Z'; });
  if (!code.empty() && !is_code)
    table.note_error("country", fmt::format("\"{}\", expected two letters of ISO 3166-1 like \"DE\"", code));
  return code;
}

std::string email(const TomlTable& table) {
  std::string address = table.text("email", "");
  const auto at = address.find('@');
  const bool is_address = at != 0 && at != std::string::npos && at + 1 < address.size() &&
                          address.find_first_of(" \t") == std::string::npos;
  if (!address.empty() && !is_address)
    table.note_error("email", fmt::format("\"{}\" is not an e-mail address, expected NAME@DOMAIN", address));
  return address;
}

Party party(const TomlTable& table) {
  return {.name = table.text("name", ""),
          .address = table.texts("address"),
          .postal_code = table.text("postal_code", ""),
          .city = table.text("city", ""),
          .country = country(table),
          .email = email(table),
          .phone = table.text("phone", "")};
}

std::vector<Person> read_people(const TomlTable& table) {
  std::vector<Person> all;
  for (const TomlTable& one : table.tables("person"))
    all.push_back({one.text("name"), one.choice("role", {"operator", "reviewer", "authorising"}), email(one)});
  return all;
}

std::vector<Equipment> equipment(const TomlTable& table) {
  std::vector<Equipment> all;
  for (const TomlTable& one : table.tables("equipment")) {
    const auto [name, names] = read_translated(one, "name");
    all.push_back({.role = one.choice("role", {"reference", "thermometer"}, "reference"),
                   .name = name,
                   .serial_number = one.text("serial_number", ""),
                   .certificate = one.text("certificate", ""),
                   .names = names,
                   .calibrated = day(one, "calibrated"),
                   .due = day(one, "due")});
    if (const Equipment& last = all.back(); !last.due.empty() && last.due < last.calibrated)
      one.note_error("due", fmt::format("is before \"calibrated\", {}", last.calibrated));
  }
  return all;
}

std::optional<Logo> logo(const TomlTable& table, const std::string& file) {
  if (!table.has("logo")) return std::nullopt;
  const std::string name = table.text("logo");
  const std::filesystem::path path = std::filesystem::path(file).parent_path() / name;
  const std::string extension = path.extension().string();
  if (extension != ".svg" && extension != ".png") {
    table.note_error("logo", fmt::format("\"{}\", expected a picture that ends in .svg or .png", name));
    return std::nullopt;
  }
  const auto bytes = read_text_file(path.string(), kLargestLogo);
  if (!bytes) {
    table.note_error("logo", text(bytes.error()));
    return std::nullopt;
  }
  const bool is_png = bytes->starts_with("\x89PNG\r\n\x1a\n");
  if (is_png != (extension == ".png")) {
    table.note_error("logo", fmt::format("\"{}\" is not a {} file", name, extension == ".png" ? "PNG" : "SVG"));
    return std::nullopt;
  }
  return Logo{is_png ? "image/png" : "image/svg+xml", plot::base64(*bytes)};
}

/// Returns a serial number of the file without surrounding blanks; empty, with a noted error, if it is invalid.
std::string check_serial_number(const std::string& text, const TomlTable& table, const char* key = kSerialNumber) {
  auto number = parse_serial_number(text);
  if (!number) table.note_error(key, fmt::format("a serial number {}", number.error().what));
  return number.value_or("");
}

CalibratedItem item(const TomlTable& table) {
  const std::string serial_number = table.text("serial_number", "");
  return {.description = texts(table, "description"),
          .manufacturer = table.text("manufacturer", ""),
          .model = table.text("model", ""),
          .serial_number = serial_number.empty() ? "" : check_serial_number(serial_number, table),
          .customers_number = table.text("customers_number", ""),
          .condition = texts(table, "condition")};
}

bool has_serial_number(std::span<const OrderedUnit> units, const std::string& number) {
  const auto has_it = [&](const OrderedUnit& unit) { return unit.item.serial_number == number; };
  return !number.empty() && std::ranges::any_of(units, has_it);
}

/// Reads the units of an order: [[unit]] and the list `serial_numbers`.
std::vector<OrderedUnit> units(const TomlTable& table) {
  std::vector<OrderedUnit> all;
  for (const TomlTable& one : table.tables("unit")) {
    all.push_back({one.text("name", ""), one.location(), item(one)});
    const OrderedUnit& last = all.back();
    const auto same = [&](const OrderedUnit& unit) {
      return unit.name == last.name && (!last.name.empty() || unit.item.serial_number.empty());
    };
    const bool is_found_by_serial = last.name.empty() && !last.item.serial_number.empty();
    if (!is_found_by_serial && std::ranges::count_if(all, same) > 1)
      one.note_error("name", fmt::format("duplicate unit \"{}\"", last.name));
    if (has_serial_number(std::span(all).first(all.size() - 1), last.item.serial_number))
      one.note_error("serial_number", fmt::format("duplicate serial number {}", last.item.serial_number));
  }
  for (const std::string& text : table.texts("serial_numbers")) {
    const std::string number = check_serial_number(text, table, kSerialNumbers);
    if (has_serial_number(all, number))
      table.note_error("serial_numbers", fmt::format("duplicate serial number {}", number));
    all.push_back({"", table.location("serial_numbers"), {.serial_number = number}});
  }
  return all;
}

std::vector<Influence> influences(const TomlTable& table) {
  std::vector<Influence> all;
  for (const TomlTable& one : table.tables("influence")) {
    Influence influence{
        .name = texts(one, "name"), .unit = one.text("unit"), .low = one.number("low"), .high = one.number("high")};
    if (influence.name.empty()) one.note_error("name", "missing, expected a text");
    if (influence.low > influence.high) one.note_error("high", "is below \"low\"");
    all.push_back(std::move(influence));
  }
  return all;
}

/// Returns all values of `quantity` that a limit may have, each as KEY.QUANTITY of a result.
std::vector<std::string> results_with_limits() {
  return {"turn_on_repeatability.std_of_bias",
          "warm_up.duration",
          "stabilised_bias.bias",
          "two_position.bias",
          "two_position.earth_rate",
          "retrace.change",
          "temperature_sensitivity.temperature_sensitivity",
          "ramp_sensitivity.ramp_sensitivity",
          "gradient_sensitivity.gradient_sensitivity",
          "hysteresis.width",
          "quantisation.quantisation",
          "angle_random_walk.angle_random_walk",
          "bias_instability.bias_instability",
          "rate_random_walk.rate_random_walk",
          "rate_ramp.rate_ramp",
          "whole_run.mean",
          "whole_run.std",
          "whole_run.rmse",
          "whole_run.largest",
          "compensated_mean.compensated_bias"};
}

/// Result that cannot have a limit: limits are upper limits, but a larger share is better.
constexpr std::string_view kShare = "coverage.seen_share";

void check_is_result(const TomlTable& limit, const std::string& quantity) {
  const auto known = results_with_limits();
  if (quantity.empty() || std::ranges::find(known, quantity) != known.end()) return;
  if (quantity == kShare) {
    limit.note_error(
        "quantity",
        fmt::format("\"{}\" cannot have a limit: limits are upper limits, and larger values of it are better", kShare));
    return;
  }
  const std::string near = find_nearest(quantity, known);
  limit.note_error("quantity", fmt::format("unknown result \"{}\", {}", quantity,
                                           near.empty() ? "expected one like \"compensated_mean.compensated_bias\""
                                                        : fmt::format("did you mean \"{}\"?", near)));
}

std::vector<ReportedLimit> limits(const TomlTable& table) {
  std::vector<ReportedLimit> all;
  for (const TomlTable& one : table.tables("limit")) {
    ReportedLimit limit{.quantity = one.text("quantity"), .at_most = one.number("at_most")};
    if (one.has("stage")) limit.stage = one_of(kStages, one, "stage");
    check_is_result(one, limit.quantity);
    if (!(limit.at_most > 0)) one.note_error("at_most", "expected a number above 0");
    const auto is_same = [&](const ReportedLimit& other) {
      return other.quantity == limit.quantity && other.stage == limit.stage;
    };
    if (std::ranges::any_of(all, is_same))
      one.note_error("quantity", fmt::format("duplicate limit of \"{}\"{}", limit.quantity,
                                             one.has("stage") ? " in this stage" : ""));
    all.push_back(std::move(limit));
  }
  return all;
}

bool is_sha256(std::string_view text) {
  constexpr std::size_t kDigits = 64;
  return text.size() == kDigits && std::ranges::all_of(text, [](unsigned char c) { return std::isxdigit(c) != 0; });
}

std::optional<OtherReport> read_replaced_report(const TomlTable& table) {
  if (!table.has("replaces")) return std::nullopt;
  const TomlTable other = table.table("replaces");
  OtherReport report{other.text("number"), other.text("sha256", ""), texts(other, "reason")};
  if (!report.sha256.empty() && !is_sha256(report.sha256))
    other.note_error("sha256", fmt::format("\"{}\", expected 64 hexadecimal digits", report.sha256));
  for (char& digit : report.sha256) digit = static_cast<char>(std::tolower(static_cast<unsigned char>(digit)));
  return report;
}

/// Returns true for a UTC time such as "2026-11-25T14:03:00Z".
bool is_instant(const std::string& text) {
  constexpr std::size_t kDayLength = 10;
  static const std::regex kTime("T([01][0-9]|2[0-3])(:[0-5][0-9]){2}Z");
  return record::parse_day(text.substr(0, kDayLength)) && std::regex_match(text.substr(kDayLength), kTime);
}

std::vector<Deviation> deviations(const TomlTable& table) {
  std::vector<Deviation> all;
  for (const TomlTable& one : table.tables("deviation")) {
    const auto [text, translations] = read_translated(one, "text");
    all.push_back({.utc = one.text("utc", ""), .kind = "stated", .text = text, .translations = translations});
    if (const std::string& utc = all.back().utc; !utc.empty() && !is_instant(utc))
      one.note_error("utc", fmt::format("\"{}\", expected a UTC time like \"2026-11-25T14:03:00Z\"", utc));
  }
  return all;
}

}  // namespace

Result<LaboratoryFile> parse_laboratory(std::string_view toml, const std::string& file) {
  const auto table = TomlTable::parse(toml, file);
  if (!table) return failure(table.error());
  table->expect("schema", kLaboratorySchema);
  LaboratoryFile laboratory{.party = party(*table),
                            .logo = logo(*table, file),
                            .title = texts(*table, "title"),
                            .method = texts(*table, "method"),
                            .traceability = texts(*table, "traceability")};
  for (const TomlTable& one : table->tables("statement"))
    laboratory.statements.push_back({one.text("en", ""), one.text("de", "")});
  laboratory.equipment = equipment(*table);
  laboratory.people = read_people(*table);
  if (auto verdict = table->verdict(); !verdict) return failure(verdict.error());
  return laboratory;
}

Result<OrderFile> parse_order(std::string_view toml, const std::string& file) {
  const auto table = TomlTable::parse(toml, file);
  if (!table) return failure(table.error());
  table->expect("schema", kOrderSchema);
  OrderFile order{.number = table->text("number", ""),
                  .customer = party(table->table("customer")),
                  .people = read_people(*table),
                  .units = units(*table),
                  .received = day(*table, "received"),
                  .issued = day(*table, "issued"),
                  .place_kind = table->choice("place_kind", {"laboratory", "customer", "other"}, "laboratory"),
                  .place = texts(*table, "place"),
                  .method = texts(*table, "method"),
                  .remarks = texts(*table, "remarks"),
                  .influences = influences(*table),
                  .deviations = deviations(*table),
                  .rule = one_of(kRules, *table, "decision_rule", "simple"),
                  .limits = limits(*table),
                  .replaces = read_replaced_report(*table)};
  if (auto verdict = table->verdict(); !verdict) return failure(verdict.error());
  return order;
}

namespace {

/// Assigns `from` to `into` unless `from` is empty.
void replace_if_given(std::string& into, const std::string& from) {
  if (!from.empty()) into = from;
}
void replace_if_given(Texts& into, const Texts& from) {
  if (!from.empty()) into = from;
}

template <class T>
void append(std::vector<T>& into, const std::vector<T>& from) {
  into.insert(into.end(), from.begin(), from.end());
}

bool has_role(const std::vector<Person>& people, std::string_view role) {
  return std::ranges::find(people, role, &Person::role) != people.end();
}

void add_laboratory(CalibrationReport& report, const LaboratoryFile& laboratory) {
  report.laboratory = laboratory.party;
  report.logo = laboratory.logo;
  report.title = laboratory.title;
  report.method = laboratory.method;
  report.traceability = laboratory.traceability;
  report.statements = laboratory.statements;
  for (Equipment one : laboratory.equipment) {
    one.overdue = !one.due.empty() && one.due < report.ended;
    report.equipment.push_back(std::move(one));
  }
}

/// Returns the persons of a report. The order's operators and reviewers replace those of the laboratory, whose data of
/// a person are used if the order has none. The laboratory's persons with the role authorising are always listed,
/// because the order cannot give this role. A person has each role once.
std::vector<Person> merge_people(const std::vector<Person>& laboratory, const std::vector<Person>& order) {
  std::vector<Person> all;
  const auto add = [&all](const Person& person) {
    const auto is_it = [&](const Person& one) { return one.name == person.name && one.role == person.role; };
    const auto known = std::ranges::find_if(all, is_it);
    if (known == all.end()) return all.push_back(person);
    replace_if_given(known->email, person.email);
  };
  for (const Person& person : laboratory) {
    const auto is_it = [&](const Person& one) { return one.name == person.name && one.role == person.role; };
    if (person.role == "authorising" || !has_role(order, person.role) || std::ranges::any_of(order, is_it)) add(person);
  }
  std::ranges::for_each(order, add);
  return all;
}

void add_unit(CalibratedItem& item, const CalibratedItem& ordered) {
  replace_if_given(item.description, ordered.description);
  replace_if_given(item.manufacturer, ordered.manufacturer);
  if (item.model.empty()) item.model = ordered.model;
  if (item.serial_number.empty()) item.serial_number = ordered.serial_number;
  replace_if_given(item.customers_number, ordered.customers_number);
  replace_if_given(item.condition, ordered.condition);
}

/// Returns whether the order is for one unit, which is this item by its name or serial number.
bool is_for_item_only(const OrderFile& order, const CalibratedItem& item) {
  if (order.units.size() != 1) return false;
  const OrderedUnit& unit = order.units.front();
  return (!unit.name.empty() && unit.name == item.name) ||
         (!item.serial_number.empty() && unit.item.serial_number == item.serial_number);
}

/// Returns the number of the item's report. It contains the serial number or name of the item if the order has several
/// units, or if other units of the record may be reported with the same order.
std::string number_report(const OrderFile& order, const CalibratedItem& item, std::size_t units_in_record) {
  const OrderedUnit* unit = find_ordered_unit(order, item);
  const bool has_several = order.units.size() > 1 || (units_in_record > 1 && !is_for_item_only(order, item));
  if (order.number.empty() || !has_several) return order.number;
  const std::string serial_number = unit == nullptr ? item.serial_number : unit->item.serial_number;
  return order.number + "-" + (serial_number.empty() ? item.name : serial_number);
}

void add_order(CalibrationReport& report, const OrderFile& order, std::size_t units_in_record) {
  report.number = number_report(order, report.item, units_in_record);
  const OrderedUnit* unit = find_ordered_unit(order, report.item);
  if (unit != nullptr) add_unit(report.item, unit->item);
  report.customer = order.customer;
  report.received = order.received;
  report.issued = order.issued;
  report.place_kind = order.place_kind;
  report.place = order.place;
  replace_if_given(report.method, order.method);
  report.remarks = order.remarks;
  append(report.influences, order.influences);
  append(report.deviations, order.deviations);
  report.replaces = order.replaces;
}

/// Lists persons of the order whose role the laboratory does not confirm. Only the laboratory gives the role
/// authorising. For another role the laboratory may leave the choice to the order by listing no person with that role.
void list_unconfirmed_roles(CalibrationReport& report, const std::optional<LaboratoryFile>& laboratory,
                            const std::optional<OrderFile>& order) {
  const auto listed = laboratory ? laboratory->people : std::vector<Person>();
  for (const Person& person : order ? order->people : std::vector<Person>()) {
    if (person.role != "authorising" && !has_role(listed, person.role)) continue;
    const auto is_listed = [&](const Person& one) { return one.name == person.name && one.role == person.role; };
    if (std::ranges::any_of(listed, is_listed)) continue;
    report.missing.push_back(fmt::format("laboratory.toml: person \"{}\" with role \"{}\", whom order.toml names",
                                         plain(person.name), person.role));
  }
}

/// Returns true if each model, as found and as left, has a result on a record to which it was not fitted.
bool is_verified(const CalibrationReport& report) {
  return std::ranges::all_of(report.results, [&](const ResultTable& one) {
    const auto is_unseen = [&](const ResultTable& other) {
      return other.axis == one.axis && other.stage == one.stage && !other.in_sample;
    };
    return one.stage == Stage::uncompensated || std::ranges::any_of(report.results, is_unseen);
  });
}

/// Lists the records whose rows may have been changed, and those without a date: the days of the report and the due
/// days of the equipment would not cover them.
void list_missing_of_records(CalibrationReport& report) {
  bool are_dated = !report.begun.empty();
  for (const UsedFile& file : report.files) {
    if (file.role != "record") continue;
    if (!file.chain_verified) report.missing.push_back(fmt::format("records: verified hash chain of {}", file.name));
    if (!file.started_utc.empty()) continue;
    are_dated = true;
    report.missing.push_back(fmt::format(
        "records: start time of {}; an imported record has one only if its map states the start of its time",
        file.name));
  }
  if (!are_dated)
    report.missing.emplace_back(
        "records: start times; an imported record has them only if its map states the start of its time");
}

/// Lists equipment that was calibrated after the last run: its certificate does not cover the run.
void list_later_calibrations(CalibrationReport& report) {
  for (const Equipment& one : report.equipment) {
    if (one.calibrated.empty() || report.ended.empty() || one.calibrated <= report.ended) continue;
    const bool is_thermometer = !one.channel.empty();
    report.missing.push_back(
        plain(fmt::format("{}: calibrated of \"{}\", on or before {} (UTC) when the calibration ended; it is {}",
                          is_thermometer ? "records" : "laboratory.toml", is_thermometer ? one.channel : one.name,
                          report.ended, one.calibrated)));
  }
}

void list_missing(CalibrationReport& report) {
  const auto require_key = [&](bool is_there, const char* file, const char* key) {
    if (!is_there) report.missing.push_back(fmt::format("{}: {}", file, key));
  };
  constexpr const char *kLaboratory = "laboratory.toml", *kOrder = "order.toml";
  require_key(!report.laboratory.name.empty(), kLaboratory, "name");
  require_key(!report.laboratory.city.empty(), kLaboratory, "city");
  require_key(!report.laboratory.country.empty(), kLaboratory, "country");
  require_key(!report.traceability.empty(), kLaboratory, "traceability");
  require_key(!report.method.empty(), kOrder, "method");
  require_key(!report.number.empty(), kOrder, "number");
  require_key(!report.customer.name.empty(), kOrder, "customer.name");
  require_key(!report.customer.city.empty(), kOrder, "customer.city");
  require_key(!report.received.empty(), kOrder, "received");
  require_key(!report.issued.empty(), kOrder, "issued");
  if (!report.simulated) append(report.missing, find_wrong_days(report));
  if (!report.simulated) list_later_calibrations(report);
  require_key(!report.item.model.empty(), kOrder, "unit.model");
  require_key(!report.item.serial_number.empty(), kOrder, "unit.serial_number");
  require_key(!report.item.condition.empty(), kOrder, "unit.condition");
  if (const auto channels = find_uncertified_thermometers(report); !report.simulated && !channels.empty())
    report.missing.push_back(
        fmt::format("records: certificate of a thermometer{}; without one in the rig file, equipment with role "
                    "\"thermometer\" in laboratory.toml",
                    channels.front().empty() ? "" : fmt::format(": {}", fmt::join(channels, ", "))));
  list_missing_of_records(report);
  require_key(is_verified(report), "records", "a record that the model was not trained on");
  require_key(has_role(report.people, "operator"), kOrder, "person with role \"operator\"");
  require_key(has_role(report.people, "authorising"), kLaboratory, "person with role \"authorising\"");
  append(report.missing, find_placeholders(report));
}

/// Compares two rows of one column by verdict, then by probability if known, then by magnitude; an unknown value has
/// the greatest magnitude. Each row has its own uncertainty.
bool is_worse(const Conformity& one, const Conformity& other) {
  const auto key = [](const Conformity& of) {
    const double magnitude = std::abs(of.value.value);
    return std::tuple(of.verdict, std::isnan(of.probability) ? -2 : -of.probability,
                      std::isnan(magnitude) ? std::numeric_limits<double>::infinity() : magnitude);
  };
  return key(one) > key(other);
}

}  // namespace

std::vector<std::string> find_wrong_days(const CalibrationReport& report) {
  std::vector<std::string> wrong;
  const auto are_in_order = [](const std::string& first, const std::string& then) {
    return first.empty() || then.empty() || first <= then;
  };
  if (!are_in_order(report.received, report.begun))
    wrong.push_back(
        fmt::format("order.toml: received, on or before {} (UTC) when the calibration began", report.begun));
  if (!are_in_order(report.ended, report.issued))
    wrong.push_back(fmt::format("order.toml: issued, on or after {} (UTC) when the calibration ended", report.ended));
  if (!are_in_order(report.received, report.issued))
    wrong.push_back(fmt::format("order.toml: issued, on or after {} when the unit was received", report.received));
  return wrong;
}

std::vector<std::string> find_days_against_authorisation(const CalibrationReport& report, const std::string& now_utc) {
  constexpr std::chrono::days kLocalTime{1}, kFarthestIssue{31};
  const std::string day_of_now = now_utc.substr(0, std::string_view("2026-11-25").size());
  const auto issued = record::parse_day(report.issued), ended = record::parse_day(report.ended),
             today = record::parse_day(day_of_now);
  std::vector<std::string> wrong;
  if (ended && today && *ended > *today)
    wrong.push_back(fmt::format(
        "records: end of the calibration on {} (UTC), after {}, the time of authorisation; check the clocks",
        report.ended, now_utc));
  if (issued && today && *today > *issued + kLocalTime)
    wrong.push_back(fmt::format("order.toml: issued, on or after {} (UTC), the day of authorisation", now_utc));
  if (issued && today && *issued > *today + kFarthestIssue)
    wrong.push_back(fmt::format("order.toml: issued, at most {} days after {} (UTC), the day of authorisation",
                                kFarthestIssue.count(), now_utc));
  return wrong;
}

Conformity find_worst_row(const std::vector<ReportedValue>& values, double limit, DecisionRule rule) {
  std::optional<Conformity> worst;
  for (const ReportedValue& value : values) {
    const Conformity one = compare_with_limits(value, limit, rule);
    if (!worst || is_worse(one, *worst)) worst = one;
  }
  return worst.value_or(compare_with_limits({}, limit, rule));
}

const OrderedUnit* find_ordered_unit(const OrderFile& order, const CalibratedItem& item) {
  if (!item.serial_number.empty()) {
    const auto same = std::ranges::find(order.units, item.serial_number,
                                        [](const OrderedUnit& unit) { return unit.item.serial_number; });
    if (same != order.units.end()) return &*same;
  }
  const auto is_named = [&](const OrderedUnit& unit) { return !unit.name.empty() && unit.name == item.name; };
  const auto named = std::ranges::find_if(order.units, is_named);
  if (named != order.units.end()) return &*named;
  return order.units.size() == 1 && order.units.front().name.empty() ? &order.units.front() : nullptr;
}

void add_order(CalibrationReport& report, const std::optional<LaboratoryFile>& laboratory,
               const std::optional<OrderFile>& order, std::size_t units_in_record) {
  if (laboratory) add_laboratory(report, *laboratory);
  report.people = merge_people(laboratory ? laboratory->people : std::vector<Person>(),
                               order ? order->people : std::vector<Person>());
  if (order) {
    add_order(report, *order, units_in_record);
    apply_limits(report, order->limits, order->rule);
  }
  list_missing(report);
  list_unconfirmed_roles(report, laboratory, order);
}

Result<void> check_may_authorise(const std::vector<Person>& people, const std::string& by) {
  std::vector<std::string> names;
  for (const Person& person : people)
    if (person.role == "authorising") names.push_back(person.name);
  if (std::ranges::find(names, by) != names.end()) return {};
  const std::string others = plain(fmt::format("\"{}\"", fmt::join(names, "\", \"")));
  return failure(FaultKind::usage, "--by",
                 fmt::format("\"{}\" does not have the role authorising; laboratory.toml gives it to {}", plain(by),
                             names.empty() ? "no person" : others));
}

namespace {

Result<void> check_unit(const OrderedUnit& ordered_unit, const CalibratedItem& item, const std::string& from) {
  const CalibratedItem& unit = ordered_unit.item;
  for (const auto& [key, ordered, own] : {std::tuple("model", &unit.model, &item.model),
                                          std::tuple("serial_number", &unit.serial_number, &item.serial_number)})
    if (!ordered->empty() && !own->empty() && *ordered != *own)
      return failure(FaultKind::bad_file, ordered_unit.place,
                     fmt::format("the unit's {} is \"{}\", but {} contains \"{}\"; remove it from the order", key,
                                 *ordered, from, *own));
  if (!ordered_unit.name.empty() && ordered_unit.name != item.name)
    return failure(FaultKind::bad_file, ordered_unit.place,
                   fmt::format("the unit {} is \"{}\", but in {} it is \"{}\"; correct the name in the order",
                               unit.serial_number, ordered_unit.name, from, item.name));
  return {};
}

/// Fails if the order lists serial numbers, and neither that of the item nor a unit for its position.
Result<void> check_is_ordered(const OrderFile& order, const CalibratedItem& item, const std::string& from) {
  const auto has_serial = [](const OrderedUnit& unit) { return !unit.item.serial_number.empty(); };
  const auto listed = std::ranges::find_if(order.units, has_serial);
  if (item.serial_number.empty() || listed == order.units.end()) return {};
  return failure(FaultKind::bad_file, listed->place,
                 fmt::format("the order does not contain the serial number \"{}\" of {} in {}", item.serial_number,
                             item.name, from));
}

}  // namespace

Result<void> check_units(const OrderFile& order, const std::vector<CalibratedItem>& items, const std::string& from) {
  const auto has_no_serial = [](const CalibratedItem& item) { return item.serial_number.empty(); };
  const bool are_found_by_serial = std::ranges::none_of(items, has_no_serial);
  const auto unnamed = std::ranges::find_if(order.units, [&](const OrderedUnit& unit) {
    return unit.name.empty() && (unit.item.serial_number.empty() || !are_found_by_serial);
  });
  if (items.size() > 1 && unnamed != order.units.end()) {
    std::vector<std::string> names;
    for (const CalibratedItem& item : items) names.push_back(item.name);
    return failure(FaultKind::bad_file, unnamed->place,
                   fmt::format("the unit has no name although {} has several units, expected one of {}", from,
                               fmt::join(names, ", ")));
  }
  for (const CalibratedItem& item : items) {
    const OrderedUnit* unit = find_ordered_unit(order, item);
    auto same = unit != nullptr ? check_unit(*unit, item, from) : check_is_ordered(order, item, from);
    if (!same) return same;
  }
  return {};
}

namespace {

/// Returns the unit of a quantity that has a limit, for a report without a result of this quantity.
std::string limited_unit(std::string_view quantity) {
  static constexpr std::array<std::pair<std::string_view, const char*>, 8> kUnits{{{"duration", "s"},
                                                                                   {"temperature_sensitivity", "°/h/K"},
                                                                                   {"gradient_sensitivity", "°/h/K"},
                                                                                   {"ramp_sensitivity", "°/h/(K/min)"},
                                                                                   {"quantisation", "″"},
                                                                                   {"angle_random_walk", "°/√h"},
                                                                                   {"rate_random_walk", "°/h/√h"},
                                                                                   {"rate_ramp", "°/h/h"}}};
  const auto found = std::ranges::find(kUnits, quantity, &std::pair<std::string_view, const char*>::first);
  return found == kUnits.end() ? "°/h" : found->second;
}

/// Returns the stages of the results in their order; as left for a report without results.
std::vector<Stage> list_stages(const CalibrationReport& report) {
  std::set<Stage> stages;
  for (const ResultTable& table : report.results) stages.insert(table.stage);
  if (stages.empty()) return {Stage::as_left};
  return {stages.begin(), stages.end()};
}

/// Returns the comparison without its verdict and probability; the value has no uncertainty.
Conformity without_verdict(const Conformity& one) {
  return {.value = {.value = one.value.value}, .limit = one.limit, .rule = one.rule, .verdict = Verdict::not_known};
}

}  // namespace

Conformity judge_column(const CalibrationReport& report, const ResultTable& table, const Column& column, double limit,
                        DecisionRule rule) {
  const Conformity worst = find_worst_row(column.values, limit, rule);
  return has_unknown_zero(report, table, column.quantity) ? without_verdict(worst) : worst;
}

namespace {

/// A limit, and the result that it names.
struct AppliedLimit {
  const ReportedLimit& limit;
  DecisionRule rule;
  std::string key, quantity;
};

/// Returns the row of a limit without a result.
Conformity row_without_result(const AppliedLimit& of, const std::string& axis, Stage stage) {
  Conformity none = compare_with_limits({}, of.limit.at_most, of.rule);
  none.quantity = of.limit.quantity;
  none.axis = axis;
  none.stage = stage;
  none.unit = limited_unit(of.quantity);
  return none;
}

/// Returns true if the limit concerns a noise term that the evaluated noise of this axis and stage does not show. Such
/// a term is too small to be seen; its evidence is not missing.
bool is_unseen_noise(const CalibrationReport& report, const AppliedLimit& of, const std::string& axis, Stage stage) {
  const auto is_noise = [](const ResultTable& table) { return table.group == Group::random_drift && !table.in_sample; };
  return std::ranges::any_of(report.results,
                             [&](const ResultTable& table) { return is_noise(table) && table.key == of.key; }) &&
         std::ranges::any_of(report.results, [&](const ResultTable& table) {
           return is_noise(table) && table.axis == axis && table.stage == stage;
         });
}

/// Returns true if a result of this axis and stage cannot be compared with the limit: it exists only on records to
/// which the model was fitted, the quantity exists only with a model, the axis has no earlier model, or the result is a
/// noise term that is not seen.
bool is_excluded(const CalibrationReport& report, const AppliedLimit& of, const std::string& axis, Stage stage) {
  if (stage == Stage::uncompensated && of.key == "compensated_mean") return true;
  if (is_unseen_noise(report, of, axis, stage)) return true;
  bool has_any = false, has_unseen = false, has_in_sample = false;
  for (const ResultTable& table : report.results) {
    if (table.axis != axis || table.stage != stage) continue;
    has_any = true;
    has_unseen = has_unseen || !table.in_sample;
    has_in_sample =
        has_in_sample || (table.in_sample && table.key == of.key && find_column(table, of.quantity) != nullptr);
  }
  return has_in_sample || (has_any && !has_unseen) || (stage == Stage::as_found && !has_any);
}

/// Adds a row without a verdict for each axis and stage to which the limit applies, but that has no result.
void add_rows_without_result(CalibrationReport& report, const AppliedLimit& of, std::size_t first) {
  const auto stages = of.limit.stage ? std::vector{*of.limit.stage} : list_stages(report);
  if (report.conformity.size() == first) {
    for (const Stage stage : stages) report.conformity.push_back(row_without_result(of, "", stage));
    return;
  }
  for (const std::string& axis : report.item.axes)
    for (const Stage stage : stages) {
      const auto is_it = [&](const Conformity& one) { return one.axis == axis && one.stage == stage; };
      const auto begin = report.conformity.begin() + static_cast<std::ptrdiff_t>(first);
      if (std::any_of(begin, report.conformity.end(), is_it) || is_excluded(report, of, axis, stage)) continue;
      report.conformity.push_back(row_without_result(of, axis, stage));
    }
}

}  // namespace

void apply_limits(CalibrationReport& report, const std::vector<ReportedLimit>& limits, DecisionRule rule) {
  report.rule = rule;
  for (const ReportedLimit& limit : limits) {
    const auto dot = limit.quantity.find('.');
    const AppliedLimit of{limit, rule, limit.quantity.substr(0, dot), limit.quantity.substr(dot + 1)};
    const std::size_t before = report.conformity.size();
    for (const ResultTable& table : report.results) {
      const Column* column = find_column(table, of.quantity);
      if (table.key != of.key || column == nullptr || table.in_sample) continue;
      if (limit.stage && *limit.stage != table.stage) continue;
      Conformity one = judge_column(report, table, *column, limit.at_most, rule);
      one.quantity = limit.quantity;
      one.axis = table.axis;
      one.stage = table.stage;
      one.run = table.run;
      one.unit = column->unit;
      report.conformity.push_back(std::move(one));
    }
    add_rows_without_result(report, of, before);
  }
}

}  // namespace gyrotherm::report
