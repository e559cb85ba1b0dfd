// SPDX-License-Identifier: Apache-2.0
/// Feeds any report to the virtual USB-TEMP. A reply must belong to a known command and not exceed its length.
#include <cstdlib>

#include "simulator/servers/virtual_thermometers.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::simulator {

FUZZ_TARGET(virtual_usb_temp, const std::uint8_t* data, std::size_t size) {
  static const VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  static std::mutex guard;
  static VirtualUsbTemp device(laboratory, guard, {0, 1, 2, 3});
  if (!device.write(std::as_bytes(std::span(data, size)))) std::abort();
  std::array<std::byte, 256> report{};
  const auto got = device.read(report, {});
  if (got &&
      (size == 0 || *got < 2 || *got > drivers::kMccLongestReport || report[0] != static_cast<std::byte>(data[0])))
    std::abort();
  if (device.read(report, {})) std::abort();
  return 0;
}

}  // namespace gyrotherm::simulator
