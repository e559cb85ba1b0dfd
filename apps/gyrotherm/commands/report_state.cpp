// SPDX-License-Identifier: Apache-2.0
/// `report authorise`, `report sign` and `report supersede`: changes of a report's state from draft to authorised,
/// signed and superseded.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "apps/console/command.hpp"
#include "apps/gyrotherm/prove/proof_page.hpp"
#include "apps/gyrotherm/report/calibration_folder.hpp"
#include "apps/gyrotherm/report/draft_check.hpp"
#include "apps/gyrotherm/validate/validation.hpp"
#include "core/clock.hpp"
#include "core/text.hpp"
#include "report/order.hpp"
#include "report/signed_report.hpp"

namespace gyrotherm::app {
namespace {

struct StateArguments {
  std::string folder, by, reason;
};

struct AuthoriseArguments {
  std::string by;
  DraftCheckOptions draft;
};

Result<Exit> rewrite_report(Console& console, const FiledReport& filed, const std::string& folder,
                            bool sources_compared = false) {
  if (auto written = write_calibration(console, filed.report, folder, languages_in(folder), sources_compared); !written)
    return failure(written.error());
  return Exit::done;
}

/// Fails unless a report is a draft, or an unsigned authorised report that must be authorised again: its views have
/// changed since, or gyrotherm 0.1.0 authorised it without storing digests.
Result<void> check_may_be_authorised(Console& console, const FiledReport& filed, const std::string& folder) {
  const report::CalibrationReport& report = filed.report;
  if (report.state == report::ReportState::draft) return {};
  const auto refused = failure(FaultKind::usage, filed.path, fmt::format("is {}, not a draft", name(report.state)));
  if (report.state != report::ReportState::authorised) return refused;
  const auto already = report::is_signed(folder);
  if (!already) return failure(already.error());
  if (*already) return failure(FaultKind::usage, filed.path, "is signed; a signed report cannot be authorised again");
  const auto differences = report::compare_with_authorisation(folder, report);
  if (differences && differences->changed.empty() && differences->missing.empty()) return refused;
  console.print_message(fmt::format("{}: was authorised by {}; since then: {}", filed.path,
                                    plain(report.authorised->name),
                                    differences ? text(*differences) : text(differences.error())));
  return {};
}

/// Fails if the days of the report contradict each other or the time of the authorisation. For a simulated report,
/// whose days come from a virtual clock, the contradictions are printed instead.
Result<void> check_days(Console& console, const report::CalibrationReport& report, const std::string& now) {
  std::vector<std::string> wrong = report::find_wrong_days(report);
  std::ranges::move(report::find_days_against_authorisation(report, now), std::back_inserter(wrong));
  if (wrong.empty()) return {};
  if (report.simulated) {
    console.print_message(fmt::format("SIMULATED, therefore accepted: {}", fmt::join(wrong, "; ")));
    return {};
  }
  return failure(FaultKind::usage, report.number,
                 fmt::format("has days that contradict each other: {}; make the report again with a corrected order",
                             fmt::join(wrong, "; ")));
}

Result<Exit> authorise(Console& console, const AuthoriseArguments& options) {
  const std::string& folder = options.draft.folder;
  if (auto there = check_report_folder(folder); !there) return failure(there.error());
  auto filed = load_calibration(folder);
  if (!filed) return failure(filed.error());
  report::CalibrationReport& report = filed->report;
  if (auto may = check_may_be_authorised(console, *filed, folder); !may) return failure(may.error());
  auto missing = report.missing;
  for (const std::string& one : report::find_placeholders(report))  // drafts of gyrotherm 0.1.0
    if (std::ranges::find(missing, one) == missing.end()) missing.push_back(one);
  if (!missing.empty())
    return failure(FaultKind::usage, filed->path, fmt::format("is incomplete; missing: {}", fmt::join(missing, "; ")));
  if (auto may = report::check_may_authorise(report.people, options.by); !may) return failure(may.error());
  const auto draft = check_draft(console, *filed, options.draft);
  if (!draft) return failure(draft.error());
  if (auto may = report::check_may_authorise(draft->laboratory.people, options.by); !may) return failure(may.error());
  const std::string now = civil_time(SteadyClock().now().utc);
  if (auto in_time = check_days(console, report, now); !in_time) return failure(in_time.error());
  report.state = report::ReportState::authorised;
  report.authorised = report::Authorisation{options.by, now};
  return rewrite_report(console, *filed, folder, draft->sources_compared);
}

struct SigningArguments {
  std::string folder;
  report::SigningKey key;
};

Result<Exit> sign_folder(Console& console, const SigningArguments& options) {
  if (auto there = check_report_folder(options.folder); !there) return failure(there.error());
  if (const auto signer = report::read_signer_of(options.key); signer && !describe_weak_key(*signer).empty())
    console.print_message("warning: " + describe_weak_key(*signer));
  for (const ProtocolKind& kind : {proof_protocol(), validation_protocol()}) {
    if (!has_protocol(options.folder, kind)) continue;
    if (auto done = sign_protocol(options.folder, kind, options.key); !done) return failure(done.error());
    console.print_message(fmt::format("{}: signed the protocol {}.json", options.folder, kind.stem));
    return Exit::done;
  }
  if (auto usable = report::check_signing_key_without_prompt(options.key); !usable) return failure(usable.error());
  const auto names =
      report::sign_report(options.folder, options.key, render_calibration, civil_time(SteadyClock().now().utc));
  if (!names) return failure(names.error());
  console.print_message(fmt::format("{}: signed {}", options.folder, fmt::join(*names, ", ")));
  return Exit::done;
}

/// Fails unless the order of `by` names the report of `filed` in [replaces], with its number and, if given, its
/// SHA-256.
Result<void> check_names_replaced(const FiledReport& by, const FiledReport& filed) {
  const auto refused = [&](const std::string& why) { return failure(FaultKind::usage, by.path, plain(why)); };
  const report::CalibrationReport &one = by.report, &report = filed.report;
  if (report.replaces && report.replaces->number == one.number)
    return refused(fmt::format("is the replaced report: {} replaces {}; supersede {} by {} instead", report.number,
                               one.number, one.number, report.number));
  if (!one.replaces)
    return refused(fmt::format("does not replace a report; name {} in [replaces] of its order", report.number));
  if (one.replaces->number != report.number)
    return refused(fmt::format("replaces {}, not {}", one.replaces->number, report.number));
  if (const std::string& digest = one.replaces->sha256; !digest.empty() && digest != filed.sha256)
    return refused(fmt::format("replaces a report with SHA-256 {}, but {} has {}", digest, filed.path, filed.sha256));
  return {};
}

/// Fails unless `by` may replace the report of `filed`: it is authorised, covers the same unit, has another number,
/// names that report, and both or neither are simulated.
Result<void> check_may_replace(const FiledReport& by, const FiledReport& filed) {
  const auto refused = [&](const std::string& why) { return failure(FaultKind::usage, by.path, why); };
  const report::CalibrationReport &one = by.report, &report = filed.report;
  if (one.number == report.number) return refused(fmt::format("has the same number, {}", report.number));
  if (one.state != report::ReportState::authorised)
    return refused(fmt::format("is {}; only an authorised report can replace another", name(one.state)));
  if (one.item.model != report.item.model || one.item.serial_number != report.item.serial_number)
    return refused(fmt::format("covers another unit: {} {}, expected {} {}", one.item.model, one.item.serial_number,
                               report.item.model, report.item.serial_number));
  if (one.simulated != report.simulated)
    return refused(one.simulated ? fmt::format("is SIMULATED, but {} is a report of real measurements", report.number)
                                 : fmt::format("is a report of real measurements, but {} is SIMULATED", report.number));
  return check_names_replaced(by, filed);
}

Result<Exit> supersede(Console& console, const StateArguments& options) {
  if (auto there = check_report_folder(options.folder); !there) return failure(there.error());
  auto filed = load_calibration(options.folder);
  const auto by = load_calibration(options.by);
  if (!filed || !by) return failure(filed ? by.error() : filed.error());
  report::CalibrationReport& report = filed->report;
  if (report.state == report::ReportState::superseded)
    return failure(FaultKind::usage, filed->path,
                   fmt::format("is already superseded by {}", report.replaced_by->number));
  if (auto may = check_may_replace(*by, *filed); !may) return failure(may.error());
  if (report.state == report::ReportState::draft)
    return failure(FaultKind::usage, filed->path,
                   "is a draft, which was never valid; only an authorised report can be superseded");
  for (const FiledReport* one : {&std::as_const(*filed), &*by})
    if (auto same = check_is_unchanged(console, *one, WithoutDigest::refused); !same) return failure(same.error());
  if (auto kept = copy_signed_report(console, options.folder); !kept) return failure(kept.error());
  report.state = report::ReportState::superseded;
  const report::Texts reason =
      options.reason.empty() ? by->report.replaces->reason : report::Texts{options.reason, options.reason};
  report.replaced_by = report::OtherReport{by->report.number, by->sha256, reason};
  return rewrite_report(console, *filed, options.folder);
}

void add_authorise(Program& program, CLI::App& report) {
  auto [command, options] = add_subcommand(
      program, report, "authorise",
      "Authorises a complete draft: a person with the role authorising releases it unchanged as a report.",
      "gyrotherm report authorise out/calibration --by \"A. Metrologist\"", authorise);
  command.add_option("folder", options.draft.folder, "the folder of the report")->type_name(value::kFolder)->required();
  command.add_option("--by", options.by, "a person with the role authorising in laboratory.toml")
      ->type_name("NAME")
      ->required();
  command
      .add_option("--laboratory", options.draft.laboratory,
                  "laboratory.toml, which gives the role authorising (default: the one of the draft)")
      ->type_name(value::kToml);
  command
      .add_option("--records", options.draft.records,
                  "a folder with records, models or the order of the draft, if they were moved; may be repeated")
      ->type_name(value::kFolder);
  command.add_flag("--without-sources", options.draft.without_sources,
                   "authorise although records, models or the order are not found; the authorisation states it");
}

void add_supersede(Program& program, CLI::App& report) {
  auto [command, options] =
      add_subcommand(program, report, "supersede", "Marks a report as superseded and names its replacement.",
                     "gyrotherm report supersede out/calibration --by out/calibration-2", supersede);
  command.add_option("folder", options.folder, "the folder of the report")->type_name(value::kFolder)->required();
  command.add_option("--by", options.by, "the folder of the replacement")->type_name(value::kFolder)->required();
  command
      .add_option("--reason", options.reason,
                  "the reason (default: that of [replaces] in the order of the replacement)")
      ->type_name("TEXT");
}

}  // namespace

void add_report_state(Program& program, CLI::App& report) {
  add_authorise(program, report);
  add_supersede(program, report);
}

void add_report_sign(Program& program, CLI::App& report) {
  auto [command, options] =
      add_subcommand(program, report, "sign",
                     "Signs an authorised report: its PDF, and the certificate dcc.xml that covers all its files.",
                     "gyrotherm report sign out/report --key lab.key --certificate lab.pem", sign_folder);
  command.add_option("dir", options.folder, "the folder with calibration.json, proof.json or validation.json")
      ->type_name(value::kFolder)
      ->required();
  command.add_option("--key", options.key.key_file, "the laboratory's private key, RSA, PEM")
      ->type_name(value::kPem)
      ->required();
  command.add_option("--certificate", options.key.certificate_file, "its certificate and the chain above it, PEM")
      ->type_name(value::kPem)
      ->required();
  command
      .add_option("--password-file", options.key.password_file, "a file with the password of the key in its first line")
      ->type_name(value::kFile);
}

}  // namespace gyrotherm::app
