// SPDX-License-Identifier: Apache-2.0
#include "report/signed_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "core/file.hpp"
#include "core/sha256.hpp"
#include "report/dcc.hpp"
#include "report/dcc_reader.hpp"
#include "report/new_files.hpp"
#include "report/other_program.hpp"

namespace gyrotherm::report {
namespace {

bool is_pdf(const std::string& name) { return name.ends_with(".pdf"); }

/// The files beside calibration.json that are issued with it, by name.
std::vector<std::string> issued_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& path : entries_of(folder)) {
    const std::string name = path.filename().string();
    std::error_code error;
    const bool issued = is_pdf(name) || name.ends_with(".html") || name.ends_with(".csv");
    if (issued && std::filesystem::is_regular_file(path, error)) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

/// The PDFs of the folder, signed.
Result<std::vector<NewFile>> signed_pdfs(const std::string& folder, const std::vector<std::string>& names,
                                         const SigningKey& key, const std::string& number) {
  const auto place = PrivateFolder::make();
  if (!place) return failure(place.error());
  std::string reason = "Calibration report ";
  for (const char c : number) reason += c >= ' ' && c <= '~' ? c : '_';
  std::vector<NewFile> files;
  for (const std::string& name : names) {
    if (!is_pdf(name)) continue;
    const std::string path = *place / "signed.pdf";
    if (auto made = sign_pdf(folder + "/" + name, path, key, reason); !made) return failure(made.error());
    auto bytes = read_text_file(path, kLargestTable);
    if (!bytes) return failure(bytes.error());
    files.push_back({name, std::move(*bytes)});
  }
  return files;
}

Result<void> is_unsigned(const std::string& folder) {
  const std::string path = folder + "/" + kDccFile;
  const auto dcc = read_text_file_if_any(path, kLargestTable);
  if (!dcc) return failure(dcc.error());
  if (*dcc && (*dcc)->find("<ds:Signature") != std::string::npos)
    return failure(FaultKind::bad_file, path, "is signed already");
  return {};
}

Result<CalibrationReport> report_to_sign(const std::string& json, const std::string& path) {
  auto report = calibration_from_json(json, path);
  if (!report) return report;
  if (report->state == ReportState::draft || !report->authorised)
    return failure(FaultKind::bad_file, path, "is a draft; only a report that somebody has authorised is signed");
  if (report->state == ReportState::superseded)
    return failure(FaultKind::bad_file, path, "has been replaced; sign the report that replaces it");
  return report;
}

Result<DccOptions> options_for(const std::string& folder, const std::string& json, const std::vector<NewFile>& pdfs,
                               const std::vector<std::string>& names) {
  DccOptions options;
  options.files.push_back({kCalibrationFile, sha256(json)});
  for (const std::string& name : names) {
    const auto pdf = std::ranges::find(pdfs, name, &NewFile::name);
    auto bytes =
        pdf != pdfs.end() ? Result<std::string>(pdf->bytes) : read_text_file(folder + "/" + name, kLargestTable);
    if (!bytes) return failure(bytes.error());
    options.files.push_back({name, sha256(*bytes)});
  }
  if (!pdfs.empty()) options.pdf = ReadableReport{pdfs.front().name, pdfs.front().bytes};
  return options;
}

/// Looks at one file that the certificate names.
class FileChecks {
 public:
  FileChecks(std::string folder, const Trust& trust, const Signer& signer)
      : folder_(std::move(folder)), trust_(trust), signer_(signer) {}

  Result<Check> check(const IssuedFile& file) const {
    using enum Check::Outcome;
    if (file.name.find('/') != std::string::npos) return Check{file.name, fails, "is no name of a file"};
    const std::string path = folder_ + "/" + file.name;
    const auto bytes = read_text_file_if_any(path, kLargestTable);
    if (!bytes) return Check{file.name, fails, text(bytes.error())};
    if (!*bytes) return Check{file.name, file.name == kCalibrationFile ? fails : not_there, "is not there"};
    if (sha256(**bytes) != file.sha256) return Check{file.name, fails, "is not the file that was signed"};
    return is_pdf(file.name) ? pdf(file.name, path) : Check{file.name, holds, "as it was signed"};
  }

 private:
  Result<Check> pdf(const std::string& name, const std::string& path) const {
    using enum Check::Outcome;
    const auto signer = verify_pdf(path, trust_);
    if (!signer && signer.error().where == path) return Check{name, fails, signer.error().what};
    if (!signer && signer.error().kind != FaultKind::bad_file) return Check{name, fails, text(signer.error())};
    if (!signer) return failure(signer.error());
    if (*signer != signer_) return Check{name, fails, "is signed by another: " + signer->subject};
    return Check{name, holds, "as it was signed, by the same signer"};
  }

  std::string folder_;
  const Trust& trust_;
  const Signer& signer_;
};

std::string named(const Signer& signer) {
  return fmt::format("signed by {}, certificate {} of {}, valid until {}", signer.subject, signer.serial_number,
                     signer.issuer, signer.not_after);
}

/// What the signature over a certificate is worth is a check; that it could not be looked at is a fault.
bool is_a_check(const Fault& fault, const std::string& path, const Trust& trust) {
  return fault.where.starts_with(path) ||
         (fault.where == trust.certificates_file && fault.what.starts_with("the signer is not trusted"));
}

}  // namespace

Result<std::vector<std::string>> sign_report(const std::string& folder, const SigningKey& key) {
  if (auto fresh = is_unsigned(folder); !fresh) return failure(fresh.error());
  const std::string path = folder + "/" + kCalibrationFile;
  const auto json = read_text_file(path, kLargestTable);
  if (!json) return failure(json.error());
  const auto report = report_to_sign(*json, path);
  if (!report) return failure(report.error());
  const auto names = issued_in(folder);
  auto pdfs = signed_pdfs(folder, names, key, report->number);
  if (!pdfs) return failure(pdfs.error());
  const auto options = options_for(folder, *json, *pdfs, names);
  if (!options) return failure(options.error());
  const auto dcc = dcc_of(*report, *options);
  if (!dcc) return failure(dcc.error());
  const auto signed_dcc = sign_dcc(*dcc, key);
  if (!signed_dcc) return failure(signed_dcc.error());
  std::vector<std::string> all;
  pdfs->push_back({kDccFile, *signed_dcc});
  if (auto put = replace_all(folder, *pdfs); !put) return failure(put.error());
  all.emplace_back(kDccFile);
  for (const IssuedFile& file : options->files) all.push_back(file.name);
  return all;
}

Result<VerifiedReport> verify_report(const std::string& folder, const Trust& trust) {
  using enum Check::Outcome;
  VerifiedReport found;
  const std::string path = folder + "/" + kDccFile;
  const auto bytes = read_text_file(path, kLargestTable);
  if (!bytes) return failure(bytes.error());
  const auto signer = verify_dcc(*bytes, path, trust);
  if (!signer) {
    if (!is_a_check(signer.error(), path, trust)) return failure(signer.error());
    found.checks.push_back({kDccFile, fails, signer.error().what});
    return found;
  }
  found.signer = *signer;
  found.checks.push_back({kDccFile, holds, named(*signer)});
  const auto text = without_signature(*bytes, path);
  if (!text) return failure(text.error());
  const auto read = read_dcc(*text, path);
  if (!read) return failure(read.error());
  found.identifier = read->identifier;
  const FileChecks files(folder, trust, *signer);
  for (const IssuedFile& file : read->files) {
    auto check = files.check(file);
    if (!check) return failure(check.error());
    const bool is_report = file.name == kCalibrationFile && check->outcome == holds;
    found.checks.push_back(std::move(*check));
    if (!is_report) continue;
    const auto json = read_text_file(folder + "/" + kCalibrationFile, kLargestTable);
    if (!json || sha256(*json) != file.sha256) continue;
    if (auto report = calibration_from_json(*json, kCalibrationFile)) found.report = std::move(*report);
  }
  return found;
}

}  // namespace gyrotherm::report
