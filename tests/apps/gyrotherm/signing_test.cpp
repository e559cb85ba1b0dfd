// SPDX-License-Identifier: Apache-2.0
/// A laboratory signs a report, and its customer verifies it.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "acquisition/record/record.hpp"
#include "acquisition/record/run_file.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"
#include "report/calibration.hpp"
#include "tests/apps/gyrotherm/program.hpp"
#include "tests/apps/gyrotherm/small_record.hpp"

namespace gyrotherm::app {
namespace {

report::CalibrationReport report_on(const Folder& folder) {
  const auto used = [&](const char* role, const std::string& name) {
    return report::UsedFile{
        .role = role, .name = name, .sha256 = sha256(*read_text_file(folder / name, kLargestTable))};
  };
  report::CalibrationReport report;
  report.number = "C-1";
  report.state = report::ReportState::draft;
  report.laboratory = {.name = "House of Gyros", .city = "Berlin", .country = "DE"};
  report.customer.name = "Harbour Pilots";
  report.people = {{"B. Berg", "authorising", ""}};
  report.item.name = record::read_info(folder / "record.db").value().units.front().name;
  report.item.serial_number = "0042";
  report.begun = report.ended = "2020-11-20";
  report.issued = civil_time(SteadyClock().now().utc).substr(0, 10);
  report.cluster_length_s = 100;
  report.results = {{.group = report::Group::bias,
                     .key = "stabilised_bias",
                     .columns = {{"bias", "°/h", {report::value_with_uncertainty(0.1, 0.01, 30)}}}}};
  report.files = {used("record", "record.db"), used("model_left", "model.json")};
  report.files.push_back({.role = "profile", .name = "elsewhere.toml"});
  return report;
}

/// Record, model and signed report.
class Signing : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    make_small_model(*folder_);
    std::filesystem::create_directory(*folder_ / "report");
    std::ofstream(*folder_ / "report/calibration.json") << to_json(report_on(*folder_));
    std::ofstream(*folder_ / "laboratory.toml")
        << "schema = \"gyrotherm-laboratory/1\"\nname = \"House of Gyros\"\n[[person]]\nname = \"B. Berg\"\n"
           "role = \"authorising\"\n";
    std::ofstream(*folder_ / "report/calibration.html") << "a view in this language is rendered";
    const auto authorised =
        gyrotherm_with("report authorise " + (*folder_ / "report") + " --by 'B. Berg' --without-sources --laboratory " +
                       (*folder_ / "laboratory.toml"));
    ASSERT_EQ(authorised.exit_code, 0) << authorised.err;
    const auto keys = shell("cd " + (*folder_ / ".") +
                            " && openssl req -x509 -newkey rsa:2048 -nodes -keyout lab.key -out lab.pem -days 30 "
                            "-subj '/CN=Our laboratory' -addext basicConstraints=critical,CA:FALSE -addext "
                            "keyUsage=critical,digitalSignature && openssl req -x509 -newkey rsa:2048 -nodes -keyout "
                            "other.key -out other.pem -days 30 -subj /CN=Other");
    ASSERT_EQ(keys.exit_code, 0) << keys.err;
    expect_refused_when_changed_after_authorisation();
    std::filesystem::copy(*folder_ / "report", *folder_ / "unsigned");
    const auto done = gyrotherm_with(sign_command());
    ASSERT_EQ(done.exit_code, 0) << done.err;
    ready_ = true;
  }
  /// Checks that a file changed between authorisation and signature is never signed, then restores the file.
  static void expect_refused_when_changed_after_authorisation() {
    const auto refused = [](const std::string& name, const std::string& bytes, const std::string& why) {
      const std::string path = *folder_ / ("report/" + name), before = read_text_file(path, kLargestTable).value_or("");
      std::ofstream(path, std::ios::binary) << bytes;
      const auto ran = gyrotherm_with(sign_command());
      EXPECT_EQ(ran.exit_code, 4) << name;
      EXPECT_NE(ran.err.find(why + " " + name), std::string::npos) << ran.err;
      before.empty() ? (void)std::filesystem::remove(path) : (void)(std::ofstream(path, std::ios::binary) << before);
    };
    for (const char* name : {"calibration.json", "calibration.html", "calibration.csv", "calibration.pdf", "dcc.xml"})
      refused(name, read_text_file(*folder_ / ("report/" + std::string(name)), kLargestTable).value_or("") + "\n",
              "changed");
    for (const char* name : {"note.html", "zz.pdf", "calibration.de.csv"})
      refused(name, "lies", "not part of the report");
  }
  static std::string sign_command() {
    return "report sign " + (*folder_ / "report") + " --key " + (*folder_ / "lab.key") + " --certificate " +
           (*folder_ / "lab.pem");
  }
  static void TearDownTestSuite() { delete folder_; }
  void SetUp() override { ASSERT_TRUE(ready_); }

  static Ran verify(const std::string& options, const std::string& trusted = "lab.pem") {
    return gyrotherm_with("report verify " + (*folder_ / "report") + " --trusted " + (*folder_ / trusted) + " " +
                          options);
  }
  /// Verifies after one byte of a file was changed, then restores the file.
  static Ran verify_with_changed_byte(const std::string& name) {
    const std::string before = *read_text_file(*folder_ / name, kLargestTable);
    std::string after = before;
    after[after.size() / 2] ^= 1;
    std::ofstream(*folder_ / name, std::ios::binary) << after;
    const Ran ran = verify("");
    std::ofstream(*folder_ / name, std::ios::binary) << before;
    return ran;
  }

  static inline Folder* folder_ = nullptr;
  static inline bool ready_ = false;
};

TEST_F(Signing, IsVerifiedByCustomer) {
  const auto ran = verify("");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.out.find("holds      dcc.xml: signed by CN=Our laboratory"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("holds      record.db: is the file on which the report is based, and all of its"),
            std::string::npos);
  EXPECT_NE(ran.out.find("holds      model.json"), std::string::npos);
  EXPECT_NE(ran.out.find("not there  elsewhere.toml"), std::string::npos);
  EXPECT_NE(ran.err.find("report C-1 matches what was signed"), std::string::npos) << ran.err;
}

/// Sets a variable of the environment for the programs that a test starts.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    ::setenv(name, value.c_str(), 1);
  }
  ~Variable() { before_ ? ::setenv(name_, before_->c_str(), 1) : ::unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

/// xmlsec1 waits when it is about to sign, with the decrypted key.
TEST_F(Signing, LeavesNoKeyWhenInterrupted) {
  const std::string folder = *folder_ / "unsigned", programs = *folder_ / "programs", reached = *folder_ / "reached";
  std::filesystem::create_directory(programs);
  std::ofstream(programs + "/xmlsec1") << "#!/bin/sh\n: > '" << reached << "'\nexec sleep 60\n";
  std::filesystem::permissions(programs + "/xmlsec1", std::filesystem::perms::owner_all);
  ASSERT_EQ(shell("cd " + (*folder_ / ".") +
                  " && openssl pkey -in lab.key -aes256 -passout pass:secret -out locked.key "
                  "&& echo secret > password")
                .exit_code,
            0);
  const auto files = list_folder(folder);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const std::string temporary = *folder_ / ("temporary-" + std::to_string(signal));
    std::filesystem::create_directory(temporary);
    std::filesystem::remove(reached);
    const Variable path("PATH", programs + ":" + std::getenv("PATH")), place("TMPDIR", temporary),
        runtime("XDG_RUNTIME_DIR", temporary);
    Background signing({"report", "sign", folder, "--key", *folder_ / "locked.key", "--certificate",
                        *folder_ / "lab.pem", "--password-file", *folder_ / "password"},
                       *folder_ / "out");
    while (signing.is_running() && !std::filesystem::exists(reached))
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ASSERT_TRUE(signing.is_running()) << signing.output();
    signing.signal(signal);
    EXPECT_EQ(signing.wait(), -signal) << signing.output();
    EXPECT_TRUE(std::filesystem::is_empty(temporary));
    EXPECT_EQ(list_folder(folder), files);
  }
}

TEST_F(Signing, IsNotAuthorisedWithLogoMissingFromPdf) {
  const std::string folder = *folder_ / "logo";
  std::filesystem::create_directory(folder);
  auto report = report_on(*folder_);
  report.logo =
      report::Logo{.media_type = "image/svg+xml", .base64 = "PHN2Zz48aW1hZ2UgaHJlZj0iaHR0cDovL2EvYi5wbmciLz48L3N2Zz4="};
  std::ofstream(folder + "/calibration.json") << to_json(report);
  std::ofstream(folder + "/calibration.html") << "a view in this language is rendered";
  const auto refused = gyrotherm_with("report authorise " + folder + " --by 'B. Berg' --without-sources --laboratory " +
                                      (*folder_ / "laboratory.toml"));
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_NE(refused.err.find("calibration.pdf: laboratory.logo: "), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(folder + "/authorisation.json"));
}

TEST_F(Signing, IsVerifiedAsJson) {
  const auto found = nlohmann::json::parse(verify("--json").out);
  EXPECT_EQ(found["holds"], true);
  EXPECT_EQ(found["report"], "C-1");
  EXPECT_EQ(found["signer"]["subject"], "CN=Our laboratory");
  EXPECT_EQ(found["checks"].size(), 9u);
}

TEST_F(Signing, NamesForeignAndMissingFiles) {
  const std::string page = *folder_ / "report/calibration.html", note = *folder_ / "report/Calibration report.pdf";
  std::filesystem::copy_file(*folder_ / "report/calibration.pdf", note);
  std::filesystem::rename(page, *folder_ / "page.html");
  const auto ran = verify(""), as_json = verify("--json");
  std::filesystem::rename(*folder_ / "page.html", page);
  std::filesystem::remove(note);
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.out.find("MISSING    calibration.html: "), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("FOREIGN    Calibration report.pdf: "), std::string::npos) << ran.out;
  EXPECT_NE(ran.err.find("2 of 10 checks fail"), std::string::npos) << ran.err;
  EXPECT_EQ(nlohmann::json::parse(as_json.out)["holds"], false);
}

TEST_F(Signing, FailsForChangedFiles) {
  for (const char* name : {"report/dcc.xml", "report/calibration.json", "record.db", "model.json"}) {
    const auto ran = verify_with_changed_byte(name);
    EXPECT_EQ(ran.exit_code, 4) << name;
    EXPECT_NE(ran.out.find("FAILS      " + std::filesystem::path(name).filename().string()), std::string::npos)
        << ran.out;
  }
  EXPECT_EQ(verify("").exit_code, 0);
}

/// A continuation file must not add rows that were never signed.
TEST_F(Signing, CoversAllFilesOfRecord) {
  const std::string manifest = *folder_ / "record.db.sha256", bytes = *read_text_file(manifest);
  std::filesystem::remove(manifest);
  {
    const auto info = record::read_info(*folder_ / "record.db").value();
    const record::Continuation continuation{.part = 2, .before = "record.db", .from = 100, .cause = "tested"};
    auto part = record::RunFile::create(*folder_ / "record.2.db", info, continuation);
    ASSERT_TRUE(part) << text(part.error());
    ASSERT_TRUE(part->begin() && part->insert_event(-1, {{}, EventKind::fault, "goes on"}) &&
                part->replace_frames({}) && part->commit());
  }
  const auto ran = verify("");
  std::filesystem::remove(*folder_ / "record.2.db");
  std::ofstream(manifest) << bytes;
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.out.find("FAILS      record.db: has 2 files, but the report names 1"), std::string::npos) << ran.out;
}

/// A file that was signed is a file of the folder, also if a link leads to the same bytes.
TEST_F(Signing, RefusesSymbolicLinkToSignedFile) {
  for (const char* name : {"calibration.csv", "calibration.pdf", "authorisation.json"}) {
    const std::string path = *folder_ / ("report/" + std::string(name)), outside = *folder_ / name;
    std::filesystem::rename(path, outside);
    std::filesystem::create_symlink(outside, path);
    const auto ran = verify("");
    std::filesystem::remove(path);
    std::filesystem::rename(outside, path);
    EXPECT_EQ(ran.exit_code, 4) << name;
    EXPECT_NE(ran.out.find("FAILS      " + std::string(name) + ": is a symbolic link"), std::string::npos) << ran.out;
  }
}

/// Files with the names of a record's companions belong to the report only beside that record.
TEST_F(Signing, AcceptsManifestAndStatusOnlyBesideRecord) {
  const std::string report = *folder_ / "report/";
  for (const char* name : {"record.db.sha256", "record.db.status"}) std::ofstream(report + name) << "evil\n";
  std::filesystem::create_directory(report + "model.json");
  const auto smuggled = verify("");
  std::filesystem::remove(report + "model.json");
  EXPECT_EQ(smuggled.exit_code, 4);
  for (const char* name : {"record.db.sha256", "record.db.status", "model.json"})
    EXPECT_NE(smuggled.out.find("FOREIGN    " + std::string(name)), std::string::npos) << smuggled.out;
  std::filesystem::copy_file(*folder_ / "record.db", report + "record.db");
  EXPECT_EQ(verify("").exit_code, 4) << "the manifest is not that of the record";
  std::filesystem::copy_file(*folder_ / "record.db.sha256", report + "record.db.sha256",
                             std::filesystem::copy_options::overwrite_existing);
  const auto genuine = verify("");
  EXPECT_EQ(genuine.exit_code, 0) << genuine.out;
  EXPECT_NE(genuine.out.find("unsigned   record.db.status"), std::string::npos) << genuine.out;
  for (const char* name : {"record.db", "record.db.sha256", "record.db.status"}) std::filesystem::remove(report + name);
}

TEST_F(Signing, FindsRecordsInGivenFolderAndTwoFoldersAbove) {
  const std::string deep = *folder_ / "lot/u1", elsewhere = *folder_ / "elsewhere";
  std::filesystem::create_directories(*folder_ / "lot");
  std::filesystem::copy(*folder_ / "report", deep, std::filesystem::copy_options::recursive);
  const auto verify_deep = [&](const std::string& options) {
    return gyrotherm_with("report verify " + deep + " --trusted " + (*folder_ / "lab.pem") + options);
  };
  EXPECT_NE(verify_deep("").out.find("holds      record.db"), std::string::npos) << "two folders above";
  std::filesystem::create_directory(elsewhere);
  std::filesystem::rename(*folder_ / "model.json", elsewhere + "/model.json");
  EXPECT_NE(verify_deep("").out.find("not there  model.json"), std::string::npos);
  EXPECT_NE(verify_deep(" --records " + elsewhere).out.find("holds      model.json"), std::string::npos);
  std::ofstream(*folder_ / "lot/model.json") << "another model";
  EXPECT_EQ(verify_deep(" --records " + elsewhere).exit_code, 0) << "the first one with the right digest counts";
  std::ofstream(deep + "/model.json") << "another model";
  EXPECT_EQ(verify_deep(" --records " + elsewhere).exit_code, 4) << "a file beside the report always counts";
  std::filesystem::rename(elsewhere + "/model.json", *folder_ / "model.json");
  std::filesystem::remove_all(*folder_ / "lot");
}

TEST_F(Signing, StatesThatSourcesWereNotCompared) {
  const auto ran = verify("");
  EXPECT_NE(ran.out.find("the report was authorised without a comparison with its records"), std::string::npos)
      << ran.out;
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "report/sources.json"));
}

TEST_F(Signing, RefusesShortKey) {
  const auto keys = shell("cd " + (*folder_ / ".") +
                          " && openssl req -x509 -newkey rsa:1024 -nodes -keyout short.key -out short.pem -days 30 "
                          "-subj '/CN=Short' -addext basicConstraints=critical,CA:FALSE -addext "
                          "keyUsage=critical,digitalSignature");
  ASSERT_EQ(keys.exit_code, 0) << keys.err;
  const auto ran = gyrotherm_with("report sign " + (*folder_ / "report") + " --key " + (*folder_ / "short.key") +
                                  " --certificate " + (*folder_ / "short.pem"));
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(verify("").out.find("the RSA key of the signer has 2048 bits; 3072 or more are recommended"),
            std::string::npos);
}

TEST_F(Signing, RefusesUntrustedSigner) {
  const auto ran = verify("", "other.pem");
  EXPECT_EQ(ran.exit_code, 4);
  EXPECT_NE(ran.out.find("FAILS      dcc.xml: the signer is not trusted"), std::string::npos) << ran.out;
}

TEST_F(Signing, RequiresTrustedCertificate) {
  EXPECT_EQ(gyrotherm_with("report verify " + (*folder_ / "report")).exit_code, 2);
  EXPECT_EQ(gyrotherm_with("report").exit_code, 2);
}

/// The report has views in two languages, and an authorised report that replaces it.
TEST_F(Signing, KeepsSignedFilesOfSupersededReport) {
  const auto in = [](const std::string& name) { return *folder_ / name; };
  const auto read = [&](const std::string& name) { return read_text_file(in(name), kLargestTable).value_or(""); };
  report::CalibrationReport next = report_on(*folder_);
  next.number = "C-2";
  next.replaces = report::OtherReport{"C-1", "", {"a year", "ein Jahr"}};
  for (const auto& [name, made] : {std::pair{"issued", report_on(*folder_)}, {"next", next}}) {
    std::filesystem::create_directory(in(name));
    for (const char* file : {"/calibration.html", "/calibration.de.html"})
      std::ofstream(in(name) + file) << "a view in this language is rendered";
    std::ofstream(in(name) + "/calibration.json") << to_json(made);
    const auto done = gyrotherm_with("report authorise " + in(name) +
                                     " --by 'B. Berg' --without-sources --laboratory " + in("laboratory.toml"));
    ASSERT_EQ(done.exit_code, 0) << done.err;
  }
  const auto done =
      gyrotherm_with("report sign " + in("issued") + " --key " + in("lab.key") + " --certificate " + in("lab.pem"));
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const std::string supersede = "report supersede " + in("issued") + " --by " + in("next");
  const auto refused = [&] {
    const auto ran = gyrotherm_with(supersede);
    EXPECT_NE(ran.exit_code, 0);
    EXPECT_EQ(read("issued/calibration.json").find("C-2"), std::string::npos);
    return ran.err;
  };
  for (const std::string name : {"issued", "next"}) {
    const std::string sound = read(name + "/calibration.json");
    std::ofstream(in(name + "/calibration.json"), std::ios::app) << "\n";
    EXPECT_NE(refused().find("calibration.json: was changed after it was authorised or signed"), std::string::npos);
    std::ofstream(in(name + "/calibration.json")) << sound;
  }
  EXPECT_FALSE(std::filesystem::exists(in("issued/as-signed")));
  const std::string incomplete = "as-signed: is not a complete copy of the signed report";
  std::filesystem::create_directory(in("issued/as-signed"));
  EXPECT_NE(refused().find(incomplete), std::string::npos);
  for (const auto& path : list_folder(in("issued")))
    if (std::filesystem::is_regular_file(path))
      std::filesystem::copy_file(path, in("issued/as-signed/" + path.filename().string()));
  for (const std::string name : {"calibration.csv", "calibration.de.pdf", "dcc.xml"}) {
    const std::string copy = "issued/as-signed/" + name, sound = read(copy);
    std::ofstream(in(copy)) << sound.substr(0, sound.size() / 2);
    EXPECT_NE(refused().find(incomplete), std::string::npos) << name;
    std::ofstream(in(copy)) << sound;
  }
  std::filesystem::remove_all(in("issued/as-signed"));
  for (const char* page : {"issued/calibration.html", "issued/calibration.de.html"}) std::filesystem::remove(in(page));
  const std::string signed_pdf = read("issued/calibration.de.pdf");
  const auto marked = gyrotherm_with(supersede);
  ASSERT_EQ(marked.exit_code, 0) << marked.err;
  EXPECT_EQ(read("issued/as-signed/calibration.de.pdf"), signed_pdf);
  EXPECT_FALSE(std::filesystem::exists(in("issued/as-signed.new")));
  for (const char* name : {"calibration.pdf", "calibration.de.pdf"})
    EXPECT_NE(shell("pdftotext " + in("issued/") + name + " - | grep -c C-2").out, "0\n")
        << "a PDF without its page must not remain valid: " << name;
}

}  // namespace
}  // namespace gyrotherm::app
