// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "apps/console/command.hpp"
#include "apps/gyrotherm/prove/proof_page.hpp"
#include "apps/gyrotherm/qualify/axis_experiment.hpp"
#include "apps/gyrotherm/report/calibration_folder.hpp"
#include "apps/gyrotherm/validate/validation.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/sha256.hpp"
#include "report/signed_report.hpp"
#include "report/temperature_certificate.hpp"

namespace gyrotherm::app {
namespace {

using report::Check;

struct SignedReportArguments {
  std::string folder;
  report::Trust trust;
  std::string on_day;
  /// Folder with certificate files; may be empty.
  std::string certificates;
  /// PEM file with the trusted signers of certificate files; may be empty.
  std::string trusted_issuers;
};

/// Returns the file with that name in the folder of the report or in its parent folder; empty if there is none.
std::string find_nearby_file(const std::string& folder, const std::string& name) {
  std::error_code error;
  if (name.empty() || name.find('/') != std::string::npos) return {};
  const std::filesystem::path here = std::filesystem::absolute(folder, error) / "";
  for (const auto& candidate : {here / name, here.parent_path().parent_path() / name})
    if (std::filesystem::is_regular_file(candidate, error)) return candidate.string();
  return {};
}

/// Counts the files of a record, including its parts, that the report names.
int count_named_files(const report::CalibrationReport& report, const std::string& record) {
  return 1 + static_cast<int>(std::ranges::count_if(report.files, [&](const report::UsedFile& file) {
           const auto part = record::part_name(file.name);
           return file.role == "record_part" && part && part->record == record;
         }));
}

/// Returns whether the digest of a record's rows is the one that the report names.
bool has_rows(const std::string& path, const std::string& sha256) {
  const auto record = record::read_record(path);
  return record && digest_rows(*record) == sha256;
}

/// Checks a file on which the report is based by its digest. A record is also verified against its hash chain; its
/// digest may be that of the file or that of its rows.
Check check_used_file(const std::string& folder, const report::CalibrationReport& report,
                      const report::UsedFile& file) {
  using enum Check::Outcome;
  const std::string path = find_nearby_file(folder, file.name);
  if (path.empty()) return {file.name, not_there, "is not next to the report; not checked"};
  const auto digest = record::file_digest(path);
  const bool has_bytes = digest && *digest == file.sha256;
  const Check another{file.name, fails, "is not the file on which the report is based"};
  if (file.role != "record")
    return has_bytes ? Check{file.name, holds, "is the file on which the report is based"} : another;
  const auto verified = record::verify_record(path);
  if (!verified) return {file.name, fails, text(verified.error())};
  if (!has_bytes && !has_rows(path, file.sha256)) return another;
  if (const int named = count_named_files(report, file.name); has_bytes && verified->files != named)
    return {file.name, fails, fmt::format("has {} files, but the report names {}", verified->files, named)};
  return {
      file.name, holds,
      fmt::format("is the file on which the report is based, and all of its {} rows are unchanged", verified->rows)};
}

/// Returns the certificate file with that name: in the given folder if it is there, otherwise near the report.
std::string find_certificate_file(const SignedReportArguments& options, const std::string& name) {
  std::error_code error;
  if (name.find('/') != std::string::npos) return {};
  const std::filesystem::path given = std::filesystem::path(options.certificates) / name;
  if (!options.certificates.empty() && std::filesystem::is_regular_file(given, error)) return given.string();
  return find_nearby_file(options.folder, name);
}

/// Checks the certificate file of a thermometer: its digest, and its own signature.
Check check_certificate_file(const SignedReportArguments& options, const report::UsedFile& file) {
  using enum Check::Outcome;
  const std::string path = find_certificate_file(options, file.name);
  if (path.empty()) return {file.name, not_there, "is not next to the report; not checked"};
  const auto bytes = read_text_file(path, report::kLargestForeignDcc);
  if (!bytes) return {file.name, fails, text(bytes.error())};
  if (sha256(*bytes) != file.sha256) return {file.name, fails, "is not the certificate that the report names"};
  const auto dcc = report::read_foreign_dcc(*bytes, path);
  if (!dcc) return {file.name, fails, text(dcc.error())};
  const report::Trust trust{.certificates_file = options.trusted_issuers,
                            .on_day = options.on_day.empty() ? report::find_issue_day(*dcc) : options.on_day};
  const auto signer = report::verify_foreign_dcc(*bytes, *dcc, path, trust);
  if (!signer) return {file.name, fails, text(signer.error())};
  return {file.name, holds,
          fmt::format("is the certificate that the report names, signed by {}{}", signer->subject,
                      options.trusted_issuers.empty() ? "; whether to trust this signer was not checked" : "")};
}

const char* outcome_name(Check::Outcome outcome) {
  switch (outcome) {
    case Check::Outcome::holds: return "holds";
    case Check::Outcome::fails: return "FAILS";
    case Check::Outcome::not_there: return "not there";
    case Check::Outcome::missing: return "MISSING";
    case Check::Outcome::foreign: return "FOREIGN";
  }
  return "";
}

std::string checks_json(const report::VerifiedReport& found, bool holds) {
  Json json{{"report", found.identifier}, {"holds", holds}, {"signer", nullptr}, {"checks", Json::array()}};
  if (const auto& signer = found.signer)
    json["signer"] = {{"subject", signer->subject},
                      {"issuer", signer->issuer},
                      {"serial_number", signer->serial_number},
                      {"sha256", signer->fingerprint},
                      {"not_after", signer->not_after}};
  for (const Check& check : found.checks)
    json["checks"].push_back({{"what", check.what}, {"outcome", outcome_name(check.outcome)}, {"text", check.text}});
  return json_text(json) + "\n";
}

std::string checks_text(const report::VerifiedReport& found) {
  std::string lines;
  for (const Check& check : found.checks)
    lines += fmt::format("{:<9}  {}: {}\n", outcome_name(check.outcome), check.what, check.text);
  return lines;
}

Result<Exit> verify_signed(Console& console, const SignedReportArguments& options) {
  report::Trust trust = options.trust;
  if (!options.on_day.empty()) trust.on_day = options.on_day;
  if (auto there = check_report_folder(options.folder); !there) return failure(there.error());
  std::error_code error;
  if (!options.certificates.empty() && !std::filesystem::is_directory(options.certificates, error))
    return failure(FaultKind::usage, "--certificates", fmt::format("{} is not a folder", options.certificates));
  for (const auto& file : {trust.certificates_file, options.trusted_issuers})
    if (!file.empty())
      if (auto usable = report::check_trusted_file(file); !usable) return failure(usable.error());
  for (const ProtocolKind& kind : {proof_protocol(), validation_protocol()}) {
    if (!has_protocol(options.folder, kind)) continue;
    const auto signer = verify_protocol(options.folder, kind, trust);
    if (!signer) return failure(signer.error());
    console.print(fmt::format("holds      {}: signed by {}\n", options.folder, signer->subject));
    return Exit::done;
  }
  auto found = report::verify_report(options.folder, trust);
  if (!found) return failure(found.error());
  if (found->report)
    for (const report::UsedFile& file : found->report->files)
      found->checks.push_back(file.role == "certificate_file" ? check_certificate_file(options, file)
                                                              : check_used_file(options.folder, *found->report, file));
  const auto failing = std::ranges::count_if(found->checks, report::is_failure, &Check::outcome);
  console.print(console.json ? checks_json(*found, failing == 0) : checks_text(*found));
  if (failing > 0)
    return failure(
        FaultKind::bad_file, options.folder,
        fmt::format("does not match what was signed: {} of {} checks failed", failing, found->checks.size()));
  console.print_message(fmt::format("{}: report {} matches what was signed", options.folder, found->identifier));
  return Exit::done;
}

}  // namespace

void add_report_verify(Program& program, CLI::App& report) {
  auto [command, options] = add_subcommand(
      program, report, "verify",
      "Checks that the folder of a signed report contains exactly the signed files, unchanged; prints the signer, and "
      "checks any records, models and certificates next to the report against it.",
      "gyrotherm report verify out/report --trusted authority.pem", verify_signed);
  command.add_option("dir", options.folder, "the folder with dcc.xml")->type_name(value::kFolder)->required();
  command
      .add_option("--trusted", options.trust.certificates_file,
                  "trusted certificates, of authorities or of the laboratory, PEM")
      ->type_name(value::kPem)
      ->required();
  command.add_option("--certificates", options.certificates, "a folder with the certificates of the thermometers")
      ->type_name(value::kFolder);
  command
      .add_option("--trusted-issuers", options.trusted_issuers,
                  "trusted signers of the certificates of the thermometers, PEM")
      ->type_name(value::kPem);
  command.add_option("--on", options.on_day, "the day on which certificates must be valid (default: today)")
      ->type_name("YYYY-MM-DD");
}

}  // namespace gyrotherm::app
