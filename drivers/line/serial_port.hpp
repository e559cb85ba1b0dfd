/// The machine's serial ports: which there are, and opening one.
#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"
#include "drivers/line/descriptor.hpp"
#include "drivers/line/line_address.hpp"

namespace gyrotherm {

/// Opens `device` without waiting for a carrier, for this program alone (a lock that others respect, and the kernel's),
/// with `format`, which is read back. Reads and writes do not block. Fails with disconnected.
[[nodiscard]] Result<Descriptor> open_serial_port(const std::string& device, const SerialFormat& format);

struct SerialPortFound {
  std::string device;       ///< "/dev/ttyUSB0"
  std::string description;  ///< "FT232R USB UART - A50285BI", as the adapter says
  std::string serial;       ///< of a USB adapter, else empty
  std::string stable_name;  ///< the link under /dev/serial/by-id, which survives another order of plugging; or empty
  int vendor{}, product{};  ///< of a USB adapter, else 0
};
[[nodiscard]] std::vector<SerialPortFound> serial_ports();

}  // namespace gyrotherm
