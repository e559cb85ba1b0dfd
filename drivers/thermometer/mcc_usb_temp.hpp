/// MCC USB-TEMP and USB-TC: eight thermometers over HID.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "core/clock.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/hid_line.hpp"
#include "drivers/thermometer/mcc_usb_temp_setup.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm {

inline constexpr std::array<HidKind, 2> kMccKinds{{{0x09DB, 0x008D, "USB-TEMP"}, {0x09DB, 0x0090, "USB-TC"}}};

struct MccOptions {
  /// What is connected to each input; nothing: the instrument is not told and not asked, and any temperature between
  /// absolute zero and the end of type B may be true.
  std::array<std::optional<MccSensor>, kMccInputs> sensors{};
  Duration within = std::chrono::milliseconds(500);  ///< for a reply; after one that did not come, silence as long
  const Clock* clock = nullptr;                      ///< of a device with a time of its own
};

/// Whenever the instrument was opened, and before it is read, its set-up is compared with `sensors`; where it differs
/// it is set, and the instrument calibrates itself, which takes some seconds, in which read() yields a timeout in every
/// place and identify() waits. Then the set-up is compared again; mismatch if it does not hold it. `place` names the
/// instrument in its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_mcc_usb_temp(std::unique_ptr<HidReports> reports, std::string place,
                                                             MccOptions options = {});

}  // namespace gyrotherm
