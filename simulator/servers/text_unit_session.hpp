// SPDX-License-Identifier: Apache-2.0
/// Session of a virtual text instrument: splits the received bytes into lines, without terminator, frame and prefix.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/chamber/register_map.hpp"
#include "simulator/servers/session.hpp"

namespace gyrotherm::simulator {

class TextUnitSession : public Session {
 public:
  [[nodiscard]] bool feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) final;

 protected:
  explicit TextUnitSession(drivers::MapLink link);

 private:
  /// Returns the answer to a line, or nothing.
  [[nodiscard]] virtual std::optional<std::string> answer_line(const std::string& line) = 0;

  [[nodiscard]] std::optional<std::string> take_line();
  [[nodiscard]] std::optional<std::string> answer_prefixed(const std::string& line);

  drivers::MapLink link_;
  std::string prefix_;
  std::string received_;
};

}  // namespace gyrotherm::simulator
