// SPDX-License-Identifier: Apache-2.0
/// A laboratory validates the installed program and its rig.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/file.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

/// A validation, made once, of a virtual rig that is too warm for every shipped program.
class Validation : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    auto rig = *read_text_file(GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml");
    for (auto at = rig.find("\"../"); at != rig.npos; at = rig.find("\"../"))
      rig.replace(at, 4, "\"" GYROTHERM_SOURCE_DIR "/profiles/");
    const auto lowest = rig.find("lowest = \"");
    rig.replace(lowest, rig.find('\n', lowest) - lowest, "lowest = \"10 °C\"");
    std::ofstream(*folder_ / "warm.toml") << rig;
    ran_ = gyrotherm_with("validate --rig " + (*folder_ / "warm.toml") + " --by 'A. Operator' --out " +
                          (*folder_ / "validation"));
    const auto keys = shell("cd " + (*folder_ / ".") +
                            " && openssl req -x509 -newkey rsa:2048 -nodes -keyout lab.key -out lab.pem -days 30 -subj "
                            "/CN=laboratory -addext basicConstraints=critical,CA:FALSE -addext "
                            "keyUsage=critical,digitalSignature");
    ASSERT_EQ(keys.exit_code, 0) << keys.err;
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string path(const std::string& name) { return *folder_ / ("validation/" + name); }
  static nlohmann::json protocol() { return nlohmann::json::parse(*read_text_file(path("validation.json"))); }

  static inline Folder* folder_ = nullptr;
  static inline Ran ran_;
};

TEST_F(Validation, MeetsEachRequirementOrSaysWhyNot) {
  const auto validation = protocol();
  EXPECT_EQ(validation["schema"], "gyrotherm-validation/1");
  EXPECT_EQ(validation["operator"], "A. Operator");
  EXPECT_EQ(validation["simulated"], true);
  ASSERT_EQ(validation["results"].size(), 15u);
  for (const auto& result : validation["results"]) {
    const auto id = result["id"].get<std::string>();
    if (id == "OQ-7") {
      EXPECT_EQ(result["verdict"], "failed") << result.dump(2);
    } else if (id.starts_with("OQ") || id == "IQ-1" || id == "IQ-2") {
      // A build machine may have no synchronised clock, a small disk, or limits.
      EXPECT_NE(result["verdict"], "failed") << result.dump(2);
    }
    EXPECT_NE(result["evidence"], "") << id;
    EXPECT_NE(result["evidence_de"], "") << id;
  }
  EXPECT_EQ(validation["verdict"], "failed");
  EXPECT_EQ(ran_.exit_code, 1) << ran_.err;
  EXPECT_NE(ran_.out.find("SIMULATED"), std::string::npos);
}

TEST_F(Validation, HasPagesInBothLanguages) {
  const auto english = *read_text_file(path("validation.en.html")),
             german = *read_text_file(path("validation.de.html"));
  for (const char* text : {"UNSIGNED", "SIMULATED", "A run records each second of its profile."})
    EXPECT_NE(english.find(text), std::string::npos) << text;
  EXPECT_NE(german.find("Ein Lauf zeichnet jede Sekunde seines Profils auf."), std::string::npos);
  EXPECT_NE(german.find("Registerbeschreibungen"), std::string::npos);
  for (const char* text : {"were recorded", "is writable", "can be read", "no limit", "none is overdue", "an altered",
                           "rig is virtual", "within the limits"})
    EXPECT_EQ(german.find(text), std::string::npos) << text;
  EXPECT_NE(german.find("der Prüfstand ist virtuell"), std::string::npos) << "the reason of \"nicht anwendbar\"";
}

TEST_F(Validation, RefusesAFolderThatExists) {
  const auto again = gyrotherm_with("validate --rig virtual --out " + (*folder_ / "validation"));
  EXPECT_EQ(again.exit_code, 2);
}

TEST_F(Validation, IsSignedAndVerified) {
  const auto copy = *folder_ / "signed";
  std::filesystem::copy(*folder_ / "validation", copy, std::filesystem::copy_options::recursive);
  const auto verify = "report verify " + copy + " --trusted " + (*folder_ / "lab.pem");
  EXPECT_EQ(gyrotherm_with(verify).exit_code, 4) << "unsigned";
  const auto sign =
      "report sign " + copy + " --key " + (*folder_ / "lab.key") + " --certificate " + (*folder_ / "lab.pem");
  const auto done = gyrotherm_with(sign);
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(gyrotherm_with(sign).exit_code, 2) << "signed already";
  const auto holds = gyrotherm_with(verify);
  EXPECT_EQ(holds.exit_code, 0) << holds.err;
  EXPECT_NE(holds.out.find("CN=laboratory"), std::string::npos) << holds.out;
  EXPECT_NE(holds.out.find("validation.json: signed by"), std::string::npos) << holds.out;
  for (const char* file : {"validation.json", "validation.p7s"}) {
    const auto sound = *read_text_file(copy + "/" + file);
    auto changed = sound;
    changed[changed.size() / 2] = changed[changed.size() / 2] == 'x' ? 'y' : 'x';
    std::ofstream(copy + "/" + file) << changed;
    EXPECT_EQ(gyrotherm_with(verify).exit_code, 4) << file;
    std::ofstream(copy + "/" + file) << sound;
  }
  EXPECT_EQ(gyrotherm_with(verify).exit_code, 0);
}

/// The protocol was written and signed by a version with other pages. Only the JSON file is signed.
TEST_F(Validation, IsVerifiedWithPagesOfAnotherVersion) {
  const auto copy = *folder_ / "older";
  std::filesystem::copy(*folder_ / "validation", copy, std::filesystem::copy_options::recursive);
  std::ofstream(copy + "/validation.de.html", std::ios::app) << "<!-- older -->";
  const auto sign =
      "report sign " + copy + " --key " + (*folder_ / "lab.key") + " --certificate " + (*folder_ / "lab.pem");
  const auto refused = gyrotherm_with(sign);
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_NE(refused.err.find("delete the page"), std::string::npos) << refused.err;
  std::filesystem::remove(copy + "/validation.de.html");
  ASSERT_EQ(gyrotherm_with(sign).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(copy + "/validation.de.html"));
  std::ofstream(copy + "/validation.de.html", std::ios::app) << "<!-- older -->";
  std::filesystem::remove(copy + "/validation.en.html");
  const auto holds = gyrotherm_with("report verify " + copy + " --trusted " + (*folder_ / "lab.pem"));
  EXPECT_EQ(holds.exit_code, 0) << holds.err;
  for (const char* line :
       {"unsigned   validation.de.html: is not the page that this version renders; only validation.json is signed",
        "not there  validation.en.html"})
    EXPECT_NE(holds.out.find(line), std::string::npos) << holds.out;
}

/// A report whose calibration.json was removed is not hidden by a protocol with a valid signature.
TEST_F(Validation, DoesNotHideReportInItsFolder) {
  const auto copy = *folder_ / "hidden";
  std::filesystem::copy(*folder_ / "validation", copy, std::filesystem::copy_options::recursive);
  const auto verify = "report verify " + copy + " --trusted " + (*folder_ / "lab.pem");
  ASSERT_EQ(gyrotherm_with("report sign " + copy + " --key " + (*folder_ / "lab.key") + " --certificate " +
                           (*folder_ / "lab.pem"))
                .exit_code,
            0);
  std::ofstream(copy + "/zz.txt") << "x";
  const auto with_other = gyrotherm_with(verify);
  EXPECT_EQ(with_other.exit_code, 0);
  EXPECT_NE(with_other.out.find("unsigned   zz.txt"), std::string::npos) << with_other.out;
  for (const char* name :
       {"dcc.xml", "authorisation.json", "calibration.pdf", "calibration.de.html", "calibration.json"}) {
    std::ofstream(copy + "/" + name) << "{}";
    const auto ran = gyrotherm_with(verify);
    EXPECT_EQ(ran.exit_code, 4) << name << ran.out;
    EXPECT_EQ(ran.out.find("validation.json: signed by"), std::string::npos) << ran.out;
    std::filesystem::remove(copy + "/" + name);
  }
}

}  // namespace
}  // namespace gyrotherm::app
