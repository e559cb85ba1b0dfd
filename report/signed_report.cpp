// SPDX-License-Identifier: Apache-2.0
#include "report/signed_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "core/file.hpp"
#include "core/sha256.hpp"
#include "core/text.hpp"
#include "report/dcc.hpp"
#include "report/dcc_text.hpp"
#include "report/draft.hpp"
#include "report/other_program.hpp"
#include "report/report_files.hpp"

namespace gyrotherm::report {
namespace {

constexpr const char* kIsLink = "is a symbolic link, expected a file of the report itself";

bool is_pdf(const std::string& name) { return name.ends_with(".pdf"); }

std::string join_path(const std::string& folder, const std::string& name) { return folder + "/" + name; }

/// Signs the PDFs among the rendered files.
Result<std::vector<NewFile>> sign_pdfs(const std::string& folder, const std::vector<NewFile>& files,
                                       const SigningKey& key, const std::string& number) {
  const auto place = PrivateFolder::make();
  if (!place) return failure(place.error());
  std::string reason = "Calibration report ";
  for (const char c : number) reason += c >= ' ' && c <= '~' ? c : '_';
  std::vector<NewFile> pdfs;
  for (const NewFile& file : files) {
    if (!is_pdf(file.name)) continue;
    const std::string rendered = *place / "rendered.pdf", path = *place / "signed.pdf";
    if (auto put = replace_own_file(rendered, file.bytes, Syncing::not_awaited); !put) return failure(put.error());
    if (auto made = sign_pdf(rendered, path, key, reason); !made)
      return failure(made.error().kind,
                     made.error().where == rendered || made.error().where == path ? join_path(folder, file.name)
                                                                                  : made.error().where,
                     made.error().what);
    auto bytes = read_text_file(path, kLargestTable);
    if (!bytes) return failure(bytes.error());
    pdfs.push_back({file.name, std::move(*bytes)});
  }
  return pdfs;
}

Result<CalibrationReport> read_report_to_sign(const std::string& json, const std::string& path) {
  auto report = calibration_from_json(json, path);
  if (!report) return report;
  if (report->state == ReportState::draft || !report->authorised)
    return failure(FaultKind::bad_file, path, "is a draft; authorise the report before signing it");
  if (report->state == ReportState::superseded)
    return failure(FaultKind::bad_file, path, "has been replaced; sign the report that replaces it");
  return report;
}

/// Compares two times, such as "2026-11-25T14:03:07Z", to the second. Returns false if one of them is not such a time.
bool is_before(std::string_view one, std::string_view other) {
  constexpr std::size_t kToTheSecond = std::string_view("2026-11-25T14:03:07").size();
  const auto is_time = [](std::string_view text) {
    return text.size() > kToTheSecond && text[10] == 'T' && text.ends_with('Z');
  };
  return is_time(one) && is_time(other) && one.substr(0, kToTheSecond) < other.substr(0, kToTheSecond);
}

Result<AuthorisedFiles> read_authorisation(const std::string& folder) {
  const std::string path = join_path(folder, kAuthorisationFile);
  if (is_symbolic_link(path)) return failure(FaultKind::bad_file, path, kIsLink);
  const auto json = read_text_file_if_any(path, kLargestTable);
  if (!json) return failure(json.error());
  if (!*json)
    return failure(FaultKind::bad_file, path,
                   "is missing, for example because gyrotherm 0.1.0 authorised the report; authorise the report again");
  auto authorised = authorised_files_from_json(**json, path);
  if (authorised && to_json(*authorised) != **json)
    return failure(FaultKind::bad_file, path, "was changed by hand; authorise the report again");
  return authorised;
}

FolderDifferences compare_folder(const std::string& folder, const AuthorisedFiles& authorised,
                                 const CalibrationReport& report) {
  auto found = compare_folder(folder, authorised.files, report.files, {kAuthorisationFile, kDccFile, kSourcesFile});
  const auto& by = report.authorised;
  if (authorised.number != report.number || !by || by->name != authorised.authorised.name ||
      by->utc != authorised.authorised.utc)
    found.changed.emplace_back(kAuthorisationFile);
  return found;
}

/// Renders the files of the report again and checks them against the authorised hashes. Returns the files sorted by
/// name, without the unsigned dcc.xml.
Result<std::vector<NewFile>> render_authorised_files(const std::string& folder, const AuthorisedFiles& authorised,
                                                     const CalibrationReport& report, const RenderFiles& render) {
  std::vector<std::string> names;
  for (const IssuedFile& file : authorised.files) names.push_back(file.name);
  const auto rendered = render(report, names);
  if (!rendered) return failure(rendered.error());
  std::vector<NewFile> files;
  for (const IssuedFile& file : authorised.files) {
    const auto made = std::ranges::find(*rendered, file.name, &NewFile::name);
    if (made == rendered->end() || sha256(made->bytes) != file.sha256)
      return failure(
          FaultKind::bad_file, join_path(folder, file.name),
          fmt::format(
              "differs from the file that this program renders from calibration.json; gyrotherm {} rendered the "
              "authorised file; authorise the report again",
              plain(authorised.program_version)));
    if (file.name != kDccFile) files.push_back(*made);
  }
  std::ranges::sort(files, {}, &NewFile::name);
  return files;
}

/// Lists the files with their hashes, calibration.json first and authorisation.json last. The hash of a PDF is computed
/// from the signed PDF. The embedded PDF is the one in this language, or the first one if there is none.
DccOptions make_dcc_options(const std::vector<NewFile>& files, const std::vector<NewFile>& pdfs,
                            const AuthorisedFiles& authorised, Language language) {
  DccOptions options;
  for (const bool first : {true, false})
    for (const NewFile& file : files) {
      if ((file.name == kCalibrationFile) != first) continue;
      const auto pdf = std::ranges::find(pdfs, file.name, &NewFile::name);
      options.files.push_back({file.name, sha256(pdf != pdfs.end() ? pdf->bytes : file.bytes)});
    }
  options.files.push_back({kAuthorisationFile, sha256(to_json(authorised))});
  if (pdfs.empty()) return options;
  const char* const wanted = language == Language::german ? "calibration.de.pdf" : "calibration.pdf";
  const auto found = std::ranges::find(pdfs, std::string(wanted), &NewFile::name);
  const NewFile& pdf = found == pdfs.end() ? pdfs.front() : *found;
  options.pdf = ReadableReport{pdf.name, pdf.bytes};
  return options;
}

/// Verifies the files listed in the certificate.
class FileChecks {
 public:
  FileChecks(std::string folder, const Trust& trust, const Signer& signer)
      : folder_(std::move(folder)), trust_(trust), signer_(signer) {}

  Result<Check> check(const IssuedFile& file) const {
    using enum Check::Outcome;
    if (file.name.find('/') != std::string::npos) return Check{file.name, fails, "is not a file name"};
    const std::string path = folder_ + "/" + file.name;
    if (is_symbolic_link(path)) return Check{file.name, fails, kIsLink};
    const auto bytes = read_text_file_if_any(path, kLargestTable);
    if (!bytes) return Check{file.name, fails, text(bytes.error())};
    if (!*bytes) return Check{file.name, missing, "was signed with the report but is missing from the folder"};
    if (sha256(**bytes) != file.sha256) return Check{file.name, fails, "was changed after it was signed"};
    return is_pdf(file.name) ? pdf(file.name, path) : Check{file.name, holds, "unchanged since it was signed"};
  }

 private:
  Result<Check> pdf(const std::string& name, const std::string& path) const {
    using enum Check::Outcome;
    const auto signer = verify_pdf(path, trust_);
    if (!signer && signer.error().where == path) return Check{name, fails, signer.error().what};
    if (!signer && signer.error().kind != FaultKind::bad_file) return Check{name, fails, text(signer.error())};
    if (!signer) return failure(signer.error());
    if (*signer != signer_) return Check{name, fails, "has a different signer: " + signer->subject};
    return Check{name, holds, "unchanged since it was signed, by the same signer"};
  }

  std::string folder_;
  const Trust& trust_;
  const Signer& signer_;
};

std::string signer_text(const Signer& signer) {
  const std::string weak = describe_weak_key(signer);
  return fmt::format("signed by {}, certificate {} of {}, valid until {}{}{}", signer.subject, signer.serial_number,
                     signer.issuer, signer.not_after, weak.empty() ? "" : "; ", weak);
}

/// Names the signed copy of a superseded report, whose own dcc.xml is not signed; empty if there is none.
std::string describe_signed_copy(const std::string& folder, std::string_view dcc) {
  const std::string copy = join_path(folder, kSignedCopyFolder);
  if (dcc.find("<ds:Signature") != std::string_view::npos || !std::filesystem::exists(join_path(copy, kDccFile)))
    return {};
  return plain(fmt::format(": the report is superseded; verify the report as it was signed, {}", copy));
}

/// Returns the failed check of a PDF whose signature is older than the authorisation of its report, or younger than the
/// day (UTC) for which it is verified; nothing otherwise, or if the time of the signature is unknown.
Result<std::optional<Check>> check_signing_time(const std::string& folder, const std::string& name,
                                                const std::optional<CalibrationReport>& report, const Trust& trust) {
  if (!is_pdf(name) || !report || !report->authorised) return std::optional<Check>();
  const auto signed_utc = find_signing_time(join_path(folder, name));
  if (!signed_utc) return failure(signed_utc.error());
  if (!*signed_utc) return std::optional<Check>();
  if (trust.on_day && is_before(*trust.on_day + "T23:59:59Z", **signed_utc))
    return Check{
        name, Check::Outcome::fails,
        plain(fmt::format("was signed at {}, after the day {} for which it is verified", **signed_utc, *trust.on_day))};
  if (!is_before(**signed_utc, report->authorised->utc)) return std::optional<Check>();
  return Check{name, Check::Outcome::fails,
               plain(fmt::format("was signed at {}, before the report was authorised at {}", **signed_utc,
                                 report->authorised->utc))};
}

/// Returns the failed check of a report that is verified for a day (UTC) before its authorisation.
std::optional<Check> check_day(const CalibrationReport& report, const Trust& trust) {
  if (!report.authorised || !trust.on_day) return {};
  if (!is_before(*trust.on_day + "T23:59:59Z", report.authorised->utc)) return {};
  return Check{"authorisation", Check::Outcome::fails,
               plain(fmt::format("the report was authorised at {}, after the day {} for which it is verified",
                                 report.authorised->utc, *trust.on_day))};
}

/// Returns what authorisation.json states about the comparison of the report with its sources.
std::string describe_comparison(const std::string& folder) {
  const auto authorised = read_authorisation(folder);
  if (!authorised) return {};
  return authorised->sources_compared ? "; the report was compared with its records before it was authorised"
                                      : "; the report was authorised without a comparison with its records";
}

/// Returns true if the fault is a failed check of the certificate, and false if the verification itself could not run.
bool is_check_result(const Fault& fault, const std::string& path) { return fault.where.starts_with(path); }

}  // namespace

bool is_failure(Check::Outcome outcome) {
  using enum Check::Outcome;
  return outcome != holds && outcome != not_there && outcome != unsigned_beside;
}

Result<bool> is_signed(const std::string& folder) {
  const auto dcc = read_text_file_if_any(join_path(folder, kDccFile), kLargestTable);
  if (!dcc) return failure(dcc.error());
  return *dcc && (*dcc)->find("<ds:Signature") != std::string::npos;
}

Result<std::vector<IssuedFile>> list_signed_files(const std::string& folder) {
  const std::string path = join_path(folder, kDccFile);
  const auto dcc = read_text_file(path, kLargestTable);
  if (!dcc) return failure(dcc.error());
  const auto text = remove_signature(*dcc, path);
  if (!text) return failure(text.error());
  auto read = read_dcc(*text, path);
  if (!read) return failure(read.error());
  return std::move(read->files);
}

Result<std::string> find_expected_digest(const std::string& folder) {
  const auto has_signature = is_signed(folder);
  if (!has_signature) return failure(has_signature.error());
  std::vector<IssuedFile> files;
  if (*has_signature) {
    auto listed = list_signed_files(folder);
    if (!listed) return failure(listed.error());
    files = std::move(*listed);
  } else if (std::filesystem::exists(join_path(folder, kAuthorisationFile))) {
    auto authorised = read_authorisation(folder);
    if (!authorised) return failure(authorised.error());
    files = std::move(authorised->files);
  }
  const auto report = std::ranges::find(files, std::string(kCalibrationFile), &IssuedFile::name);
  return report == files.end() ? std::string() : report->sha256;
}

Result<FolderDifferences> compare_with_authorisation(const std::string& folder, const CalibrationReport& report) {
  const auto authorised = read_authorisation(folder);
  if (!authorised) return failure(authorised.error());
  return compare_folder(folder, *authorised, report);
}

Result<std::vector<std::string>> sign_report(const std::string& folder, const SigningKey& key,
                                             const RenderFiles& render, const std::string& now_utc) {
  const auto already = is_signed(folder);
  if (!already) return failure(already.error());
  if (*already) return failure(FaultKind::bad_file, join_path(folder, kDccFile), "is already signed");
  const std::string path = join_path(folder, kCalibrationFile);
  const auto json = read_text_file(path, kLargestTable);
  if (!json) return failure(json.error());
  const auto report = read_report_to_sign(*json, path);
  if (!report) return failure(report.error());
  if (is_before(now_utc, report->authorised->utc))
    return failure(FaultKind::usage, path,
                   plain(fmt::format("was authorised at {}, after the time of this computer, {}; check its clock",
                                     report->authorised->utc, now_utc)));
  const auto authorised = read_authorisation(folder);
  if (!authorised) return failure(authorised.error());
  if (const auto differences = compare_folder(folder, *authorised, *report); !differences.empty())
    return failure(
        FaultKind::bad_file, folder,
        fmt::format("was changed after {} authorised it: {}", plain(authorised->authorised.name), text(differences)));
  const auto files = render_authorised_files(folder, *authorised, *report, render);
  if (!files) return failure(files.error());
  const auto unlocked = UnlockedKey::make(key);
  if (!unlocked) return failure(unlocked.error());
  auto pdfs = sign_pdfs(folder, *files, unlocked->key(), report->number);
  if (!pdfs) return failure(pdfs.error());
  const DccOptions options = make_dcc_options(*files, *pdfs, *authorised, mandatory_language(*report));
  const auto dcc = make_dcc(*report, options);
  if (!dcc) return failure(dcc.error());
  const auto signed_dcc = sign_dcc(*dcc, unlocked->key());
  if (!signed_dcc) return failure(signed_dcc.error());
  pdfs->push_back({kDccFile, *signed_dcc});
  if (auto put = replace_all(folder, *pdfs); !put) return failure(put.error());
  std::error_code error;  // a remaining file would be reported as foreign
  std::filesystem::remove(join_path(folder, kSourcesFile), error);
  std::vector<std::string> all{kDccFile};
  for (const IssuedFile& file : options.files) all.push_back(file.name);
  return all;
}

Result<VerifiedReport> verify_report(const std::string& folder, const Trust& trust) {
  using enum Check::Outcome;
  VerifiedReport found;
  const std::string path = folder + "/" + kDccFile;
  if (is_symbolic_link(path)) {
    found.checks.push_back({kDccFile, fails, kIsLink});
    return found;
  }
  const auto bytes = read_text_file(path, kLargestTable);
  if (!bytes) return failure(bytes.error());
  const auto signer = verify_dcc(*bytes, path, trust);
  if (!signer) {
    if (!is_check_result(signer.error(), path)) return failure(signer.error());
    found.checks.push_back({kDccFile, fails, signer.error().what + describe_signed_copy(folder, *bytes)});
    return found;
  }
  found.signer = *signer;
  found.checks.push_back({kDccFile, holds, signer_text(*signer)});
  const auto text = remove_signature(*bytes, path);
  if (!text) return failure(text.error());
  const auto read = read_dcc(*text, path);
  if (!read) return failure(read.error());
  found.identifier = read->identifier;
  const FileChecks files(folder, trust, *signer);
  for (const IssuedFile& file : read->files) {
    auto check = files.check(file);
    if (!check) return failure(check.error());
    const bool is_report = file.name == kCalibrationFile && check->outcome == holds;
    if (check->outcome == holds) {
      auto wrong_time = check_signing_time(folder, file.name, found.report, trust);
      if (!wrong_time) return failure(wrong_time.error());
      if (*wrong_time) check = std::move(**wrong_time);
    }
    if (file.name == kAuthorisationFile && check->outcome == holds) check->text += describe_comparison(folder);
    found.checks.push_back(std::move(*check));
    if (!is_report) continue;
    const auto json = read_text_file(folder + "/" + kCalibrationFile, kLargestTable);
    if (!json || sha256(*json) != file.sha256) continue;
    if (auto report = calibration_from_json(*json, kCalibrationFile)) found.report = std::move(*report);
  }
  if (found.report)
    if (auto too_early = check_day(*found.report, trust)) found.checks.push_back(std::move(*too_early));
  std::vector<std::string> names{kDccFile};
  for (const IssuedFile& file : read->files) names.push_back(file.name);
  const auto used = found.report ? found.report->files : std::vector<UsedFile>();
  for (const std::string& name : find_unlisted_entries(folder, names, used))
    found.checks.push_back({plain(name), foreign, "is not part of the report that was signed"});
  for (const std::string& name : find_unsigned_entries(folder, used))
    found.checks.push_back({plain(name), unsigned_beside, "belongs to a record, but was not signed"});
  return found;
}

}  // namespace gyrotherm::report
