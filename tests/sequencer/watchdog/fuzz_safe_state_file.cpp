// SPDX-License-Identifier: Apache-2.0
/// Parses any bytes as a safe-state file and as a trace. The result must be either a fault with its position, or a text
/// that is the same after it is written and read again.
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "sequencer/watchdog/safe_state_file.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::watchdog {

using fuzz::require;

namespace {

/// Returns a text with a valid beginning, so parsing reaches the bytes behind it.
std::string add_valid_beginning(std::string_view bytes, std::size_t lines) {
  const auto whole = to_text(SafeState{.record = "r",
                                       .line = "tcp://1.2.3.4",
                                       .link = drivers::LinkKind::tcp,
                                       .word_order = {},
                                       .safe_set_point = {23},
                                       .switch_off = false,
                                       .by_program = false,
                                       .written_by = {.pid = 7, .started = 9, .boot = "b"},
                                       .map_text = "m"});
  std::size_t end = 0;
  for (std::size_t i = 0; i < lines; ++i) end = whole.find('\n', end) + 1;
  return whole.substr(0, end) + std::string(bytes);
}

}  // namespace

FUZZ_TARGET(safe_state_file, const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const auto text = add_valid_beginning(bytes, data[0] % 15);
  if (const auto safe_state = parse_safe_state(text, "fuzz")) {
    require(std::isfinite(safe_state->safe_set_point.value) && safe_state->written_by.pid > 0);
    const auto again = parse_safe_state(to_text(*safe_state), "again");
    require(again.has_value() && *again == *safe_state);
  } else {
    require(safe_state.error().kind == FaultKind::bad_file && safe_state.error().where.starts_with("fuzz:"));
  }
  const auto trace = parse_made_safe(fmt::format("schema = \"{}\"\n{}", kMadeSafeSchema, bytes), "fuzz");
  if (trace) require(std::isfinite(trace->set_point.value));
  return 0;
}

}  // namespace gyrotherm::watchdog
