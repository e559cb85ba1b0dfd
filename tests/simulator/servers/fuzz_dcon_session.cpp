// SPDX-License-Identifier: Apache-2.0
/// Feeds any bytes to the virtual thermocouple modules. Each reply must be a whole line.
#include <cstdlib>

#include "simulator/servers/virtual_thermometers.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::simulator {

FUZZ_TARGET(dcon_session, const std::uint8_t* data, std::size_t size) {
  static const VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  DconSession session(laboratory,
                      {{.inputs = {0, 1}}, {.address = 2, .checksum = drivers::DconChecksum::on, .inputs = {}}});
  std::vector<std::byte> reply;
  if (!session.feed(std::as_bytes(std::span(data, size)), reply)) std::abort();
  for (const char* command : {"\r#01", "\r$01", "\r#02"}) {
    if (!session.feed(std::as_bytes(std::span(std::string_view(command))), reply)) std::abort();
    if (!session.feed(std::as_bytes(std::span(data, size)), reply)) std::abort();
  }
  if (!reply.empty() && reply.back() != std::byte{'\r'}) std::abort();
  return 0;
}

}  // namespace gyrotherm::simulator
