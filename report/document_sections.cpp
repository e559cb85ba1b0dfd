// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "report/document_parts.hpp"
#include "report/stored_texts.hpp"

namespace gyrotherm::report {
namespace {

std::string address_text(const Party& party) {
  std::vector<std::string> lines = party.address;
  std::string city = party.postal_code;
  if (!party.city.empty()) city += (city.empty() ? "" : " ") + party.city;
  if (!city.empty()) lines.push_back(city);
  if (!party.country.empty()) lines.push_back(party.country);
  std::string all;
  for (const std::string& line : lines) all += (all.empty() ? "" : "\n") + line;
  return all;
}

void add_party(DocumentWriter& writer, const char* heading_key, const char* id, const Party& party) {
  writer.subheading(writer.translated(heading_key), id);
  DefinitionsWriter lines(writer);
  lines.required_line("label.name", party.name);
  lines.required_line("label.address", address_text(party));
  lines.line("label.email", party.email);
  lines.line("label.phone", party.phone);
  writer.add(std::move(lines).finish());
}

std::string join_with_commas(const std::vector<std::string>& texts) {
  return fmt::format("{}", fmt::join(texts, ", "));
}

void add_item(DocumentWriter& writer) {
  const CalibratedItem& item = writer.report.item;
  writer.subheading(writer.translated("heading.item"), "item");
  DefinitionsWriter lines(writer);
  lines.required_line("label.item", text_in(writer.language, item.description));
  lines.required_line("label.manufacturer", item.manufacturer);
  lines.required_line("label.model", item.model);
  lines.required_line("label.serial_number", item.serial_number);
  lines.line("label.customers_number", item.customers_number);
  lines.line("label.name_in_rig", item.name);
  std::vector<std::string> named = item.axes;
  std::erase(named, "");
  lines.line("label.axes", join_with_commas(named));
  lines.required_line("label.condition", text_in(writer.language, item.condition));
  writer.add(std::move(lines).finish());
}

std::string location_text(const DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  std::string place = report.place_kind.empty() ? "" : writer.translated(report.place_kind);
  if (const std::string& own = text_in(writer.language, report.place); !own.empty())
    place += (place.empty() ? "" : ": ") + own;
  return place;
}

void add_other_report(DefinitionsWriter& lines, const DocumentWriter& writer, const char* label,
                      const std::optional<OtherReport>& other) {
  if (!other) return;
  std::string text = other->number;
  if (const std::string& reason = text_in(writer.language, other->reason); !reason.empty()) text += " – " + reason;
  if (!other->sha256.empty()) text += "\nSHA-256 " + other->sha256;
  lines.line(label, text);
}

void add_report_itself(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  const Language language = writer.language;
  writer.subheading(writer.translated("heading.report"), "report");
  DefinitionsWriter lines(writer);
  lines.required_line("label.number", report.number);
  lines.line("label.state", writer.translated(name(report.state)));
  lines.line("label.received", format_day(language, report.received));
  lines.required_line("label.performed", report.begun.empty() ? ""
                                         : report.begun == report.ended || report.ended.empty()
                                             ? format_day(language, report.begun)
                                             : writer.sentence("label.from_to", format_day(language, report.begun),
                                                               format_day(language, report.ended)));
  lines.required_line("label.issued", format_day(language, report.issued));
  lines.required_line("label.place", location_text(writer));
  add_other_report(lines, writer, "label.replaces", report.replaces);
  add_other_report(lines, writer, "label.replaced_by", report.replaced_by);
  writer.add(std::move(lines).finish());
}

/// Returns the bias reference; a line per axis and record if they differ.
std::string bias_reference_text(const DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  std::string zeros = report.bias_zero.empty() ? "" : writer.translated(report.bias_zero);
  for (const BiasReference& one : report.bias_zeros) {
    const std::string record = record_label(report, one.run);
    zeros += fmt::format("{}{}{}{}: {}", zeros.empty() ? "" : "\n", one.axis, record.empty() ? "" : ", ", record,
                         writer.translated(one.zero));
  }
  return zeros;
}

/// Returns both ends of a range with the same number of decimals.
std::pair<std::string, std::string> format_range(Language language, double low, double high) {
  constexpr int kMostDecimals = 6;
  constexpr double kRounding = 1e-6;  // numbers of a record have the precision of float
  const auto is_written = [&](double value, int decimals) {
    const double power = std::pow(10.0, decimals);
    return !std::isfinite(value) || std::abs(std::round(value * power) / power - value) <= kRounding * std::abs(value);
  };
  for (int decimals = 0; decimals <= kMostDecimals; ++decimals)
    if (is_written(low, decimals) && is_written(high, decimals))
      return {format_number(language, low, decimals), format_number(language, high, decimals)};
  return {format_plain(language, low), format_plain(language, high)};
}

DocumentTable influences_table(const DocumentWriter& writer) {
  DocumentTable table{.caption = writer.translated("caption.influences"),
                      .header = {writer.translated("column.influence"), writer.translated("column.low"),
                                 writer.translated("column.high")}};
  for (const Influence& influence : writer.report.influences) {
    const std::string name =
        influence.key.empty() ? text_in(writer.language, influence.name) : writer.translated(influence.key);
    auto [low, high] = format_range(writer.language, influence.low, influence.high);
    table.rows.push_back(
        {{.text = name_with_unit(name, influence.unit)}, {.text = std::move(low)}, {.text = std::move(high)}});
  }
  return table;
}

std::string uncertainty_text(const DocumentWriter& writer, double kelvins) {
  return std::isfinite(kelvins) ? format_significant(writer.language, kelvins, 2) : "–";
}

std::vector<Cell> equipment_row(const DocumentWriter& writer, const Equipment& one) {
  const auto dash = [](const std::string& text) { return text.empty() ? std::string("–") : text; };
  const Cell instrument{
      .text = dash(one.names.empty() ? translate_instrument(writer.language, one.name)
                                     : text_in(writer.language, one.names)),
      .note = one.serial_number.empty() ? "" : writer.translated("column.serial_number") + " " + one.serial_number};
  const Cell certificate{.text = dash(one.certificate),
                         .note = one.calibrated.empty() ? ""
                                                        : writer.translated("column.calibrated") + " " +
                                                              format_day(writer.language, one.calibrated)};
  const Cell due{.mark = one.overdue ? Cell::Mark::caution : Cell::Mark::none,
                 .text = dash(format_day(writer.language, one.due)),
                 .note = one.overdue ? writer.translated("label.overdue") : ""};
  const std::string role = writer.translated(one.role) + (one.channel.empty() ? "" : " " + one.channel);
  return {{.text = role},
          instrument,
          certificate,
          due,
          {.text = uncertainty_text(writer, one.standard_uncertainty_k)},
          {.text = uncertainty_text(writer, one.drift_k_in_a_year)}};
}

DocumentTable equipment_table(const DocumentWriter& writer) {
  DocumentTable table{.caption = writer.translated("caption.equipment"),
                      .header = {writer.translated("column.role"), writer.translated("column.instrument"),
                                 writer.translated("column.certificate"), writer.translated("column.due"),
                                 writer.translated("column.equipment_u"), writer.translated("column.equipment_drift")},
                      .text_columns = 4};
  for (const Equipment& one : writer.report.equipment) table.rows.push_back(equipment_row(writer, one));
  return table;
}

/// Returns "Thermometer A (lakeshore_218 1 at virtual, input 1)", or "Temperature chamber F4T" without a channel.
std::string overdue_name(const DocumentWriter& writer, const Equipment& one) {
  const std::string role = writer.translated(one.role);
  const std::string name =
      one.names.empty() ? translate_instrument(writer.language, one.name) : text_in(writer.language, one.names);
  if (one.channel.empty()) return name.empty() ? role : role + " " + name;
  return role + " " + one.channel + (name.empty() ? "" : " (" + name + ")");
}

std::vector<std::string> overdue_names(const DocumentWriter& writer) {
  std::vector<std::string> names;
  for (const Equipment& one : writer.report.equipment)
    if (one.overdue) names.push_back(overdue_name(writer, one));
  return names;
}

/// Formats "2026-11-11T03:00:12Z" as "2026-11-11 03:00:12" for a column with UTC in its header.
std::string table_instant(std::string utc) {
  if (utc.size() < 20 || utc[10] != 'T' || !utc.ends_with('Z')) return utc.empty() ? "–" : utc;
  utc[10] = ' ';
  return utc.substr(0, 19);
}

std::vector<Cell> deviation_row(const DocumentWriter& writer, const Deviation& one, bool with_record) {
  std::vector<Cell> row{{.text = table_instant(one.utc)}};
  if (with_record) row.push_back({.text = record_label(writer.report, one.run)});
  row.push_back({.text = writer.translated(one.kind)});
  row.push_back({.text = one.translations.empty() ? translate_event(writer.language, one.kind, one.text)
                                                  : text_in(writer.language, one.translations)});
  row.push_back({.text = format_plain(writer.language, one.seconds)});
  return row;
}

Cell chain_cell(const DocumentWriter& writer, const UsedFile& file) {
  if (file.role != "record") return {.text = "–"};
  return {.mark = file.chain_verified ? Cell::Mark::pass : Cell::Mark::fail,
          .text = writer.translated(file.chain_verified ? "title.yes" : "title.no")};
}

DocumentTable files_table(const DocumentWriter& writer) {
  DocumentTable table{.caption = writer.translated("caption.files"),
                      .header = {writer.translated("column.file"), writer.translated("column.hash"),
                                 writer.translated("column.started"), writer.translated("column.program"),
                                 writer.translated("column.chain")},
                      .text_columns = 5};
  for (const UsedFile& file : writer.report.files) {
    const std::string label = record_label(writer.report, file.id);
    std::string role = writer.translated(file.role) + (label.empty() ? "" : " " + label);
    if (!file.id.empty()) role += ", " + writer.translated("column.run") + " " + file.id;
    table.rows.push_back({{.text = file.name, .note = std::move(role)},
                          {.text = file.sha256},
                          {.text = table_instant(file.started_utc)},
                          {.text = file.program_version.empty() ? "–" : "gyrotherm " + file.program_version},
                          chain_cell(writer, file)});
  }
  return table;
}

/// Returns a sentence about the data that the customer provided; empty if the report has none of them.
std::string customer_data_text(const DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  const bool has_name = !report.customer.name.empty(), has_address = !address_text(report.customer).empty();
  std::string provided;
  if (has_name || has_address)
    provided = writer.translated(!has_address ? "provided.name" : has_name ? "provided.both" : "provided.address");
  if (!report.item.customers_number.empty()) {
    const std::string number = writer.translated("provided.number");
    provided = provided.empty() ? number : writer.sentence("provided.and", provided, number);
  }
  return provided.empty() ? provided : writer.sentence("say.by_customer", provided);
}

void add_people(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  DefinitionsWriter lines(writer);
  for (const Person& person : report.people) {
    // Others who may authorise are not responsible for an authorised report.
    if (report.authorised && person.role == "authorising" && person.name != report.authorised->name) continue;
    lines.line(person.role, person.email.empty() ? person.name : fmt::format("{}, {}", person.name, person.email));
  }
  lines.required_line("label.authorised", report.authorised
                                              ? writer.sentence("label.authorised_by", report.authorised->name,
                                                                format_instant(writer.language, report.authorised->utc))
                                              : writer.translated("say.not_authorised"));
  writer.add(std::move(lines).finish());
}

}  // namespace

void add_identification(DocumentWriter& writer) {
  writer.heading("heading.identification");
  add_item(writer);
  add_party(writer, "heading.customer", "customer", writer.report.customer);
  add_party(writer, "heading.laboratory", "laboratory", writer.report.laboratory);
  add_report_itself(writer);
}

void add_method(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  writer.heading("heading.method");
  writer.paragraph(text_in(writer.language, report.method));
  writer.paragraph(writer.translated("say.bias"));
  DefinitionsWriter lines(writer);
  lines.line("label.bias_zero", bias_reference_text(writer));
  if (report.cluster_length_s > 0)
    lines.line("label.cluster_length", format_plain(writer.language, report.cluster_length_s) + "\u00a0s");
  writer.add(std::move(lines).finish());
  if (!report.block_thermometers.empty())
    writer.paragraph(writer.sentence("say.temperature", fmt::format("{}", fmt::join(report.block_thermometers, ", "))));
  writer.table(influences_table(writer));
}

void add_equipment(DocumentWriter& writer) {
  writer.heading("heading.equipment");
  writer.paragraph(text_in(writer.language, writer.report.traceability));
  if (writer.report.equipment.empty()) writer.paragraph(writer.translated("say.no_equipment"));
  if (const auto names = overdue_names(writer); !names.empty())
    writer.paragraph(writer.sentence("say.overdue", join_with_commas(names)), Paragraph::Style::caution);
  writer.table(equipment_table(writer));
}

void add_deviations(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  writer.heading("heading.deviations");
  if (report.deviations.empty()) writer.paragraph(writer.translated("say.no_deviations"));
  const bool with_record = std::ranges::any_of(
      report.deviations, [&](const Deviation& one) { return !record_label(report, one.run).empty(); });
  DocumentTable table{.caption = writer.translated("caption.deviations"),
                      .header = {writer.translated("column.when")},
                      .text_columns = with_record ? 4u : 3u};
  if (with_record) table.header.push_back(writer.translated("column.record"));
  for (const char* key : {"column.kind", "column.text", "column.seconds"})
    table.header.push_back(writer.translated(key));
  for (const Deviation& one : report.deviations) table.rows.push_back(deviation_row(writer, one, with_record));
  writer.table(std::move(table));
  if (std::ranges::any_of(report.deviations, [](const Deviation& one) { return one.kind != "stated"; }))
    writer.paragraph(writer.translated("say.recorded_wording"), Paragraph::Style::note);
}

void add_files(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  writer.heading("heading.files");
  std::vector<std::string> broken;
  bool has_record = false;
  for (const UsedFile& file : report.files) {
    has_record = has_record || file.role == "record";
    if (file.role == "record" && !file.chain_verified) broken.push_back(file.name);
  }
  if (!broken.empty())
    writer.paragraph(writer.sentence("say.chain_broken", join_with_commas(broken)), Paragraph::Style::caution);
  else if (has_record)
    writer.paragraph(writer.translated("say.chain_verified"));
  if (report.files.empty()) writer.paragraph(writer.translated("say.no_files"));
  writer.table(files_table(writer));
  writer.paragraph(writer.sentence("say.source_file", report.program_version), Paragraph::Style::note);
}

void add_statements(DocumentWriter& writer) {
  const CalibrationReport& report = writer.report;
  writer.heading("heading.statements");
  writer.paragraph(text_in(writer.language, report.remarks));
  writer.paragraph(writer.translated(scope_key(report)) + " " + writer.translated("say.standing"));
  writer.paragraph(writer.translated("say.in_full"));
  writer.paragraph(customer_data_text(writer));
  for (const Texts& statement : report.statements) writer.paragraph(text_in(writer.language, statement));
  add_people(writer);
}

}  // namespace gyrotherm::report
