/// The lines of a rig that somebody else has made, with a time of their own: behind them stands the simulator in
/// memory, where a silent instrument costs virtual time alone, and whatever breaks them on command.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/clock.hpp"
#include "drivers/chamber/pauses.hpp"
#include "drivers/wires.hpp"
#include "rig/rig_file.hpp"

namespace gyrotherm {

class Wires {
 public:
  /// A line, and the clock on which its waits pass.
  template <class Line>
  struct Wire {
    std::unique_ptr<Line> line;
    const Clock* clock = nullptr;
  };

  virtual ~Wires() = default;
  /// Of the map's link in use.
  [[nodiscard]] virtual std::unique_ptr<Registers> chamber(const RegisterMap& map) = 0;
  [[nodiscard]] virtual std::unique_ptr<Pauses> pauses() = 0;
  /// Of the thermometer numbered `index` of the rig's file, if it is spoken to in bytes.
  [[nodiscard]] virtual Wire<ByteStream> thermometer(std::size_t index) = 0;
  /// … or if it is a USB-TEMP.
  [[nodiscard]] virtual Wire<HidReports> usb_temp(std::size_t index) = 0;
  /// One frame a second comes on it.
  [[nodiscard]] virtual Wire<ByteStream> gyro() = 0;

  /// The rig's.
  [[nodiscard]] virtual const Clock& clock() const = 0;
  /// Lets the world behind the wires and the clock move on by whole seconds.
  virtual void let_pass(std::int64_t seconds) = 0;
};

}  // namespace gyrotherm
