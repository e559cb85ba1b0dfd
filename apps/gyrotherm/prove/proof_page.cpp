// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/prove/proof_page.hpp"

#include <fmt/format.h>

#include <array>

#include "apps/gyrotherm/german_evidence.hpp"
#include "report/html_page.hpp"
#include "report/plot/svg.hpp"
#include "report/words.hpp"
#include "sequencer/prove/proof.hpp"

namespace gyrotherm::app {
namespace {

using plot::escaped;
using prove::Proof;
using prove::ProofResult;
using report::Language;

/// Texts of the page, English and German.
struct PageTexts {
  const char *kind, *heading, *rig, *chamber, *person, *time, *program, *verdict, *previous, *none, *digest, *signature,
      *is_unsigned, *results, *test, *cause, *limit, *seconds, *reading, *value, *restored, *as_found, *not_as_found,
      *item, *before, *after;
};
constexpr std::array<PageTexts, 2> kPageTexts{{
    {"Protocol of proof tests",
     "Proof tests of {}",
     "Rig",
     "Chamber",
     "Operator",
     "Time",
     "Program",
     "Result",
     "Previous protocol",
     "none",
     "SHA-256 of proof.json",
     "Signature",
     "UNSIGNED",
     "Tests",
     "Test",
     "Reason",
     "Limit",
     "Time / s",
     "Reading",
     "Value",
     "Registers of the chamber",
     "The chamber was left as it was found.",
     "The chamber was NOT left as it was found: {}",
     "Register",
     "Before",
     "After"},
    {"Protokoll der Wiederholungsprüfungen",
     "Wiederholungsprüfungen von {}",
     "Prüfstand",
     "Klimakammer",
     "Prüfer",
     "Zeit",
     "Programm",
     "Ergebnis",
     "Vorheriges Protokoll",
     "keines",
     "SHA-256 von proof.json",
     "Signatur",
     "NICHT SIGNIERT",
     "Prüfungen",
     "Prüfung",
     "Ursache",
     "Grenze",
     "Zeit / s",
     "Beobachtung",
     "Wert",
     "Register der Klimakammer",
     "Die Kammer wurde so verlassen, wie sie vorgefunden wurde.",
     "Die Kammer wurde NICHT so verlassen, wie sie vorgefunden wurde: {}",
     "Register",
     "Vorher",
     "Nachher"},
}};

const PageTexts& page_texts(Language language) { return kPageTexts[language == Language::german ? 1 : 0]; }

const char* test_text(prove::ProofTest test, Language language) {
  if (language == Language::english) return name(test);
  switch (test) {
    case prove::ProofTest::limiter: return "Temperaturbegrenzer";
    case prove::ProofTest::make_safe: return "Sicherer Zustand";
    case prove::ProofTest::line: return "Ausfall der Leitung";
    case prove::ProofTest::relay: return "Relais";
    case prove::ProofTest::interlocks: return "Verriegelungen";
    case prove::ProofTest::clock: return "Uhr";
    case prove::ProofTest::disk: return "Datenträger";
  }
  return "";
}

const char* verdict_text(prove::ProofVerdict verdict, Language language) {
  if (language == Language::english) return name(verdict);
  switch (verdict) {
    case prove::ProofVerdict::passed: return "bestanden";
    case prove::ProofVerdict::failed: return "NICHT bestanden";
    case prove::ProofVerdict::not_tested: return "nicht geprüft";
    case prove::ProofVerdict::interrupted: return "abgebrochen";
  }
  return "";
}

std::string identity_html(const Proof& proof, const std::string& sha256, const std::string& signer, Language language) {
  const auto& t = page_texts(language);
  std::string html = "<dl class=\"identity\">\n";
  const auto add = [&](const char* what, const std::string& value) {
    html += fmt::format("<dt>{}</dt><dd>{}</dd>\n", what, escaped(value));
  };
  add(t.verdict, verdict_text(overall_verdict(proof), language));
  add(t.rig, fmt::format("{}, {} ({}, SHA-256 {})", proof.rig, proof.title, proof.rig_file, proof.rig_sha256));
  if (!proof.chamber.empty()) add(t.chamber, proof.chamber);
  add(t.person, proof.operator_name);
  add(t.time, fmt::format("{} – {}", proof.began, proof.ended));
  add(t.program, "gyrotherm " + proof.version);
  add(t.previous,
      proof.previous.empty() ? t.none : fmt::format("{} (SHA-256 {})", proof.previous, proof.previous_sha256));
  add(t.digest, sha256);
  add(t.signature, signer.empty() ? t.is_unsigned : signer);
  return html + "</dl>\n";
}

/// Returns a text of the protocol, which is in English, in the language of the page.
std::string evidence_html(const std::string& text, Language language) {
  return escaped(language == Language::german ? translate_evidence(text) : text);
}

std::string result_html(const ProofResult& result, Language language) {
  const auto& t = page_texts(language);
  const auto shown = [&](const std::string& text) { return evidence_html(text, language); };
  auto html = fmt::format("<h2>{} – {}</h2>\n<p>{}, {} s</p>\n", test_text(result.test, language),
                          verdict_text(result.verdict, language), escaped(result.began),
                          report::format_number(language, result.duration_s, 1));
  if (!result.cause.empty()) html += fmt::format("<p class=\"caution\">{}: {}</p>\n", t.cause, shown(result.cause));
  report::HtmlTable limits{.header = {t.limit, t.value}, .text_columns = 2};
  for (const auto& limit : result.limits) limits.rows.push_back({shown(limit.what), shown(limit.limit)});
  report::HtmlTable readings{.header = {t.reading, t.value, t.seconds}, .text_columns = 2};
  const bool are_identifiers = result.test == prove::ProofTest::interlocks;
  for (const auto& one : result.readings)
    readings.rows.push_back({are_identifiers ? escaped(one.what) : shown(one.what), shown(one.value),
                             report::format_number(language, one.at_s, 1)});
  if (!limits.rows.empty()) html += to_html(limits);
  if (!readings.rows.empty()) html += to_html(readings);
  return html;
}

std::string registers_html(const Proof& proof, Language language) {
  if (proof.registers.empty() && proof.is_as_found) return "";
  const auto& t = page_texts(language);
  auto html = fmt::format("<h2>{}</h2>\n<p>{}</p>\n", t.restored,
                          proof.is_as_found
                              ? std::string(t.as_found)
                              : fmt::format(fmt::runtime(t.not_as_found), evidence_html(proof.restoration, language)));
  report::HtmlTable table{.header = {t.item, t.before, t.after}, .text_columns = 3};
  for (const auto& one : proof.registers)
    table.rows.push_back({escaped(one.item), escaped(one.before), escaped(one.after)});
  return table.rows.empty() ? html : html + to_html(table);
}

Result<std::string> proof_page(const ProtocolText& protocol, const std::string& file, Language language) {
  const auto read = prove::parse_proof(protocol.json, file);
  if (!read) return failure(read.error());
  const Proof& proof = *read;
  const auto& [json, sha256, signer] = protocol;
  const auto& t = page_texts(language);
  auto body = identity_html(proof, sha256, signer, language);
  report::HtmlTable overview{.header = {t.test, t.verdict, t.cause}, .text_columns = 3};
  for (const auto& result : proof.results)
    overview.rows.push_back({test_text(result.test, language), verdict_text(result.verdict, language),
                             evidence_html(result.cause, language)});
  body += fmt::format("<h2>{}</h2>\n", t.results) + to_html(overview);
  for (const auto& result : proof.results) body += result_html(result, language);
  body += registers_html(proof, language);
  const auto heading = fmt::format(fmt::runtime(t.heading), proof.title);
  return to_html(report::HtmlPage{
      .title = heading,
      .kind = fmt::format("{}{}{}", t.kind, signer.empty() ? " – " : "", signer.empty() ? t.is_unsigned : ""),
      .heading = heading,
      .subtitle = proof.began,
      .simulated = proof.simulated,
      .body = body,
      .footer = fmt::format("{}; {}", prove::kProofSchema, sha256),
      .language = report::code(language)});
}

}  // namespace

ProtocolKind proof_protocol() { return {.stem = "proof", .page = &proof_page}; }

}  // namespace gyrotherm::app
