/// One program drives a chamber: a lock of the operating system, which ends with the program that holds it, however
/// that ends.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/result.hpp"
#include "drivers/line/descriptor.hpp"
#include "drivers/line/line_address.hpp"

namespace gyrotherm {

/// The chamber at the end of a line, however the line is written: "tcp-10.0.0.7-502-1" (with the unit's number, for
/// several chambers may be behind one address), "serial-dev-ttyUSB0" (of the device that a link leads to).
[[nodiscard]] std::string chamber_place(const Line& line, std::uint16_t usual_port, std::uint8_t unit);

class ChamberLock {
 public:
  /// `record`: what is to be driven from here, for whoever is refused. At once; fails with refused if another program
  /// holds it, and names that program, or with storage if no folder for locks can be used.
  [[nodiscard]] static Result<ChamberLock> take(const std::string& place, const std::string& record);
  /// Who holds the lock of that place, in words; nothing if nobody does.
  [[nodiscard]] static std::optional<std::string> holder(const std::string& place);

 private:
  explicit ChamberLock(Descriptor file) : file_(std::move(file)) {}
  Descriptor file_;
};

}  // namespace gyrotherm
