// SPDX-License-Identifier: Apache-2.0
/// Writes the calibration report as a Digital Calibration Certificate: machine-readable XML in PTB's schema DCC 3.3.0.
/// Reads such a certificate back.
///
/// The certificate contains the whole report except its figures. Each axis is a measurementResult, and each table of an
/// axis is a result. The refType identifies a quantity: a type of PTB's vocabulary (basic_…) if one exists, otherwise
/// gyrotherm_ with the key of words.hpp. Texts are in English and German. The certificate does not depend on the time
/// of writing: the same report and options always give the same bytes.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "report/calibration.hpp"

namespace gyrotherm::report {

inline constexpr const char* kDccFile = "dcc.xml";
inline constexpr const char* kCalibrationFile = "calibration.json";
/// refType of an identification that contains a file name and its SHA-256.
inline constexpr const char* kFileDigestType = "gyrotherm_fileSha256";

/// A file issued with the certificate, identified by its hash.
struct IssuedFile {
  std::string name{};
  std::string sha256{};
};

/// The human-readable report.
struct ReadableReport {
  std::string name{};  ///< "report.pdf"
  std::string bytes{};
};

/// Largest PDF embedded in the XML. XML readers reject texts of more than 10 MB, and base64 turns three bytes into four
/// characters.
inline constexpr std::size_t kLargestEmbeddedPdf = 7'000'000;

struct DccOptions {
  /// Files to list. If calibration.json is not among them, it is listed with the hash of to_json().
  std::vector<IssuedFile> files{};
  std::optional<ReadableReport> pdf{};
};

/// Returns the unsigned certificate. In a draft, missing texts that the schema requires are replaced by "not given
/// (draft)" and missing days by 0001-01-01; identifier, statements and signer mark the certificate as a draft. Fails
/// with bad_file if a report that is not a draft has no results or is missing data required by the schema.
[[nodiscard]] Result<std::string> make_dcc(const CalibrationReport& report, const DccOptions& options = {});

/// Contents of a certificate that are needed to verify its files.
struct ReadDcc {
  std::string identifier{};
  std::vector<IssuedFile> files{};
};

/// Reads a certificate written by this program, without its signature. Fails with bad_file if it is not XML, or if any
/// byte differs from the form in which this program writes the same contents. This refuses comments, document types and
/// other encodings, which an XML signature does not detect: it covers the contents and not the bytes.
[[nodiscard]] Result<ReadDcc> read_dcc(std::string_view dcc, const std::string& file);

}  // namespace gyrotherm::report
