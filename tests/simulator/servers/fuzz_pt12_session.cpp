// SPDX-License-Identifier: Apache-2.0
/// Feeds any bytes to the virtual PT12. Each reply must be a whole line.
#include <cstdlib>

#include "simulator/servers/virtual_thermometers.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::simulator {

FUZZ_TARGET(pt12_session, const std::uint8_t* data, std::size_t size) {
  static const VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  Pt12Session session(laboratory, {0, 1, 2, 3});
  std::vector<std::byte> reply;
  if (!session.feed(std::as_bytes(std::span(data, size)), reply)) std::abort();
  for (const char* command : {"\rT", "\rCONNECTED"}) {
    if (!session.feed(std::as_bytes(std::span(std::string_view(command))), reply)) std::abort();
    if (!session.feed(std::as_bytes(std::span(data, size)), reply)) std::abort();
  }
  if (!reply.empty() && reply.back() != std::byte{'\n'}) std::abort();
  return 0;
}

}  // namespace gyrotherm::simulator
