// SPDX-License-Identifier: Apache-2.0
/// Fuzzes certificates of other laboratories. Any bytes must be read or refused with a position, and the values of a
/// certificate must be possible.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "report/temperature_certificate.hpp"
#include "report/xml_signature.hpp"
#include "tests/support/fuzz_target.hpp"

namespace {

using gyrotherm::fuzz::require;

void read_certificate(const std::string& bytes) {
  const auto root = gyrotherm::report::read_foreign_dcc(bytes, "fuzz.xml");
  if (!root) return require(root.error().where.starts_with("fuzz.xml:"));
  const auto signature = gyrotherm::report::find_whole_signature(*root, "fuzz.xml");
  require(signature ? !signature->certificates.empty() : signature.error().where.starts_with("fuzz.xml:"));
  const auto found = gyrotherm::report::read_temperature_certificate(*root, "fuzz.xml", "");
  if (!found) return require(found.error().where.starts_with("fuzz.xml:"));
  require(!found->points.empty() && !found->number.empty() && std::isfinite(found->offset_k()));
  require(found->standard_uncertainty_k() > 0 && std::isfinite(found->standard_uncertainty_k()));
  require(found->lowest_c() >= -273.15 && found->lowest_c() <= found->highest_c());
}

}  // namespace

FUZZ_TARGET(foreign_dcc, const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  read_certificate(bytes);
  const std::string begin =
      "<d:digitalCalibrationCertificate xmlns:d=\"https://ptb.de/dcc\" xmlns:s=\"https://ptb.de/si\" "
      "schemaVersion=\"3.3.0\"><d:administrativeData><d:coreData><d:uniqueIdentifier>1</d:uniqueIdentifier>"
      "<d:endPerformanceDate>2025-01-01</d:endPerformanceDate></d:coreData><d:items><d:item/></d:items>"
      "<d:calibrationLaboratory><d:contact><d:name><d:content>L</d:content></d:name></d:contact>"
      "</d:calibrationLaboratory></"
      "d:administrativeData><d:measurementResults><d:measurementResult><d:results><d:result>"
      "<d:data>";
  const std::string end =
      "</d:data></d:result></d:results></d:measurementResult></d:measurementResults></d:digitalCalibrationCertificate>";
  read_certificate(begin + bytes + end);
  read_certificate(begin +
                   "<d:quantity refType=\"basic_nominalValue\"><s:real><s:value>20</s:value><s:unit>\\degreecelsius"
                   "</s:unit></s:real></d:quantity><d:quantity refType=\"basic_measurementError\"><s:real><s:value>" +
                   bytes + "</s:value><s:unit>\\kelvin</s:unit><s:expandedUnc><s:uncertainty>" + bytes +
                   "</s:uncertainty><s:coverageFactor>2</s:coverageFactor></s:expandedUnc></s:real></d:quantity>" +
                   end);
  return 0;
}
