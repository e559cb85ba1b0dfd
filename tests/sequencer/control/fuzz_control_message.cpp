// SPDX-License-Identifier: Apache-2.0
/// Parses any bytes as a message of `tell`. A valid message must be one line, and the same after it is written and read
/// again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "core/text.hpp"
#include "sequencer/control/control_message.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::control {

using fuzz::require;

namespace {

void take(std::string_view message) {
  if (const auto request = parse_request(message)) {
    require(request->note.size() <= kLongestNote && request->note.find('\n') == std::string::npos);
    require(request->note.empty() == (request->command.has_value() || request->unit.has_value()) ||
            request->command == OperatorCommand::resume || request->unit.has_value());
    require(request->for_user.empty() || is_user_name(request->for_user));
    require(is_utf8(request->note));
    const auto again = parse_request(to_message(*request));
    require(again.has_value() && *again == *request);
  }
  if (const auto answer = parse_answer(message)) {
    const auto again = parse_answer(to_message(*answer));
    require(again.has_value() && *again == *answer);
  }
}

}  // namespace

FUZZ_TARGET(control_message, const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  take(bytes);
  for (const auto* beginning : {" ", " note ", " pause ", " done ", " refused ", " acknowledge ", " acknowledge 1 ",
                                " told ", " for=", " for=anna "})
    take(std::string(kControlSchema) + beginning + bytes);
  return 0;
}

}  // namespace gyrotherm::control
