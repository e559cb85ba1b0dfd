// SPDX-License-Identifier: Apache-2.0
/// Certificate files that a rig file names: `certificate = "t1.dcc.xml"`. A function of the program reads them; this
/// part applies their values to the channels.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::rig {

/// The ending of a `certificate` that is the path of a file and not the number of a certificate.
inline constexpr const char* kCertificateEnding = ".xml";

/// The request for the values of a certificate file.
struct CertificateRequest {
  std::string path{};
  /// The PEM file with the trusted signers.
  std::string trusted{};
  /// The serial number of the calibrated thermometer; empty: the certificate has only one item.
  std::string serial_number{};
};

/// The values of a certificate whose signature is valid and whose signer is trusted.
struct CertificateValues {
  std::string number{};
  Kelvins offset{};
  Kelvins standard_uncertainty{};
  std::chrono::sys_days calibrated{};
  std::optional<std::chrono::sys_days> due{};
  record::CertificateFile file{};
};

/// Reads certificate files for a rig.
struct CertificateReader {
  /// Reads and verifies a certificate file. Fails with bad_file at a position in the file. Empty: a rig file that names
  /// a certificate file is refused.
  std::function<Result<CertificateValues>(const CertificateRequest&)> read{};
  /// The day on which the calibrations of a real rig must be valid. A virtual rig has its own time.
  std::chrono::sys_days today{};
};

/// A certificate file that a [[thermometer]] or [[thermometer.calibration]] names.
struct NamedCertificate {
  CertificateRequest request{};
  std::string location{};               ///< position of the key in the rig file
  std::vector<std::size_t> channels{};  ///< indexes of the calibrated channels
};

/// Reads the certificate file that a table names, and notes an error for every key beside it that states a value of the
/// certificate. Returns nothing if `certificate` is missing or is not the path of a file.
[[nodiscard]] std::optional<NamedCertificate> read_named_certificate(const TomlTable& table, const std::string& folder);

/// The days with which the days of a certificate are compared. They differ for a virtual rig, which has its own time
/// but may use a certificate of the present.
struct CertificateDays {
  /// The day on which the calibration must be valid.
  std::chrono::sys_days of_run{};
  /// The last day on which the calibration may have been made.
  std::chrono::sys_days latest_calibration{};
};

/// Applies the values of a certificate to a channel, except that an earlier due day of the rig file is kept. Fails with
/// bad_file at `location` if the rig file states a later due day, if the calibration is overdue on the day of the run,
/// or if it was made after the latest day.
[[nodiscard]] Result<void> apply_certificate(const CertificateValues& values, const std::string& location,
                                             const CertificateDays& days, record::Channel& channel);

/// Copies the calibration of a channel from the channel of the same name in a record. Fails with bad_file at `location`
/// if the record has no such channel, or if the calibration of that channel is not from a certificate file.
[[nodiscard]] Result<void> restore_calibration(std::span<const record::Channel> recorded, const std::string& location,
                                               record::Channel& channel);

}  // namespace gyrotherm::rig
