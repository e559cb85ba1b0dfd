// SPDX-License-Identifier: Apache-2.0
#include "report/dcc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "core/sha256.hpp"
#include "report/cautions.hpp"
#include "report/dcc_text.hpp"
#include "report/plot/png.hpp"
#include "report/stored_texts.hpp"

namespace gyrotherm::report {
namespace {

bool is_draft(const CalibrationReport& report) { return report.state == ReportState::draft || !report.authorised; }

bool is_country(std::string_view code) {
  return code.size() == 2 && std::ranges::all_of(code, [](unsigned char c) { return std::isupper(c) != 0; });
}

/// Returns the keys of missing data that the schema requires. Only a draft may omit them.
std::vector<std::string> missing_data(const CalibrationReport& report) {
  std::vector<std::string> names;
  const auto require_data = [&](bool is_present, const char* name) {
    if (!is_present) names.emplace_back(name);
  };
  require_data(!xml_characters(report.number).empty(), "number");
  require_data(!xml_characters(report.laboratory.name).empty(), "laboratory.name");
  require_data(is_country(report.laboratory.country), "laboratory.country");
  require_data(!xml_characters(report.customer.name).empty(), "customer.name");
  require_data(calendar_day(report.begun).has_value(), "begun");
  require_data(calendar_day(report.ended).has_value(), "ended");
  require_data(calendar_day(report.issued).has_value(), "issued");
  require_data(!report.results.empty(), "results");
  return names;
}

/// Returns the number, marked for a draft or simulation so that it cannot be mistaken for a calibration.
std::string make_identifier(const CalibrationReport& report) {
  std::string marks;
  if (is_draft(report)) marks = "draft";
  if (report.simulated) marks += marks.empty() ? "simulated" : ", simulated";
  return marks.empty() ? text_or_not_given(report.number)
                       : fmt::format("{} ({})", text_or_not_given(report.number), marks);
}

std::string valid_day_or_placeholder(const std::string& text) { return calendar_day(text).value_or("0001-01-01"); }

class Certificate {
 public:
  Certificate(const CalibrationReport& report, const DccOptions& options)
      : report_(report), options_(options), dcc_(report), xml_(dcc_.xml()) {}

  std::string write() && {
    xml_.element("dcc:digitalCalibrationCertificate",
                 {{"xmlns:dcc", "https://ptb.de/dcc"},
                  {"xmlns:si", "https://ptb.de/si"},
                  {"xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance"},
                  {"xsi:schemaLocation", "https://ptb.de/dcc https://ptb.de/dcc/v3.3.0/dcc.xsd"},
                  {"schemaVersion", "3.3.0"}},
                 [&] {
                   xml_.element("dcc:administrativeData", [&] { administrative_data(); });
                   write_measurement_results(dcc_);
                   if (options_.pdf && options_.pdf->bytes.size() <= kLargestEmbeddedPdf) document(*options_.pdf);
                 });
    return std::move(xml_).text();
  }

 private:
  void administrative_data() {
    software();
    ref_type_definitions();
    xml_.element("dcc:coreData", [&] { core_data(); });
    xml_.element("dcc:items", [&] { item(); });
    xml_.element("dcc:calibrationLaboratory",
                 [&] { xml_.element("dcc:contact", [&] { contact(report_.laboratory, report_.logo); }); });
    xml_.element("dcc:respPersons", [&] { persons(); });
    xml_.element("dcc:customer", [&] { contact(report_.customer, {}); });
    xml_.element("dcc:statements", [&] { statements(); });
  }

  void software() {
    xml_.element("dcc:dccSoftware", [&] {
      xml_.element("dcc:software", [&] {
        dcc_.proper_name("dcc:name", "gyrotherm");
        xml_.leaf("dcc:release", text_or_not_given(report_.program_version));
        xml_.leaf("dcc:type", "application");
      });
    });
  }

  void ref_type_definitions() {
    const auto definition = [&](const Texts& name, const char* space, const char* link) {
      xml_.element("dcc:refTypeDefinition", [&] {
        dcc_.text("dcc:name", name);
        xml_.leaf("dcc:namespace", space);
        xml_.leaf("dcc:link", link);
      });
    };
    xml_.element("dcc:refTypeDefinitions", [&] {
      definition({"Vocabulary of PTB", "Vokabular der PTB"}, "basic", "https://digilab.ptb.de/dkd/refType/vocab/");
      definition({"Results and quantities of a gyro in a temperature test, by the keys of calibration.json",
                  "Ergebnisse und Größen eines Kreisels im Temperaturtest, nach den Schlüsseln von calibration.json"},
                 "gyrotherm", "urn:gyrotherm:calibration:1");
    });
  }

  void core_data() {
    const bool known = is_country(report_.laboratory.country);
    // "ZZ" is not assigned to any country.
    xml_.leaf("dcc:countryCodeISO3166_1", known ? report_.laboratory.country : "ZZ");
    for (const char* language : {"en", "de"}) xml_.leaf("dcc:usedLangCodeISO639_1", language);
    xml_.leaf("dcc:mandatoryLangCodeISO639_1", code(dcc_.mandatory()));
    xml_.leaf("dcc:uniqueIdentifier", make_identifier(report_));
    xml_.element("dcc:identifications", [&] { files(); });
    if (const auto day = calendar_day(report_.received)) xml_.leaf("dcc:receiptDate", *day);
    const bool both = calendar_day(report_.begun) && calendar_day(report_.ended);
    xml_.leaf("dcc:beginPerformanceDate", valid_day_or_placeholder(both ? report_.begun : ""));
    xml_.leaf("dcc:endPerformanceDate", valid_day_or_placeholder(both ? report_.ended : ""));
    const bool is_place = report_.place_kind == "laboratory" || report_.place_kind == "customer";
    xml_.leaf("dcc:performanceLocation", is_place ? report_.place_kind : "other");
    if (const auto day = calendar_day(report_.issued)) xml_.leaf("dcc:issueDate", *day);
    if (report_.replaces) replaced(*report_.replaces);
  }

  /// Writes names and hashes of the files that belong to this certificate.
  void files() {
    const auto digest = [&](const std::string& name, const std::string& digest_of_file) {
      xml_.element("dcc:identification", {{"refType", kFileDigestType}}, [&] {
        xml_.leaf("dcc:issuer", "calibrationLaboratory");
        xml_.leaf("dcc:value", text_or_not_given(digest_of_file));
        xml_.element("dcc:name", [&] {
          xml_.leaf("dcc:content", text_or_not_given(name));  // no language: the name itself
          xml_.leaf("dcc:content", "SHA-256 of the file " + text_or_not_given(name), {{"lang", "en"}});
          xml_.leaf("dcc:content", "SHA-256 der Datei " + text_or_not_given(name), {{"lang", "de"}});
        });
      });
    };
    if (std::ranges::find(options_.files, kCalibrationFile, &IssuedFile::name) == options_.files.end())
      digest(kCalibrationFile, sha256(to_json(report_)));
    for (const IssuedFile& file : options_.files) digest(file.name, file.sha256);
  }

  void replaced(const OtherReport& other) {
    xml_.element("dcc:reportAmendedSubstituted", [&] {
      xml_.leaf("dcc:typeOfChange", "substituted");
      xml_.leaf("dcc:replacedUniqueIdentifier", text_or_not_given(other.number));
    });
    if (other.sha256.empty()) return;
    xml_.element("dcc:previousReport", [&] {
      dcc_.text("dcc:referral", {"calibration.json of the report that this one replaces",
                                 "calibration.json des Berichts, den dieser ersetzt"});
      xml_.leaf("dcc:referralID", text_or_not_given(other.number));
      xml_.leaf("dcc:procedure", "SHA-256");
      xml_.leaf("dcc:value", text_or_not_given(other.sha256));
      if (!other.reason.empty()) dcc_.text("dcc:description", other.reason);
    });
  }

  void item() {
    const CalibratedItem& item = report_.item;
    xml_.element("dcc:item", {{"id", "item"}}, [&] {
      item.description.empty() ? dcc_.proper_name("dcc:name", item.name.empty() ? item.model : item.name)
                               : dcc_.text("dcc:name", item.description);
      if (!item.condition.empty())
        dcc_.text("dcc:description", join_texts(texts_for("label.condition"), ": ", item.condition));
      if (!item.manufacturer.empty())
        xml_.element("dcc:manufacturer", [&] { dcc_.proper_name("dcc:name", item.manufacturer); });
      if (!xml_characters(item.model).empty()) xml_.leaf("dcc:model", item.model);
      xml_.element("dcc:identifications", [&] { identifications(item); });
      const auto named = [](const std::string& axis) { return !axis.empty(); };
      if (std::ranges::any_of(item.axes, named)) xml_.element("dcc:subItems", [&] { axes(item); });
    });
  }

  void identifications(const CalibratedItem& item) {
    dcc_.identification("manufacturer", item.serial_number, texts_for("label.serial_number"),
                        {{"refType", "basic_serialNumber"}});
    if (!item.customers_number.empty())
      dcc_.identification("customer", item.customers_number, texts_for("label.customers_number"));
    if (!item.name.empty()) dcc_.identification("other", item.name, texts_for("label.name_in_rig"));
  }

  void axes(const CalibratedItem& item) {
    for (std::size_t i = 0; i < item.axes.size(); ++i)
      xml_.element("dcc:item", {{"id", fmt::format("axis-{}", i + 1)}}, [&] {
        dcc_.text("dcc:name", texts_for("heading.axis", text_or_not_given(item.axes[i])));
        xml_.element("dcc:identifications",
                     [&] { dcc_.identification("other", item.axes[i], texts_for("label.name_in_rig")); });
      });
  }

  void contact(const Party& party, const std::optional<Logo>& logo) {
    const auto leaf_if_any = [&](const char* name, const std::string& text) {
      if (!xml_characters(text).empty()) xml_.leaf(name, text);
    };
    dcc_.proper_name("dcc:name", party.name);
    leaf_if_any("dcc:eMail", party.email);
    leaf_if_any("dcc:phone", party.phone);
    xml_.element("dcc:location", [&] {
      xml_.leaf("dcc:city", text_or_not_given(party.city));
      if (is_country(party.country)) xml_.leaf("dcc:countryCode", party.country);
      leaf_if_any("dcc:postCode", party.postal_code);
      for (const std::string& line : party.address) leaf_if_any("dcc:street", line);
    });
    if (!logo || !is_base64(logo->base64)) return;
    xml_.element("dcc:descriptionData", [&] {
      xml_.leaf("dcc:fileName", logo->media_type == "image/png" ? "logo.png" : "logo.svg");
      xml_.leaf("dcc:mimeType", text_or_not_given(logo->media_type));
      xml_.leaf("dcc:dataBase64", logo->base64);
    });
  }

  void person(const Texts& name, const std::string& email, const std::string& role, const Texts& description,
              bool signs) {
    xml_.element("dcc:respPerson", [&] {
      xml_.element("dcc:person", [&] {
        name.en == name.de ? dcc_.proper_name("dcc:name", name.en) : dcc_.text("dcc:name", name);
        if (!xml_characters(email).empty()) xml_.leaf("dcc:eMail", email);
      });
      if (!description.empty()) dcc_.text("dcc:description", description);
      xml_.leaf("dcc:role", text_or_not_given(role));
      xml_.leaf("dcc:mainSigner", signs ? "true" : "false");
    });
  }

  [[nodiscard]] Texts authorised() const {
    const Authorisation& by = *report_.authorised;
    return join_texts(texts_for("label.authorised"), ": ",
                      same_text(fmt::format("{}, {}", text_or_not_given(by.name), text_or_not_given(by.utc))));
  }

  /// Writes the persons, first the authorising one or a note that the report is not authorised.
  void persons() {
    const bool draft = is_draft(report_);
    const std::string signer = draft ? "" : report_.authorised->name;
    std::string email;
    for (const Person& one : report_.people)
      if (one.name == signer && !one.email.empty()) email = one.email;
    person(draft ? texts_for("say.not_authorised") : same_text(text_or_not_given(signer)), email, "authorising",
           draft ? Texts{} : authorised(), true);
    for (const Person& one : report_.people)
      if (draft || one.role != "authorising")
        person(same_text(text_or_not_given(one.name)), one.email, one.role, {}, false);
  }

  void statement(const Texts& name, const char* ref_type, const Texts& declaration,
                 const std::function<void()>& after = {}) {
    xml_.element("dcc:statement", {{"refType", ref_type}}, [&] {
      dcc_.text("dcc:name", name);
      if (!declaration.empty()) dcc_.text("dcc:declaration", declaration);
      if (after) after();
    });
  }

  void statements() {
    state_statement();
    statement({"Scope of the results", "Geltungsbereich der Ergebnisse"}, "gyrotherm_scope",
              join_texts(join_texts(texts_for(scope_key(report_)), " ", texts_for("say.standing")), " ",
                         texts_for("say.in_full")));
    cautions();
    traceability();
    xml_.element("dcc:statement", {{"refType", "gyrotherm_norm"}}, [&] {
      dcc_.text("dcc:name", {"Content of the report", "Inhalt des Berichts"});
      xml_.leaf("dcc:norm", "ISO/IEC 17025:2017, 7.8.2 and 7.8.4");
      dcc_.text("dcc:declaration", {"The report contains the information required by the standard. This is not a "
                                    "statement that the laboratory is accredited.",
                                    "Der Bericht enthält die von der Norm verlangten Angaben. Dies ist keine Aussage "
                                    "über eine Akkreditierung des Laboratoriums."});
    });
    conformity();
    if (report_.replaces) revision();
    if (!report_.place.empty()) statement(texts_for("label.place"), "gyrotherm_place", report_.place);
    if (!report_.remarks.empty()) statement({"Remarks", "Bemerkungen"}, "gyrotherm_remarks", report_.remarks);
    for (const Texts& further : report_.statements)
      if (!further.empty()) statement({"Statement", "Erklärung"}, "gyrotherm_statement", further);
  }

  void write_invalid_state(const char* mark, const Texts& declaration) {
    statement(texts_for(mark), "gyrotherm_state", declaration, [&] { xml_.leaf("dcc:valid", "false"); });
  }

  /// Writes the state of the report: valid, draft, simulated or superseded.
  void state_statement() {
    if (is_draft(report_))
      write_invalid_state(
          "mark.draft",
          report_.missing.empty()
              ? texts_for("say.draft")
              : Texts{sentence(Language::english, "say.missing", translate_missing(Language::english, report_.missing)),
                      sentence(Language::german, "say.missing", translate_missing(Language::german, report_.missing))});
    if (report_.simulated) write_invalid_state("mark.simulated", texts_for("say.simulated"));
    if (report_.state == ReportState::superseded) write_invalid_state("mark.superseded", replacement());
    if (is_draft(report_) || report_.simulated || report_.state == ReportState::superseded) return;
    statement(report_.title.empty() ? texts_for("title.report") : report_.title, "gyrotherm_state", authorised(),
              [&] { xml_.leaf("dcc:valid", "true"); });
  }

  /// Returns the text about the report that replaces this one, with the reason.
  [[nodiscard]] Texts replacement() const {
    if (!report_.replaced_by) return texts_for("say.superseded_plainly");
    const OtherReport& by = *report_.replaced_by;
    const Texts text = texts_for("say.superseded", text_or_not_given(by.number));
    return by.reason.empty() ? text : join_texts(text, " ", by.reason);
  }

  /// Writes the cautions about the records, and about the results of each model: one statement per axis, stage and
  /// record.
  void cautions() {
    const auto english = list_record_cautions(Language::english, report_);
    const auto german = list_record_cautions(Language::german, report_);
    for (std::size_t i = 0; i < english.size(); ++i)
      statement(texts_for("label.record_caution"), "gyrotherm_caution",
                join_texts(same_text(text_or_not_given(english[i].run)), ": ", Texts{english[i].text, german[i].text}));
    for (const ModelVerification& one : report_.verifications) {
      const Texts text{describe_cautions(Language::english, one), describe_cautions(Language::german, one)};
      if (text.empty()) continue;
      Texts of = texts_for(name(one.stage));
      if (!one.axis.empty()) of = join_texts(same_text(text_or_not_given(one.axis)), ", ", of);
      of = join_texts(of, ", ", same_text(text_or_not_given(one.run)));
      statement(texts_for("label.caution"), "gyrotherm_caution", join_texts(of, ": ", text));
    }
  }

  /// Writes the traceability statement. Simulations, drafts and results of uncertified or overdue
  /// thermometers are not traceable.
  void traceability() {
    const bool stated = !report_.traceability.empty() && !is_draft(report_) && !report_.simulated &&
                        find_uncertified_thermometers(report_).empty() && !has_overdue_thermometer(report_);
    xml_.element("dcc:statement", {{"refType", "basic_metrologicallyTraceableToSI"}}, [&] {
      dcc_.text("dcc:name", {"Metrological traceability", "Metrologische Rückführung"});
      xml_.leaf("dcc:traceable", stated ? "true" : "false");
      dcc_.text("dcc:declaration", report_.traceability.empty() ? texts_for("label.not_given") : report_.traceability);
    });
  }

  void conformity() {
    const auto verdict = overall_verdict(report_);
    const Texts rule = texts_for(report_.rule == DecisionRule::simple ? "say.rule_simple" : "say.rule_guard_band");
    statement(texts_for("heading.conformity"), "basic_conformity",
              verdict ? join_texts(texts_for(name(*verdict)), ". ", rule) : texts_for("say.no_limits"), [&] {
                if (verdict && *dcc_verdict(*verdict) != '\0') xml_.leaf("dcc:conformity", dcc_verdict(*verdict));
              });
  }

  void revision() {
    const Texts replaced =
        join_texts(texts_for("label.replaces"), ": ", same_text(text_or_not_given(report_.replaces->number)));
    statement({"Revision", "Änderung"}, "basic_revision",
              report_.replaces->reason.empty() ? replaced : join_texts(replaced, ". ", report_.replaces->reason));
  }

  void document(const ReadableReport& pdf) {
    xml_.element("dcc:document", [&] {
      dcc_.text("dcc:name", {"Human-readable report", "Bericht in lesbarer Form"});
      xml_.leaf("dcc:fileName", text_or_not_given(pdf.name));
      xml_.leaf("dcc:mimeType", "application/pdf");
      xml_.leaf("dcc:dataBase64", plot::base64(pdf.bytes));
    });
  }

  const CalibrationReport& report_;
  const DccOptions& options_;
  DccText dcc_;
  XmlText& xml_;
};

}  // namespace

Result<std::string> make_dcc(const CalibrationReport& report, const DccOptions& options) {
  const auto names = missing_data(report);
  if (!is_draft(report) && !names.empty())
    return failure(FaultKind::bad_file, kCalibrationFile,
                   fmt::format("missing data, required unless the report is a draft: {}", fmt::join(names, ", ")));
  return Certificate(report, options).write();
}

}  // namespace gyrotherm::report
