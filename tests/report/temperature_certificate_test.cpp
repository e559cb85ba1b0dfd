// SPDX-License-Identifier: Apache-2.0
#include "report/temperature_certificate.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "core/file.hpp"
#include "core/sha256.hpp"
#include "report/temperature_values.hpp"
#include "tests/support/foreign_dcc.hpp"

namespace gyrotherm::report {
namespace {

Result<TemperatureCertificate> read(const std::string& dcc, const std::string& serial_number = "") {
  return read_foreign_dcc(dcc, "t1.xml").and_then([&](const XmlElement& root) {
    return read_temperature_certificate(root, "t1.xml", serial_number);
  });
}

/// Returns a certificate whose table has this content.
std::string with_table(const std::string& content) {
  std::string dcc = foreign_dcc();
  const std::string begin = "<dcc:list refType=\"gp_table1\">", end = "</dcc:list>";
  const auto from = dcc.find(begin) + begin.size();
  return dcc.replace(from, dcc.find(end) - from, content);
}

std::string quantity(const std::string& ref_type, const std::string& content) {
  return fmt::format("<dcc:quantity refType=\"{}\">{}</dcc:quantity>", ref_type, content);
}

std::string real(const std::string& value, const std::string& unit, const std::string& uncertainty = "") {
  return fmt::format("<si:real><si:value>{}</si:value><si:unit>{}</si:unit>{}</si:real>", value, unit, uncertainty);
}

std::string expanded_mu(const std::string& expanded, const std::string& k, const std::string& more = "") {
  return fmt::format(
      "<si:measurementUncertaintyUnivariate><si:expandedMU><si:valueExpandedMU>{}</si:valueExpandedMU>"
      "<si:coverageFactor>{}</si:coverageFactor>{}</si:expandedMU></si:measurementUncertaintyUnivariate>",
      expanded, k, more);
}

TEST(TemperatureCertificate, ReadsListOfTemperatures) {
  const auto found = read(foreign_dcc(), "T-0417");
  ASSERT_TRUE(found) << text(found.error());
  EXPECT_EQ(found->number, "THERMO-2025-0417");
  EXPECT_EQ(found->issuer, "Thermo Lab");
  EXPECT_EQ(found->calibrated, "2025-11-04");
  EXPECT_EQ(found->due, "2026-11-04");
  ASSERT_EQ(found->points.size(), 5u);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(found->points[i].correction_k, -0.02 + 0.01 * i, 1e-12) << i;
  EXPECT_DOUBLE_EQ(found->lowest_c(), -39.98);
  EXPECT_DOUBLE_EQ(found->highest_c(), 59.98);
  EXPECT_EQ(found->offset_k(), 0) << "without rounding errors";
  // u = 0.021/2; mean square of −20, −10, 0, 10, 20 mK: 200 mK².
  EXPECT_NEAR(found->standard_uncertainty_k(), std::hypot(0.0105, std::sqrt(2e-4)), 1e-12);
  EXPECT_DOUBLE_EQ(found->most_uncertain().expanded_k, 0.021);
}

TEST(TemperatureCertificate, ReadsOnePointWithExactUncertainty) {
  const auto found = read(
      with_table(quantity("basic_nominalValue", real("293.15", "\\kelvin")) +
                 quantity("basic_measurementError",
                          real("0.03", "\\degreecelsius",
                               expanded_mu("0.05", "2", "<si:coverageProbability>0.9545</si:coverageProbability>")))));
  ASSERT_TRUE(found) << text(found.error());
  EXPECT_NEAR(found->offset_k(), -0.03, 1e-12);
  EXPECT_DOUBLE_EQ(found->standard_uncertainty_k(), 0.025);
  EXPECT_NEAR(found->lowest_c(), 20, 1e-9);
  EXPECT_EQ(found->lowest_c(), found->highest_c());
}

TEST(TemperatureCertificate, ReadsRowsOfPairs) {
  std::string rows;
  for (const auto& [reference, indicated] : {std::pair("0.00", "0.10"), {"50.00", "50.20"}})
    rows += "<dcc:list>" + quantity("temperature_referenceValue", real(reference, "\\degreecelsius")) +
            quantity("temperature_measuredValue", real(indicated, "\\degreecelsius", expanded_mu("0.04", "2"))) +
            "</dcc:list>";
  const auto found = read(with_table(rows));
  ASSERT_TRUE(found) << text(found.error());
  ASSERT_EQ(found->points.size(), 2u);
  EXPECT_NEAR(found->offset_k(), -0.15, 1e-12);
  EXPECT_NEAR(found->standard_uncertainty_k(), std::hypot(0.02, 0.05), 1e-12);
}

TEST(TemperatureCertificate, CombinesUncertaintiesOfPair) {
  const auto found =
      read(with_table(quantity("basic_referenceValue", real("20.00", "\\degreecelsius", expanded_mu("0.03", "3"))) +
                      quantity("basic_measuredValue", real("20.10", "\\degreecelsius", expanded_mu("0.04", "2")))));
  ASSERT_TRUE(found) << text(found.error());
  EXPECT_NEAR(found->standard_uncertainty_k(), std::hypot(0.01, 0.02), 1e-12);
}

TEST(TemperatureCertificate, ReadsListOfReals) {
  const auto found = read(with_table(
      quantity("basic_nominalValue",
               "<si:list>" + real("0", "\\degreecelsius") + real("10", "\\degreecelsius") + "</si:list>") +
      quantity("basic_correction",
               "<si:list>" + real("0.01", "\\kelvin", expanded_mu("0.02", "2")) +
                   real("0.03", "\\kelvin",
                        "<si:expandedUnc><si:uncertainty>0.06</si:uncertainty><si:coverageFactor>2</si:coverageFactor>"
                        "<si:coverageProbability>0.95</si:coverageProbability></si:expandedUnc>") +
                   "</si:list>")));
  ASSERT_TRUE(found) << text(found.error());
  EXPECT_NEAR(found->offset_k(), 0.02, 1e-12);
  EXPECT_NEAR(found->standard_uncertainty_k(), std::hypot(0.03, 0.01), 1e-12);
  EXPECT_DOUBLE_EQ(found->most_uncertain().expanded_k, 0.06);
}

TEST(TemperatureCertificate, ReadsStandardUncertainty) {
  const auto found = read(with_table(
      quantity("basic_nominalValue", real("20", "\\degreecelsius")) +
      quantity("basic_measurementError",
               real("30", "\\milli\\degreecelsius",
                    "<si:measurementUncertaintyUnivariate><si:standardMU><si:valueStandardMU>10</si:valueStandardMU>"
                    "</si:standardMU></si:measurementUncertaintyUnivariate>"))));
  ASSERT_TRUE(found) << text(found.error());
  EXPECT_DOUBLE_EQ(found->standard_uncertainty_k(), 0.01);
}

TEST(TemperatureCertificate, IgnoresValuesBeforeAdjustment) {
  const std::string before =
      "<dcc:list refType=\"basic_beforeAdjustment\">" + quantity("basic_nominalValue", real("20", "\\degreecelsius")) +
      quantity("basic_measurementError", real("5", "\\kelvin", expanded_mu("0.1", "2"))) + "</dcc:list>";
  const auto found = read(
      with_replaced(foreign_dcc(), "<dcc:list refType=\"gp_table1\">", before + "<dcc:list refType=\"gp_table1\">"));
  ASSERT_TRUE(found) << text(found.error());
  EXPECT_EQ(found->points.size(), 5u);
}

TEST(TemperatureCertificate, IgnoresOtherQuantitiesAndForeignElements) {
  const auto found = read(with_replaced(
      foreign_dcc(), "<dcc:list refType=\"gp_table1\">",
      "<dcc:list>" + quantity("basic_measurementError", real("3", "\\percent")) + "</dcc:list>" +
          "<x:quantity xmlns:x=\"urn:other\" refType=\"basic_measurementError\"/><dcc:list refType=\"gp_table1\">"));
  ASSERT_TRUE(found) << text(found.error());
  EXPECT_EQ(found->points.size(), 5u);
}

/// Returns a certificate with two items. Its table refers to `ref_id`.
std::string with_two_items(const std::string& ref_id) {
  const std::string second =
      "<dcc:item id=\"probe-2\"><dcc:identifications><dcc:identification><dcc:value>T-0418</dcc:value>"
      "</dcc:identification></dcc:identifications></dcc:item></dcc:items>";
  return with_replaced(with_replaced(foreign_dcc(), "</dcc:items>", second), "refType=\"gp_measuringResult1\"",
                       fmt::format("refId=\"{}\"", ref_id));
}

TEST(TemperatureCertificate, SelectsItemBySerialNumber) {
  EXPECT_TRUE(read(with_two_items("method-1 probe-2"), "T-0418"));
  EXPECT_TRUE(read(with_two_items("probe"), "T-0417"));
}

struct Altered {
  std::string what, with;
  /// Part of the expected cause.
  std::string cause;
};

/// Each alteration of the certificate is refused with its cause and a position in the file.
TEST(TemperatureCertificate, RefusesEachAlterationWithItsCause) {
  const std::string errors = "20 10 0 -10 -20", factor = "<si:coverageFactorXMLList>2<";
  const std::string u = "<si:uncertaintyXMLList>21<", probability = "<si:coverageProbabilityXMLList>0.95<";
  const std::string unit = "\\milli\\kelvin", end = "</dcc:digitalCalibrationCertificate>\n";
  const std::string document = "<?xml version=\"1.0\" encoding=\"utf-8\" standalone=\"no\"?>\n";
  const std::vector<Altered> all{
      {factor, "<si:coverageFactorXMLList>0<", "k is 0"},
      {factor, "<si:coverageFactorXMLList>-2<", "k is -2"},
      {factor, "<si:coverageFactorXMLList>0.5<", "k is 0.5"},
      {factor, "<si:coverageFactorXMLList>nan<", "k is \"nan\""},
      {factor, "<si:coverageFactorXMLList>inf<", "k is \"inf\""},
      {factor, "<si:coverageFactorXMLList>two<", "k is \"two\""},
      {factor, "<si:coverageFactorXMLList><", "coverageFactorXMLList has 0 entries for 5 values"},
      {factor, "<si:coverageFactorXMLList>2 2<", "coverageFactorXMLList has 2 entries for 5 values"},
      {factor, "<si:coverageFactorXMLList>3<", "k = 3 contradicts the coverage probability of 0.95"},
      {factor, "<si:coverageFactorXMLList>1<", "k = 1 contradicts the coverage probability of 0.95"},
      {factor, "<si:coverageFactorXMLList>2 2 2 2 3<", "k = 3 contradicts"},
      {probability, "<si:coverageProbabilityXMLList>0.68<", "k = 2 contradicts the coverage probability of 0.68"},
      {probability, "<si:coverageProbabilityXMLList>0.9973<", "k = 2 contradicts"},
      {probability, "<si:coverageProbabilityXMLList>95<", "the coverage probability is 95, expected 0 to 1"},
      {probability, "<si:coverageProbabilityXMLList>0<", "the coverage probability is 0"},
      {probability, "<si:coverageProbabilityXMLList>most<", "the probability is \"most\""},
      {u, "<si:uncertaintyXMLList>0<", "U is 0 K"},
      {u, "<si:uncertaintyXMLList>-21<", "U is -0.021 K"},
      {u, "<si:uncertaintyXMLList>NaN<", "U is \"NaN\""},
      {u, "<si:uncertaintyXMLList>1e999<", "U is \"1e999\""},
      {u, "<si:uncertaintyXMLList>21 21 21 21<", "uncertaintyXMLList has 4 entries for 5 values"},
      {u, "<si:uncertaintyXMLList>21 21 21 21 21 21<", "uncertaintyXMLList has 6 entries for 5 values"},
      {"<si:uncertaintyXMLList>21</si:uncertaintyXMLList>", "", "has no uncertaintyXMLList"},
      {"<si:coverageFactorXMLList>2</si:coverageFactorXMLList>", "", "has no coverageFactorXMLList"},
      {unit, "\\volt", "has the unit \\volt, expected \\degreecelsius or \\kelvin"},
      {unit, "\\degreefahrenheit", "has the unit \\degreefahrenheit, expected \\degreecelsius or \\kelvin"},
      {unit, "\\milli\\ohm", "has the unit \\milli\\ohm"},
      {unit, "\\kelvin\\tothe{2}", "has the unit"},
      {unit, "K", "has the unit K"},
      {unit, "\\kelvin", "contradicts itself"},
      {unit, "", "unitXMLList has 0 entries for 5 values"},
      {unit, "\\kelvin \\kelvin", "unitXMLList has 2 entries for 5 values"},
      {errors, "20 10 0 -10", "has a table with 4 and 5 values"},
      {errors, "20 10 0 -10 -20 -30", "has a table with 6 and 5 values"},
      {errors, "20 10 0 -10 nan", "\"nan\" is not a temperature"},
      {errors, "20 10 0 -10 -inf", "\"-inf\" is not a temperature"},
      {errors, "20 10 0 -10 0x10", "\"0x10\" is not a temperature"},
      {errors, "20 10 0 -10 -2,0", "\"-2,0\" is not a temperature"},
      {errors, "", "expected a number"},
      {errors, "20 10 0 -10 9000", "contradicts itself"},
      {"-39.98 -14.99", "-3998 -14.99", "is below absolute zero"},
      {"-40 -15 10 35 60", "-40 -15 10 35 61", "contradicts the value in another unit"},
      {"233.15 258.15", "-1 258.15", "is below absolute zero"},
      {"https://ptb.de/dcc\"", "https://ptb.de/other\"", "is not a digital calibration certificate"},
      {"schemaVersion=\"3.2.0\"", "schemaVersion=\"2.4.0\"", "is a DCC of version \"2.4.0\""},
      {"schemaVersion=\"3.2.0\"", "schemaVersion=\"4.0.0\"", "is a DCC of version \"4.0.0\""},
      {"schemaVersion=\"3.2.0\"", "schemaVersion=\"3.4.0\"", "is a DCC of version \"3.4.0\""},
      {"schemaVersion=\"3.2.0\"", "schemaVersion=\"3\"", "is a DCC of version \"3\""},
      {"schemaVersion=\"3.2.0\"", "", "is a DCC of version \"\""},
      {end, "", "is not XML or is incomplete"},
      {"</dcc:coreData>", "", "is not XML or is incomplete"},
      {document, document + "<!DOCTYPE dcc>\n", "has a document type"},
      {document, document + "<!DOCTYPE d [<!ENTITY a \"b\">]>\n", "has a document type"},
      {document, document + "<!DOCTYPE d SYSTEM \"file:///etc/passwd\">\n", "has a document type"},
      {"THERMO-2025-0417", "&secret;", "is not XML or is incomplete"},
      {"encoding=\"utf-8\"", "encoding=\"ISO-8859-1\"", "is not in UTF-8"},
      {"THERMO-2025-0417", " \n ", "has no number"},
      {"Thermo Lab", "", "does not name the calibration laboratory"},
      {"2025-11-04</dcc:end", "2025-02-30</dcc:end", "\"2025-02-30\" is not a day"},
      {"2025-11-04</dcc:end", "yesterday</dcc:end", "\"yesterday\" is not a day"},
      {"2025-11-04</dcc:end", "</dcc:end", "does not state the day of the calibration"},
      {"2026-11-04</dcc:date>", "2024-11-04</dcc:date>", "is due before the day of the calibration"},
      {"</dcc:statements>",
       "<dcc:statement "
       "refType=\"basic_recalibration\"><dcc:date>2030-01-01</dcc:date></dcc:statement></dcc:statements>",
       "states two days of recalibration"},
      {" T-0417 ", "T-9999", "is for another item: none has the serial number \"T-0417\""},
      {"basic_measurementError", "basic_beforeAdjustment", "does not state the uncertainty U of each value"},
      {"<dcc:data>", "<dcc:data><dcc:quantity refType=\"basic_measurementError\"/>", "has no value in the notation"},
      {"<si:hybrid>", "<si:complex>", "is not XML or is incomplete"},
  };
  for (const Altered& one : all) {
    const auto found = read(with_replaced(foreign_dcc(), one.what, one.with), "T-0417");
    ASSERT_FALSE(found) << one.cause;
    EXPECT_EQ(found.error().kind, FaultKind::bad_file);
    EXPECT_NE(found.error().what.find(one.cause), std::string::npos)
        << text(found.error()) << "\nexpected: " << one.cause;
    EXPECT_TRUE(found.error().where.starts_with("t1.xml:")) << found.error().where;
  }
  EXPECT_GE(all.size(), 50u);
}

TEST(TemperatureCertificate, NamesLineOfCause) {
  const auto found = read(with_replaced(foreign_dcc(), "\\milli\\kelvin", "\\volt"));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().where, "t1.xml:50");
}

TEST(TemperatureCertificate, RefusesUnclearItems) {
  const auto cause = [](const std::string& dcc, const std::string& serial_number) {
    const auto found = read(dcc, serial_number);
    return found ? "" : found.error().what;
  };
  EXPECT_EQ(cause(with_two_items("probe"), ""), "has 2 items; state the serial_number of the thermometer");
  EXPECT_EQ(cause(with_two_items("probe"), "T-0418"),
            "has several items and does not state which results belong to the thermometer (refId)");
  EXPECT_EQ(cause(with_replaced(with_two_items("probe"), "T-0418", "T-0417"), "T-0417"),
            "has 2 items with the serial number \"T-0417\"");
}

TEST(TemperatureCertificate, RefusesRepeatedId) {
  const std::string two = with_two_items("probe");
  EXPECT_TRUE(read_foreign_dcc(two, "t1.xml"));
  EXPECT_TRUE(read_foreign_dcc(with_replaced(foreign_dcc(), "<dcc:result ", "<dcc:result id=\"Probe\" "), "t1.xml"));
  for (const std::string& dcc : {with_replaced(two, "<dcc:item id=\"probe-2\"", "<dcc:item id=\"probe\""),
                                 with_replaced(foreign_dcc(), "<dcc:result ", "<dcc:result id=\" probe \" "),
                                 with_replaced(foreign_dcc(), "<dcc:result ", "<dcc:result xml:id=\"probe\" "),
                                 with_replaced(foreign_dcc(), "</dcc:digitalCalibrationCertificate>",
                                               "<dcc:comment><Object xmlns=\"urn:other\" Id=\"probe\"/></dcc:comment>"
                                               "</dcc:digitalCalibrationCertificate>")}) {
    const auto refused = read_foreign_dcc(dcc, "t1.xml");
    ASSERT_FALSE(refused) << dcc;
    EXPECT_EQ(refused.error().kind, FaultKind::bad_file);
    EXPECT_TRUE(refused.error().what.starts_with("has the id \"probe\" of the element in line"))
        << refused.error().what;
  }
}

TEST(TemperatureCertificate, RefusesCertificateWithoutTemperatures) {
  const auto cause = [](const std::string& content) {
    const auto found = read(with_table(content));
    return found ? "" : found.error().what;
  };
  EXPECT_EQ(cause(""), "has no measurement error, correction, or pair of indicated and reference temperature");
  EXPECT_EQ(cause(quantity("basic_measurementError", real("3", "\\percent", expanded_mu("1", "2")))),
            "has the unit \\percent, expected \\degreecelsius or \\kelvin");
  EXPECT_EQ(cause(quantity("basic_nominalValue", real("68", "\\degreefahrenheit")) +
                  quantity("basic_measurementError", real("3", "\\degreefahrenheit", expanded_mu("1", "2")))),
            "has the unit \\degreefahrenheit, expected \\degreecelsius or \\kelvin");
  EXPECT_EQ(cause(quantity("basic_measurementError", real("3", "\\kelvin", expanded_mu("1", "2")))),
            "does not state the temperatures at which it was calibrated");
  EXPECT_EQ(cause(quantity("basic_nominalValue", real("20", "\\degreecelsius")) +
                  quantity("basic_measurementError", real("3", "\\kelvin"))),
            "does not state the uncertainty U of each value");
}

TEST(TemperatureCertificate, RefusesHugeAndDeepFiles) {
  const auto kind = [](const std::string& bytes) {
    const auto found = read_foreign_dcc(bytes, "t1.xml");
    return found ? "" : found.error().what;
  };
  EXPECT_EQ(kind(foreign_dcc() + std::string(kLargestForeignDcc, ' ')),
            fmt::format("has {} bytes, at most {}", foreign_dcc().size() + kLargestForeignDcc, kLargestForeignDcc));
  std::string deep;
  for (std::size_t i = 0; i <= kDeepestXml; ++i) deep += "<a>";
  EXPECT_EQ(kind(deep), "has more than 64 levels of elements");
  std::string many = "<a>";
  for (std::size_t i = 0; i <= kMostXmlElements; ++i) many += "<b/>";
  EXPECT_EQ(kind(many), "has more than 500000 elements");
  EXPECT_NE(kind("\xFE\xFF"), "");
  EXPECT_NE(kind(""), "");
  EXPECT_NE(kind("<a>\xC3\x28</a>"), "");
}

TEST(TemperatureCertificate, RefusesEveryTruncation) {
  const std::string whole = foreign_dcc();
  const std::size_t end = whole.rfind('>');
  int refused = 0;
  for (std::size_t size = 0; size <= end; size += 7) refused += read(whole.substr(0, size)) ? 0 : 1;
  EXPECT_EQ(refused, static_cast<int>(end / 7 + 1));
}

TEST(UncertaintyRefusal, ComparesCoverageFactorWithProbability) {
  const auto refused = [](double k, double probability, std::string_view distribution) {
    return !uncertainty_refusal(0.1, k, probability, distribution).empty();
  };
  EXPECT_FALSE(refused(2, 0.95, "normal"));
  EXPECT_FALSE(refused(2, 0.9545, "normal"));
  EXPECT_FALSE(refused(1.96, 0.95, ""));
  EXPECT_FALSE(refused(2.87, 0.95, "t"));
  EXPECT_FALSE(refused(3, 0.997, "normal"));
  EXPECT_FALSE(refused(1.65, 0.95, "uniform"));
  EXPECT_TRUE(refused(2.87, 0.95, "normal"));
  EXPECT_TRUE(refused(1.65, 0.95, "t"));
  EXPECT_TRUE(refused(2, 0.95, "uniform"));
  EXPECT_TRUE(refused(30, 0.95, ""));
  EXPECT_TRUE(refused(1, 0.95, ""));
}

class ForeignSignature : public testing::Test {
 protected:
  static void SetUpTestSuite() { keys_ = std::make_unique<ForeignKeys>(); }
  static void TearDownTestSuite() { keys_.reset(); }

  [[nodiscard]] static Result<VerifiedCertificate> verify(const std::string& dcc,
                                                          const std::string& trusted = "authority") {
    return verify_temperature_certificate(dcc, "t1.xml", "T-0417", {.certificates_file = *keys_ / (trusted + ".pem")});
  }
  /// Returns the cause of a refusal; empty if the certificate is accepted.
  [[nodiscard]] static std::string cause(const std::string& dcc, const std::string& trusted = "authority") {
    const auto found = verify(dcc, trusted);
    if (found) return {};
    EXPECT_TRUE(found.error().where.starts_with("t1.xml:")) << text(found.error());
    return found.error().what;
  }

  static inline std::unique_ptr<ForeignKeys> keys_{};
};

TEST_F(ForeignSignature, IsVerified) {
  const std::string dcc = keys_->sign(foreign_dcc());
  const auto found = verify(dcc);
  ASSERT_TRUE(found) << text(found.error());
  EXPECT_EQ(found->signer.subject, "CN=laboratory,O=Thermo Lab");
  EXPECT_EQ(found->sha256, sha256(dcc));
  EXPECT_EQ(found->certificate.points.size(), 5u);
  EXPECT_EQ(cause(dcc, "laboratory"), "") << "the laboratory's own certificate may be trusted";
}

TEST_F(ForeignSignature, OfOtherMethodsIsVerified) {
  keys_->issue("curve", "authority", "ec", "3650");
  EXPECT_EQ(cause(keys_->sign(foreign_dcc(), "curve", "ecdsa-sha256")), "");
  EXPECT_EQ(cause(keys_->sign(foreign_dcc(), "laboratory", "rsa-sha512")), "");
}

TEST_F(ForeignSignature, FindsSignerAmongSeveralCertificates) {
  const std::string others = keys_->certificate("stranger") + "</ds:X509Certificate><ds:X509Certificate>" +
                             keys_->certificate("authority") + "</ds:X509Certificate><ds:X509Certificate>" +
                             keys_->certificate("laboratory");
  const std::string end = "</dcc:digitalCalibrationCertificate>";
  const auto found = verify(keys_->sign_template(
      with_replaced(foreign_dcc(), end, signature_template("rsa-sha256", others) + end), "laboratory"));
  ASSERT_TRUE(found) << text(found.error());
  EXPECT_EQ(found->signer.subject, "CN=laboratory,O=Thermo Lab");
}

TEST_F(ForeignSignature, RefusesEachChangedValue) {
  const std::string dcc = keys_->sign(foreign_dcc());
  const std::string altered = "its signature is not valid: the file was changed after it was signed";
  for (const auto& [what, with] : {std::pair<std::string, std::string>{"20 10 0 -10 -20", "20 10 0 -10 -10"},
                                   {"<si:uncertaintyXMLList>21<", "<si:uncertaintyXMLList>11<"},
                                   {"2026-11-04</dcc:date>", "2027-11-04</dcc:date>"},
                                   {" T-0417 ", " T-0418 "},
                                   {"THERMO-2025-0417", "THERMO-2025-0418"},
                                   {"Thermo Lab</dcc", "Thermo Lob</dcc"}})
    EXPECT_EQ(cause(with_replaced(dcc, what, with)), altered) << what;
  EXPECT_EQ(cause(with_replaced(dcc, "<!-- an invented certificate -->", "")), "") << "a comment is not signed";
}

TEST_F(ForeignSignature, RefusesUnsignedCertificate) { EXPECT_EQ(cause(foreign_dcc()), "is not signed"); }

TEST_F(ForeignSignature, RefusesUnknownSigner) {
  EXPECT_TRUE(cause(keys_->sign(foreign_dcc(), "stranger")).starts_with("the signer is not trusted"));
  EXPECT_EQ(cause(keys_->sign(foreign_dcc(), "stranger"), "other-authority"), "");
  EXPECT_NE(cause(keys_->sign(foreign_dcc(), "authority")), "") << "an authority does not sign certificates";
}

/// A certificate of another signer in the file must not make its signature trusted.
TEST_F(ForeignSignature, RefusesCertificateOfAnotherKey) {
  const std::string end = "</dcc:digitalCalibrationCertificate>";
  const auto document =
      with_replaced(foreign_dcc(), end, signature_template("rsa-sha256", keys_->certificate("laboratory")) + end);
  EXPECT_TRUE(cause(keys_->sign_template(document, "stranger")).starts_with("its signature is not valid"));
}

TEST_F(ForeignSignature, RefusesWeakMethod) {
  EXPECT_NE(cause(with_replaced(keys_->sign(foreign_dcc()), "xmldsig-more#rsa-sha256", "xmldsig-more#rsa-md5")), "");
  EXPECT_NE(cause(with_replaced(keys_->sign(foreign_dcc()), "xmlenc#sha256", "xmldsig#sha1")), "");
}

/// Moves a signed certificate into another one, whose values are not signed (signature wrapping).
TEST_F(ForeignSignature, RefusesSignatureOfAnotherPart) {
  const std::string end = "</dcc:digitalCalibrationCertificate>";
  const std::string empty = signature_template("rsa-sha256", keys_->certificate("laboratory"));
  std::string part = with_replaced(empty, "URI=\"\"", "URI=\"#probe\"");
  EXPECT_EQ(cause(with_replaced(foreign_dcc(), end, part + end)),
            "its signature covers other parts than the whole certificate");
  const std::string filter =
      "<ds:Transform Algorithm=\"http://www.w3.org/TR/1999/REC-xpath-19991116\"><ds:XPath>"
      "false()</ds:XPath></ds:Transform></ds:Transforms>";
  EXPECT_NE(cause(with_replaced(foreign_dcc(), end, with_replaced(empty, "</ds:Transforms>", filter) + end))
                .find("uses the transform"),
            std::string::npos);
  EXPECT_NE(cause(with_replaced(foreign_dcc(), "</dcc:items>", empty + "</dcc:items>")).find("does not cover"),
            std::string::npos);
  EXPECT_EQ(cause(with_replaced(foreign_dcc(), end, empty + empty + end)), "has 2 signatures, expected 1");
}

/// The keys of the test are made today, after the day of issue. The signer must be valid on one of the two days.
TEST_F(ForeignSignature, IsTrustedOnDayOfIssueOrToday) {
  const auto dcc = keys_->sign(foreign_dcc());
  const auto root = read_foreign_dcc(dcc, "t1.xml");
  ASSERT_TRUE(root);
  EXPECT_EQ(find_issue_day(*root), "2025-11-04");
  EXPECT_TRUE(verify(dcc));
  keys_->issue("expired", "authority", "rsa:2048", "0");
  EXPECT_TRUE(cause(keys_->sign(foreign_dcc(), "expired")).starts_with("the signer is not trusted"));
}

/// A certificate of this program is valid, but not a thermometer's.
TEST(TemperatureCertificate, RefusesCertificateOfGyro) {
  const char* shared = std::getenv("GYROTHERM_SHARED");
  if (shared == nullptr) GTEST_SKIP() << "GYROTHERM_SHARED is not set: the example is not at hand";
  const auto bytes = read_text_file(std::string(shared) + "/dcc/example-rlg.xml", kLargestTable);
  ASSERT_TRUE(bytes);
  EXPECT_FALSE(read(*bytes));
}

}  // namespace
}  // namespace gyrotherm::report
