// SPDX-License-Identifier: Apache-2.0
/// A rig whose thermometer has a certificate file, from its check to the record, its resume and the signed report.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "acquisition/record/record.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"
#include "report/calibration.hpp"
#include "tests/apps/gyrotherm/program.hpp"
#include "tests/apps/gyrotherm/small_record.hpp"
#include "tests/support/foreign_dcc.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kShortProfile = R"(schema = "gyrotherm-profile/1"
name = "short"

[[segment]]
kind = "hold"
at = "20 °C"
time = "30 s"
)";

class CertificateFiles : public testing::Test {
 protected:
  static void SetUpTestSuite() { keys_ = new report::ForeignKeys; }
  static void TearDownTestSuite() { delete keys_; }

  void SetUp() override {
    write("laboratories.pem", *read_text_file(*keys_ / "authority.pem"));
    write("t1.dcc.xml", keys_->sign(report::foreign_dcc()));
    write("short.toml", kShortProfile);
    write_rig("");
  }

  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }
  /// Writes the shipped virtual rig, whose thermometer "shell" has the certificate file, and more keys for it.
  void write_rig(const std::string& more) const {
    std::string text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml").value();
    const auto from = text.find("offsets = [0]\n"), to = text.find("[gyro]\n");
    ASSERT_LT(from, to);
    text.replace(from, to - from,
                 "certificate = \"t1.dcc.xml\"\nserial_number = \"T-0417\"\n" + more +
                     "\n[certificates]\ntrusted = \"laboratories.pem\"\n\n");
    for (auto at = text.find("\"../"); at != std::string::npos; at = text.find("\"../"))
      text.replace(at, 4, "\"" GYROTHERM_SOURCE_DIR "/profiles/");
    write("rig.toml", text);
  }
  [[nodiscard]] Ran check(const std::string& options = "") const {
    return gyrotherm_with("check --rig " + (folder_ / "rig.toml") + options);
  }
  /// Returns the options that authorise a report written by a test, which has no sources.
  [[nodiscard]] std::string without_sources() const {
    write("laboratory.toml",
          "schema = \"gyrotherm-laboratory/1\"\nname = \"House of Gyros\"\n[[person]]\nname = \"B. Berg\"\n"
          "role = \"authorising\"\n");
    return " --without-sources --laboratory " + (folder_ / "laboratory.toml");
  }
  [[nodiscard]] std::string digest() const { return sha256(*read_text_file(folder_ / "t1.dcc.xml", kLargestTable)); }

  static inline report::ForeignKeys* keys_ = nullptr;
  Folder folder_{};
};

TEST_F(CertificateFiles, CheckShowsContents) {
  const auto ran = check();
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.out.find("certificate THERMO-2025-0417, due 2026-11-04"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("shell: t1.dcc.xml of Thermo Lab, signed by CN=laboratory,O=Thermo Lab: U = 0.021 K (k = 2), "
                         "-39.98 to 59.98 °C, SHA-256 " +
                         digest()),
            std::string::npos)
      << ran.out;
  const auto found = nlohmann::json::parse(check(" --json").out)["rig"]["certificates"]["shell"];
  EXPECT_EQ(found["number"], "THERMO-2025-0417");
  EXPECT_EQ(found["sha256"], digest());
  EXPECT_EQ(found["due"], "2026-11-04");
  EXPECT_EQ(found["coverage_factor"], 2);
}

TEST_F(CertificateFiles, CheckRefusesEachFaultWithPosition) {
  const auto refused = [&](const std::string& where, const std::string& cause) {
    const auto ran = check();
    EXPECT_EQ(ran.exit_code, 4) << cause;
    EXPECT_NE(ran.err.find(where), std::string::npos) << ran.err;
    EXPECT_NE(ran.err.find(cause), std::string::npos) << ran.err;
  };
  const std::string dcc = keys_->sign(report::foreign_dcc());
  write("t1.dcc.xml", report::with_replaced(dcc, "20 10 0 -10 -20", "20 10 0 -10 -10"));
  refused("t1.dcc.xml:", "the file was changed after it was signed");
  write("t1.dcc.xml", report::foreign_dcc());
  refused("t1.dcc.xml:2", "is not signed");
  write("t1.dcc.xml", keys_->sign(report::foreign_dcc(), "stranger"));
  refused("t1.dcc.xml:", "the signer is not trusted");
  write("t1.dcc.xml", dcc);
  write_rig("uncertainty = 0.04\n");
  refused("rig.toml:", "contradicts the certificate file");
  write_rig("due = \"2027-01-01\"\n");
  refused("rig.toml:", "is due 2026-11-04");
  std::filesystem::remove(folder_ / "t1.dcc.xml");
  write_rig("");
  refused("t1.dcc.xml", "");
}

TEST_F(CertificateFiles, AreKeptInRecord) {
  const auto ran = gyrotherm_with("run " + (folder_ / "short.toml") + " --rig " + (folder_ / "rig.toml") + " --out " +
                                  (folder_ / "run.db"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const auto info = record::read_info(folder_ / "run.db");
  ASSERT_TRUE(info) << text(info.error());
  const auto& shell = info->thermometers.back();
  EXPECT_EQ(shell.certificate, "THERMO-2025-0417");
  EXPECT_EQ(shell.due, record::parse_day("2026-11-04"));
  EXPECT_EQ(shell.uncertainty.calibrated, record::parse_day("2025-11-04"));
  ASSERT_TRUE(shell.certificate_file);
  EXPECT_EQ(shell.certificate_file->sha256, digest());
  EXPECT_EQ(shell.certificate_file->issuer, "Thermo Lab");
}

/// Returns a draft that names the certificate file of a thermometer.
report::CalibrationReport report_with_certificate(const std::string& digest) {
  report::CalibrationReport report;
  report.number = "C-2";
  report.state = report::ReportState::draft;
  report.laboratory = {.name = "House of Gyros", .city = "Berlin", .country = "DE"};
  report.customer.name = "Harbour Pilots";
  report.people = {{"B. Berg", "authorising", ""}};
  report.item.serial_number = "0042";
  report.begun = report.ended = "2020-11-20";
  report.issued = civil_time(SteadyClock().now().utc).substr(0, 10);
  report.cluster_length_s = 100;
  report.results = {{.group = report::Group::bias,
                     .key = "stabilised_bias",
                     .columns = {{"bias", "°/h", {report::value_with_uncertainty(0.1, 0.01, 30)}}}}};
  report.equipment = {{.role = "thermometer",
                       .channel = "shell",
                       .name = "bridge",
                       .certificate = "THERMO-2025-0417",
                       .certificate_sha256 = digest}};
  report.files = {{.role = "certificate_file", .name = "t1.dcc.xml", .sha256 = digest}};
  return report;
}

/// The chain from the signed report to the certificate of its thermometer.
TEST_F(CertificateFiles, AreVerifiedWithReport) {
  std::filesystem::create_directory(folder_ / "report");
  write("report/calibration.json", to_json(report_with_certificate(digest())));
  const std::string report = folder_ / "report";
  const auto authorised = gyrotherm_with("report authorise " + report + " --by 'B. Berg'" + without_sources());
  ASSERT_EQ(authorised.exit_code, 0) << authorised.err;
  const auto done = gyrotherm_with("report sign " + report + " --key " + (*keys_ / "laboratory.key") +
                                   " --certificate " + (*keys_ / "laboratory.pem"));
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const std::string dcc = *read_text_file(folder_ / "report/dcc.xml", kLargestTable);
  EXPECT_NE(dcc.find("<dcc:procedure>SHA-256</dcc:procedure>"), std::string::npos);
  EXPECT_NE(dcc.find("<dcc:value>" + digest() + "</dcc:value>"), std::string::npos);
  const auto verify = [&](const std::string& options = "") {
    return gyrotherm_with("report verify " + report + " --trusted " + (*keys_ / "authority.pem") + options);
  };
  const auto expect = [](const Ran& ran, int exit_code, const std::string& line) {
    EXPECT_EQ(ran.exit_code, exit_code) << ran.err;
    EXPECT_NE(ran.out.find(line), std::string::npos) << ran.out;
  };
  const std::string trusted = " --trusted-issuers " + (folder_ / "laboratories.pem");
  expect(verify(), 0, "holds      t1.dcc.xml: is the certificate that the report names, signed by CN=laboratory");
  expect(verify(), 0, "whether to trust this signer was not checked");
  EXPECT_EQ(verify(trusted).out.find("was not checked"), std::string::npos);
  expect(verify(" --trusted-issuers " + (*keys_ / "other-authority.pem")), 4, "the signer is not trusted");
  const std::string bytes = *read_text_file(folder_ / "t1.dcc.xml", kLargestTable);
  std::filesystem::create_directory(folder_ / "certificates");
  std::filesystem::rename(folder_ / "t1.dcc.xml", folder_ / "certificates/t1.dcc.xml");
  expect(verify(), 0, "not there  t1.dcc.xml");
  expect(verify(" --certificates " + (folder_ / "certificates") + trusted), 0, "holds      t1.dcc.xml");
  write("t1.dcc.xml", bytes + "\n");
  expect(verify(), 4, "FAILS      t1.dcc.xml: is not the certificate that the report names");
  std::filesystem::copy_file(folder_ / "certificates/t1.dcc.xml", folder_ / "report/t1.dcc.xml");
  expect(verify(), 0, "holds      t1.dcc.xml");
}

/// A report may state the digest of a record's file or of its exported rows. Early builds exported rows without the
/// thermometers of the units.
TEST_F(CertificateFiles, AreVerifiedBesideRecordOfAnyBuild) {
  write("record.csv", small_rows(300));
  write("map.toml", small_map());
  const std::string record = folder_ / "record.db", table = folder_ / "table.csv";
  ASSERT_EQ(
      gyrotherm_with("import " + (folder_ / "record.csv") + " --map " + (folder_ / "map.toml") + " --out " + record)
          .exit_code,
      0);
  ASSERT_EQ(gyrotherm_with("export " + record + " --out " + table).exit_code, 0);
  const std::string rows = *read_text_file(table, kLargestTable), list = "# unit gyro: gradients A, B\n";
  ASSERT_NE(rows.find(list), std::string::npos) << rows.substr(0, 500);
  const auto authorise = [&](const std::string& sha256_of_record, int round) {
    const auto report = fmt::format("{}-{}", folder_ / "report", round);
    std::filesystem::create_directory(report);
    auto with_record = report_with_certificate(digest());
    with_record.item.name = "gyro";
    with_record.files.push_back({.role = "record", .name = "record.db", .sha256 = sha256_of_record});
    std::ofstream(report + "/calibration.json") << to_json(with_record);
    return gyrotherm_with("report authorise " + report + " --by 'B. Berg'" + without_sources());
  };
  int round = 0;
  for (const std::string& bytes :
       {*read_text_file(record, kLargestTable), rows, report::with_replaced(rows, list, "")}) {
    const auto ran = authorise(sha256(bytes), round++);
    EXPECT_EQ(ran.exit_code, 0) << round << ran.err;
  }
  const auto other = authorise(sha256(report::with_replaced(rows, list, "# unit gyro: gradients B, A\n")), round);
  EXPECT_NE(other.exit_code, 0);
  EXPECT_NE(other.err.find("record.db: is not the file on which the report is based"), std::string::npos) << other.err;
}

/// A file with the digest of the report, whose own signature is not valid.
TEST_F(CertificateFiles, FailWithReportIfTheirSignatureIsNotValid) {
  write("t1.dcc.xml", report::with_replaced(keys_->sign(report::foreign_dcc()), "THERMO-2025", "THERMO-2026"));
  std::filesystem::create_directory(folder_ / "report");
  write("report/calibration.json", to_json(report_with_certificate(digest())));
  const std::string report = folder_ / "report";
  ASSERT_EQ(gyrotherm_with("report authorise " + report + " --by 'B. Berg'" + without_sources()).exit_code, 0);
  ASSERT_EQ(gyrotherm_with("report sign " + report + " --key " + (*keys_ / "laboratory.key") + " --certificate " +
                           (*keys_ / "laboratory.pem"))
                .exit_code,
            0);
  const auto ran = gyrotherm_with("report verify " + report + " --trusted " + (*keys_ / "authority.pem"));
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.out.find("FAILS      t1.dcc.xml"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("its signature is not valid"), std::string::npos) << ran.out;
}

}  // namespace
}  // namespace gyrotherm::app
