// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/protocol_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/file.hpp"
#include "core/sha256.hpp"
#include "core/text.hpp"
#include "report/dcc.hpp"
#include "report/report_files.hpp"

namespace gyrotherm::app {
namespace {

constexpr auto kProtocolLanguages = {report::Language::english, report::Language::german};

std::string json_path(const std::string& folder, const ProtocolKind& kind) {
  return fmt::format("{}/{}.json", folder, kind.stem);
}
std::string signature_path(const std::string& folder, const ProtocolKind& kind) {
  return fmt::format("{}/{}.p7s", folder, kind.stem);
}
std::string page_path(const std::string& folder, const ProtocolKind& kind, report::Language language) {
  return fmt::format("{}/{}.{}.html", folder, kind.stem, report::code(language));
}

Result<void> write_protocol_pages(const std::string& folder, const ProtocolKind& kind, const ProtocolText& protocol) {
  for (const auto language : kProtocolLanguages) {
    const auto page = kind.page(protocol, json_path(folder, kind), language);
    if (!page) return failure(page.error());
    if (auto written = replace_text_file(page_path(folder, kind, language), *page); !written) return written;
  }
  return {};
}

/// Returns whether a page in the folder is the one that this program renders; nothing if there is no page. Fails with
/// bad_file if the page cannot be rendered or read.
Result<std::optional<bool>> is_rendered_page(const std::string& folder, const ProtocolKind& kind,
                                             const ProtocolText& protocol, report::Language language) {
  const auto found = read_text_file_if_any(page_path(folder, kind, language));
  if (!found) return failure(found.error());
  if (!*found) return std::optional<bool>();
  const auto page = kind.page(protocol, json_path(folder, kind), language);
  if (!page) return failure(page.error());
  return std::optional(**found == *page);
}

/// Fails if a page is not the one that this program renders. A missing page is accepted, because signing renders it.
Result<void> compare_protocol_pages(const std::string& folder, const ProtocolKind& kind, const ProtocolText& protocol) {
  for (const auto language : kProtocolLanguages) {
    const auto same = is_rendered_page(folder, kind, protocol, language);
    if (!same) return failure(same.error());
    if (!same->value_or(true))
      return failure(FaultKind::bad_file, page_path(folder, kind, language),
                     fmt::format("is not the page that this version renders from {}.json; delete the page, and the "
                                 "signature makes it again",
                                 kind.stem));
  }
  return {};
}

/// Returns the check of a page. No signature covers it, so it never fails.
report::Check check_protocol_page(const std::string& folder, const ProtocolKind& kind, const ProtocolText& protocol,
                                  report::Language language) {
  using enum report::Check::Outcome;
  const std::string name = std::filesystem::path(page_path(folder, kind, language)).filename().string();
  const auto same = is_rendered_page(folder, kind, protocol, language);
  if (!same) return {name, unsigned_beside, text(same.error())};
  if (!*same) return {name, not_there, "was not found; not checked"};
  if (**same) return {name, holds, fmt::format("is the page of {}.json", kind.stem)};
  return {name, unsigned_beside,
          fmt::format("is not the page that this version renders; only {}.json is signed", kind.stem)};
}

/// Returns whether a folder has a file of a calibration report, such as one whose calibration.json is missing.
bool has_report_file(const std::string& folder) {
  return std::ranges::any_of(list_folder(folder), [](const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    return name == report::kDccFile || name == report::kAuthorisationFile || name.starts_with("calibration.");
  });
}

Result<ProtocolText> read_protocol(const std::string& folder, const ProtocolKind& kind) {
  auto json = read_text_file(json_path(folder, kind));
  if (!json) return failure(json.error());
  auto digest = sha256(*json);
  return ProtocolText{.json = std::move(*json), .sha256 = std::move(digest), .signer = ""};
}

}  // namespace

Result<void> write_protocol(const std::string& folder, const ProtocolKind& kind, const std::string& json) {
  if (auto written = replace_text_file(json_path(folder, kind), json); !written) return written;
  return write_protocol_pages(folder, kind, {.json = json, .sha256 = sha256(json), .signer = ""});
}

void add_signing_options(CLI::App& command, report::SigningKey& key) {
  command.add_option("--key", key.key_file, "sign the protocol with this private key, RSA, PEM")
      ->type_name(value::kPem);
  command.add_option("--certificate", key.certificate_file, "its certificate and the chain above it, PEM")
      ->type_name(value::kPem);
  command.add_option("--password-file", key.password_file, "a file with the password of the key")
      ->type_name(value::kFile);
}

Result<void> check_signing_options(const report::SigningKey& key) {
  if (key.key_file.empty() != key.certificate_file.empty())
    return failure(FaultKind::usage, "--key", "expected --key and --certificate together");
  if (!key.key_file.empty()) return report::check_signing_key(key);
  if (!key.password_file.empty())
    return failure(FaultKind::usage, "--password-file", "requires --key and --certificate");
  return {};
}

bool has_protocol(const std::string& folder, const ProtocolKind& kind) {
  std::error_code error;
  return std::filesystem::exists(json_path(folder, kind), error) && !has_report_file(folder);
}

Result<void> sign_protocol(const std::string& folder, const ProtocolKind& kind, const report::SigningKey& key) {
  auto protocol = read_protocol(folder, kind);
  if (!protocol) return failure(protocol.error());
  const auto path = signature_path(folder, kind);
  if (std::error_code error; std::filesystem::exists(path, error))
    return failure(FaultKind::usage, path, "the protocol is signed already");
  if (auto same = compare_protocol_pages(folder, kind, *protocol); !same) return same;
  const auto signature = report::sign_bytes(protocol->json, key);
  if (!signature) return failure(signature.error());
  const auto signer =
      report::verify_bytes(protocol->json, *signature, path, {.certificates_file = key.certificate_file, .on_day = {}});
  if (!signer) return failure(signer.error());
  protocol->signer = signer->subject;
  if (auto written = write_protocol_pages(folder, kind, *protocol); !written) return written;
  return replace_text_file(path, *signature);
}

Result<report::VerifiedReport> verify_protocol(const std::string& folder, const ProtocolKind& kind,
                                               const report::Trust& trust) {
  using enum report::Check::Outcome;
  auto protocol = read_protocol(folder, kind);
  if (!protocol) return failure(protocol.error());
  const auto path = signature_path(folder, kind);
  const auto signature = read_text_file_if_any(path, kLargestText, Links::followed);
  if (!signature) return failure(signature.error());
  if (!*signature) return failure(FaultKind::bad_file, path, "the protocol is UNSIGNED");
  auto signer = report::verify_bytes(protocol->json, **signature, json_path(folder, kind), trust);
  if (!signer) return failure(signer.error());
  protocol->signer = signer->subject;
  report::VerifiedReport found{.identifier = json_path(folder, kind), .signer = *signer};
  found.checks.push_back({found.identifier, holds, "signed by " + signer->subject});
  std::vector<std::string> names{json_path("", kind), path.substr(folder.size())};
  for (const auto language : kProtocolLanguages) {
    found.checks.push_back(check_protocol_page(folder, kind, *protocol, language));
    names.push_back(page_path("", kind, language));
  }
  for (std::string& name : names) name.erase(0, 1);
  for (const std::string& name : report::find_unlisted_entries(folder, names, {}))
    found.checks.push_back({plain(name), unsigned_beside, "is not part of the protocol that was signed"});
  return found;
}

}  // namespace gyrotherm::app
