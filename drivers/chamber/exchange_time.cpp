// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/exchange_time.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

namespace gyrotherm::drivers {

std::string describe_slow_exchange(const MapLink& link) {
  constexpr Duration kLongestCall = std::chrono::milliseconds(8500);
  const auto& modbus = link.modbus;
  const auto pause = is_text(link.kind) ? std::max({link.text.after_read, link.text.after_write, link.text.quiet})
                                        : std::max({modbus.after_write, modbus.gap, modbus.minimum_period});
  if (pause + 2 * modbus.timeout <= kLongestCall) return {};
  return fmt::format(
      "a pause of {:g} s and twice the timeout of {:g} s are {:g} s, expected at most {:g} s: the guard of a run takes "
      "a "
      "longer exchange for a hung program",
      to_seconds(pause), to_seconds(modbus.timeout), to_seconds(pause + 2 * modbus.timeout), to_seconds(kLongestCall));
}

}  // namespace gyrotherm::drivers
