// SPDX-License-Identifier: Apache-2.0
#include "report/dcc.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/file.hpp"
#include "core/sha256.hpp"
#include "report/dsi.hpp"
#include "report/other_program.hpp"
#include "tests/report/varied_calibrations.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/markup.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

#ifdef GYROTHERM_NIGHTLY
constexpr std::uint64_t kRandomReports = 500;
#else
constexpr std::uint64_t kRandomReports = 50;
#endif

std::string dcc(const CalibrationReport& report, const DccOptions& options = {}) {
  const auto made = make_dcc(report, options);
  EXPECT_TRUE(made) << text(made.error());
  return made.value_or("");
}

CalibrationReport real_report() {
  CalibrationReport report = sample_calibration();
  report.simulated = false;
  return report;
}

/// Files with the certificates of the varied reports and of random ones.
class Certificates : public testing::Test {
 protected:
  void SetUp() override {
    for (const VariedReport& one : varied_calibrations()) write_certificate(one.name, dcc(one.report, one.options));
    for (std::uint64_t seed = 0; seed < kRandomReports; ++seed) {
      CalibrationReport report = random_calibration(seed);
      if (!make_dcc(report)) report.state = ReportState::draft;
      write_certificate(fmt::format("random {}", seed), dcc(report));
    }
  }

  void expect_all_accepted(const std::string& program, std::vector<std::string> words) const {
    words.insert(words.end(), paths_.begin(), paths_.end());
    const auto run = run_program(program, words, std::chrono::minutes(10));
    ASSERT_TRUE(run) << text(run.error());
    EXPECT_EQ(run->exit_code, 0) << run->out.substr(0, 4000);
  }

  tests::TestFolder folder_;
  std::vector<std::string> paths_;

 private:
  void write_certificate(const std::string& name, const std::string& bytes) {
    paths_.push_back(folder_ / (name + ".xml"));
    ASSERT_TRUE(replace_text_file(paths_.back(), bytes));
  }
};

TEST_F(Certificates, AreValidBySchema) {
  const char* shared = std::getenv("GYROTHERM_SHARED");
  if (shared == nullptr) GTEST_SKIP() << "GYROTHERM_SHARED is not set: PTB's schema is not at hand";
  const std::string schema = std::string(shared) + "/dcc/v3.3.0/dcc/dcc.xsd";
  expect_all_accepted("xmllint", {"--nonet", "--noout", "--schema", schema});
}

TEST_F(Certificates, ObeyRulesOutsideSchema) {
  expect_all_accepted(GYROTHERM_SOURCE_DIR "/tests/report/dcc_rules.py", {});
}

TEST_F(Certificates, ReadBackToEqualBytes) {
  EXPECT_GT(paths_.size(), kRandomReports);
  for (const std::string& path : paths_) {
    const auto read = read_dcc(*read_text_file(path), path);
    EXPECT_TRUE(read) << text(read.error());
  }
}

TEST(Dcc, GivesEqualBytesEachTime) { EXPECT_EQ(dcc(sample_calibration()), dcc(sample_calibration())); }

TEST(Dcc, HasEveryResultWithItsUncertainty) {
  const CalibrationReport report = real_report();
  const std::string xml = dcc(report);
  for (const ResultTable& table : report.results)
    for (const Column& column : table.columns)
      for (const ReportedValue& value : column.values) {
        EXPECT_NE(xml.find(dsi_value(value)), std::string::npos) << table.key << " " << column.quantity;
        if (classify_certainty(value) >= Certainty::with_normal_u) {
          EXPECT_NE(xml.find(dsi_expanded(value)), std::string::npos) << table.key << " " << column.quantity;
        }
      }
  EXPECT_EQ(tests::count_occurrences(xml, "<dcc:measurementResult "), 2);
  EXPECT_EQ(tests::count_occurrences(xml, "basic_conformity\">"), 5);
  EXPECT_EQ(tests::count_occurrences(xml, "refType=\"basic_conformity\">\n          <dcc:name>"), 4);
}

TEST(Dcc, SplitsRowsWithUnknownValuesIntoSeparateLists) {
  CalibrationReport report = real_report();
  report.results.resize(1);
  report.results[0].columns = {
      {"set_point", "°C", {{.value = 20}, {.value = -40}, {.value = 60}}},
      {"bias", "°/h", {value_with_uncertainty(1, 0.1, 1e9), {}, value_with_uncertainty(3, 0.1, 1e9)}}};
  report.budgets.clear();
  report.compared.clear();
  const std::string xml = dcc(report);
  EXPECT_NE(xml.find(">20 60<"), std::string::npos);
  EXPECT_NE(xml.find(">-40<"), std::string::npos);
  EXPECT_NE(xml.find("not known: Bias"), std::string::npos);
  EXPECT_EQ(xml.find("NaN"), std::string::npos);
}

TEST(Dcc, NamesRecommendedModelOnlyIfOneExists) {
  CalibrationReport report = sample_calibration();
  EXPECT_EQ(tests::count_occurrences(dcc(report), "recommends no model"), 0);
  for (ComparedModel& model : report.compared) model.recommended = false;
  EXPECT_EQ(tests::count_occurrences(dcc(report), "recommends no model"), 2) << "one statement per axis";
}

TEST(Dcc, HasUnitPerSourceOfUncertainty) {
  const std::string xml = dcc(real_report());
  EXPECT_NE(xml.find(" \\kelvin \\degree</si:unitXMLList>"), std::string::npos);
  EXPECT_NE(xml.find(" \\degree\\hour\\tothe{-1}\\kelvin\\tothe{-1} "), std::string::npos);
}

/// The unit of an analogue input and of an imported column is free text.
TEST(Dcc, WritesSourcesInUnknownUnitsAsText) {
  CalibrationReport report = real_report();
  ASSERT_FALSE(report.budgets.empty());
  auto& rows = report.budgets.front().budget.rows;
  for (const char* unit : {"mW", "µA", "counts", "1", "m/s", "furlong/s"})
    rows.push_back({.source = model::Source::input_drift,
                    .of = unit,
                    .unit = unit,
                    .standard_uncertainty = 0.25,
                    .sensitivity = 0.5});
  const std::string xml = dcc(report);
  for (const char* part : {"0.25_mW", "0.25_µA", "0.25_counts", "0.25_1", "0.25_m/s", "0.5_°/h/mW", "0.5_°/h/counts",
                           "0.5_°/h 0.5_°/h/(m/s) 0.5_°/h/(furlong/s)"})
    EXPECT_NE(xml.find(part), std::string::npos) << part;
  rows.erase(rows.end() - 1);
  rows.erase(rows.end() - 5, rows.end() - 2);
  const std::string in_si = dcc(report);
  EXPECT_EQ(in_si.find("0.25_"), std::string::npos) << "all units are known to D-SI";
  EXPECT_NE(in_si.find(" \\degree\\per\\hour \\degree\\second\\hour\\tothe{-1}\\metre\\tothe{-1}<"), std::string::npos);
}

TEST(Dcc, NamesOnlyAuthorisingPersonWhoAuthorised) {
  CalibrationReport report = real_report();
  report.people.push_back({"Z. Second", "authorising", "z@lab.de"});
  report.people.push_back({report.authorised->name, "reviewer", ""});
  const std::string xml = dcc(report);
  EXPECT_EQ(xml.find("Z. Second"), std::string::npos);
  EXPECT_NE(xml.find(">reviewer<"), std::string::npos);
  EXPECT_EQ(tests::count_occurrences(xml, "<dcc:role>authorising</dcc:role>"), 1);
  report.state = ReportState::draft;
  report.authorised.reset();
  EXPECT_NE(dcc(report).find("Z. Second"), std::string::npos) << "a draft lists all who may authorise";
}

TEST(Dcc, HasDeviationsInBothLanguages) {
  CalibrationReport report = sample_calibration();
  report.deviations = {{.utc = "2026-11-12T08:00:00Z", .run = "7", .kind = "held", .text = "held: paused by ada"},
                       {.kind = "stated",
                        .text = "Door opened for two minutes.",
                        .translations = {"Door opened for two minutes.", "Tür zwei Minuten geöffnet."}}};
  const std::string text = dcc(report);
  for (const char* part :
       {"<dcc:content lang=\"en\">2026-11-12T08:00:00Z: record 7: held: paused by ada<",
        "<dcc:content lang=\"de\">2026-11-12T08:00:00Z: Aufzeichnung 7: gehalten: angehalten von ada<",
        "<dcc:content lang=\"en\">Door opened for two minutes.<",
        "<dcc:content lang=\"de\">Tür zwei Minuten geöffnet.<", "; Kette geprüft<", "; chain verified<"})
    EXPECT_NE(text.find(part), std::string::npos) << part;
}

TEST(Dcc, MarksDraft) {
  const std::string xml = dcc({});
  EXPECT_NE(xml.find("<dcc:uniqueIdentifier>not given (draft)</dcc:uniqueIdentifier>"), std::string::npos);
  EXPECT_NE(xml.find("DRAFT"), std::string::npos);
  EXPECT_NE(xml.find("<dcc:valid>false</dcc:valid>"), std::string::npos);
  EXPECT_NE(xml.find("Not authorised."), std::string::npos);
  EXPECT_EQ(xml.find("<dcc:valid>true"), std::string::npos);
}

TEST(Dcc, MarksSimulation) {
  const std::string xml = dcc(sample_calibration());
  EXPECT_NE(xml.find("<dcc:uniqueIdentifier>C-2026-0042 (simulated)</dcc:uniqueIdentifier>"), std::string::npos);
  EXPECT_NE(xml.find("This report contains no measured values"), std::string::npos);
  EXPECT_NE(xml.find("<dcc:traceable>false</dcc:traceable>"), std::string::npos);
}

TEST(Dcc, IsTraceableOnlyWithCertificateOfThermometer) {
  const auto is_traceable = [](const CalibrationReport& report) {
    return dcc(report).find("<dcc:traceable>true</dcc:traceable>") != std::string::npos;
  };
  CalibrationReport report = real_report();
  EXPECT_TRUE(is_traceable(report));
  report.equipment.front().certificate.clear();
  report.equipment.push_back({.role = "reference", .name = "Granite table", .certificate = "L-17"});
  EXPECT_FALSE(is_traceable(report));
  report.equipment.push_back({.role = "thermometer", .name = "logger", .certificate_sha256 = std::string(64, 'e')});
  EXPECT_TRUE(is_traceable(report));
}

TEST(Dcc, RefusesIncompleteReportThatIsNotDraft) {
  for (const auto& take :
       std::vector<void (*)(CalibrationReport&)>{[](CalibrationReport& report) { report.number = " "; },
                                                 [](CalibrationReport& report) { report.laboratory.country = "de"; },
                                                 [](CalibrationReport& report) { report.ended = "2026-02-30"; },
                                                 [](CalibrationReport& report) { report.customer.name.clear(); },
                                                 [](CalibrationReport& report) { report.results.clear(); }}) {
    CalibrationReport report = real_report();
    take(report);
    const auto made = make_dcc(report);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().kind, FaultKind::bad_file);
    report.state = ReportState::draft;
    EXPECT_TRUE(make_dcc(report));
  }
}

TEST(Dcc, ContainsHashOfReport) {
  const auto read = read_dcc(dcc(sample_calibration()), "dcc.xml");
  ASSERT_TRUE(read);
  ASSERT_EQ(read->files.size(), 1u);
  EXPECT_EQ(read->files[0].name, "calibration.json");
  EXPECT_EQ(read->files[0].sha256, sha256(to_json(sample_calibration())));
}

TEST(Dcc, OmitsPdfTooLargeForXmlReaders) {
  DccOptions options{.pdf = ReadableReport{"report.pdf", std::string(kLargestEmbeddedPdf + 1, 'x')}};
  EXPECT_EQ(dcc(sample_calibration(), options).find("<dcc:document>"), std::string::npos);
  options.pdf->bytes.resize(1000);
  EXPECT_NE(dcc(sample_calibration(), options).find("<dcc:document>"), std::string::npos);
}

/// XML with the same meaning but other bytes is refused.
TEST(DccReader, RefusesEquivalentXmlInOtherForm) {
  const std::string xml = dcc(sample_calibration());
  const auto with = [&](const std::string& what, const std::string& instead) {
    std::string other = xml;
    other.replace(other.find(what), what.size(), instead);
    return read_dcc(other, "dcc.xml").has_value();
  };
  EXPECT_TRUE(with("<dcc:city>", "<dcc:city>"));
  EXPECT_FALSE(with("<dcc:city>", "<dcc:city >"));
  EXPECT_FALSE(with("<dcc:city>", "<dcc:city><!-- -->"));
  EXPECT_FALSE(with("<dcc:city>", "<dcc:city><?x?>"));
  EXPECT_FALSE(with("<dcc:city>Berlin", "<dcc:city><![CDATA[Berlin]]>"));
  EXPECT_FALSE(with("<dcc:city>Berlin", "<dcc:city>&#66;erlin"));
  EXPECT_FALSE(with("lang=\"en\"", "lang='en'"));
  EXPECT_FALSE(with("UTF-8", "utf-8"));
  EXPECT_FALSE(with("1.0\" enc", "1.1\" enc"));
  EXPECT_FALSE(with("?>\n", "?>\n<!DOCTYPE x [<!ENTITY a \"b\">]>\n"));
  EXPECT_FALSE(with("</dcc:digitalCalibrationCertificate>\n", "</dcc:digitalCalibrationCertificate>\n\n"));
  EXPECT_FALSE(with("</dcc:digitalCalibrationCertificate>\n", ""));
}

}  // namespace
}  // namespace gyrotherm::report
