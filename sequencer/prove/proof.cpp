// SPDX-License-Identifier: Apache-2.0
#include "sequencer/prove/proof.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <tuple>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/sha256.hpp"
#include "core/shipped.hpp"
#include "sequencer/prove/driven_child.hpp"

namespace gyrotherm::prove {
namespace {

namespace fs = std::filesystem;

constexpr auto kProofDay = std::chrono::hours(24);

/// Parses "2026-01-31T12:00:00Z"; nothing for another text.
std::optional<Duration> parse_utc(const std::string& text) {
  int year{}, month{}, day{}, hour{}, minute{}, second{};
  if (std::sscanf(text.c_str(), "%4d-%2d-%2dT%2d:%2d:%2dZ", &year, &month, &day, &hour, &minute, &second) != 6)
    return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch() + std::chrono::hours(hour) + std::chrono::minutes(minute) +
         std::chrono::seconds(second);
}

/// The newest attempt at one test.
struct LastAttempt {
  const FiledProof* filed{};
  const ProofResult* result{};
};

/// Returns whether a protocol says something about this rig: a rehearsal on a virtual chamber says nothing about a real
/// one.
bool counts_for(const rig::RigFile& rig, const FiledProof& filed) {
  return filed.fault.empty() && (rig.simulated || !filed.proof.simulated);
}

LastAttempt find_last_attempt(const rig::RigFile& rig, const std::vector<FiledProof>& proofs, ProofTest test) {
  for (auto filed = proofs.rbegin(); filed != proofs.rend(); ++filed)  // unreadable protocols have no results
    for (const auto& result : filed->proof.results)
      if (counts_for(rig, *filed) && result.test == test &&
          (result.verdict == ProofVerdict::passed || result.verdict == ProofVerdict::failed))
        return {&*filed, &result};
  return {};
}

/// Returns a sentence about a test that is not valid now; empty if it is.
std::string describe_shortcoming(const rig::RigFile& rig, ProofTest test, const LastAttempt& last, Duration utc) {
  if (last.result == nullptr)
    return rig.proof.every ? fmt::format("proof test {}: never passed; \"gyrotherm prove {}\"", name(test), rig.file)
                           : "";
  const auto day = last.result->began.substr(0, 10);
  if (last.result->verdict == ProofVerdict::failed)
    return fmt::format("proof test {}: FAILED on {}: {}", name(test), day, last.result->cause);
  const auto began = parse_utc(last.result->began);
  if (!began) return fmt::format("proof test {}: its date cannot be read: {}", name(test), last.result->began);
  if (!rig.proof.every) return "";
  const auto due = *began + *rig.proof.every;
  if (*began > utc + kProofDay) return fmt::format("proof test {}: its date is in the future: {}", name(test), day);
  if (utc < due) return "";
  return fmt::format("proof test {}: due since {} (passed on {})", name(test), civil_time(due).substr(0, 10), day);
}

}  // namespace

ProofVerdict overall_verdict(const Proof& proof) {
  const auto has = [&](ProofVerdict verdict) {
    return std::ranges::any_of(proof.results, [&](const auto& result) { return result.verdict == verdict; });
  };
  if (has(ProofVerdict::failed) || has_failed_restoration(proof)) return ProofVerdict::failed;
  if (has(ProofVerdict::interrupted)) return ProofVerdict::interrupted;
  const bool is_complete = has(ProofVerdict::passed) && !has(ProofVerdict::not_tested);
  return is_complete ? ProofVerdict::passed : ProofVerdict::not_tested;
}

std::string to_json(const Proof& proof) { return json_text(make_json(proof), 2) + "\n"; }

Result<Proof> parse_proof(const std::string& text, const std::string& file) {
  const auto document = JsonNode::parse(text, file, JsonNode::Nulls::are_errors);
  if (!document) return failure(document.error());
  if (const auto schema = (*document)["schema"].text(); schema != kProofSchema)
    (*document)["schema"].note_error(fmt::format("\"{}\", expected \"{}\"", schema, kProofSchema));
  Proof proof;
  if (document->verdict()) read_json(*document, proof);
  if (auto verdict = document->verdict(); !verdict) return failure(std::move(verdict.error()));
  return proof;
}

std::string proofs_folder(const rig::RigFile& rig) {
  const fs::path folder(rig.proof.folder);
  // Users cannot write beside a shipped rig, so its protocols are in the working folder.
  const auto shipped =
      find_shipped_file(fmt::format("{}/{}", kShippedRig.folder, fs::path(rig.file).filename().string()));
  std::error_code error;
  if (!shipped.empty() && fs::equivalent(shipped, rig.file, error)) return folder.string();
  return folder.is_absolute() ? folder.string() : (fs::path(parent_folder(rig.file)) / folder).string();
}

namespace {

/// Returns the rig in the name of a folder, "oven-2026-11-29T195614Z"; empty if the name has another form.
std::string find_rig_in_folder_name(const fs::path& folder) {
  const auto name = folder.filename().string();
  constexpr std::string_view kForm = "-0000-00-00T000000Z";
  if (name.size() <= kForm.size()) return "";
  const auto time = std::string_view(name).substr(name.size() - kForm.size());
  const auto fits = [](char form, char byte) { return form == '0' ? byte >= '0' && byte <= '9' : byte == form; };
  return std::ranges::equal(kForm, time, fits) ? name.substr(0, name.size() - kForm.size()) : "";
}

/// Reads the protocol of a folder. Returns nothing if there is none.
std::optional<FiledProof> read_filed_proof(const fs::path& folder) {
  const auto path = (folder / kProofFile).string();
  std::error_code error;
  FiledProof filed{.folder = folder.string(),
                   .proof = {},
                   .sha256 = {},
                   .fault = {},
                   .is_signed = fs::exists(folder / kProofSignatureFile, error)};
  const auto text = read_text_file_if_any(path, kLargestText, Links::followed);
  if (text && !*text) return std::nullopt;
  if (!text) {
    filed.fault = gyrotherm::text(text.error());
    return filed;
  }
  filed.sha256 = sha256(**text);
  if (auto proof = parse_proof(**text, path))
    filed.proof = std::move(*proof);
  else
    filed.fault = gyrotherm::text(proof.error());
  return filed;
}

}  // namespace

std::vector<FiledProof> find_proofs(const rig::RigFile& rig) {
  std::vector<FiledProof> proofs;
  std::error_code error;
  for (const auto& folder : list_folder(proofs_folder(rig))) {
    if (!fs::is_directory(folder, error)) continue;
    auto filed = read_filed_proof(folder);
    if (!filed) continue;
    const auto name = filed->fault.empty() ? filed->proof.rig : find_rig_in_folder_name(folder);
    const bool may_be_ours = name == rig.name || (!filed->fault.empty() && name.empty());
    if (may_be_ours) proofs.push_back(std::move(*filed));
  }
  const auto key = [](const FiledProof& filed) {
    return std::tuple(!filed.fault.empty(), filed.proof.began, filed.folder);
  };
  std::ranges::sort(proofs, {}, key);
  return proofs;
}

const FiledProof* find_newest(const std::vector<FiledProof>& proofs) {
  const auto newest = std::find_if(proofs.rbegin(), proofs.rend(), [](const auto& one) { return one.fault.empty(); });
  return newest == proofs.rend() ? nullptr : &*newest;
}

std::vector<std::string> list_broken_links(const std::vector<FiledProof>& proofs) {
  std::vector<std::string> broken;
  std::string expected;
  for (const auto& filed : proofs) {
    if (!filed.fault.empty()) continue;
    if (filed.proof.previous_sha256 != expected)
      broken.push_back(fmt::format("{}: the previous protocol {} or was changed since", filed.folder,
                                   expected.empty() ? "is missing" : "is another one"));
    expected = filed.sha256;
  }
  return broken;
}

std::vector<ProofTest> needed_tests(const rig::RigFile& rig) {
  std::vector<ProofTest> tests;
  for (const auto test : kProofTests) {
    if (test == ProofTest::relay && !rig.safe_also) continue;
    if (rig.simulated && moves_chamber(test)) continue;
    if (test == ProofTest::line && is_exclusive_line(rig)) continue;
    tests.push_back(test);
  }
  return tests;
}

ProofState judge_proofs(const rig::RigFile& rig, const std::vector<FiledProof>& proofs, Duration utc) {
  ProofState state{.is_valid = true};
  for (const auto test : needed_tests(rig)) {
    auto line = describe_shortcoming(rig, test, find_last_attempt(rig, proofs, test), utc);
    if (line.empty()) continue;
    state.is_valid = false;
    state.lines.push_back(std::move(line));
  }
  for (const auto& filed : proofs) {
    if (filed.fault.empty()) continue;
    state.is_valid = false;
    state.lines.push_back(fmt::format("{}: the protocol cannot be read, restore it or move its folder away: {}",
                                      filed.folder, filed.fault));
  }
  for (auto& line : list_broken_links(proofs)) {
    state.is_valid = false;
    state.lines.push_back(std::move(line));
  }
  const auto last = std::find_if(proofs.rbegin(), proofs.rend(), [&](const auto& one) { return counts_for(rig, one); });
  if (const auto* shown = find_newest(proofs); shown != nullptr && !counts_for(rig, *shown))
    state.lines.push_back(shown->folder + ": a rehearsal on a virtual chamber; it does not count");
  if (last == proofs.rend()) return state;
  const auto& newest = *last;
  if (has_failed_restoration(newest.proof)) {
    state.is_valid = false;
    state.lines.push_back(
        fmt::format("{}: the chamber was not left as found: {}", newest.folder, newest.proof.restoration));
  }
  if (newest.proof.rig_sha256 != sha256(rig.text))
    state.lines.push_back(fmt::format("{}: the rig file has changed since these proof tests", newest.folder));
  if (!newest.is_signed) state.lines.push_back(newest.folder + ": the protocol is UNSIGNED");
  return state;
}

}  // namespace gyrotherm::prove
