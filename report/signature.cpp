// SPDX-License-Identifier: Apache-2.0
#include "report/signature.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <optional>
#include <ranges>
#include <regex>
#include <vector>

#include "core/file.hpp"
#include "core/text.hpp"
#include "report/certificate_usage.hpp"
#include "report/dcc.hpp"
#include "report/dcc_text.hpp"
#include "report/other_program.hpp"
#include "report/xml_signature.hpp"
#include "report/xml_text.hpp"

namespace gyrotherm::report {
namespace {

using Strings = std::vector<std::string>;

// The signature has a fixed form: only the parts between these texts vary. An enveloped signature over the empty
// reference covers the whole document.
constexpr std::string_view kBeforeDigest =
    "\n  <ds:Signature xmlns:ds=\"http://www.w3.org/2000/09/xmldsig#\"><ds:SignedInfo>"
    "<ds:CanonicalizationMethod Algorithm=\"http://www.w3.org/2001/10/xml-exc-c14n#\"></ds:CanonicalizationMethod>"
    "<ds:SignatureMethod Algorithm=\"http://www.w3.org/2001/04/xmldsig-more#rsa-sha256\"></ds:SignatureMethod>"
    "<ds:Reference URI=\"\"><ds:Transforms>"
    "<ds:Transform Algorithm=\"http://www.w3.org/2000/09/xmldsig#enveloped-signature\"></ds:Transform>"
    "<ds:Transform Algorithm=\"http://www.w3.org/2001/10/xml-exc-c14n#\"></ds:Transform></ds:Transforms>"
    "<ds:DigestMethod Algorithm=\"http://www.w3.org/2001/04/xmlenc#sha256\"></ds:DigestMethod><ds:DigestValue>";
constexpr std::string_view kBeforeValue = "</ds:DigestValue></ds:Reference></ds:SignedInfo><ds:SignatureValue>";
constexpr std::string_view kBeforeCertificates = "</ds:SignatureValue><ds:KeyInfo><ds:X509Data>";
constexpr std::string_view kCertificate = "<ds:X509Certificate>", kCertificateEnd = "</ds:X509Certificate>";
constexpr std::string_view kAfterCertificates = "</ds:X509Data></ds:KeyInfo></ds:Signature>";
constexpr std::string_view kRootEnd = "\n</dcc:digitalCalibrationCertificate>\n";

constexpr std::size_t kMaxCertificates = 8;

/// Parts of a signed certificate (DCC).
struct SignedDcc {
  /// The text that was signed.
  std::string text;
  std::string digest, value;
  /// Base64; the certificate of the key comes first.
  Strings certificates;
};

std::string signature_xml(const SignedDcc& parts) {
  std::string text(kBeforeDigest);
  text.append(parts.digest).append(kBeforeValue).append(parts.value).append(kBeforeCertificates);
  for (const std::string& one : parts.certificates) text.append(kCertificate).append(one).append(kCertificateEnd);
  return text.append(kAfterCertificates);
}

/// Returns the text between the first `before` and the next `after`; nothing if one is missing.
std::optional<std::string> text_between(std::string_view text, std::string_view before, std::string_view after) {
  const auto begins = text.find(before);
  if (begins == std::string_view::npos) return std::nullopt;
  const auto from = begins + before.size(), to = text.find(after, from);
  if (to == std::string_view::npos) return std::nullopt;
  return std::string(text.substr(from, to - from));
}

Strings all_texts_between(std::string_view text, std::string_view before, std::string_view after) {
  Strings found;
  for (auto one = text_between(text, before, after); one; one = text_between(text, before, after)) {
    found.push_back(*one);
    text.remove_prefix(text.find(before) + before.size() + one->size() + after.size());
  }
  return found;
}

Result<SignedDcc> split_certificate(std::string_view dcc, const std::string& file) {
  const auto refused = [&](const char* what) { return failure(FaultKind::bad_file, file, what); };
  const auto begins = dcc.find(kBeforeDigest.substr(0, kBeforeDigest.find('>')));
  if (begins == std::string_view::npos) return refused("contains no signature written by gyrotherm");
  if (!dcc.ends_with(kRootEnd)) return refused("has unexpected content after its signature");
  const std::string_view signature = dcc.substr(begins, dcc.size() - kRootEnd.size() - begins);
  SignedDcc parts;
  parts.text = std::string(dcc.substr(0, begins)) + std::string(kRootEnd);
  parts.digest = text_between(signature, "<ds:DigestValue>", "</ds:DigestValue>").value_or("");
  parts.value = text_between(signature, "<ds:SignatureValue>", "</ds:SignatureValue>").value_or("");
  parts.certificates = all_texts_between(signature, kCertificate, kCertificateEnd);
  const bool base64 = is_base64(parts.digest) && is_base64(parts.value) &&
                      std::ranges::all_of(parts.certificates, [](const auto& one) { return is_base64(one); });
  const bool has_certificates = !parts.certificates.empty() && parts.certificates.size() <= kMaxCertificates;
  if (!base64 || !has_certificates || signature != signature_xml(parts))
    return refused("has a signature that was not written by gyrotherm");
  return parts;
}

// Other programs

/// Returns an absolute path, which no program interprets as an option.
std::string absolute_path(const std::string& path) {
  std::error_code error;
  return std::filesystem::absolute(path, error).string();
}

/// Returns a fault without the path of a private folder.
tl::unexpected<Fault> private_failure(const Fault& fault) {
  return failure(fault.kind, hide_private_paths(fault.where), hide_private_paths(fault.what));
}

/// Writes a file of the private folder without waiting for the disk.
Result<void> write_private(const std::string& path, std::string_view text) {
  if (auto written = replace_own_file(path, text, Syncing::not_awaited); !written)
    return private_failure(written.error());
  return {};
}

/// Reads a file of the private folder.
Result<std::string> read_private(const std::string& path) {
  auto content = read_text_file(path, kLargestTable);
  if (!content) return private_failure(content.error());
  return content;
}

/// Runs a program of the signing or verification and returns its output. Fails with bad_file if the exit code is not 0.
Result<std::string> run_step(const std::string& program, const Strings& arguments, const char* what) {
  const auto run = run_program(program, arguments);
  if (!run) return failure(run.error());
  if (run->exit_code == 0) return run->out;
  const std::string output = plain(trimmed(run->out, " \t\r\n"));
  return failure(FaultKind::bad_file, program, fmt::format("{}: {}", what, output.substr(0, 600)));
}

// PEM files

enum class PemContent { certificate, signer_certificate, private_key };

/// Returns why a file does not contain what is expected; empty if it does. Names what it contains instead.
std::string pem_refusal(std::string_view text, PemContent expected) {
  const bool expects_key = expected == PemContent::private_key;
  const std::string_view name = expects_key ? "a private key" : "a certificate";
  const auto refused = [&](std::string_view is) { return fmt::format("{}, expected {} in PEM", is, name); };
  if (text.empty()) return refused("is empty");
  // DER and PKCS #12 begin with a sequence of more than 127 bytes.
  constexpr unsigned char kLongLength = 0x80;
  if (text.size() > 1 && text[0] == '\x30' && static_cast<unsigned char>(text[1]) >= kLongLength)
    return refused("is a binary file, such as DER or PKCS #12") + "; \"openssl\" converts it";
  const auto label = text_between(text, "-----BEGIN ", "-----");
  if (!label) return refused("contains no PEM text");
  for (const auto& each : all_texts_between(text, "-----BEGIN ", "-----")) {
    const bool is_exact = expected == PemContent::signer_certificate;
    if (is_exact ? each == "CERTIFICATE" : each.ends_with(expects_key ? "PRIVATE KEY" : "CERTIFICATE")) return {};
  }
  return refused(fmt::format("contains \"{}\"", plain(*label)));
}

/// Reads a PEM file. Fails with bad_file if it does not contain what is expected.
Result<std::string> read_pem(const std::string& path, PemContent expected) {
  auto content = read_text_file(path);
  if (!content) return content;
  if (auto refusal = pem_refusal(*content, expected); !refusal.empty())
    return failure(FaultKind::bad_file, path, std::move(refusal));
  return content;
}

/// Checks the first certificate of a PEM file with find_usage_refusal(). Fails with bad_file at `where` if it must not
/// sign a report, or if openssl is not installed or cannot read the certificate.
Result<void> check_usage(const std::string& certificate, const std::string& where) {
  const auto run = run_program(
      "openssl", {"x509", "-in", certificate, "-noout", "-ext", "basicConstraints,keyUsage,extendedKeyUsage"});
  if (!run) return failure(run.error());
  if (run->exit_code != 0) return failure(FaultKind::bad_file, where, "openssl cannot read the signer's certificate");
  const std::string refusal = find_usage_refusal(run->out);
  return refusal.empty() ? Result<void>{} : failure(FaultKind::bad_file, where, "the signer's certificate " + refusal);
}

/// Fails with bad_file at `where` if the first certificate of a PEM file is signed by its issuer with an algorithm that
/// no verification accepts.
Result<void> check_signature_of(const std::string& certificate, const std::string& where) {
  const auto text = run_step("openssl", {"x509", "-in", certificate, "-noout", "-text", "-subject", "-issuer"},
                             "cannot read the signer's certificate");
  if (!text) return failure(text.error());
  const auto algorithm = text_between(*text, "Signature Algorithm: ", "\n").value_or("");
  const auto subject = text_between(*text, "\nsubject=", "\n"), issuer = text_between(*text, "\nissuer=", "\n");
  const bool is_weak = std::regex_search(algorithm, std::regex("md[245]|sha1", std::regex::icase));
  if (!is_weak || subject == issuer) return {};
  return failure(
      FaultKind::bad_file, where,
      fmt::format("is signed with {}, which no verification accepts; have it issued with SHA-256", plain(algorithm)));
}

/// Returns the bits of the RSA key of the first certificate of a PEM file; 0 for another kind of key.
Result<int> count_rsa_bits(const std::string& certificate) {
  const auto folder = PrivateFolder::make();
  if (!folder) return failure(folder.error());
  const std::string key = *folder / "public.pem";
  for (const Strings& arguments : {Strings{"x509", "-in", certificate, "-noout", "-pubkey", "-out", key},
                                   Strings{"pkey", "-pubin", "-in", key, "-noout", "-text"}}) {
    const auto run = run_step("openssl", arguments, "cannot read the key of the certificate");
    if (!run) return failure(run.error());
    static const std::regex bits(R"(Public-Key: \((\d{1,6}) bit)");
    std::smatch match;
    if (run->find("Modulus:") != std::string::npos && std::regex_search(*run, match, bits)) return std::stoi(match[1]);
  }
  return 0;
}

// Trust

/// Level of openssl for all keys and signatures of a chain: at least 112 bits of security, so RSA keys of 2048 bits or
/// more and no SHA-1 (NIST SP 800-131A Rev. 2).
constexpr const char* kSecurityLevel = "2";

/// Returns the starts of validity of the certificates in PEM files, s since 1970. Ignores files that openssl cannot
/// read.
std::vector<std::int64_t> read_validity_starts(const Strings& files) {
  std::vector<std::int64_t> starts;
  for (const std::string& file : files) {
    const auto run = run_program("openssl", {"storeutl", "-certs", "-noout", "-text", file});
    if (!run) continue;
    for (const std::string& start : all_texts_between(run->out, "Not Before: ", "\n")) {
      std::tm time{};
      if (::strptime(start.c_str(), "%b %d %H:%M:%S %Y", &time) != nullptr) starts.push_back(::timegm(&time));
    }
  }
  return starts;
}

/// Returns the instants at which certificates are verified, s since 1970; absent for the current time. For a day these
/// are its last second, its first second, noon, and each start of validity on that day: a chain that is valid at some
/// time of the day is valid at one of these instants or at the latest start of its certificates.
std::vector<std::optional<std::int64_t>> verification_times(const Trust& trust, const Strings& certificate_files) {
  if (!trust.on_day) return {std::nullopt};
  int year = 0;
  unsigned month = 0, day = 0;
  const char* text = trust.on_day->data();
  std::from_chars(text, text + 4, year);
  std::from_chars(text + 5, text + 7, month);
  std::from_chars(text + 8, text + 10, day);
  const std::chrono::sys_days at = std::chrono::year(year) / std::chrono::month(month) / std::chrono::day(day);
  const std::int64_t begins = std::chrono::seconds(at.time_since_epoch()).count();
  constexpr std::int64_t kDay_s = 86400;
  std::vector<std::optional<std::int64_t>> times{begins + kDay_s - 1, begins, begins + kDay_s / 2};
  for (const std::int64_t start : read_validity_starts(certificate_files))
    if (start >= begins && start < begins + kDay_s) times.emplace_back(start);
  return times;
}

/// Runs `openssl verify` with the certificates of `trust` and without those of the system. Succeeds if the certificates
/// are valid at any of the instants. check_usage() verifies the key usage separately.
Result<ProgramRun> run_openssl_verify(const Trust& trust, const Strings& files) {
  const Strings all{"verify",      "-no-CApath",   "-no-CAstore", "-partial_chain",
                    "-auth_level", kSecurityLevel, "-CAfile",     trust.certificates_file};
  Strings certificate_files{trust.certificates_file};
  std::ranges::copy_if(files, std::back_inserter(certificate_files),
                       [](const std::string& argument) { return !argument.starts_with('-'); });
  Result<ProgramRun> run = ProgramRun{};
  for (const auto& moment : verification_times(trust, certificate_files)) {
    Strings arguments = all;
    if (moment) arguments.insert(arguments.end(), {"-attime", std::to_string(*moment)});
    arguments.insert(arguments.end(), files.begin(), files.end());
    run = run_program("openssl", arguments);
    if (!run || run->exit_code == 0) break;
  }
  return run;
}

Result<void> check_trust_file(const Trust& trust) {
  if (auto there = read_pem(trust.certificates_file, PemContent::certificate); !there) return failure(there.error());
  if (trust.on_day && !calendar_day(*trust.on_day))
    return failure(FaultKind::usage, *trust.on_day, "is not a date, expected one like 2026-11-25");
  return {};
}

/// Checks that "own.pem" in the folder is trusted, with "chain.pem" as intermediate certificates, and that it may sign
/// the document at `where`.
Result<void> check_trust(const PrivateFolder& folder, const Trust& trust, const std::string& where) {
  const auto run = run_openssl_verify(trust, {"-untrusted", folder / "chain.pem", folder / "own.pem"});
  if (!run) return failure(run.error());
  if (run->exit_code == 0) return check_usage(folder / "own.pem", where);
  const std::string why = text_between(run->out, "lookup: ", "\n").value_or("the certificate cannot be read");
  return failure(FaultKind::bad_file, where, "the signer is not trusted: " + plain(why));
}

std::string to_pem(const std::string& base64) {
  std::string lines;
  for (std::size_t at = 0; at < base64.size(); at += 64) lines += base64.substr(at, 64) + "\n";
  return "-----BEGIN CERTIFICATE-----\n" + lines + "-----END CERTIFICATE-----\n";
}

/// Fails unless each certificate is followed by its issuer's. The signature does not cover the certificates, so this
/// check is needed to refuse unrelated ones.
Result<void> check_chain(const PrivateFolder& folder, const Strings& certificates, const std::string& file) {
  for (std::size_t i = 1; i < certificates.size(); ++i) {
    for (const auto& [name, one] :
         {std::pair("below.pem", certificates[i - 1]), std::pair("above.pem", certificates[i])})
      if (auto written = write_private(folder / name, to_pem(one)); !written) return written;
    const auto run = run_program("openssl", {"verify", "-no-CApath", "-no-CAstore", "-partial_chain", "-no_check_time",
                                             "-CAfile", folder / "above.pem", folder / "below.pem"});
    if (!run) return failure(run.error());
    if (run->exit_code != 0)
      return failure(FaultKind::bad_file, file, "its certificates do not form a chain: the issuer's must follow each");
  }
  return {};
}

std::string line_value(std::string_view text, std::string_view key) {
  return text_between(text, key, "\n").value_or("");
}

Result<Signer> read_signer(const std::string& certificate) {
  const auto output = run_step("openssl",
                               {"x509", "-in", certificate, "-noout", "-subject", "-issuer", "-serial", "-fingerprint",
                                "-sha256", "-enddate", "-nameopt", "RFC2253,-esc_msb,utf8"},
                               "cannot read the signer's certificate");
  if (!output) return failure(output.error());
  const auto bits = count_rsa_bits(certificate);
  if (!bits) return failure(bits.error());
  const std::string lines = "\n" + *output;
  std::string fingerprint = line_value(lines, "\nsha256 Fingerprint=");
  std::erase(fingerprint, ':');
  return Signer{.subject = plain(line_value(lines, "\nsubject=")),
                .issuer = plain(line_value(lines, "\nissuer=")),
                .serial_number = line_value(lines, "\nserial="),
                .fingerprint = fingerprint,
                .rsa_bits = *bits,
                .not_after = line_value(lines, "\nnotAfter=")};
}

/// Returns the decrypted key in a file in memory. Fails with bad_file if the file of the key contains no private key,
/// or if the password does not open it.
Result<MemoryFile> unlock_key(const SigningKey& key) {
  const auto pem = read_pem(key.key_file, PemContent::private_key);
  if (!pem) return failure(pem.error());
  auto unlocked_key = MemoryFile::make();
  if (!unlocked_key) return unlocked_key;
  Strings arguments{"pkey", "-in", key.key_file, "-out", unlocked_key->path()};
  if (!key.password_file.empty()) {
    const auto password = read_text_file(key.password_file);
    if (!password) return failure(password.error());
    if (password->substr(0, password->find('\n')).empty())
      return failure(FaultKind::bad_file, key.password_file, "expected the password of the key in the first line");
    arguments.insert(arguments.end(), {"-passin", "file:" + key.password_file});
  }
  const auto unlocked = run_program("openssl", arguments);
  if (!unlocked) return failure(unlocked.error());
  if (unlocked->exit_code == 0) return unlocked_key;
  if (pem->find("ENCRYPTED") == std::string::npos)
    return failure(FaultKind::bad_file, key.key_file, "openssl cannot read the private key");
  return failure(FaultKind::bad_file, key.key_file,
                 key.password_file.empty() ? "is protected by a password; name a file with it by --password-file"
                                           : fmt::format("the password in {} does not open it", key.password_file));
}

/// Fails with bad_file unless the first certificate of the folder's "chain.pem" is valid today.
Result<void> check_validity(const PrivateFolder& folder, const std::string& where) {
  const auto run =
      run_openssl_verify({.certificates_file = folder / "chain.pem", .on_day = {}}, {folder / "chain.pem"});
  if (!run) return failure(run.error());
  if (run->exit_code == 0) return {};
  const std::string why = text_between(run->out, "lookup: ", "\n").value_or("openssl does not accept it");
  return failure(FaultKind::bad_file, where, "cannot be used for signing today: " + plain(why));
}

/// Returns the algorithm of a public key in PEM as openssl names it: "rsaEncryption", "rsassaPss", "id-ecPublicKey".
Result<std::string> read_algorithm(const PrivateFolder& folder, const std::string& public_key) {
  const std::string path = folder / "public.pem";
  if (auto written = write_private(path, public_key); !written) return failure(written.error());
  const auto parsed = run_step("openssl", {"asn1parse", "-in", path}, "cannot read the public key");
  if (!parsed) return parsed;
  const std::string object = text_between(*parsed, "prim: OBJECT", "\n").value_or("");
  return std::string(trimmed(object, " :\t\r"));
}

/// Fails with bad_file at `where` unless a public key in PEM is an RSA key for any signature. xmlsec1 and pdfsig sign
/// with PKCS #1 v1.5, which an RSA-PSS key does not permit (RFC 4055, 1.2).
Result<void> check_algorithm(const PrivateFolder& folder, const std::string& public_key, const std::string& where) {
  const auto algorithm = read_algorithm(folder, public_key);
  if (!algorithm) return failure(algorithm.error());
  if (*algorithm == "rsaEncryption") return {};
  return failure(FaultKind::bad_file, where,
                 *algorithm == "rsassaPss" ? "is an RSA-PSS key, expected rsaEncryption" : "is not an RSA key");
}

/// Writes the certificates as "chain.pem" into the folder and returns the public key of the first one. Fails with
/// bad_file unless this certificate may sign reports.
Result<std::string> prepare_certificate(const PrivateFolder& folder, const SigningKey& key) {
  const std::string chain = folder / "chain.pem";
  const auto certificates = read_pem(key.certificate_file, PemContent::signer_certificate);
  if (!certificates) return certificates;
  if (auto written = write_private(chain, *certificates); !written) return failure(written.error());
  if (auto usable = check_usage(chain, key.certificate_file); !usable) return failure(usable.error());
  if (auto strong = check_signature_of(chain, key.certificate_file); !strong) return failure(strong.error());
  return run_step("openssl", {"x509", "-in", chain, "-noout", "-pubkey"}, "cannot read the certificate");
}

/// Fails with bad_file unless the first certificate of the folder's "chain.pem" has a permitted RSA key and is valid
/// today.
Result<void> check_certificate(const PrivateFolder& folder, const std::string& public_key, const std::string& where) {
  if (auto rsa = check_algorithm(folder, public_key, where); !rsa)
    return failure(rsa.error().kind, rsa.error().where, "the key of the certificate " + rsa.error().what);
  const auto bits = count_rsa_bits(folder / "chain.pem");
  if (!bits) return failure(bits.error());
  if (*bits > 0 && *bits < kFewestRsaBits)
    return failure(FaultKind::bad_file, where,
                   fmt::format("has an RSA key of {} bits, expected {} or more", *bits, kFewestRsaBits));
  return check_validity(folder, where);
}

/// Returns the decrypted key in a file in memory, and writes the certificates as "chain.pem" into the folder. Fails
/// unless the key is an RSA key that matches the first certificate, and this certificate is valid today.
Result<MemoryFile> prepare_key(const PrivateFolder& folder, const SigningKey& key) {
  const auto of_certificate = prepare_certificate(folder, key);
  if (!of_certificate) return failure(of_certificate.error());
  auto unlocked = unlock_key(key);
  if (!unlocked) return unlocked;
  const auto of_key = run_step("openssl", {"pkey", "-in", unlocked->path(), "-pubout"}, "cannot read the key");
  if (!of_key) return failure(of_key.error());
  if (auto rsa = check_algorithm(folder, *of_key, key.key_file); !rsa) return failure(rsa.error());
  if (*of_key != *of_certificate)
    return failure(FaultKind::bad_file, key.certificate_file, "is not the certificate of the key " + key.key_file);
  if (auto usable = check_certificate(folder, *of_certificate, key.certificate_file); !usable)
    return failure(usable.error());
  return unlocked;
}

Strings read_certificates(const std::string& pem) {
  Strings all = all_texts_between(pem, "-----BEGIN CERTIFICATE-----", "-----END CERTIFICATE-----");
  for (std::string& one : all) std::erase_if(one, [](char c) { return c == '\n' || c == '\r' || c == ' '; });
  return all;
}

std::string remove_blanks(std::string text) {
  std::erase_if(text, [](char c) { return c == '\n' || c == '\r' || c == ' '; });
  return text;
}

/// Writes the certificates of a signature into the folder in the form required by check_trust().
Result<void> write_certificates(const PrivateFolder& folder, const Strings& certificates) {
  std::string chain;
  for (const std::string& one : certificates) chain += to_pem(one);
  if (auto written = write_private(folder / "chain.pem", chain); !written) return written;
  return write_private(folder / "own.pem", to_pem(certificates.front()));
}

/// Verifies the signature in the folder's "in.xml" with the key of "own.pem" only. Ignores all keys in the document.
Result<bool> verify_foreign_signature(const PrivateFolder& folder) {
  const auto run = run_program("xmlsec1", {"--verify", "--pubkey-cert-pem", folder / "own.pem", "--enabled-key-data",
                                           "key-name", "--enabled-reference-uris", "empty,same-doc", "--id-attr:Id",
                                           "http://uri.etsi.org/01903/v1.3.2#:SignedProperties", folder / "in.xml"});
  if (!run) return failure(run.error());
  return run->exit_code == 0;
}

// PDF

/// Signature of a PDF as reported by pdfsig.
struct PdfSignature {
  /// Byte offsets: [0, first_end) and [second_begin, end) are signed.
  std::size_t first_end{}, second_begin{}, end{};
};

std::size_t count_occurrences(std::string_view text, std::string_view word) {
  std::size_t count = 0;
  for (auto at = text.find(word); at != std::string_view::npos; at = text.find(word, at + word.size())) ++count;
  return count;
}

/// Reads the output of pdfsig. Each line used must occur exactly once, because a signer's name could contain a copy of
/// it.
Result<PdfSignature> read_signature(const std::string& output, const std::string& path) {
  const auto refused = [&](std::string what) { return failure(FaultKind::bad_file, path, std::move(what)); };
  if (output.find("does not contain any signatures") != std::string::npos) return refused("has no signature");
  for (const char* line : {"Signature #", "- Signed Ranges: ", "- Signature Validation: ", "otal document signed"})
    if (count_occurrences(output, line) != 1) return refused("is not signed exactly once");
  const std::string validation = line_value(output, "- Signature Validation: ");
  if (validation != "Signature is Valid.") return refused("its signature is not valid: " + plain(validation));
  if (output.find("- Total document signed\n") == std::string::npos)
    return refused("its signature does not cover the whole file");
  static const std::regex ranges(R"(- Signed Ranges: \[0 - (\d{1,12})\], \[(\d{1,12}) - (\d{1,12})\]\n)");
  std::smatch match;
  if (!std::regex_search(output, match, ranges)) return refused("its signature does not cover the whole file");
  return PdfSignature{std::stoul(match[1]), std::stoul(match[2]), std::stoul(match[3])};
}

/// Converts the line "  - Signing Time: Nov 30 2026 08:47:35" of pdfsig, in UTC, to "2026-11-30T08:47:35Z".
std::optional<std::string> parse_signing_time(const std::string& output) {
  static const std::regex line(R"(\n *- Signing Time: ([A-Z][a-z]{2}) +(\d{1,2}) (\d{4}) (\d\d:\d\d:\d\d)\n)");
  constexpr std::string_view kMonthNames = "JanFebMarAprMayJunJulAugSepOctNovDec";
  std::smatch match;
  if (count_occurrences(output, "- Signing Time: ") != 1 || !std::regex_search(output, match, line))
    return std::nullopt;
  const auto month = kMonthNames.find(match[1].str());
  if (month == std::string_view::npos || month % 3 != 0) return std::nullopt;
  return fmt::format("{}-{:02}-{:0>2}T{}Z", match[3].str(), month / 3 + 1, match[2].str(), match[4].str());
}

/// Returns the options with which pdfsig signs a PDF: into the empty field left by gyrotherm-pdf, or into a new field,
/// which adds a font of half a megabyte.
Result<Strings> signing_options(const std::string& path) {
  const auto run = run_program("pdfsig", {"-nocert", absolute_path(path)});
  if (!run) return failure(run.error());
  if (run->out.find("does not contain any signatures") != std::string::npos) return Strings{"-add-signature"};
  const std::string field = line_value(run->out, "- Signature Field Name: ");
  const bool plain_name = !field.empty() && std::ranges::all_of(field, [](unsigned char c) { return std::isalnum(c); });
  const bool is_empty = run->out.find("The signature form field is not signed.") != std::string::npos;
  if (plain_name && is_empty && count_occurrences(run->out, "Signature #") == 1) return Strings{"-sign", field};
  return failure(FaultKind::bad_file, path, "is already signed or is not a PDF");
}

std::optional<std::string> decode_hex(std::string_view hex) {
  std::string bytes;
  if (hex.size() % 2 != 0) return std::nullopt;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    unsigned byte = 0;
    const auto end = hex.data() + i + 2;
    if (std::from_chars(hex.data() + i, end, byte, 16).ptr != end) return std::nullopt;
    bytes += static_cast<char>(byte);
  }
  return bytes;
}

/// Writes the signed bytes, "content", and the signature, "signature.der", into the folder.
Result<void> extract_signature(const PrivateFolder& folder, const std::string& path, const PdfSignature& signature) {
  const auto pdf = read_text_file(path, kLargestTable);
  if (!pdf) return failure(pdf.error());
  const std::string_view bytes = *pdf;
  const auto [first_end, second_begin, end] = signature;
  const auto refused = [&] {
    return failure(FaultKind::bad_file, path, "its signature does not cover the whole file");
  };
  if (end != bytes.size() || first_end + 2 > second_begin || second_begin > end) return refused();
  if (bytes[first_end] != '<' || bytes[second_begin - 1] != '>') return refused();
  const auto der = decode_hex(bytes.substr(first_end + 1, second_begin - first_end - 2));
  if (!der) return refused();
  if (auto written = write_private(folder / "signature.der", *der); !written) return written;
  return write_private(folder / "content",
                       std::string(bytes.substr(0, first_end)) + std::string(bytes.substr(second_begin)));
}

/// Creates the NSS key store "store" for pdfsig in the folder and imports the key and the folder's certificates. The
/// store encrypts the key with `password`.
Result<void> make_key_store(const PrivateFolder& folder, const MemoryFile& key, const std::string& password) {
  const std::string store = "sql:" + folder / "store";
  std::error_code error;
  std::filesystem::create_directory(folder / "store", error);
  const auto password_file = MemoryFile::make(password + "\n"), package = MemoryFile::make();
  if (!password_file) return failure(password_file.error());
  if (!package) return failure(package.error());
  const std::vector<std::pair<const char*, Strings>> steps{
      {"openssl",
       {"pkcs12", "-export", "-inkey", key.path(), "-in", folder / "chain.pem", "-name", "gyrotherm", "-passout",
        "file:" + password_file->path(), "-out", package->path()}},
      {"certutil", {"-N", "-f", password_file->path(), "-d", store}},
      {"pk12util", {"-i", package->path(), "-d", store, "-w", password_file->path(), "-k", password_file->path()}}};
  for (const auto& [program, arguments] : steps)
    if (auto done = run_step(program, arguments, "cannot import the key"); !done) return failure(done.error());
  return {};
}

}  // namespace

Result<void> check_signing_key(const SigningKey& key) {
  const auto folder = PrivateFolder::make();
  if (!folder) return failure(folder.error());
  if (const auto unlocked = prepare_key(*folder, key); !unlocked) return failure(unlocked.error());
  return {};
}

Result<UnlockedKey> UnlockedKey::make(const SigningKey& key) {
  const auto folder = PrivateFolder::make();
  if (!folder) return failure(folder.error());
  auto memory = prepare_key(*folder, key);
  if (!memory) return failure(memory.error());
  SigningKey unlocked{.key_file = memory->path(), .certificate_file = key.certificate_file};
  return UnlockedKey(std::move(*memory), std::move(unlocked));
}

Result<void> check_signing_key_without_prompt(const SigningKey& key) {
  const auto pem = read_pem(key.key_file, PemContent::private_key);
  if (!pem) return failure(pem.error());
  if (!key.password_file.empty() || pem->find("ENCRYPTED") == std::string::npos) return check_signing_key(key);
  const auto folder = PrivateFolder::make();
  if (!folder) return failure(folder.error());
  const auto public_key = prepare_certificate(*folder, key);
  return public_key ? check_certificate(*folder, *public_key, key.certificate_file) : failure(public_key.error());
}

Result<void> check_trusted_file(const std::string& path) {
  return read_pem(path, PemContent::certificate).map([](const std::string&) {});
}

std::string describe_weak_key(const Signer& signer) {
  if (signer.rsa_bits == 0 || signer.rsa_bits >= kEnoughRsaBits) return {};
  return fmt::format("the RSA key of the signer has {} bits; {} or more are recommended", signer.rsa_bits,
                     kEnoughRsaBits);
}

Result<Signer> read_signer_of(const SigningKey& key) { return read_signer(key.certificate_file); }

Result<std::string> sign_dcc(std::string_view dcc, const SigningKey& key) {
  if (auto written = read_dcc(dcc, kDccFile); !written) return failure(written.error());
  const auto folder = PrivateFolder::make();
  if (!folder) return failure(folder.error());
  const auto unlocked = prepare_key(*folder, key);
  if (!unlocked) return failure(unlocked.error());
  const auto chain = read_private(*folder / "chain.pem");
  if (!chain) return failure(chain.error());
  SignedDcc parts{.text = std::string(dcc), .digest = "", .value = "", .certificates = read_certificates(*chain)};
  const std::string before(dcc.substr(0, dcc.size() - kRootEnd.size()));
  if (auto written = write_private(*folder / "in.xml", before + signature_xml(parts) + std::string(kRootEnd)); !written)
    return failure(written.error());
  const auto made = run_step("xmlsec1",
                             {"--sign", "--privkey-pem", unlocked->path(), "--enabled-key-data", "key-name", "--output",
                              *folder / "out.xml", *folder / "in.xml"},
                             "cannot sign");
  if (!made) return failure(made.error());
  const auto out = read_private(*folder / "out.xml");
  if (!out) return failure(out.error());
  parts.digest = remove_blanks(text_between(*out, "<ds:DigestValue>", "</ds:DigestValue>").value_or(""));
  parts.value = remove_blanks(text_between(*out, "<ds:SignatureValue>", "</ds:SignatureValue>").value_or(""));
  std::string signed_dcc = before + signature_xml(parts) + std::string(kRootEnd);
  const Trust own{.certificates_file = key.certificate_file};
  if (auto holds = verify_dcc(signed_dcc, kDccFile, own); !holds) return failure(holds.error());
  return signed_dcc;
}

Result<std::string> remove_signature(std::string_view signed_dcc, const std::string& file) {
  auto parts = split_certificate(signed_dcc, file);
  if (!parts) return failure(parts.error());
  return std::move(parts->text);
}

Result<Signer> verify_dcc(std::string_view signed_dcc, const std::string& file, const Trust& trust) {
  if (auto usable = check_trust_file(trust); !usable) return failure(usable.error());
  const auto parts = split_certificate(signed_dcc, file);
  if (!parts) return failure(parts.error());
  if (auto read = read_dcc(parts->text, file); !read) return failure(read.error());
  const auto folder = PrivateFolder::make();
  if (!folder) return failure(folder.error());
  if (auto written = write_certificates(*folder, parts->certificates); !written) return failure(written.error());
  if (auto written = write_private(*folder / "in.xml", signed_dcc); !written) return failure(written.error());
  // Verify with the key of the first certificate only: it is the reported signer. Ignore other keys in the document.
  const auto run = run_program("xmlsec1", {"--verify", "--pubkey-cert-pem", *folder / "own.pem", "--enabled-key-data",
                                           "key-name", "--enabled-reference-uris", "empty", *folder / "in.xml"});
  if (!run) return failure(run.error());
  if (run->exit_code != 0)
    return failure(FaultKind::bad_file, file, "its signature is not valid: the file was changed after it was signed");
  if (auto chain = check_chain(*folder, parts->certificates, file); !chain) return failure(chain.error());
  if (auto trusted = check_trust(*folder, trust, file); !trusted) return failure(trusted.error());
  return read_signer(*folder / "own.pem");
}

Result<Signer> verify_foreign_dcc(std::string_view dcc, const XmlElement& root, const std::string& file,
                                  const Trust& trust) {
  if (!trust.certificates_file.empty())
    if (auto usable = check_trust_file(trust); !usable) return failure(usable.error());
  auto signature = find_whole_signature(root, file);
  if (!signature) return failure(signature.error());
  const std::string where = fmt::format("{}:{}", file, signature->line);
  const auto folder = PrivateFolder::make();
  if (!folder) return failure(folder.error());
  if (auto written = write_private(*folder / "in.xml", dcc); !written) return failure(written.error());
  Strings& all = signature->certificates;
  bool is_valid = false;
  // The certificate of the signer may have any position. It comes first for the verification of the others.
  for (std::size_t i = 0; i < all.size() && !is_valid; ++i) {
    std::rotate(all.begin(), all.begin() + (i == 0 ? 0 : 1), all.end());
    if (auto written = write_certificates(*folder, all); !written) return failure(written.error());
    const auto verified = verify_foreign_signature(*folder);
    if (!verified) return failure(verified.error());
    is_valid = *verified;
  }
  if (!is_valid)
    return failure(FaultKind::bad_file, where, "its signature is not valid: the file was changed after it was signed");
  if (!trust.certificates_file.empty()) {
    auto trusted = check_trust(*folder, trust, where);
    if (!trusted && trust.on_day) trusted = check_trust(*folder, {.certificates_file = trust.certificates_file}, where);
    if (!trusted) return failure(trusted.error());
  }
  return read_signer(*folder / "own.pem");
}

Result<void> sign_pdf(const std::string& path, const std::string& signed_path, const SigningKey& key,
                      const std::string& reason) {
  const auto field_options = signing_options(path);
  if (!field_options) return failure(field_options.error());
  const auto folder = PrivateFolder::make();
  if (!folder) return failure(folder.error());
  const auto unlocked = prepare_key(*folder, key);
  if (!unlocked) return failure(unlocked.error());
  // The command line shows this password, but it opens only the store in the private folder.
  const auto password = make_random_password();
  if (!password) return failure(password.error());
  if (auto made = make_key_store(*folder, *unlocked, *password); !made) return made;
  Strings arguments{"-nssdir", "sql:" + *folder / "store", "-nss-pwd", *password, "-nick", "gyrotherm", "-reason",
                    reason};
  arguments.insert(arguments.end(), field_options->begin(), field_options->end());
  arguments.insert(arguments.end(), {absolute_path(path), absolute_path(signed_path)});
  const auto done = run_step("pdfsig", arguments, "cannot sign");
  if (!done) return failure(done.error());
  if (auto holds = verify_pdf(signed_path, {.certificates_file = key.certificate_file}); !holds)
    return failure(holds.error());
  return {};
}

Result<Signer> verify_pdf(const std::string& path, const Trust& trust) {
  if (auto usable = check_trust_file(trust); !usable) return failure(usable.error());
  const auto output = run_program("pdfsig", {"-nocert", absolute_path(path)});
  if (!output) return failure(output.error());
  const auto signature = read_signature(output->out, path);
  if (!signature) return failure(signature.error());
  const auto folder = PrivateFolder::make();
  if (!folder) return failure(folder.error());
  if (auto extracted = extract_signature(*folder, path, *signature); !extracted) return failure(extracted.error());
  const auto run =
      run_program("openssl", {"cms", "-verify", "-noverify", "-binary", "-inform", "DER", "-in",
                              *folder / "signature.der", "-content", *folder / "content", "-out", "/dev/null",
                              "-signer", *folder / "own.pem", "-certsout", *folder / "chain.pem"});
  if (!run) return failure(run.error());
  if (run->exit_code != 0) return failure(FaultKind::bad_file, path, "its signature is not valid");
  if (auto trusted = check_trust(*folder, trust, path); !trusted) return failure(trusted.error());
  return read_signer(*folder / "own.pem");
}

Result<std::optional<std::string>> find_signing_time(const std::string& path) {
  const auto output = run_program("pdfsig", {"-nocert", absolute_path(path)});
  if (!output) return failure(output.error());
  return parse_signing_time(output->out);
}

Result<std::string> sign_bytes(std::string_view bytes, const SigningKey& key) {
  const auto folder = PrivateFolder::make();
  if (!folder) return failure(folder.error());
  const auto unlocked = prepare_key(*folder, key);
  if (!unlocked) return failure(unlocked.error());
  if (auto written = write_private(*folder / "content", bytes); !written) return failure(written.error());
  const auto chain = read_private(*folder / "chain.pem");
  if (!chain) return failure(chain.error());
  Strings arguments{"cms",
                    "-sign",
                    "-binary",
                    "-md",
                    "sha256",
                    "-in",
                    *folder / "content",
                    "-inkey",
                    unlocked->path(),
                    "-signer",
                    *folder / "chain.pem",
                    "-outform",
                    "PEM",
                    "-out",
                    *folder / "signature.pem"};
  std::string issuers;  // openssl refuses a certificate that it has twice
  for (const std::string& one : read_certificates(*chain) | std::views::drop(1)) issuers += to_pem(one);
  if (auto written = write_private(*folder / "issuers.pem", issuers); !written) return failure(written.error());
  if (!issuers.empty()) arguments.insert(arguments.end(), {"-certfile", *folder / "issuers.pem"});
  if (const auto made = run_step("openssl", arguments, "cannot sign"); !made) return failure(made.error());
  auto signature = read_private(*folder / "signature.pem");
  if (!signature) return signature;
  const Trust own{.certificates_file = key.certificate_file};
  if (auto holds = verify_bytes(bytes, *signature, key.certificate_file, own); !holds) return failure(holds.error());
  return signature;
}

Result<Signer> verify_bytes(std::string_view bytes, std::string_view signature, const std::string& file,
                            const Trust& trust) {
  if (auto usable = check_trust_file(trust); !usable) return failure(usable.error());
  const auto folder = PrivateFolder::make();
  if (!folder) return failure(folder.error());
  for (const auto& [name, content] : {std::pair("content", bytes), std::pair("signature.pem", signature)})
    if (auto written = write_private(*folder / name, content); !written) return failure(written.error());
  const auto run =
      run_program("openssl", {"cms", "-verify", "-noverify", "-binary", "-inform", "PEM", "-in",
                              *folder / "signature.pem", "-content", *folder / "content", "-out", "/dev/null",
                              "-signer", *folder / "own.pem", "-certsout", *folder / "chain.pem"});
  if (!run) return failure(run.error());
  if (run->exit_code != 0)
    return failure(FaultKind::bad_file, file, "its signature is not valid: the file was changed after it was signed");
  if (auto trusted = check_trust(*folder, trust, file); !trusted) return failure(trusted.error());
  return read_signer(*folder / "own.pem");
}

}  // namespace gyrotherm::report
