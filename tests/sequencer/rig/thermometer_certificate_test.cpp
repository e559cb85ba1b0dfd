// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/thermometer_certificate.hpp"

#include <gtest/gtest.h>

#include "core/file.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::rig {
namespace {

const std::string kShellRigFolder = GYROTHERM_SOURCE_DIR "/profiles/rigs/";

/// Returns the shipped virtual rig with these keys in the thermometer "shell", and these in its calibration.
std::string shell_rig_with(const std::string& keys, const std::string& calibration = "",
                           const std::string& root = "[certificates]\ntrusted = \"laboratories.pem\"\n") {
  std::string text = read_text_file(kShellRigFolder + "virtual.toml").value();
  const auto from = text.find("offsets = [0]\n"), to = text.find("[gyro]\n");
  EXPECT_LT(from, to);
  if (from >= to) return text;
  const std::string table =
      calibration.empty() ? "" : "[[thermometer.calibration]]\nchannel = \"shell\"\n" + calibration;
  return text.replace(from, to - from, keys + table + root);
}

record::CertificateFile t1_file() {
  return {.name = "t1.xml",
          .sha256 = std::string(64, 'a'),
          .issuer = "Thermo Lab",
          .signer = "CN=Seal",
          .expanded = {0.02},
          .coverage_factor = 2,
          .lowest = {-40},
          .highest = {60}};
}

CertificateValues t1_values() {
  return {.number = "T1-2025",
          .offset = {-0.012},
          .standard_uncertainty = {0.011},
          .calibrated = record::parse_day("2025-11-04").value(),
          .due = record::parse_day("2026-11-04"),
          .file = t1_file()};
}

/// Reads a rig whose certificate files all have the values of `values`. Keeps the requests.
struct Reading {
  CertificateValues values = t1_values();
  std::vector<CertificateRequest> requests{};
  NamedTexts known{};
  std::chrono::sys_days today{};

  Result<RigFile> read(const std::string& text) {
    const auto reader = [this](const CertificateRequest& request) -> Result<CertificateValues> {
      requests.push_back(request);
      return values;
    };
    return parse_rig(text, kShellRigFolder + "virtual.toml", known, {.read = reader, .today = today});
  }
  std::string cause(const std::string& text) {
    const auto rig = read(text);
    if (rig) return {};
    EXPECT_EQ(rig.error().kind, FaultKind::bad_file);
    EXPECT_NE(rig.error().where.find("virtual.toml:"), std::string::npos) << rig.error().where;
    return rig.error().what;
  }
};

record::Channel channel_named(const RigFile& rig, const std::string& name) {
  for (const auto& channel : list_channels(rig))
    if (channel.name == name) return channel;
  ADD_FAILURE() << name;
  return {};
}

TEST(ThermometerCertificate, FillsCalibrationOfChannel) {
  Reading reading;
  const auto rig =
      reading.read(shell_rig_with("", "certificate = \"certificates/t1.xml\"\nserial_number = \"T-0417\"\n"));
  ASSERT_TRUE(rig) << text(rig.error());
  const auto shell = channel_named(*rig, "shell");
  EXPECT_EQ(shell.certificate, "T1-2025");
  EXPECT_EQ(shell.offset, Kelvins{-0.012});
  EXPECT_EQ(shell.uncertainty.calibration, Kelvins{0.011});
  EXPECT_EQ(shell.uncertainty.calibrated, record::parse_day("2025-11-04"));
  EXPECT_EQ(shell.due, record::parse_day("2026-11-04"));
  EXPECT_EQ(shell.certificate_file, t1_file());
  EXPECT_FALSE(channel_named(*rig, "A").certificate_file);
  ASSERT_EQ(reading.requests.size(), 1u);
  EXPECT_EQ(reading.requests[0].path, kShellRigFolder + "certificates/t1.xml");
  EXPECT_EQ(reading.requests[0].trusted, kShellRigFolder + "laboratories.pem");
  EXPECT_EQ(reading.requests[0].serial_number, "T-0417");
}

TEST(ThermometerCertificate, OfThermometerFillsItsChannelsAndKeepsDrift) {
  Reading reading;
  const auto rig = reading.read(shell_rig_with("certificate = \"t1.xml\"\ndrift_k_per_year = 0.03\n"));
  ASSERT_TRUE(rig) << text(rig.error());
  const auto shell = channel_named(*rig, "shell");
  EXPECT_EQ(shell.certificate, "T1-2025");
  EXPECT_EQ(shell.uncertainty.drift_in_a_year, Kelvins{0.03});
}

TEST(ThermometerCertificate, KeepsTextThatIsNotFile) {
  Reading reading;
  const auto rig = reading.read(shell_rig_with("certificate = \"t1.xml (paper)\"\noffsets = [0.5]\n", "", ""));
  ASSERT_TRUE(rig) << text(rig.error());
  EXPECT_EQ(channel_named(*rig, "shell").certificate, "t1.xml (paper)");
  EXPECT_EQ(channel_named(*rig, "shell").offset, Kelvins{0.5});
  EXPECT_TRUE(reading.requests.empty());
}

TEST(ThermometerCertificate, RefusesKeysThatStateItsValues) {
  for (const std::string key : {"offset = 0.1", "polynomial = [0, 1]", "uncertainty = 0.02",
                                "calibrated = \"2025-01-01\"", "coverage_factor = 2", "distribution = \"normal\""}) {
    Reading reading;
    const auto cause = reading.cause(shell_rig_with("", "certificate = \"t1.xml\"\n" + key + "\n"));
    EXPECT_NE(cause.find("contradicts the certificate file"), std::string::npos) << key << ": " << cause;
    EXPECT_TRUE(reading.requests.empty()) << "a wrong rig file reads no certificate";
  }
  EXPECT_NE(Reading().cause(shell_rig_with("certificate = \"t1.xml\"\noffsets = [0.1]\n")).find("contradicts"),
            std::string::npos);
  EXPECT_NE(Reading().cause(shell_rig_with("certificate = \"t1.xml\"\n", "uncertainty = 0.1\n")).find("contradicts"),
            std::string::npos);
}

TEST(ThermometerCertificate, RefusesSerialNumberWithoutFile) {
  EXPECT_NE(Reading().cause(shell_rig_with("certificate = \"K-1\"\nserial_number = \"T\"\n")).find("is not one (.xml)"),
            std::string::npos);
  EXPECT_NE(Reading().cause(shell_rig_with("serial_number = \"T\"\n")).find("is not one (.xml)"), std::string::npos);
}

TEST(ThermometerCertificate, KeepsEarlierDueDayOfRig) {
  Reading reading;
  const auto rig = reading.read(shell_rig_with("due = \"2026-05-01\"\n", "certificate = \"t1.xml\"\n"));
  ASSERT_TRUE(rig) << text(rig.error());
  EXPECT_EQ(channel_named(*rig, "shell").due, record::parse_day("2026-05-01"));
  EXPECT_EQ(Reading().cause(shell_rig_with("", "certificate = \"t1.xml\"\ndue = \"2026-11-05\"\n")),
            "\"due\" is 2026-11-05, but certificate T1-2025 is due 2026-11-04");
}

/// The virtual clock starts on 2026-01-01, the last permitted due day.
TEST(ThermometerCertificate, RefusesOverdueCalibration) {
  Reading reading;
  const std::string named = shell_rig_with("", "certificate = \"t1.xml\"\n");
  reading.values.due = record::parse_day("2026-01-01");
  EXPECT_EQ(reading.cause(named), "");
  reading.values.due = record::parse_day("2025-12-31");
  EXPECT_EQ(reading.cause(named),
            "certificate T1-2025 was due 2025-12-31, expected a calibration that is valid on 2026-01-01");
  EXPECT_NE(Reading().cause(shell_rig_with("", "certificate = \"t1.xml\"\ndue = \"2025-12-01\"\n")), "");
}

TEST(ThermometerCertificate, RefusesFutureCalibration) {
  const std::string named = shell_rig_with("", "certificate = \"t1.xml\"\n");
  const auto cause_on = [&](const char* today, const char* calibrated) {
    Reading reading;
    reading.today = record::parse_day(today).value();
    reading.values.calibrated = record::parse_day(calibrated).value();
    reading.values.due.reset();
    return reading.cause(named);
  };
  EXPECT_EQ(cause_on("2026-11-30", "2026-11-30"), "") << "after the start of the virtual clock";
  EXPECT_EQ(cause_on("2025-06-01", "2026-01-01"), "") << "the start of the virtual clock";
  EXPECT_EQ(cause_on("2026-11-30", "2026-12-01"),
            "certificate T1-2025 states a calibration on 2026-12-01, after 2026-11-30; check the clock and the file");
  EXPECT_NE(cause_on("2026-11-30", "2031-11-04"), "");
}

TEST(ThermometerCertificate, OfRealRigIsComparedWithToday) {
  record::Channel channel;
  CertificateValues values = t1_values();
  const CertificateDays today{.of_run = values.calibrated, .latest_calibration = values.calibrated};
  EXPECT_TRUE(apply_certificate(values, "rig.toml:1", today, channel));
  values.calibrated += std::chrono::days(1);
  const auto refused = apply_certificate(values, "rig.toml:1", today, channel);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::bad_file);
}

TEST(ThermometerCertificate, RequiresTrustedSignersAndReader) {
  const std::string keys = "certificate = \"t1.xml\"\n";
  EXPECT_NE(Reading().cause(shell_rig_with("", keys, "")).find("no trusted signers"), std::string::npos);
  const auto rig = parse_rig(shell_rig_with("", keys), kShellRigFolder + "virtual.toml");
  ASSERT_FALSE(rig);
  EXPECT_NE(rig.error().what.find("cannot be read here"), std::string::npos);
}

TEST(ThermometerCertificate, ReportsFailureOfReader) {
  const auto fails = [](const CertificateRequest&) -> Result<CertificateValues> {
    return failure(FaultKind::bad_file, "t1.xml:7", "is not signed");
  };
  const auto rig = parse_rig(shell_rig_with("", "certificate = \"t1.xml\"\n"), kShellRigFolder + "virtual.toml", {},
                             {.read = fails});
  ASSERT_FALSE(rig);
  EXPECT_EQ(rig.error().where, "t1.xml:7");
}

/// A resumed run continues with the values of its record, although the certificate file has changed or is missing.
TEST(ThermometerCertificate, IsRestoredFromRecord) {
  const std::string named = shell_rig_with("", "certificate = \"t1.xml\"\n");
  Reading first, resumed;
  const auto before = first.read(named);
  ASSERT_TRUE(before) << text(before.error());
  resumed.known.channels = list_channels(*before);
  resumed.values.offset = {7};
  const auto after = resumed.read(named);
  ASSERT_TRUE(after) << text(after.error());
  EXPECT_TRUE(resumed.requests.empty());
  EXPECT_EQ(channel_named(*after, "shell").offset, Kelvins{-0.012});
  EXPECT_EQ(channel_named(*after, "shell").certificate_file, t1_file());
  resumed.known.channels->back().certificate_file.reset();
  EXPECT_NE(resumed.cause(named).find("the record does not contain the certificate file of channel shell"),
            std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::rig
