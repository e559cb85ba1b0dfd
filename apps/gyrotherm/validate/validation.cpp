// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/validate/validation.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/json.hpp"
#include "report/html_page.hpp"
#include "report/plot/svg.hpp"

namespace gyrotherm::app {

void describe(auto& form, Like<InstalledProgram> auto& program) {
  form("name", program.name);
  form("sha256", program.sha256);
}

void describe(auto& form, Like<RequirementResult> auto& result) {
  form("id", result.id);
  form("requirement", result.english);
  form("requirement_de", result.german);
  form("verdict", one_of(result.verdict, kValidationVerdicts));
  form("evidence", result.evidence);
  form.if_present("evidence_de", !result.evidence_german.empty(), result.evidence_german);
}

void describe(auto& form, Like<Validation> auto& validation) {
  form.derived("schema", kValidationSchema);
  form.derived("verdict", name(overall_verdict(validation)));
  form("rig", validation.rig);
  form("title", validation.title);
  form("rig_file", validation.rig_file);
  form("rig_sha256", validation.rig_sha256);
  form("simulated", validation.simulated);
  form("version", validation.version);
  form("operator", validation.operator_name);
  form("began", validation.began);
  form("ended", validation.ended);
  form("programs", validation.programs);
  form("results", validation.results);
}

namespace {

/// Texts of the page, in one language.
struct ValidationWords {
  const char *kind, *heading, *rig, *person, *time, *program, *verdict, *digest, *signature, *is_unsigned,
      *requirements, *number, *requirement, *evidence, *files, *file, *passed, *failed, *not_applicable;
};
constexpr ValidationWords kEnglishWords{"Protocol of a validation",
                                        "Installation and operation of {}",
                                        "Rig",
                                        "Operator",
                                        "Time",
                                        "Program",
                                        "Result",
                                        "SHA-256 of validation.json",
                                        "Signature",
                                        "UNSIGNED",
                                        "Requirements",
                                        "No.",
                                        "Requirement",
                                        "Observation",
                                        "Programs",
                                        "File",
                                        "passed",
                                        "FAILED",
                                        "not applicable"};
constexpr ValidationWords kGermanWords{"Validierungsprotokoll",
                                       "Installation und Betrieb von {}",
                                       "Prüfstand",
                                       "Prüfer",
                                       "Zeit",
                                       "Programm",
                                       "Ergebnis",
                                       "SHA-256 von validation.json",
                                       "Signatur",
                                       "NICHT SIGNIERT",
                                       "Anforderungen",
                                       "Nr.",
                                       "Anforderung",
                                       "Nachweis",
                                       "Programme",
                                       "Datei",
                                       "erfüllt",
                                       "NICHT erfüllt",
                                       "nicht anwendbar"};

const char* verdict_word(ValidationVerdict verdict, const ValidationWords& words) {
  if (verdict == ValidationVerdict::passed) return words.passed;
  return verdict == ValidationVerdict::failed ? words.failed : words.not_applicable;
}

/// Returns an identifier with hyphens at which no line is broken.
std::string unbroken(const std::string& id) {
  std::string text;
  for (const char c : plot::escaped(id)) text += c == '-' ? "\u2011" : std::string(1, c);
  return text;
}

std::string identity_html(const Validation& validation, const ProtocolText& protocol, const ValidationWords& words) {
  std::string html = "<dl class=\"identity\">\n";
  const auto add = [&](const char* what, const std::string& value) {
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", what, plot::escaped(value));
  };
  add(words.verdict, verdict_word(overall_verdict(validation), words));
  add(words.rig, fmt::format("{}, {} ({}, SHA-256 {})", validation.rig, validation.title, validation.rig_file,
                             validation.rig_sha256));
  add(words.person, validation.operator_name);
  add(words.time, fmt::format("{} – {}", validation.began, validation.ended));
  add(words.program, "gyrotherm " + validation.version);
  add(words.digest, protocol.sha256);
  add(words.signature, protocol.signer.empty() ? words.is_unsigned : protocol.signer);
  return html + "</dl>\n";
}

Result<std::string> validation_page(const ProtocolText& protocol, const std::string& file, report::Language language) {
  const auto validation = parse_validation(protocol.json, file);
  if (!validation) return failure(validation.error());
  const bool is_german = language == report::Language::german;
  const ValidationWords& words = is_german ? kGermanWords : kEnglishWords;
  report::HtmlTable table{.header = {words.number, words.requirement, words.verdict, words.evidence},
                          .text_columns = 4};
  for (const RequirementResult& result : validation->results)
    table.rows.push_back(
        {unbroken(result.id), plot::escaped(is_german ? result.german : result.english),
         verdict_word(result.verdict, words),
         plot::escaped(is_german && !result.evidence_german.empty() ? result.evidence_german : result.evidence)});
  report::HtmlTable programs{.header = {words.file, "SHA-256"}, .text_columns = 2};
  for (const InstalledProgram& program : validation->programs)
    programs.rows.push_back({plot::escaped(program.name), plot::escaped(program.sha256)});
  const auto heading = fmt::format(fmt::runtime(words.heading), validation->title);
  return to_html(report::HtmlPage{
      .title = heading,
      .kind = protocol.signer.empty() ? fmt::format("{} – {}", words.kind, words.is_unsigned) : words.kind,
      .heading = heading,
      .subtitle = validation->began,
      .simulated = validation->simulated,
      .body = identity_html(*validation, protocol, words) + fmt::format("<h2>{}</h2>\n", words.requirements) +
              to_html(table) + fmt::format("<h2>{}</h2>\n", words.files) + to_html(programs),
      .footer = fmt::format("{}; {}", kValidationSchema, protocol.sha256),
      .language = report::code(language)});
}

}  // namespace

ValidationVerdict overall_verdict(const Validation& validation) {
  const bool has_failed = std::ranges::any_of(
      validation.results, [](const RequirementResult& result) { return result.verdict == ValidationVerdict::failed; });
  return has_failed ? ValidationVerdict::failed : ValidationVerdict::passed;
}

std::string to_json(const Validation& validation) { return json_text(make_json(validation), 2) + "\n"; }

Result<Validation> parse_validation(std::string_view json, const std::string& file) {
  const auto document = JsonNode::parse(json, file);
  if (!document) return failure(document.error());
  if (const auto schema = (*document)["schema"].text(); schema != kValidationSchema)
    return failure(FaultKind::bad_file, file,
                   fmt::format("its schema is \"{}\", expected \"{}\"", schema, kValidationSchema));
  Validation validation;
  read_json(*document, validation);
  if (auto valid = document->verdict(); !valid) return failure(valid.error());
  return validation;
}

ProtocolKind validation_protocol() { return {.stem = "validation", .page = &validation_page}; }

}  // namespace gyrotherm::app
