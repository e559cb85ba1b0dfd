// SPDX-License-Identifier: Apache-2.0
/// Fuzzes MCC reports with any bytes as a request and as a reply. A decoded request must encode to the same bytes.
#include <algorithm>
#include <cstdlib>

#include "drivers/thermometer/mcc_usb_temp.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::drivers {

namespace {

void read_reply(const MccRequest& request, std::span<const std::byte> report) {
  const auto length = mcc_reply_length(request);
  const auto bytes = decode_mcc_bytes(request, report);
  if (bytes && (bytes->size() != length || length >= report.size())) std::abort();
  const bool numbers = request.command == MccCommand::scan || request.command == MccCommand::read_input;
  if (!numbers || request.arguments.back() != 0) return;
  const auto readings = decode_mcc_temperatures(request, report);
  if (readings.has_value() != bytes.has_value()) std::abort();
  if (!readings) return;
  if (readings->size() * sizeof(float) != length) std::abort();
  for (const auto& reading : *readings)
    if (reading && !(reading->value >= -273.15 && reading->value <= 1820)) std::abort();
}

}  // namespace

FUZZ_TARGET(mcc_usb_temp_codec, const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  std::vector<std::byte> report(bytes.begin(), bytes.end());
  if (const auto request = decode_mcc_request(report)) {
    const auto again = encode_mcc_request(*request);
    if (again.size() > report.size() || !std::equal(again.begin(), again.end(), report.begin())) std::abort();
    read_reply(*request, report);
  }
  (void)decode_mcc_date(std::span(data, size).first(std::min<std::size_t>(size, 6)));

  // Repeats the test with the bytes as the reply to each query of temperatures.
  report.resize(std::min(report.size(), kMccLongestReport));
  for (const auto& request : {mcc_scan(0, 7), mcc_scan(3, 5), mcc_read_input(2), mcc_read_input(kMccColdJunction0)}) {
    if (!report.empty()) report[0] = static_cast<std::byte>(request.command);
    read_reply(request, report);
  }
  return 0;
}

}  // namespace gyrotherm::drivers
