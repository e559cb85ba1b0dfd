// SPDX-License-Identifier: Apache-2.0
#include "report/signature.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <random>
#include <regex>

#include "core/file.hpp"
#include "core/sha256.hpp"
#include "report/dcc.hpp"
#include "report/report_files.hpp"
#include "report/signed_report.hpp"
#include "tests/report/signing_keys.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

#ifdef GYROTHERM_NIGHTLY
constexpr int kTries = 100;
#else
constexpr int kTries = 10;
#endif

constexpr const char* kLateUtc = "2999-01-01T00:00:00Z";
std::string bytes_of(const std::string& path) { return read_text_file(path, kLargestTable).value_or(""); }

/// Fixture with keys, and a folder with a report that is signed with them.
class Signed : public testing::Test {
 protected:
  static void SetUpTestSuite() { keys_ = std::make_unique<Keys>(); }
  static void TearDownTestSuite() { keys_.reset(); }

  void SetUp() override {
    write("calibration.json", to_json(sample_calibration()));
    write("report.pdf", pdf_of("Bias 0.0021 deg/h", "page 2"));
    write("report.html", "<p>Bias</p>");
    authorise();
  }

  /// Authorises the files in the folder. The renderer returns these files from now on.
  void authorise() {
    views_.clear();
    for (const auto& path : list_folder(folder_path()))
      if (const std::string name = path.filename(); name != kAuthorisationFile && name != kDccFile)
        views_.push_back({name, bytes(name)});
    const auto report = calibration_from_json(bytes("calibration.json"), "calibration.json");
    ASSERT_TRUE(report);
    write(kAuthorisationFile, to_json(make_authorisation(*report, views_, "0.1.0")));
  }
  /// Signs with a clock that is later than any authorisation, unless the test sets another.
  [[nodiscard]] Result<std::vector<std::string>> signed_with(const SigningKey& key,
                                                             const std::string& now_utc = kLateUtc) const {
    return sign_report(
        folder_path(), key, [&](const CalibrationReport&, const std::vector<std::string>&) { return views_; }, now_utc);
  }
  void sign() {
    const auto done = signed_with(keys_->key("lab"));
    ASSERT_TRUE(done) << text(done.error());
  }
  void write(const std::string& name, const std::string& bytes) { ASSERT_TRUE(replace_text_file(at(name), bytes)); }
  [[nodiscard]] std::string at(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] std::string folder_path() const { return std::filesystem::path(at("x")).parent_path().string(); }
  [[nodiscard]] std::string bytes(const std::string& name) const { return bytes_of(at(name)); }
  [[nodiscard]] static bool dcc_holds(const std::string& dcc, const Trust& trust = keys_->trust()) {
    return verify_dcc(dcc, "dcc.xml", trust).has_value();
  }
  /// Returns the names of the failed checks of the folder.
  [[nodiscard]] std::vector<std::string> failing(const Trust& trust = keys_->trust()) const {
    const auto found = verify_report(folder_path(), trust);
    EXPECT_TRUE(found) << text(found.error());
    std::vector<std::string> names;
    if (found)
      for (const Check& check : found->checks)
        if (is_failure(check.outcome)) names.push_back(check.what);
    return names;
  }

  static std::unique_ptr<Keys> keys_;
  std::vector<NewFile> views_{};  ///< files that the renderer returns

 private:
  tests::TestFolder folder_;
};

std::unique_ptr<Keys> Signed::keys_;

/// Changes one byte at a random position. If `digits` is true, replaces a digit by another digit.
std::string with_another_byte(std::string bytes, std::mt19937_64& engine, bool digits, std::size_t from = 0,
                              std::size_t to = std::string::npos) {
  to = std::min(to, bytes.size());
  for (;;) {
    char& byte = bytes[from + engine() % (to - from)];
    const char before = byte;
    if (digits && std::isdigit(static_cast<unsigned char>(byte)) == 0) continue;
    byte = digits ? static_cast<char>('0' + engine() % 10) : static_cast<char>(engine() % 256);
    if (byte != before) return bytes;
    byte = before;
  }
}

TEST_F(Signed, VerifiesUnchangedFolder) {
  sign();
  const auto found = verify_report(folder_path(), keys_->trust());
  ASSERT_TRUE(found) << text(found.error());
  EXPECT_EQ(found->identifier, "C-2026-0042 (simulated)");
  ASSERT_TRUE(found->signer);
  EXPECT_EQ(found->signer->subject, "CN=lab,O=Inertial Laboratory,C=DE");
  EXPECT_EQ(found->signer->issuer, "CN=ca");
  EXPECT_EQ(found->signer->fingerprint.size(), 64u);
  EXPECT_TRUE(found->report);
  std::vector<std::string> names;
  for (const Check& check : found->checks) {
    EXPECT_EQ(check.outcome, Check::Outcome::holds) << check.what << ": " << check.text;
    names.push_back(check.what);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"dcc.xml", "calibration.json", "report.html", "report.pdf",
                                             "authorisation.json"}));
}

TEST_F(Signed, CertificateIsValidBySchema) {
  const char* shared = std::getenv("GYROTHERM_SHARED");
  if (shared == nullptr) GTEST_SKIP() << "GYROTHERM_SHARED is not set: PTB's schema is not at hand";
  sign();
  run("xmllint", {"--nonet", "--noout", "--schema", std::string(shared) + "/dcc/v3.3.0/dcc/dcc.xsd", at("dcc.xml")});
}

TEST_F(Signed, VerifyRefusesChangedByteInCertificate) {
  sign();
  const std::string dcc = bytes("dcc.xml");
  ASSERT_TRUE(dcc_holds(dcc));
  const std::size_t embedded = dcc.find("<dcc:document>");
  for (int i = 0; i < kTries; ++i) {
    std::mt19937_64 engine(static_cast<std::uint64_t>(i));
    EXPECT_FALSE(dcc_holds(with_another_byte(dcc, engine, false))) << "seed " << i;
    EXPECT_FALSE(dcc_holds(with_another_byte(dcc, engine, true, 0, embedded))) << "seed " << i << ", a digit";
    EXPECT_FALSE(dcc_holds(with_another_byte(dcc, engine, false, dcc.find("<ds:Signature")))) << "seed " << i;
    std::string without = dcc, with = dcc;
    without.erase(engine() % dcc.size(), 1);
    with.insert(engine() % dcc.size(), 1, ' ');
    EXPECT_FALSE(dcc_holds(without)) << "seed " << i << ", a byte less";
    EXPECT_FALSE(dcc_holds(with)) << "seed " << i << ", a blank more";
  }
}

TEST_F(Signed, VerifyRefusesChangedByteInPdf) {
  sign();
  const std::string pdf = bytes("report.pdf");
  ASSERT_TRUE(verify_pdf(at("report.pdf"), keys_->trust()));
  // A signature does not cover its own bytes; dcc.xml protects them.
  const std::size_t begins = pdf.rfind("/Contents <"), ends = pdf.find('>', begins);
  ASSERT_NE(begins, std::string::npos);
  const auto holds = [&](const std::string& other) {
    (void)replace_text_file(at("other.pdf"), other);
    return verify_pdf(at("other.pdf"), keys_->trust()).has_value();
  };
  ASSERT_TRUE(holds(pdf));
  const std::size_t original = pdf_of("Bias 0.0021 deg/h", "page 2").size();
  for (int i = 0; i < kTries; ++i) {
    std::mt19937_64 engine(static_cast<std::uint64_t>(i));
    EXPECT_FALSE(holds(with_another_byte(pdf, engine, false, 0, begins))) << "seed " << i;
    EXPECT_FALSE(holds(with_another_byte(pdf, engine, true, 0, original))) << "seed " << i << ", a digit";
    EXPECT_FALSE(holds(with_another_byte(pdf, engine, false, ends + 1))) << "seed " << i << ", after the signature";
  }
}

TEST_F(Signed, VerifyRefusesReplacedPageInPdf) {
  sign();
  const std::string pdf = bytes("report.pdf");
  const auto refused = [&](const std::string& other) {
    write("other.pdf", other);
    const auto signer = verify_pdf(at("other.pdf"), keys_->trust());
    return signer ? "" : signer.error().what;
  };
  std::string fewer = pdf;
  fewer.replace(fewer.find("[3 0 R 4 0 R] /Count 2"), 22, "[3 0 R      ] /Count 1");
  EXPECT_NE(refused(fewer), "");
  // Appended as an incremental update: the signature over the previous bytes is still valid.
  const std::size_t at_table =
      pdf.rfind("startxref\n") == std::string::npos ? pdf.rfind("startxref") : pdf.rfind("startxref");
  const std::string previous = pdf.substr(at_table + 9, pdf.find("%%EOF", at_table) - at_table - 9);
  std::string appended = pdf;
  const std::size_t object = appended.size();
  appended += "2 0 obj\n<< /Type /Pages /Kids [4 0 R] /Count 1 >>\nendobj\n";
  const std::size_t table = appended.size();
  appended +=
      fmt::format("xref\n2 1\n{:010} 00000 n \ntrailer\n<< /Size 19 /Root 1 0 R /Prev {} >>\nstartxref\n{}\n%%EOF\n",
                  object, std::stoul(previous), table);
  EXPECT_EQ(refused(appended), "its signature does not cover the whole file");
  EXPECT_NE(refused(pdf_of("Bias 0.0001 deg/h", "page 2")), "");
}

TEST_F(Signed, VerifyRefusesChangedByteInAnyFile) {
  sign();
  for (const char* name : {"calibration.json", "report.pdf", "report.html"}) {
    const std::string before = bytes(name);
    for (int i = 0; i < std::max(1, kTries / 10); ++i) {
      std::mt19937_64 engine(static_cast<std::uint64_t>(i));
      write(name, with_another_byte(before, engine, false));
      EXPECT_EQ(failing(), std::vector<std::string>{name}) << "seed " << i;
    }
    write(name, before);
  }
  EXPECT_TRUE(failing().empty());
}

TEST_F(Signed, VerifyReportsMissingFile) {
  sign();
  std::filesystem::remove(at("report.html"));
  EXPECT_EQ(failing(), std::vector<std::string>{"report.html"});
  std::filesystem::remove(at("calibration.json"));
  EXPECT_EQ(failing(), (std::vector<std::string>{"calibration.json", "report.html"}));
}

/// A report signed by gyrotherm 0.1.0 does not list authorisation.json.
TEST_F(Signed, VerifiesReportOfFirstVersion) {
  const auto dcc = make_dcc(sample_calibration(), {.files = {{"calibration.json", sha256(bytes("calibration.json"))},
                                                             {"report.html", sha256(bytes("report.html"))}}});
  ASSERT_TRUE(dcc);
  write("dcc.xml", *sign_dcc(*dcc, keys_->key("lab")));
  std::filesystem::remove(at("report.pdf"));
  std::filesystem::remove(at(kAuthorisationFile));
  EXPECT_TRUE(failing().empty());
  write("Calibration report.html", "other values");
  EXPECT_EQ(failing(), std::vector<std::string>{"Calibration report.html"});
}

/// The folder lists the German PDF first.
TEST_F(Signed, EmbedsPdfInMandatoryLanguage) {
  std::filesystem::remove(at("report.pdf"));
  write("calibration.de.pdf", pdf_of("Nullpunkt", "Seite 2"));
  write("calibration.pdf", pdf_of("Bias 0.0021 deg/h", "page 2"));
  authorise();
  sign();
  const std::string dcc = bytes("dcc.xml");
  EXPECT_NE(dcc.find("<dcc:mandatoryLangCodeISO639_1>en<"), std::string::npos);
  EXPECT_NE(dcc.find("calibration.pdf", dcc.find("<dcc:document>")), std::string::npos);
  EXPECT_EQ(dcc.find("calibration.de.pdf", dcc.find("<dcc:document>")), std::string::npos);
  EXPECT_TRUE(failing().empty());
}

TEST_F(Signed, VerifyNamesForeignFilesInFolder) {
  sign();
  write("rate.db", "a record that calibration.json names is judged by itself");
  write("rate.db.sha256", "");
  EXPECT_TRUE(failing().empty());
  write("report.de.html", "<p>Bias</p>");
  write("Calibration report.pdf", bytes("report.pdf"));
  write(".hidden", "");
  std::filesystem::create_directory(at("views"));
  std::filesystem::create_symlink("report.pdf", at("zz.pdf"));
  EXPECT_EQ(failing(),
            (std::vector<std::string>{".hidden", "Calibration report.pdf", "report.de.html", "views", "zz.pdf"}));
}

TEST_F(Signed, VerifyNamesRenamedFileUnderBothNames) {
  sign();
  std::filesystem::rename(at("report.pdf"), at("renamed.pdf"));
  EXPECT_EQ(failing(), (std::vector<std::string>{"report.pdf", "renamed.pdf"}));
}

TEST_F(Signed, RefusesFolderChangedAfterAuthorisation) {
  const auto refusal = [&] {
    const auto done = signed_with(keys_->key("lab"));
    EXPECT_FALSE(std::filesystem::exists(at("dcc.xml")));
    return done ? "" : text(done.error());
  };
  const std::string begins = folder_path() + ": was changed after A. Metrologist authorised it: ";
  const auto with = [&](const std::string& name, const std::string& other) {
    const std::string before = bytes(name);
    write(name, other);
    const std::string found = refusal();
    before.empty() ? (void)std::filesystem::remove(at(name)) : write(name, before);
    return found;
  };
  std::string changed = bytes("calibration.json");
  changed.replace(changed.find("0.0021"), 6, "0.0001");
  EXPECT_EQ(with("calibration.json", changed), begins + "changed calibration.json");
  EXPECT_EQ(with("report.html", "<p>Bias 0.1</p>"), begins + "changed report.html");
  EXPECT_EQ(with("report.pdf", bytes("report.pdf") + "\n"), begins + "changed report.pdf");
  EXPECT_EQ(with("note.html", "a note"), begins + "not part of the report note.html");
  EXPECT_EQ(with("calibration.de.html", "of an earlier draft"), begins + "not part of the report calibration.de.html");
  std::string other = bytes(kAuthorisationFile);
  other.replace(other.find("A. Metrologist"), 14, "B. Metrologist");
  EXPECT_NE(with(kAuthorisationFile, other).find("changed authorisation.json"), std::string::npos);
  EXPECT_NE(with(kAuthorisationFile, bytes(kAuthorisationFile) + " "), "") << "not the canonical form";
  std::filesystem::remove(at("report.html"));
  EXPECT_EQ(refusal(), begins + "missing report.html");
  write("report.html", "<p>Bias</p>");
  std::filesystem::remove(at(kAuthorisationFile));
  EXPECT_NE(refusal().find("authorise the report again"), std::string::npos);
}

/// Digests would not detect a change of both a view and its digest.
TEST_F(Signed, RefusesViewNotRenderedFromSource) {
  const auto rendered = views_;
  for (const char* name : {"report.html", "report.pdf"}) {
    const std::string before = bytes(name);
    write(name, "other numbers");
    authorise();
    views_ = rendered;
    const auto refused = signed_with(keys_->key("lab"));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().where, at(name));
    write(name, before);
  }
  write("more.csv", "a table that nothing renders");
  authorise();
  views_ = rendered;
  const auto refused = signed_with(keys_->key("lab"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, at("more.csv"));
}

/// All certificates are issued by the trusted authority.
TEST_F(Signed, RefusesCertificateForOtherPurpose) {
  const std::string end_entity = "basicConstraints=critical,CA:FALSE\n";
  const std::string signs = end_entity + "keyUsage=critical,digitalSignature\nextendedKeyUsage=";
  const std::vector<std::pair<std::string, std::string>> others{
      {"www", "keyUsage=critical,keyEncipherment\nextendedKeyUsage=critical,serverAuth\n"},
      {"www-signs", signs + "serverAuth,clientAuth\n"},
      {"time-stamps", signs + "critical,timeStamping\n"},
      {"code", signs + "codeSigning\n"},
      {"encrypts", end_entity + "keyUsage=critical,keyEncipherment,dataEncipherment\n"},
      {"no-usage", end_entity},
      {"no-extensions", "subjectKeyIdentifier=hash\n"},
      {"intermediate", "basicConstraints=critical,CA:TRUE\nkeyUsage=critical,digitalSignature,keyCertSign\n"}};
  for (const auto& [name, extensions] : others) {
    SCOPED_TRACE(name);
    keys_->issue_with(name, extensions);
    const auto refused = signed_with(keys_->key(name));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, FaultKind::bad_file);
    EXPECT_NE(refused.error().where.find(name + ".pem"), std::string::npos) << text(refused.error());
    EXPECT_FALSE(std::filesystem::exists(at("dcc.xml")));
  }
  const std::vector<std::pair<std::string, std::string>> permitted{
      {"mail", signs + "emailProtection,clientAuth\n"},
      {"documents", signs + "critical,1.3.6.1.5.5.7.3.36\n"},
      {"seal", end_entity + "keyUsage=critical,nonRepudiation\n"}};
  for (const auto& [name, extensions] : permitted) {
    SCOPED_TRACE(name);
    keys_->issue_with(name, extensions);
    const auto done = signed_with(keys_->key(name));
    ASSERT_TRUE(done) << text(done.error());
    EXPECT_TRUE(failing().empty());
    for (const NewFile& file : views_) write(file.name, file.bytes);
    std::filesystem::remove(at("dcc.xml"));
  }
}

/// gyrotherm 0.1.0 signed with any certificate of the authority.
TEST_F(Signed, VerifyRefusesCertificateForOtherPurpose) {
  sign();
  ASSERT_TRUE(dcc_holds(bytes("dcc.xml")));
  keys_->issue_with("server", "keyUsage=critical,digitalSignature\nextendedKeyUsage=critical,serverAuth\n");
  run("openssl", {"x509", "-in", *keys_ / "lab.pem", "-noout", "-pubkey", "-out", at("public.pem")});
  /// Another certificate for the same key and name has another purpose. The signature itself is valid.
  run("openssl", {"x509", "-new", "-force_pubkey", at("public.pem"), "-subj", "/C=DE/O=Inertial Laboratory/CN=lab",
                  "-CA", *keys_ / "ca.pem", "-CAkey", *keys_ / "ca.key", "-days", "30", "-extfile",
                  *keys_ / "extensions", "-out", at("other.pem")});
  const auto base64 = [](std::string pem) {
    std::erase(pem, '\n');
    return pem.substr(27, pem.size() - 27 - 25);
  };
  std::string dcc = bytes("dcc.xml");
  const std::string old = base64(bytes_of(*keys_ / "lab.pem")), other = base64(bytes("other.pem"));
  ASSERT_NE(dcc.find(old), std::string::npos);
  dcc.replace(dcc.find(old), old.size(), other);
  const auto refused = verify_dcc(dcc, "dcc.xml", keys_->trust());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "dcc.xml");
  EXPECT_NE(refused.error().what.find("extended key usage is TLS Web Server Authentication"), std::string::npos)
      << refused.error().what;
}

TEST_F(Signed, VerifyRefusesCertificateOfOtherReport) {
  sign();
  const std::string other = bytes("dcc.xml");
  CalibrationReport report = sample_calibration();
  report.number = "C-2026-0043";
  write("calibration.json", to_json(report));
  write("report.pdf", pdf_of("Bias 0.0021 deg/h", "page 2"));
  std::filesystem::remove(at("dcc.xml"));
  authorise();
  sign();
  EXPECT_TRUE(failing().empty());
  write("dcc.xml", other);
  EXPECT_EQ(failing(), (std::vector<std::string>{"calibration.json", "report.pdf", "authorisation.json"}));
}

TEST_F(Signed, VerifyRefusesUntrustedSigner) {
  sign();
  EXPECT_EQ(failing(keys_->trust("other-ca")), std::vector<std::string>{"dcc.xml"});
  const auto signer = verify_dcc(bytes("dcc.xml"), "dcc.xml", keys_->trust("other-ca"));
  ASSERT_FALSE(signer);
  EXPECT_NE(signer.error().what.find("the signer is not trusted: unable to get"), std::string::npos);
  EXPECT_FALSE(verify_pdf(at("report.pdf"), keys_->trust("other-ca")));
  EXPECT_TRUE(dcc_holds(bytes("dcc.xml"), keys_->trust("lab"))) << "the certificate of the laboratory is sufficient";
  EXPECT_FALSE(dcc_holds(bytes("dcc.xml"), keys_->trust("colleague")));
}

/// Both signers are trusted, but the report names another signer than the actual one.
TEST_F(Signed, VerifyRefusesNameOfOtherSigner) {
  sign();
  const std::string dcc = bytes("dcc.xml");
  std::string certificate;
  for (const char c : bytes_of(*keys_ / "colleague.pem")) certificate += c == '\n' ? "" : std::string(1, c);
  certificate = certificate.substr(27, certificate.size() - 27 - 25);
  const std::string element = "<ds:X509Certificate>" + certificate + "</ds:X509Certificate>";
  std::string first = dcc, second = dcc;
  first.insert(first.find("<ds:X509Certificate>"), element);
  second.insert(second.find("</ds:X509Data>"), element);
  EXPECT_FALSE(dcc_holds(first));
  EXPECT_FALSE(dcc_holds(second));
}

TEST_F(Signed, PdfUsesExistingSignatureField) {
  write("report.pdf", pdf_of("Bias 0.0021 deg/h", "page 2", true));
  const auto nobody = verify_pdf(at("report.pdf"), keys_->trust());
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().what, "is not signed exactly once");
  authorise();
  sign();
  EXPECT_TRUE(failing().empty());
  EXPECT_LT(bytes("report.pdf").size(), 20'000u);
  EXPECT_NE(bytes("report.pdf").find("/T (Signature)"), std::string::npos);
}

TEST_F(Signed, VerifyReportsPdfOfOtherSigner) {
  ASSERT_TRUE(sign_pdf(at("report.pdf"), at("by-colleague.pdf"), keys_->key("colleague"), "x"));
  write("report.pdf", bytes("by-colleague.pdf"));
  std::filesystem::remove(at("by-colleague.pdf"));
  authorise();
  const auto refused = signed_with(keys_->key("lab"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(text(refused.error()), at("report.pdf") + ": is already signed or is not a PDF");
  for (const char* name : {"report.html", "calibration.json", "authorisation.json"}) std::filesystem::remove(at(name));
  const auto dcc = make_dcc(sample_calibration(), {.files = {{"report.pdf", sha256(bytes("report.pdf"))}}});
  ASSERT_TRUE(dcc);
  const auto signed_dcc = sign_dcc(*dcc, keys_->key("lab"));
  ASSERT_TRUE(signed_dcc) << text(signed_dcc.error());
  write("dcc.xml", *signed_dcc);
  EXPECT_EQ(failing(), (std::vector<std::string>{"calibration.json", "report.pdf"}));
}

TEST_F(Signed, VerifiesOnGivenDayOfValidity) {
  sign();
  Trust trust = keys_->trust();
  trust.on_day = "2015-01-01";
  EXPECT_EQ(failing(trust), std::vector<std::string>{"dcc.xml"});
  EXPECT_FALSE(verify_pdf(at("report.pdf"), trust));
  trust.on_day = "never";
  const auto found = verify_report(folder_path(), trust);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, FaultKind::usage);
}

/// The clock of the signature, and the day of the verification, are before the authorisation.
TEST_F(Signed, RefusesTimesBeforeAuthorisation) {
  CalibrationReport report = sample_calibration();
  report.authorised->utc = "2998-06-01T12:00:00Z";
  write("calibration.json", to_json(report));
  authorise();
  const auto refused = signed_with(keys_->key("lab"), "2998-06-01T11:59:59Z");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::usage);
  EXPECT_FALSE(*is_signed(folder_path()));
  sign();
  const auto signed_utc = find_signing_time(at("report.pdf"));
  ASSERT_TRUE(signed_utc && *signed_utc);
  EXPECT_TRUE(std::regex_match(**signed_utc, std::regex(R"(20\d\d-\d\d-\d\dT\d\d:\d\d:\d\dZ)"))) << **signed_utc;
  EXPECT_EQ(failing(), std::vector<std::string>{"report.pdf"}) << "the clock of pdfsig is that of this computer";
  Trust trust = keys_->trust();
  trust.on_day = (*signed_utc)->substr(0, 10);
  EXPECT_EQ(failing(trust), (std::vector<std::string>{"report.pdf", "authorisation"}));
}

/// The certificate is valid on both days, but the signature did not exist on the first.
TEST_F(Signed, RefusesSignatureAfterDayOfVerification) {
  CalibrationReport report = sample_calibration();
  report.authorised->utc = "2020-01-01T12:00:00Z";
  write("calibration.json", to_json(report));
  authorise();
  const std::time_t now = std::time(nullptr);
  constexpr int kDay_s = 86400;
  constexpr const char* kOfOpenssl = "%Y%m%d%H%M%SZ";
  const auto issued = keys_->issue_again(at("ca"), {"-startdate", utc_text(now - 30 * kDay_s, kOfOpenssl), "-enddate",
                                                    utc_text(now + 30 * kDay_s, kOfOpenssl)});
  const std::string moved = *keys_ / "month.pem";
  std::filesystem::copy_file(issued, moved);
  std::filesystem::remove_all(at("ca"));
  const auto done = signed_with({.key_file = *keys_ / "lab.key", .certificate_file = moved});
  ASSERT_TRUE(done) << text(done.error());
  Trust trust{.certificates_file = moved};  // the authority is valid only from now on
  for (const int days : {-20, -2}) {
    trust.on_day = utc_text(now + days * kDay_s, "%Y-%m-%d");
    EXPECT_EQ(failing(trust), std::vector<std::string>{"report.pdf"}) << *trust.on_day;
  }
  for (const int days : {1, 20}) {
    trust.on_day = utc_text(now + days * kDay_s, "%Y-%m-%d");
    EXPECT_TRUE(failing(trust).empty()) << *trust.on_day;
  }
}

TEST_F(Signed, RefusesSymbolicLinks) {
  const std::string elsewhere = at("../elsewhere-" + std::filesystem::path(folder_path()).filename().string());
  const auto replace_by_link = [&](const char* name) {
    std::filesystem::rename(at(name), elsewhere);
    std::filesystem::create_symlink(elsewhere, at(name));
  };
  const auto restore = [&](const char* name) { std::filesystem::rename(elsewhere, at(name)); };
  for (const char* name : {kAuthorisationFile, kCalibrationFile, "report.pdf"}) {
    replace_by_link(name);
    const auto refused = signed_with(keys_->key("lab"));
    restore(name);
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.error().kind, FaultKind::bad_file);
    EXPECT_NE(text(refused.error()).find(name), std::string::npos) << text(refused.error());
  }
  sign();
  for (const char* name : {kDccFile, kAuthorisationFile, kCalibrationFile, "report.pdf"}) {
    replace_by_link(name);
    const auto found = failing();
    restore(name);
    EXPECT_EQ(found, std::vector<std::string>{name});
  }
  EXPECT_TRUE(failing().empty());
}

TEST_F(Signed, NamesSignedCopyOfSupersededReport) {
  const auto text_of_dcc = [&] { return verify_report(folder_path(), keys_->trust())->checks.front().text; };
  sign();
  EXPECT_EQ(text_of_dcc().find("as-signed"), std::string::npos);
  std::filesystem::create_directory(at(kSignedCopyFolder));
  std::filesystem::copy_file(at(kDccFile), at("as-signed/dcc.xml"));
  EXPECT_EQ(text_of_dcc().find("as-signed"), std::string::npos) << "signed itself";
  CalibrationReport report = sample_calibration();
  report.state = ReportState::superseded;
  write(kDccFile, make_dcc(report, {}).value());
  EXPECT_TRUE(text_of_dcc().ends_with("verify the report as it was signed, " + at(kSignedCopyFolder))) << text_of_dcc();
  std::filesystem::remove_all(at(kSignedCopyFolder));
  EXPECT_EQ(text_of_dcc().find("as-signed"), std::string::npos);
}

TEST_F(Signed, AcceptsDayOfAuthorisation) {
  CalibrationReport report = sample_calibration();
  sign();
  const std::string today = (**find_signing_time(at("report.pdf"))).substr(0, 10);
  Trust trust = keys_->trust();
  trust.on_day = today;
  for (const auto& path : list_folder(folder_path()))
    if (const std::string name = path.filename(); name == kDccFile || name == kAuthorisationFile)
      std::filesystem::remove(path);
  write("report.pdf", pdf_of("Bias 0.0021 deg/h", "page 2"));
  report.authorised->utc = today + "T00:00:00Z";
  write("calibration.json", to_json(report));
  authorise();
  ASSERT_TRUE(signed_with(keys_->key("lab"), today + "T00:00:00Z"));
  EXPECT_TRUE(failing(trust).empty());
}

/// The result does not depend on the time of day at which the certificate starts and ends.
TEST_F(Signed, VerifiesOnFirstAndLastDayOfCertificate) {
  const SigningKey brief = keys_->key("brief");
  ASSERT_TRUE(signed_with(brief));
  const auto signer = verify_dcc(bytes("dcc.xml"), "dcc.xml", keys_->trust());
  ASSERT_TRUE(signer) << text(signer.error());
  std::tm ends{};
  ASSERT_NE(::strptime(signer->not_after.c_str(), "%b %d %H:%M:%S %Y", &ends), nullptr) << signer->not_after;
  const auto days_after = [last = ::timegm(&ends)](int days) {
    constexpr int kDay_s = 86400;
    Trust trust = keys_->trust();
    const std::time_t at = last + days * kDay_s;
    std::tm day{};
    ::gmtime_r(&at, &day);
    trust.on_day = fmt::format("{:04}-{:02}-{:02}", day.tm_year + 1900, day.tm_mon + 1, day.tm_mday);
    return trust;
  };
  EXPECT_TRUE(failing(days_after(-1)).empty());
  EXPECT_TRUE(failing(days_after(0)).empty());
  EXPECT_EQ(failing(days_after(-2)), std::vector<std::string>{"dcc.xml"});
  EXPECT_EQ(failing(days_after(1)), std::vector<std::string>{"dcc.xml"});
}

TEST_F(Signed, VerifiesOnDayOfCertificateOfMinutes) {
  const std::time_t now = std::time(nullptr);
  constexpr const char* kOfOpenssl = "%Y%m%d%H%M%SZ";
  const auto brief = keys_->issue_again(
      at("ca"), {"-startdate", utc_text(now - 60, kOfOpenssl), "-enddate", utc_text(now + 600, kOfOpenssl)});
  const std::string moved = *keys_ / "minutes.pem";
  std::filesystem::copy_file(brief, moved);
  std::filesystem::remove_all(at("ca"));
  const auto done = signed_with({.key_file = *keys_ / "lab.key", .certificate_file = moved});
  ASSERT_TRUE(done) << text(done.error());
  Trust trust = keys_->trust();
  trust.on_day = utc_text(now - 60, "%Y-%m-%d");
  EXPECT_TRUE(verify_dcc(bytes("dcc.xml"), "dcc.xml", trust)) << *trust.on_day;
  trust.on_day = utc_text(now + 2 * 86400, "%Y-%m-%d");
  EXPECT_FALSE(verify_dcc(bytes("dcc.xml"), "dcc.xml", trust));
}

TEST_F(Signed, RefusesCertificateSignedWithWeakDigest) {
  const auto weak = keys_->issue_again(at("ca"), {"-md", "sha1", "-days", "30"});
  const auto refused = check_signing_key({.key_file = *keys_ / "lab.key", .certificate_file = weak});
  ASSERT_FALSE(refused);
  EXPECT_EQ(
      text(refused.error()),
      weak + ": is signed with sha1WithRSAEncryption, which no verification accepts; have it issued with SHA-256");
}

TEST_F(Signed, VerifyRefusesSignatureInOtherForm) {
  sign();
  const std::string dcc = bytes("dcc.xml");
  const auto with = [&](const std::string& what, const std::string& instead) {
    std::string other = dcc;
    other.replace(other.find(what), what.size(), instead);
    return other;
  };
  EXPECT_FALSE(dcc_holds(with("Reference URI=\"\"", "Reference URI=\"#item\"")));
  EXPECT_FALSE(dcc_holds(with("</ds:Transforms>", "<ds:Transform Algorithm=\"x\"></ds:Transform></ds:Transforms>")));
  EXPECT_FALSE(dcc_holds(with("rsa-sha256", "hmac-sha256")));
  EXPECT_FALSE(dcc_holds(with("</ds:KeyInfo>", "<ds:KeyValue></ds:KeyValue></ds:KeyInfo>")));
  const std::size_t begins = dcc.find("\n  <ds:Signature"), ends = dcc.find("</ds:Signature>") + 15;
  EXPECT_FALSE(dcc_holds(std::string(dcc).insert(ends, dcc.substr(begins, ends - begins))));
  EXPECT_FALSE(dcc_holds(std::string(dcc).erase(begins, ends - begins)));
  EXPECT_FALSE(dcc_holds(""));
  EXPECT_FALSE(dcc_holds(dcc + dcc));
}

TEST_F(Signed, RequiresPasswordOfLockedKey) {
  SigningKey key = keys_->key("lab");
  key.key_file = *keys_ / "locked.key";
  key.password_file = *keys_ / "wrong-password";
  const auto refused = signed_with(key);
  ASSERT_FALSE(refused);
  EXPECT_EQ(text(refused.error()), key.key_file + ": the password in " + key.password_file + " does not open it");
  key.password_file = *keys_ / "password";
  const auto done = signed_with(key);
  ASSERT_TRUE(done) << text(done.error());
  EXPECT_TRUE(failing().empty());
}

TEST_F(Signed, UnlockedKeySignsWithoutPassword) {
  SigningKey locked = keys_->key("lab");
  locked.key_file = *keys_ / "locked.key";
  locked.password_file = *keys_ / "password";
  const auto unlocked = UnlockedKey::make(locked);
  ASSERT_TRUE(unlocked) << text(unlocked.error());
  EXPECT_EQ(unlocked->key().password_file, "");
  for (const char* bytes : {"first", "second"}) {
    const auto signature = sign_bytes(bytes, unlocked->key());
    ASSERT_TRUE(signature) << text(signature.error());
    EXPECT_TRUE(verify_bytes(bytes, *signature, bytes, {.certificates_file = locked.certificate_file}));
  }
}

TEST_F(Signed, RefusesKeyOfOtherCertificate) {
  SigningKey key = keys_->key("lab");
  key.certificate_file = *keys_ / "colleague.pem";
  const std::string before = bytes("report.pdf");
  const auto refused = signed_with(key);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("is not the certificate of the key"), std::string::npos);
  EXPECT_EQ(bytes("report.pdf"), before);
}

TEST_F(Signed, NamesFileThatIsNotKeyOrCertificate) {
  const auto refusal = [](const SigningKey& key) {
    const auto checked = check_signing_key(key);
    EXPECT_FALSE(checked);
    return checked ? std::string() : text(checked.error());
  };
  const SigningKey good = keys_->key("lab");
  EXPECT_TRUE(check_signing_key(good));
  EXPECT_EQ(refusal({.key_file = good.certificate_file, .certificate_file = good.key_file}),
            good.key_file + ": contains \"PRIVATE KEY\", expected a certificate in PEM");
  EXPECT_EQ(refusal({.key_file = good.certificate_file, .certificate_file = good.certificate_file}),
            good.certificate_file + ": contains \"CERTIFICATE\", expected a private key in PEM");
  const std::string der = at("lab.der"), empty = at("empty"), table = at("table.csv");
  run("openssl", {"x509", "-in", good.certificate_file, "-outform", "DER", "-out", der});
  write("empty", "");
  write("table.csv", "0,1\n");
  EXPECT_EQ(
      refusal({.key_file = good.key_file, .certificate_file = der}),
      der + ": is a binary file, such as DER or PKCS #12, expected a certificate in PEM; \"openssl\" converts it");
  EXPECT_EQ(refusal({.key_file = empty, .certificate_file = good.certificate_file}),
            empty + ": is empty, expected a private key in PEM");
  EXPECT_EQ(refusal({.key_file = table, .certificate_file = good.certificate_file}),
            table + ": contains no PEM text, expected a private key in PEM");
  EXPECT_FALSE(check_trusted_file(good.key_file));
  EXPECT_TRUE(check_trusted_file(good.certificate_file));
}

TEST_F(Signed, NamesCauseWhenPasswordIsMissing) {
  SigningKey key = keys_->key("lab");
  key.key_file = *keys_ / "locked.key";
  key.password_file = at("none");
  const auto missing = check_signing_key(key);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().where, key.password_file);
  for (const auto* content : {"", "\na secret\n"}) {
    write("none", content);
    const auto refused = check_signing_key(key);
    ASSERT_FALSE(refused);
    EXPECT_EQ(text(refused.error()), key.password_file + ": expected the password of the key in the first line");
  }
}

TEST_F(Signed, RefusesExpiredCertificateBeforeItSigns) {
  const auto expired = keys_->issue_again(at("ca"), {"-startdate", "20200101000000Z", "-enddate", "20210101000000Z"});
  const auto refused = check_signing_key({.key_file = *keys_ / "lab.key", .certificate_file = expired});
  ASSERT_FALSE(refused);
  EXPECT_EQ(text(refused.error()), expired + ": cannot be used for signing today: certificate has expired");
}

TEST_F(Signed, RefusesKeyThatIsNotRsa) {
  const std::string key = *keys_ / "ec.key", certificate = *keys_ / "ec.pem";
  run("openssl", {"req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-keyout", key,
                  "-out", certificate, "-days", "30", "-subj", "/CN=ec", "-addext",
                  "basicConstraints=critical,CA:FALSE", "-addext", "keyUsage=critical,digitalSignature"});
  const auto refused = signed_with({.key_file = key, .certificate_file = certificate});
  ASSERT_FALSE(refused);
  EXPECT_EQ(text(refused.error()), key + ": is not an RSA key");
}

/// The disk becomes full while the last file is written.
TEST_F(Signed, LeavesFolderUnchangedWhenDiskIsFull) {
  const std::string before = bytes("report.pdf");
  const auto refused = sign_report(
      folder_path(), keys_->key("lab"),
      [&](const CalibrationReport&, const std::vector<std::string>&) {
        std::filesystem::create_directories(at("dcc.xml.new/in-the-way"));
        return views_;
      },
      kLateUtc);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::storage);
  EXPECT_EQ(bytes("report.pdf"), before);
  EXPECT_FALSE(std::filesystem::exists(at("report.pdf.new")));
  std::filesystem::remove_all(at("dcc.xml.new"));
  sign();
  EXPECT_TRUE(failing().empty());
}

TEST_F(Signed, LeavesNoKeyBehind) {
  tests::TestFolder place;
  ASSERT_EQ(::setenv("XDG_RUNTIME_DIR", std::filesystem::path(place / "x").parent_path().c_str(), 1), 0);
  sign();
  EXPECT_TRUE(failing().empty());
  EXPECT_TRUE(list_folder(std::filesystem::path(place / "x").parent_path()).empty());
  ::unsetenv("XDG_RUNTIME_DIR");
}

TEST_F(Signed, RefusesDraft) {
  for (const ReportState state : {ReportState::draft, ReportState::superseded}) {
    CalibrationReport report = sample_calibration();
    report.state = state;
    write("calibration.json", to_json(report));
    authorise();
    const auto refused = signed_with(keys_->key("lab"));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, FaultKind::bad_file);
  }
}

TEST_F(Signed, RefusesSignedReport) {
  sign();
  const auto again = signed_with(keys_->key("lab"));
  ASSERT_FALSE(again);
  EXPECT_EQ(text(again.error()), at("dcc.xml") + ": is already signed");
  EXPECT_TRUE(failing().empty());
  std::filesystem::remove(at("dcc.xml"));
  const auto pdf = signed_with(keys_->key("lab"));
  ASSERT_FALSE(pdf);
  EXPECT_NE(text(pdf.error()).find("changed report.pdf"), std::string::npos) << text(pdf.error());
}

TEST_F(Signed, NamesPackageOfMissingProgram) {
  const std::string path = std::getenv("PATH");
  ASSERT_EQ(::setenv("PATH", "/nowhere", 1), 0);
  const auto refused = signed_with(keys_->key("lab"));
  ::setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(refused);
  EXPECT_NE(text(refused.error()).find("package poppler-utils"), std::string::npos) << text(refused.error());
}

}  // namespace
}  // namespace gyrotherm::report
