// SPDX-License-Identifier: Apache-2.0
/// Feeds any bytes to a virtual scanner that a file describes. Each reply must be a whole line.
#include <cstdlib>

#include "core/file.hpp"
#include "simulator/servers/scanner_server.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::simulator {

FUZZ_TARGET(scanner_session, const std::uint8_t* data, std::size_t size) {
  static const VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  static const auto description = [] {
    const std::string file = GYROTHERM_SOURCE_DIR "/profiles/thermometers/keysight_34970a.toml";
    return drivers::parse_thermometer_description(read_text_file(file).value(), file).value();
  }();
  const auto session = make_scanner_session(laboratory, description, {0, 1, 2, 3});
  std::vector<std::byte> reply;
  if (!session->feed(std::as_bytes(std::span(data, size)), reply)) std::abort();
  for (const auto& step : description.preparation) {
    const auto line = "\n" + step.line + "\n";
    if (!session->feed(std::as_bytes(std::span(line)), reply)) std::abort();
  }
  if (!session->feed(std::as_bytes(std::span(data, size)), reply)) std::abort();
  constexpr std::string_view kScan = "\nINIT;*OPC?;FETC?\n";
  if (!session->feed(std::as_bytes(std::span(kScan)), reply)) std::abort();
  if (reply.empty() || reply.back() != std::byte{'\n'}) std::abort();
  return 0;
}

}  // namespace gyrotherm::simulator
