// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "apps/console/command.hpp"
#include "apps/gyrotherm/prove/proof_page.hpp"
#include "apps/gyrotherm/qualify/axis_experiment.hpp"
#include "apps/gyrotherm/report/calibration_folder.hpp"
#include "apps/gyrotherm/report/used_files.hpp"
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
  std::vector<std::string> records;  ///< folders with records, models, profiles and rigs
  /// Folder with certificate files; may be empty.
  std::string certificates;
  /// PEM file with the trusted signers of certificate files; may be empty.
  std::string trusted_issuers;
};

/// Checks the certificate file of a thermometer: its digest, and its own signature.
Check check_certificate_file(const SignedReportArguments& options, const report::UsedFile& file,
                             const std::vector<report::UsedFile>& all) {
  using enum Check::Outcome;
  std::vector<std::string> given = options.records;
  if (!options.certificates.empty()) given.insert(given.begin(), options.certificates);
  const std::string path = find_used_file(search_folders(options.folder, given), file, all);
  if (path.empty()) return {file.name, not_there, "was not found; not checked"};
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
    case Check::Outcome::unsigned_beside: return "unsigned";
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
  for (const auto& folder : options.records)
    if (!std::filesystem::is_directory(folder, error))
      return failure(FaultKind::bad_file, folder, "is not a folder, expected one with records of the report");
  if (!options.certificates.empty() && !std::filesystem::is_directory(options.certificates, error))
    return failure(FaultKind::usage, "--certificates", fmt::format("{} is not a folder", options.certificates));
  for (const auto& file : {trust.certificates_file, options.trusted_issuers})
    if (!file.empty())
      if (auto usable = report::check_trusted_file(file); !usable) return failure(usable.error());
  for (const ProtocolKind& kind : {proof_protocol(), validation_protocol()}) {
    if (!has_protocol(options.folder, kind)) continue;
    const auto protocol = verify_protocol(options.folder, kind, trust);
    if (!protocol) return failure(protocol.error());
    console.print(console.json ? checks_json(*protocol, true) : checks_text(*protocol));
    return Exit::done;
  }
  auto found = report::verify_report(options.folder, trust);
  if (!found) return failure(found.error());
  const SearchFolders folders = search_folders(options.folder, options.records);
  if (found->report)
    for (const report::UsedFile& file : found->report->files)
      found->checks.push_back(file.role == "certificate_file"
                                  ? check_certificate_file(options, file, found->report->files)
                                  : check_used_file(folders, *found->report, file));
  const auto failing = std::ranges::count_if(found->checks, report::is_failure, &Check::outcome);
  console.print(console.json ? checks_json(*found, failing == 0) : checks_text(*found));
  if (failing > 0)
    return failure(FaultKind::bad_file, options.folder,
                   fmt::format("{} of {} checks failed, so the report is not verified", failing, found->checks.size()));
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
  command
      .add_option("--records", options.records,
                  "a folder with the records, models, profiles and rigs of the report; may be repeated")
      ->type_name(value::kFolder);
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
