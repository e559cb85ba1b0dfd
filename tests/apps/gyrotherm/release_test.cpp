// SPDX-License-Identifier: Apache-2.0
/// A site reviews and releases its programs, and its runs say which release they used.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "acquisition/record/record.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"
#include "tests/apps/gyrotherm/program.hpp"

namespace gyrotherm::app {
namespace {

/// A site with a register, a key, and copies of a profile and a virtual rig.
class Releases : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    keys_ = new Folder;
    const auto made = shell("cd " + (*keys_ / ".") +
                            " && for one in site other; do openssl req -x509 -newkey rsa:2048 -nodes -keyout $one.key "
                            "-out $one.pem -days 30 -subj /CN=$one -addext basicConstraints=critical,CA:FALSE -addext "
                            "keyUsage=critical,digitalSignature; done");
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  static void TearDownTestSuite() { delete keys_; }

  void SetUp() override {
    std::filesystem::create_directory(site_ / "register");
    copy("tests/profiles/ten-seconds.toml", "brief.toml");
    auto rig = *read_text_file(GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml");
    for (auto at = rig.find("\"../"); at != rig.npos; at = rig.find("\"../"))
      rig.replace(at, 4, "\"" GYROTHERM_SOURCE_DIR "/profiles/");
    write("lab.toml", rig);
    for (const char* file : {"site.key", "site.pem", "other.key", "other.pem"})
      std::filesystem::copy_file(*keys_ / file, site_ / file);
  }

  void copy(const std::string& from, const std::string& to) {
    std::filesystem::copy_file(GYROTHERM_SOURCE_DIR "/" + from, site_ / to);
  }
  void write(const std::string& name, const std::string& text) { std::ofstream(site_ / name) << text; }

  Ran review(const std::string& file, const std::string& by = "'R. Reviewer'", const std::string& revision = "3") {
    return gyrotherm_with("release review " + (site_ / file) + " --revision " + revision + " --by " + by +
                          " --register " + (site_ / "register"));
  }
  Ran sign(const std::string& file, const std::string& by = "'A. Authoriser'", const std::string& key = "site") {
    return gyrotherm_with("release sign " + (site_ / file) + " --by " + by + " --key " + (site_ / (key + ".key")) +
                          " --certificate " + (site_ / (key + ".pem")) + " --register " + (site_ / "register"));
  }
  void release(const std::string& file) {
    const auto reviewed = review(file), signed_now = sign(file);
    ASSERT_EQ(reviewed.exit_code, 0) << reviewed.err;
    ASSERT_EQ(signed_now.exit_code, 0) << signed_now.err;
  }
  std::string entry(const std::string& file) {
    return site_ / ("register/" + sha256(*read_text_file(site_ / file)) + ".json");
  }
  void use_policy(const std::string& unreleased = "marked") {
    write("policy.toml",
          "schema = \"gyrotherm-policy/1\"\n[releases]\nregister = \"register\"\ntrusted = \"site.pem\"\n"
          "unreleased = \"" +
              unreleased + "\"\n");
  }
  Ran list(const std::string& options = "") {
    return gyrotherm_with("release list --register " + (site_ / "register") + " --trusted " + (site_ / "site.pem") +
                          options);
  }
  /// Runs the brief profile on the virtual rig under the policy.
  Ran run(const std::string& out = "run.db") {
    return shell("GYROTHERM_POLICY=" + (site_ / "policy.toml") + " gyrotherm run " + (site_ / "brief.toml") +
                 " --rig " + (site_ / "lab.toml") + " --out " + (site_ / out));
  }
  record::RunInfo info(const std::string& out = "run.db") {
    const auto record = record::read_record(site_ / out);
    EXPECT_TRUE(record) << text(record.error());
    return record ? record->info : record::RunInfo{};
  }

  static inline Folder* keys_ = nullptr;
  Folder site_;
};

TEST_F(Releases, AreReviewedByOnePersonAndSignedByAnother) {
  EXPECT_EQ(sign("brief.toml").exit_code, 2) << "not reviewed";
  ASSERT_EQ(review("brief.toml").exit_code, 0);
  EXPECT_NE(list().out.find("NOT RELEASED"), std::string::npos);
  const auto second = review("brief.toml", "'B. Other'");
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_NE(second.err.find("was reviewed by R. Reviewer at "), std::string::npos) << second.err;
  EXPECT_EQ(review("brief.toml").exit_code, 0) << "the same person may repeat the review";
  const auto same = sign("brief.toml", "'R. Reviewer'");
  EXPECT_EQ(same.exit_code, 2);
  EXPECT_NE(same.err.find("another person"), std::string::npos) << same.err;
  ASSERT_EQ(sign("brief.toml").exit_code, 0);
  EXPECT_EQ(sign("brief.toml").exit_code, 2) << "already released";
  EXPECT_EQ(review("brief.toml").exit_code, 2) << "already released";
  const auto listed = list();
  EXPECT_EQ(listed.exit_code, 0);
  for (const char* part : {"brief.toml", "revision 3", "R. Reviewer", "A. Authoriser", "CN=site"})
    EXPECT_NE(listed.out.find(part), std::string::npos) << part << " in " << listed.out;
  const auto entries = nlohmann::json::parse(list(" --json").out);
  ASSERT_EQ(entries.size(), 1u);
  EXPECT_EQ(entries[0]["state"], "released");
  EXPECT_EQ(entries[0]["trouble"], "");
}

TEST_F(Releases, RecogniseReviewerInOtherSpelling) {
  ASSERT_EQ(review("brief.toml", "'Ö. Reviewer'").exit_code, 0);
  for (const char* same : {"'ö. reviewer'", "'  Ö.   REVIEWER '", "'Ö.\u00a0Reviewer'"}) {
    const auto refused = sign("brief.toml", same);
    EXPECT_EQ(refused.exit_code, 2) << same;
    EXPECT_NE(refused.err.find(" reviewed this text"), std::string::npos) << refused.err;
    EXPECT_EQ(review("brief.toml", same).exit_code, 0) << "the same person may repeat the review";
  }
  EXPECT_EQ(sign("brief.toml", "'O. Reviewer'").exit_code, 0);
}

TEST_F(Releases, RefuseInvalidPrograms) {
  auto profile = *read_text_file(site_ / "brief.toml");
  write("profile.toml", profile + "colour = 1\n");
  write("rig.toml", *read_text_file(site_ / "lab.toml") + "[policy]\nfrozen = \"perhaps\"\n");
  write("map.toml", "schema = \"gyrotherm-chamber/1\"\nname = \"x\"\n");
  write("stream.toml", "schema = \"gyrotherm-gyro-stream/1\"\nname = \"x\"\n");
  write("text.toml", "schema = \"gyrotherm-text/1\"\nname = \"x\"\n");
  write("inputs.toml", "schema = \"gyrotherm-analogue-inputs/1\"\nname = \"x\"\n");
  for (const char* file : {"profile.toml", "rig.toml", "map.toml", "stream.toml", "text.toml", "inputs.toml"}) {
    const auto refused = review(file);
    EXPECT_EQ(refused.exit_code, 4) << file;
    EXPECT_NE(refused.err.find(std::string(file) + ":"), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(entry(file))) << file;
  }
}

TEST_F(Releases, AcceptEachShippedKindOfProgram) {
  for (const char* file : {"profiles/chambers/watlow_f4t.toml", "profiles/chambers/lauda.toml",
                           "profiles/gyro-streams/stim300.toml", "profiles/thermometers/keysight_34970a.toml"}) {
    copy(file, "shipped.toml");
    const auto reviewed = review("shipped.toml");
    EXPECT_EQ(reviewed.exit_code, 0) << reviewed.err;
    std::filesystem::remove(site_ / "shipped.toml");
  }
}

TEST_F(Releases, StateThatRegisterIsEmptyAndCheckCertificates) {
  const auto listed = list();
  EXPECT_EQ(listed.exit_code, 0);
  EXPECT_NE(listed.err.find("no releases in "), std::string::npos) << listed.err;
  EXPECT_EQ(gyrotherm_with("release list --register " + (site_ / "register") + " --trusted " + (site_ / "lab.toml"))
                .exit_code,
            4);
}

TEST_F(Releases, AreRefusedWithRepeatedKeyOrInUtf16) {
  ASSERT_EQ(review("brief.toml").exit_code, 0);
  const auto path = entry("brief.toml");
  auto repeated = *read_text_file(path);
  repeated.insert(repeated.find("\"by\""), "\"by\": \"B. Other\", ");
  for (const auto& [text, cause] : {std::pair(repeated, "the key \"by\" occurs twice"),
                                    std::pair(std::string("\xFF\xFE{\0}\0", 6), "is in UTF-16")}) {
    std::ofstream(path) << text;
    const auto listed = list();
    EXPECT_EQ(listed.exit_code, 4) << cause;
    EXPECT_NE(listed.err.find(cause), std::string::npos) << listed.err;
  }
}

TEST_F(Releases, AreInTheRecordAndMarkedOnViews) {
  use_policy();
  release("brief.toml");
  const auto ran = run();
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_NE(ran.err.find("rig virtual: UNRELEASED: is not in the register"), std::string::npos) << ran.err;
  const auto releases = info().releases;
  ASSERT_GE(releases.size(), 2u);
  EXPECT_EQ(releases[0].title, "profile ten-seconds");
  EXPECT_EQ(releases[0].revision, "3");
  EXPECT_EQ(releases[0].released_by, "A. Authoriser");
  EXPECT_EQ(releases[0].signer, "CN=site");
  EXPECT_EQ(releases[0].unreleased, "");
  EXPECT_NE(releases[1].unreleased, "");
  const auto status = gyrotherm_with("status " + (site_ / "run.db"));
  EXPECT_NE(status.out.find("UNRELEASED: rig virtual"), std::string::npos) << status.out;
  EXPECT_EQ(status.out.find("profile ten-seconds"), std::string::npos) << status.out;
  ASSERT_EQ(gyrotherm_with("export " + (site_ / "run.db") + " --out " + (site_ / "run.csv")).exit_code, 0);
  const auto csv = *read_text_file(site_ / "run.csv");
  EXPECT_NE(csv.find("# rig virtual: UNRELEASED"), std::string::npos);
  EXPECT_NE(csv.find("# profile ten-seconds: revision 3, released by A. Authoriser"), std::string::npos);
}

TEST_F(Releases, AreStatedByCheck) {
  use_policy();
  release("brief.toml");
  const auto checked = shell("GYROTHERM_POLICY=" + (site_ / "policy.toml") + " gyrotherm check " +
                             (site_ / "brief.toml") + " --rig " + (site_ / "lab.toml"));
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
  EXPECT_NE(checked.out.find("profile ten-seconds: revision 3, released by A. Authoriser"), std::string::npos);
  EXPECT_NE(checked.out.find("rig virtual: UNRELEASED: is not in the register"), std::string::npos);
}

TEST_F(Releases, AreNotStatedWithoutRegister) {
  const auto ran = shell("GYROTHERM_POLICY= gyrotherm run " + (site_ / "brief.toml") + " --rig " +
                         (site_ / "lab.toml") + " --out " + (site_ / "run.db"));
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  EXPECT_TRUE(info().releases.empty());
  EXPECT_EQ(ran.err.find("UNRELEASED"), std::string::npos);
}

TEST_F(Releases, EndWithAnyChangeOfTheText) {
  use_policy();
  release("brief.toml");
  std::ofstream(site_ / "brief.toml", std::ios::app) << "# a comment\n";
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_EQ(info().releases.front().unreleased, "is not in the register");
}

TEST_F(Releases, AreNotBelievedIfTheEntryWasChanged) {
  use_policy();
  release("brief.toml");
  const auto path = entry("brief.toml");
  const auto sound = *read_text_file(path);
  const auto expect_unreleased = [&](const std::string& changed, const std::string& cause) {
    std::ofstream(path) << changed;
    const auto listed = list();
    EXPECT_EQ(listed.exit_code, 4) << cause;
    static int number = 0;
    const auto out = "run-" + std::to_string(++number) + ".db";
    ASSERT_EQ(run(out).exit_code, 0);
    EXPECT_NE(info(out).releases.front().unreleased.find(cause), std::string::npos)
        << info(out).releases.front().unreleased;
  };
  const auto replaced = [&](const std::string& from, const std::string& to) {
    auto changed = sound;
    changed.replace(changed.find(from), from.size(), to);
    return changed;
  };
  expect_unreleased(replaced("\"3\"", "\"4\""), "signature is not valid");
  expect_unreleased(replaced("A. Authoriser", "R. Reviewer"), "signature is not valid");
  expect_unreleased(replaced("gyrotherm-release/1", "gyrotherm-release/9"), "schema");
  expect_unreleased(sound.substr(0, sound.size() / 2), "");
  const auto other = sha256(*read_text_file(site_ / "lab.toml"));
  expect_unreleased(replaced(sha256(*read_text_file(site_ / "brief.toml")), other), "another text");
}

TEST_F(Releases, OfStrangersAreNotBelieved) {
  use_policy();
  ASSERT_EQ(review("brief.toml").exit_code, 0);
  ASSERT_EQ(sign("brief.toml", "'A. Authoriser'", "other").exit_code, 0);
  EXPECT_EQ(list().exit_code, 4);
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_NE(info().releases.front().unreleased.find("not trusted"), std::string::npos)
      << info().releases.front().unreleased;
}

TEST_F(Releases, MustBeValidForRealRigsIfTheSiteDemandsIt) {
  use_policy("refused");
  EXPECT_EQ(run().exit_code, 0) << "a virtual rig is only marked";
  const auto refused =
      shell("GYROTHERM_POLICY=" + (site_ / "policy.toml") + " gyrotherm run " + (site_ / "brief.toml") +
            " --rig " GYROTHERM_SOURCE_DIR "/profiles/rigs/example-binder-dcon-stim300.toml --unit gyro=0042 --out " +
            (site_ / "real.db"));
  EXPECT_EQ(refused.exit_code, 2) << refused.err;
  EXPECT_NE(refused.err.find("not released"), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(site_ / "real.db"));
}

TEST_F(Releases, NeedAValidPolicy) {
  for (const std::string policy :
       {"", "schema = \"gyrotherm-rig/1\"\n", "schema = \"gyrotherm-policy/1\"\nrelease = 1\n",
        "schema = \"gyrotherm-policy/1\"\n[releases]\nregister = \"register\"\n",
        "schema = \"gyrotherm-policy/1\"\n[releases]\nregister = \"register\"\n"
        "trusted = \"site.pem\"\nunreleased = \"ignored\"\n"}) {
    write("policy.toml", policy);
    const auto ran = run();
    EXPECT_EQ(ran.exit_code, 4) << policy << ran.err;
    EXPECT_NE(ran.err.find("policy.toml:"), std::string::npos) << ran.err;
  }
  std::filesystem::remove(site_ / "policy.toml");
  EXPECT_EQ(run().exit_code, 4);
  EXPECT_FALSE(std::filesystem::exists(site_ / "run.db"));
}

}  // namespace
}  // namespace gyrotherm::app
