// SPDX-License-Identifier: Apache-2.0
/// Answers about a new rig. Each function here checks one answer, stores it, and otherwise fails with usage and the
/// reason. Only descriptions of instruments are read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/shipped.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// Answers for an instrument without a description: a chamber with Modbus or with lines of text; a scanner or a gyro.
inline constexpr const char *kOtherModbus = "other-modbus", *kOtherText = "other-text", *kOther = "other";
/// Answer that leaves an optional value open, and the answer for an unknown latitude or limiter.
inline constexpr const char *kNone = "none", *kUnknown = "unknown";

struct ScannerAnswer {
  /// Driver, name or path of a description, or kOther.
  std::string kind;
  std::string line;
  std::vector<std::string> channels;
  /// Settings of dcon modules.
  std::vector<std::uint8_t> addresses;
  std::string type;
};

struct RigAnswers {
  /// Path of the rig file. Paths in the rig file are relative to its folder.
  std::string file;
  std::string title;
  /// Name or path of a map, kOtherModbus or kOtherText.
  std::string chamber;
  std::optional<drivers::RegisterMap> map;  ///< absent for another chamber
  std::string chamber_line;
  std::optional<std::uint8_t> chamber_unit;
  std::optional<drivers::WordOrder> word_order;
  Celsius lowest, highest, safe;
  CelsiusPerMinute fastest;
  /// An interlock ends a run outside these temperatures of the air.
  Celsius air_lowest, air_highest;
  std::optional<rig::Limiter> limiter;
  std::vector<ScannerAnswer> scanners;
  /// Name or path of a stream, or kOther.
  std::string gyro;
  std::optional<drivers::GyroStream> stream;  ///< absent for another gyro
  std::string gyro_line;
  std::string axis;
  std::optional<double> arcsec_per_pulse;
  std::optional<double> latitude;
  double azimuth = 0, elevation = 90;
  std::string serial_number;
};

/// Returns the path of the chamber's description if the chamber is not listed: "bench-chamber.toml" for "bench.toml".
/// Empty otherwise.
[[nodiscard]] std::string chamber_file_path(const RigAnswers& answers);

[[nodiscard]] Result<void> accept_chamber(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_chamber_line(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_chamber_unit(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_lowest(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_highest(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_fastest(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_safe(RigAnswers& answers, const std::string& text);
/// Accepts two temperatures, "-50 70".
[[nodiscard]] Result<void> accept_air(RigAnswers& answers, const std::string& text);
/// Accepts the class and the settings of the limiter, "3.3 -50 75" or "3.1 75", or kUnknown.
[[nodiscard]] Result<void> accept_limiter(RigAnswers& answers, const std::string& text);

/// Accepts a whole scanner: kind, line, for dcon "addresses=1,2" and "type=T", and channels, separated by blanks.
[[nodiscard]] Result<void> accept_scanner(RigAnswers& answers, const std::string& text);
/// These accept the parts of the last scanner in the answers.
[[nodiscard]] Result<void> accept_scanner_kind(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_scanner_line(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_scanner_addresses(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_scanner_type(RigAnswers& answers, const std::string& text);
/// Accepts names, or a number n for the first n letters that are not in use.
[[nodiscard]] Result<void> accept_scanner_channels(RigAnswers& answers, const std::string& text);

[[nodiscard]] Result<void> accept_gyro(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_gyro_line(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_axis(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_arcsec_per_pulse(RigAnswers& answers, const std::string& text);
/// Accepts degrees, or kUnknown.
[[nodiscard]] Result<void> accept_latitude(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_azimuth(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_elevation(RigAnswers& answers, const std::string& text);
/// Accepts a serial number, or kNone: the program then asks for it at the start of each run.
[[nodiscard]] Result<void> accept_serial_number(RigAnswers& answers, const std::string& text);
[[nodiscard]] Result<void> accept_title(RigAnswers& answers, const std::string& text);

/// Returns the number of inputs of a scanner, or 64 if it is unknown.
[[nodiscard]] std::size_t count_scanner_inputs(const ScannerAnswer& scanner);
/// Returns the channels of all scanners.
[[nodiscard]] std::vector<std::string> list_channel_names(const RigAnswers& answers);
/// Returns up to `most` of the letters A to H that are not the name of a channel, or "shell" if none is left.
[[nodiscard]] std::vector<std::string> list_free_channels(const RigAnswers& answers, std::size_t most);

}  // namespace gyrotherm::app
