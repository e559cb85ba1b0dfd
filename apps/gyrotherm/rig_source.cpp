// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/rig_source.hpp"

#include <filesystem>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "report/temperature_certificate.hpp"

namespace gyrotherm::app {
namespace {

Result<rig::CertificateValues> read_certificate_values(const rig::CertificateRequest& request) {
  const auto bytes = read_text_file(request.path, report::kLargestForeignDcc);
  if (!bytes) return failure(bytes.error());
  const auto verified = report::verify_temperature_certificate(*bytes, request.path, request.serial_number,
                                                               {.certificates_file = request.trusted});
  if (!verified) return failure(verified.error());
  const report::TemperatureCertificate& certificate = verified->certificate;
  const auto calibrated = record::parse_day(certificate.calibrated);
  if (!calibrated) return failure(FaultKind::bad_file, request.path, "the day of its calibration is out of range");
  const auto& point = certificate.most_uncertain();
  return rig::CertificateValues{.number = certificate.number,
                                .offset = {certificate.offset_k()},
                                .standard_uncertainty = {certificate.standard_uncertainty_k()},
                                .calibrated = *calibrated,
                                .due = record::parse_day(certificate.due),
                                .file = {.name = std::filesystem::path(request.path).filename().string(),
                                         .sha256 = verified->sha256,
                                         .issuer = certificate.issuer,
                                         .signer = verified->signer.subject,
                                         .expanded = {point.expanded_k},
                                         .coverage_factor = point.coverage_factor,
                                         .lowest = {certificate.lowest_c()},
                                         .highest = {certificate.highest_c()}}};
}

}  // namespace

Result<rig::RigFile> load_rig(const std::string& given) {
  const auto today = std::chrono::floor<std::chrono::days>(SteadyClock().now().utc);
  return rig::read_rig(given, {.read = read_certificate_values, .today = std::chrono::sys_days(today)});
}

}  // namespace gyrotherm::app
