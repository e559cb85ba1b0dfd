// SPDX-License-Identifier: Apache-2.0
/// The protocol of the proof tests of a rig (schema gyrotherm-proof/1), and the search for the newest one. Values; any
/// thread.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/form.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::prove {

inline constexpr const char* kProofSchema = "gyrotherm-proof/1";
/// File names in the folder of a protocol.
inline constexpr const char *kProofFile = "proof.json", *kProofSignatureFile = "proof.p7s";

enum class ProofTest { limiter, make_safe, line, relay, interlocks, clock, disk };
inline constexpr std::initializer_list<ProofTest> kProofTests = {
    ProofTest::limiter,    ProofTest::make_safe, ProofTest::line, ProofTest::relay,
    ProofTest::interlocks, ProofTest::clock,     ProofTest::disk};
/// Returns the keyword of the command line and of the protocol.
[[nodiscard]] inline const char* name(ProofTest test) {
  return enumerator_text<ProofTest::disk>({"limiter", "make-safe", "line", "relay", "interlocks", "clock", "disk"},
                                          test);
}
/// Returns true for a test that commands the chamber.
[[nodiscard]] inline bool moves_chamber(ProofTest test) { return test <= ProofTest::relay; }

enum class ProofVerdict {
  passed,
  failed,
  /// Neither: the rig has nothing to test, or the test could not be carried out. The cause says which.
  not_tested,
  interrupted,
};
inline constexpr std::initializer_list<ProofVerdict> kProofVerdicts = {
    ProofVerdict::passed, ProofVerdict::failed, ProofVerdict::not_tested, ProofVerdict::interrupted};
[[nodiscard]] inline const char* name(ProofVerdict verdict) {
  return enumerator_text<ProofVerdict::interrupted>({"passed", "failed", "not tested", "interrupted"}, verdict);
}

struct ProofLimit {
  std::string what, limit;
};
void describe(auto& form, Like<ProofLimit> auto& limit) {
  form("what", limit.what);
  form("limit", limit.limit);
}

struct ProofReading {
  /// Time since the start of the test.
  double at_s{};
  std::string what, value;
};
void describe(auto& form, Like<ProofReading> auto& reading) {
  form("at_s", reading.at_s);
  form("what", reading.what);
  form("value", reading.value);
}

struct ProofResult {
  ProofTest test{};
  ProofVerdict verdict = ProofVerdict::not_tested;
  /// Reason for a verdict other than passed.
  std::string cause{};
  std::string began{};  ///< UTC
  double duration_s{};
  std::vector<ProofLimit> limits{};
  std::vector<ProofReading> readings{};
};
void describe(auto& form, Like<ProofResult> auto& result) {
  form("test", one_of(result.test, kProofTests));
  form("verdict", one_of(result.verdict, kProofVerdicts));
  form("cause", result.cause);
  form("began", result.began);
  form("duration_s", result.duration_s);
  form("limits", result.limits);
  form("readings", result.readings);
}

/// A register that prove changed or found changed, as the words on the line.
struct ProofRegister {
  std::string item, before, after;
};
void describe(auto& form, Like<ProofRegister> auto& item) {
  form("item", item.item);
  form("before", item.before);
  form("after", item.after);
}

struct Proof {
  std::string rig{}, title{};
  std::string rig_file{};
  std::string rig_sha256{};
  bool simulated{};       ///< the rig or its chamber is virtual
  std::string chamber{};  ///< as identified; empty: it was not asked
  std::string version{};  ///< the program's version
  std::string operator_name{};
  std::string began{}, ended{};  ///< UTC
  std::vector<ProofResult> results{};
  /// Writable registers of the chamber before and after; empty if no test commanded the chamber.
  std::vector<ProofRegister> registers{};
  /// The chamber was left as it was found.
  bool is_as_found = true;
  /// False if it was left safe instead, because it does not show the set point with which it was found.
  bool is_restorable = true;
  /// Reason for which it was not left as found; may be empty.
  std::string restoration{};
  /// Folder and digest of the previous protocol of this rig; empty: there was none.
  std::string previous{}, previous_sha256{};
};
void describe(auto& form, Like<Proof> auto& proof) {
  form.derived("schema", kProofSchema);
  form("rig", proof.rig);
  form("title", proof.title);
  form("rig_file", proof.rig_file);
  form("rig_sha256", proof.rig_sha256);
  form("simulated", proof.simulated);
  form("chamber", proof.chamber);
  form("version", proof.version);
  form("operator", proof.operator_name);
  form("began", proof.began);
  form("ended", proof.ended);
  form("results", proof.results);
  form("registers", proof.registers);
  form("is_as_found", proof.is_as_found);
  form.if_present("is_restorable", !proof.is_restorable, proof.is_restorable);
  form("restoration", proof.restoration);
  form("previous", proof.previous);
  form("previous_sha256", proof.previous_sha256);
}

/// Returns whether the chamber should have been restored, and was not.
[[nodiscard]] inline bool has_failed_restoration(const Proof& proof) {
  return !proof.is_as_found && proof.is_restorable;
}

/// Returns failed if a test failed or the chamber was not restored, otherwise interrupted if a test was; passed only if
/// all tests passed. A selected test that could not be carried out makes it not_tested.
[[nodiscard]] ProofVerdict overall_verdict(const Proof& proof);

[[nodiscard]] std::string to_json(const Proof& proof);
/// Parses a protocol. Fails with bad_file, also for another schema. `file` is its path, for faults.
[[nodiscard]] Result<Proof> parse_proof(const std::string& text, const std::string& file);

/// A protocol in its folder.
struct FiledProof {
  std::string folder;
  Proof proof;
  std::string sha256;  ///< digest of proof.json
  /// Reason for which proof.json could not be read or parsed; `proof` is then empty. Empty: it was read.
  std::string fault;
  /// The folder contains a signature, which is not verified.
  bool is_signed{};
};

/// Returns the folder of the protocols of a rig: beside the rig file, or for a shipped rig in the working folder.
[[nodiscard]] std::string proofs_folder(const rig::RigFile& rig);
/// Returns the protocols of this rig, oldest first, then those that cannot be read. Skips folders without a protocol,
/// protocols of other rigs, and unreadable ones whose folder has the name of another rig.
[[nodiscard]] std::vector<FiledProof> find_proofs(const rig::RigFile& rig);
/// Returns the newest protocol that could be read; null: there is none.
[[nodiscard]] const FiledProof* find_newest(const std::vector<FiledProof>& proofs);
/// Returns the protocols whose predecessor is missing or was changed, as sentences. Ignores unreadable protocols.
[[nodiscard]] std::vector<std::string> list_broken_links(const std::vector<FiledProof>& proofs);

/// The state of the proof tests of a rig on a day.
struct ProofState {
  /// False if a test is due, was never passed, or failed at its last attempt, or if a protocol cannot be read.
  bool is_valid{};
  std::vector<std::string> lines{};  ///< for people
};
/// Looks at the newest result of each test that this rig needs. `utc` is now. Ignores rehearsals on a virtual chamber
/// if the rig is real.
[[nodiscard]] ProofState judge_proofs(const rig::RigFile& rig, const std::vector<FiledProof>& proofs, Duration utc);

/// Returns the tests that this rig can have: no relay test without [safe.also], no cut of a serial line.
[[nodiscard]] std::vector<ProofTest> needed_tests(const rig::RigFile& rig);

}  // namespace gyrotherm::prove
