// SPDX-License-Identifier: Apache-2.0
/// Protocols of proof tests: their text, their chain, and the day on which a test is due.
#include "sequencer/prove/proof.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::prove {
namespace {

constexpr Duration kDay = std::chrono::hours(24);

class Proofs : public ::testing::Test {
 protected:
  Proofs() {
    rig.name = "oven";
    rig.file = folder / "rig.toml";
    rig.text = "the rig";
    rig.proof.every = 180 * kDay;
  }
  /// Files a protocol of all tests on a day, chained to the last one.
  std::string file(int day, ProofVerdict verdict = ProofVerdict::passed, const std::string& name = "oven") {
    Proof proof{.rig = name,
                .rig_sha256 = sha256(rig.text),
                .simulated = is_rehearsal,
                .began = civil_time(kVirtualEpoch + day * kDay)};
    for (const auto test : needed_tests(rig))
      proof.results.push_back({.test = test, .verdict = verdict, .cause = "why", .began = proof.began});
    proof.previous_sha256 = last;
    const auto path = folder / ("proofs/" + std::to_string(1000 + day));
    std::filesystem::create_directories(path);
    const auto text = to_json(proof);
    std::ofstream(path + "/" + kProofFile) << text;
    if (name == "oven") last = sha256(text);
    return path + "/" + kProofFile;
  }
  ProofState judge(int day) { return judge_proofs(rig, find_proofs(rig), kVirtualEpoch + day * kDay); }

  const tests::TestFolder folder;
  rig::RigFile rig;
  std::string last;
  bool is_rehearsal = false;
};

TEST_F(Proofs, AreReadAsWritten) {
  Proof proof{.rig = "oven", .title = "Oven \"A\"", .operator_name = "Ada", .is_as_found = false};
  proof.results.push_back({.test = ProofTest::limiter,
                           .verdict = ProofVerdict::failed,
                           .cause = "late",
                           .began = "2026-01-01T00:00:00Z",
                           .duration_s = 1.5,
                           .limits = {{"trip", "30 °C"}},
                           .readings = {{0.5, "air", "31 °C"}}});
  proof.registers.push_back({"set_point", "41A0 0000", "41A0 0000"});
  const auto read = parse_proof(to_json(proof), "proof.json");
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_EQ(to_json(*read), to_json(proof));
  EXPECT_NE(to_json(proof).find("\"schema\": \"gyrotherm-proof/1\""), std::string::npos);
}

TEST_F(Proofs, PassOnlyIfAllSelectedTestsPassed) {
  using enum ProofVerdict;
  const std::pair<std::vector<ProofVerdict>, ProofVerdict> cases[] = {
      {{passed, passed}, passed},
      {{passed}, passed},
      {{passed, not_tested}, not_tested},
      {{not_tested}, not_tested},
      {{}, not_tested},
      {{not_tested, interrupted, passed}, interrupted},
      {{failed, interrupted, not_tested, passed}, failed},
  };
  for (const auto& [verdicts, expected] : cases) {
    Proof proof;
    for (const auto verdict : verdicts) proof.results.push_back({.verdict = verdict});
    EXPECT_EQ(overall_verdict(proof), expected) << verdicts.size();
    proof.is_as_found = false;
    EXPECT_EQ(overall_verdict(proof), failed);
  }
}

/// A chamber that does not show its set point cannot be restored, and its proofs must still be able to pass.
TEST_F(Proofs, StayValidIfChamberCannotBeRestored) {
  Proof proof{.is_as_found = false, .is_restorable = false, .restoration = "left safe"};
  proof.results.push_back({.verdict = ProofVerdict::passed});
  EXPECT_EQ(overall_verdict(proof), ProofVerdict::passed);
  const auto read = parse_proof(to_json(proof), "proof.json");
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_FALSE(read->is_as_found);
  EXPECT_FALSE(read->is_restorable);
  proof.is_restorable = true;
  EXPECT_EQ(overall_verdict(proof), ProofVerdict::failed);
  EXPECT_EQ(to_json(proof).find("is_restorable"), std::string::npos) << "as in protocols of earlier versions";
  EXPECT_TRUE(parse_proof(to_json(proof), "proof.json")->is_restorable);
}

TEST_F(Proofs, RefuseOtherTexts) {
  const auto good = to_json(Proof{.rig = "oven"});
  auto other = good;
  other.replace(other.find("proof/1"), 7, "proof/2");
  for (const auto& bad : {std::string("{"), other, std::string("[]"), std::string(""), good.substr(0, 60)})
    EXPECT_FALSE(parse_proof(bad, "proof.json")) << bad;
}

TEST_F(Proofs, AreDueAfterInterval) {
  EXPECT_FALSE(judge(0).is_valid) << "none was ever passed";
  EXPECT_EQ(judge(0).lines.size(), needed_tests(rig).size());
  file(0);
  EXPECT_TRUE(judge(0).is_valid);
  EXPECT_TRUE(judge(179).is_valid);
  const auto due = judge(180);
  EXPECT_FALSE(due.is_valid);
  EXPECT_NE(due.lines.at(0).find("proof test limiter: due since 2026-06-30 (passed on 2026-01-01)"), std::string::npos)
      << due.lines[0];
  EXPECT_FALSE(judge(-3).is_valid) << "a protocol of the future proves nothing";
}

TEST_F(Proofs, OfOtherRigsDoNotCount) {
  file(0, ProofVerdict::passed, "fridge");
  EXPECT_TRUE(find_proofs(rig).empty());
  EXPECT_FALSE(judge(1).is_valid);
}

TEST_F(Proofs, OfVirtualChamberDoNotCountForRealRig) {
  is_rehearsal = true;
  file(0);
  const auto state = judge(1);
  EXPECT_FALSE(state.is_valid) << "none was ever passed on the real chamber";
  EXPECT_NE(state.lines.back().find("a rehearsal on a virtual chamber"), std::string::npos) << state.lines.back();
  is_rehearsal = false;
  file(2);
  is_rehearsal = true;
  file(4, ProofVerdict::failed);
  EXPECT_TRUE(judge(5).is_valid) << "a failed rehearsal does not block the real rig";
  EXPECT_TRUE(list_broken_links(find_proofs(rig)).empty()) << "a rehearsal is a link of the chain";
}

TEST_F(Proofs, OfVirtualChamberCountForVirtualRig) {
  rig.simulated = is_rehearsal = true;
  file(0);
  EXPECT_TRUE(judge(1).is_valid);
  file(2, ProofVerdict::failed);
  EXPECT_FALSE(judge(3).is_valid);
}

TEST_F(Proofs, FailUntilTestIsPassedAgain) {
  file(0);
  file(10, ProofVerdict::failed);
  EXPECT_FALSE(judge(11).is_valid);
  EXPECT_NE(judge(11).lines.at(0).find("FAILED on 2026-01-11: why"), std::string::npos);
  file(12, ProofVerdict::interrupted);
  EXPECT_FALSE(judge(13).is_valid) << "an interrupted test does not replace a failed one";
  file(14);
  EXPECT_TRUE(judge(15).is_valid);
}

TEST_F(Proofs, ReportChangedPredecessor) {
  const auto first = file(0);
  file(10);
  EXPECT_TRUE(list_broken_links(find_proofs(rig)).empty());
  std::ofstream(first, std::ios::app) << " ";
  EXPECT_EQ(list_broken_links(find_proofs(rig)).size(), 1u);
  EXPECT_FALSE(judge(11).is_valid);
  std::filesystem::remove(first);
  EXPECT_EQ(list_broken_links(find_proofs(rig)).size(), 1u) << "a missing one is seen, too";
}

TEST_F(Proofs, AreInvalidIfNewestCannotBeRead) {
  file(0);
  const auto newest = file(10, ProofVerdict::failed);
  const auto whole = read_text_file(newest).value();
  for (const auto& bad :
       {whole.substr(0, whole.size() / 2), std::string(), std::string("{}"), std::string("\xff\xfe")}) {
    std::ofstream(newest) << bad;
    const auto state = judge(11);
    EXPECT_FALSE(state.is_valid) << bad;
    ASSERT_FALSE(state.lines.empty());
    EXPECT_NE(state.lines.at(0).find("proofs/1010: the protocol cannot be read"), std::string::npos) << state.lines[0];
    EXPECT_EQ(find_newest(find_proofs(rig))->folder, folder / "proofs/1000") << "the chain continues from it";
  }
  std::filesystem::remove_all(std::filesystem::path(newest).parent_path());
  EXPECT_TRUE(judge(11).is_valid) << "its folder was moved away";
}

TEST_F(Proofs, AreInvalidIfFileIsFolder) {
  file(0);
  std::filesystem::create_directories(folder / "proofs/oven-2026-01-05T000000Z/proof.json");
  EXPECT_FALSE(judge(6).is_valid);
}

TEST_F(Proofs, OfOtherRigsMayBeUnreadable) {
  file(0);
  const auto place = folder / "proofs/fridge-2026-01-05T000000Z";
  std::filesystem::create_directories(place);
  std::ofstream(place + "/" + kProofFile) << "{";
  std::filesystem::create_directories(folder / "proofs/empty");
  std::ofstream(folder / "proofs/notes.txt") << "no protocol";
  EXPECT_TRUE(judge(6).is_valid);
  EXPECT_EQ(find_proofs(rig).size(), 1u);
}

TEST_F(Proofs, SayThatTheyAreUnsignedAndRigChanged) {
  const auto path = file(0);
  EXPECT_NE(judge(1).lines.at(0).find("UNSIGNED"), std::string::npos);
  rig.text = "another rig";
  EXPECT_NE(judge(1).lines.at(0).find("the rig file has changed"), std::string::npos);
  std::ofstream(std::filesystem::path(path).parent_path() / kProofSignatureFile) << "signature";
  EXPECT_EQ(judge(1).lines.size(), 1u);
}

TEST_F(Proofs, NeedRelayTestOnlyWithRelay) {
  EXPECT_EQ(std::ranges::count(needed_tests(rig), ProofTest::relay), 0);
  rig.safe_also.emplace();
  EXPECT_EQ(std::ranges::count(needed_tests(rig), ProofTest::relay), 1);
  EXPECT_EQ(std::ranges::count(needed_tests(rig), ProofTest::line), 1);
  rig.chamber_line = "serial:/dev/ttyUSB0";
  EXPECT_EQ(std::ranges::count(needed_tests(rig), ProofTest::line), 0) << "else the list would never be empty";
  rig.simulated = true;
  EXPECT_EQ(needed_tests(rig), (std::vector{ProofTest::interlocks, ProofTest::clock, ProofTest::disk}));
}

}  // namespace
}  // namespace gyrotherm::prove
