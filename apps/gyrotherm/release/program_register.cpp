// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/release/program_register.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <tuple>
#include <utility>

#include "core/file.hpp"
#include "core/json.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::app {
namespace {

constexpr std::size_t kLargestRelease = std::size_t{1} << 20U;

bool is_sha256(std::string_view text) {
  constexpr std::size_t kDigits = 64;
  return text.size() == kDigits &&
         std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

/// Fails with bad_file unless the register is a folder.
Result<void> check_register(const std::string& folder) {
  std::error_code unknown;
  if (std::filesystem::is_directory(folder, unknown)) return {};
  return failure(FaultKind::bad_file, folder, "is not a folder, expected the register of releases");
}

}  // namespace

void describe(auto& form, Like<ReleaseStep> auto& step) {
  form("by", step.by);
  form("at", step.at);
}

void describe(auto& form, Like<Release> auto& release) {
  form.derived("schema", kReleaseSchema);
  form("title", release.title);
  form("sha256", release.sha256);
  form.expect("sha256", is_sha256(release.sha256), "expected 64 hexadecimal digits in lower case");
  form("revision", release.revision);
  form("reviewed", release.reviewed);
  form.if_present("released", !release.released.by.empty(), release.released);
  form.if_present("signature", !release.signature.empty(), release.signature);
}

namespace {

/// Completes the release of one text, or states why there is none.
Result<void> find_valid_release(record::ProgramRelease& found, const ReleasePolicy& policy) {
  const auto release = find_release(policy.register_folder, found.sha256);
  if (!release) return failure(release.error());
  if (!*release) return failure(FaultKind::bad_file, found.title, "is not in the register");
  found.revision = (*release)->revision;
  const auto signer = verify_release(**release, release_path(policy.register_folder, found.sha256),
                                     {.certificates_file = policy.trusted, .on_day = {}});
  if (!signer) return failure(signer.error());
  found.released_by = (*release)->released.by;
  found.released_at = (*release)->released.at;
  found.signer = signer->subject;
  return {};
}

}  // namespace

const char* state_of(const Release& release) { return release.signature.empty() ? "reviewed" : "released"; }

std::string to_json(const Release& release) { return json_text(make_json(release), 2) + "\n"; }

std::string signed_text(const Release& release) {
  Release unsigned_release = release;
  unsigned_release.signature.clear();
  return to_json(unsigned_release);
}

Result<Release> parse_release(std::string_view json, const std::string& file) {
  const auto document = JsonNode::parse(json, file);
  if (!document) return failure(document.error());
  if (const auto schema = (*document)["schema"].text(); schema != kReleaseSchema)
    return failure(FaultKind::bad_file, file,
                   fmt::format("its schema is \"{}\", expected \"{}\"", schema, kReleaseSchema));
  Release release;
  read_json(*document, release);
  if (auto valid = document->verdict(); !valid) return failure(valid.error());
  return release;
}

std::string release_path(const std::string& register_folder, const std::string& sha256) {
  return (std::filesystem::path(register_folder) / (sha256 + ".json")).string();
}

Result<std::optional<Release>> find_release(const std::string& register_folder, const std::string& sha256) {
  if (auto folder = check_register(register_folder); !folder) return failure(folder.error());
  std::error_code unknown;
  const auto path = release_path(register_folder, sha256);
  if (!std::filesystem::exists(path, unknown) && !unknown) return std::nullopt;
  const auto text = read_text_file(path, kLargestRelease);
  if (!text) return failure(text.error());
  auto release = parse_release(*text, path);
  if (!release) return failure(release.error());
  if (release->sha256 != sha256)
    return failure(FaultKind::bad_file, path, "is the release of another text: its \"sha256\" is not its file name");
  return std::optional(std::move(*release));
}

Result<std::vector<Release>> list_releases(const std::string& register_folder) {
  std::error_code error;
  std::vector<Release> all;
  if (auto folder = check_register(register_folder); !folder) return failure(folder.error());
  std::filesystem::directory_iterator entries(register_folder, error);
  if (error) return failure(FaultKind::bad_file, register_folder, error.message());
  for (const auto& entry : entries) {
    const auto stem = entry.path().stem().string();
    if (entry.path().extension() != ".json" || !is_sha256(stem)) continue;
    auto release = find_release(register_folder, stem);
    if (!release) return failure(release.error());
    if (*release) all.push_back(std::move(**release));
  }
  std::ranges::sort(
      all, {}, [](const Release& release) { return std::tie(release.title, release.reviewed.at, release.sha256); });
  return all;
}

Result<report::Signer> verify_release(const Release& release, const std::string& file, const report::Trust& trust) {
  if (release.signature.empty()) return failure(FaultKind::bad_file, file, "is reviewed but not released");
  return report::verify_bytes(signed_text(release), release.signature, file, trust);
}

std::vector<ProgramText> list_programs(const profile::Profile& profile, const rig::RigFile& rig) {
  std::vector<ProgramText> all{{"profile " + profile.name, profile.text}, {"rig " + rig.name, rig.text}};
  const auto add = [&](std::string title, const std::string& text) {
    const auto is_known = [&](const ProgramText& one) { return one.text == text; };
    if (!text.empty() && std::ranges::none_of(all, is_known)) all.push_back({std::move(title), text});
  };
  add("chamber map", rig.chamber_map.text);
  const auto add_all = [&](const char* title, const std::vector<std::string>& texts) {
    for (std::size_t i = 0; i < texts.size(); ++i) add(fmt::format("{} {}", title, i + 1), texts[i]);
  };
  add_all("map of analogue input", collect_analogue_map_texts(rig));
  add_all("description of thermometer", collect_thermometer_texts(rig));
  add_all("description of supply", collect_supply_texts(rig));
  return all;
}

std::vector<record::ProgramRelease> judge_programs(const std::vector<ProgramText>& programs,
                                                   const ReleasePolicy& policy) {
  std::vector<record::ProgramRelease> all;
  for (const ProgramText& program : programs) {
    record::ProgramRelease found{.title = program.title, .sha256 = sha256(program.text)};
    if (const auto valid = find_valid_release(found, policy); !valid) found.unreleased = valid.error().what;
    all.push_back(std::move(found));
  }
  return all;
}

Result<std::vector<record::ProgramRelease>> check_releases(const profile::Profile& profile, const rig::RigFile& rig) {
  const auto policy = read_policy();
  if (!policy) return failure(policy.error());
  if (!*policy || !(*policy)->releases) return std::vector<record::ProgramRelease>{};
  auto all = judge_programs(list_programs(profile, rig), *(*policy)->releases);
  std::vector<std::string> refused;
  for (const auto& one : all)
    if (!one.unreleased.empty()) refused.push_back(fmt::format("{} {}", one.title, one.unreleased));
  const bool refuses = !rig.simulated && (*policy)->releases->unreleased == Unreleased::refused;
  if (refuses && !refused.empty())
    return failure(FaultKind::usage, (*policy)->file,
                   fmt::format("the site refuses programs that are not released: {}", fmt::join(refused, "; ")));
  return all;
}

}  // namespace gyrotherm::app
