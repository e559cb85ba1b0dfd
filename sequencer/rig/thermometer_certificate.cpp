// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/thermometer_certificate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>

namespace gyrotherm::rig {

namespace {

/// Returns true if a text ends in .xml, in capitals or not. Other texts are numbers of certificates.
bool is_certificate_file(const std::string& name) {
  const auto is_equal = [](char one, char other) { return std::tolower(static_cast<unsigned char>(one)) == other; };
  const std::string_view ending = kCertificateEnding;
  return name.size() >= ending.size() &&
         std::equal(name.end() - static_cast<std::ptrdiff_t>(ending.size()), name.end(), ending.begin(), is_equal);
}

}  // namespace

std::optional<NamedCertificate> read_named_certificate(const TomlTable& table, const std::string& folder) {
  const std::string name = table.has("certificate") ? table.text("certificate") : "";
  const std::string serial_number = table.text("serial_number", "");
  if (!is_certificate_file(name)) {
    if (table.has("serial_number"))
      table.note_error("serial_number", "selects an item of a certificate file, but \"certificate\" is not one (.xml)");
    return std::nullopt;
  }
  for (const char* key :
       {"offset", "offsets", "polynomial", "uncertainty", "coverage_factor", "distribution", "calibrated"})
    if (table.has(key))
      table.note_error(key, fmt::format("contradicts the certificate file, which states this value: expected one of "
                                        "\"{}\" and \"certificate\"",
                                        key));
  NamedCertificate named{.location = table.location("certificate")};
  named.request = {.path = (std::filesystem::path(folder) / name).string(), .serial_number = serial_number};
  return named;
}

Result<void> apply_certificate(const CertificateValues& values, const std::string& location,
                               const CertificateDays& days, record::Channel& channel) {
  const auto refused = [&](std::string what) { return failure(FaultKind::bad_file, location, std::move(what)); };
  if (channel.due && values.due && *channel.due > *values.due)
    return refused(fmt::format("\"due\" is {}, but certificate {} is due {}", record::format_day(*channel.due),
                               values.number, record::format_day(*values.due)));
  const auto due = channel.due ? channel.due : values.due;
  if (due && *due < days.of_run)
    return refused(fmt::format("certificate {} was due {}, expected a calibration that is valid on {}", values.number,
                               record::format_day(*due), record::format_day(days.of_run)));
  if (values.calibrated > days.latest_calibration)
    return refused(fmt::format("certificate {} states a calibration on {}, after {}; check the clock and the file",
                               values.number, record::format_day(values.calibrated),
                               record::format_day(days.latest_calibration)));
  channel.certificate = values.number;
  channel.offset = values.offset;
  channel.due = due;
  channel.uncertainty.calibration = values.standard_uncertainty;
  channel.uncertainty.rectangular = false;
  channel.uncertainty.calibrated = values.calibrated;
  channel.certificate_file = values.file;
  return {};
}

Result<void> restore_calibration(std::span<const record::Channel> recorded, const std::string& location,
                                 record::Channel& channel) {
  const auto found = std::ranges::find(recorded, channel.name, &record::Channel::name);
  if (found == recorded.end() || !found->certificate_file)
    return failure(FaultKind::bad_file, location,
                   fmt::format("the record does not contain the certificate file of channel {}", channel.name));
  channel.certificate = found->certificate;
  channel.offset = found->offset;
  channel.polynomial = found->polynomial;
  channel.due = found->due;
  channel.uncertainty = found->uncertainty;
  channel.certificate_file = found->certificate_file;
  return {};
}

}  // namespace gyrotherm::rig
