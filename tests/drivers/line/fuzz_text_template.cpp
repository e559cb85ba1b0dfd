// SPDX-License-Identifier: Apache-2.0
/// Fuzzes the templates of text instruments: any bytes as a template, as an answer to templates of shipped files, and
/// as a framed answer. A template that matches must format its values to a line that it matches again. A line that fits
/// a stricter check must fit the others.
#include <array>
#include <string>
#include <string_view>

#include "drivers/line/text_frame.hpp"
#include "drivers/line/text_template.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::array<std::string_view, 8> kTemplates{
    "1¶{value:f}",
    "{a:f}, {b:f}, {c:f}, {d:f}",
    "{_:f}, [{_:f}], {mode:s}, {alarms:d}",
    "{{S00{value:x4}",
    "A0 {value:f05.1} {set:f05.1}",
    "1;{value:f*8,}",
    "{a:f06.1} {b:f06.1} {_:b1}{run:b1}{rest:b6}",
    "{status:d} {text:s}",
};

void require_round_trip(const TextTemplate& form, const std::string& line) {
  const auto values = form.match(line);
  if (!values) return;
  const auto again = form.match(form.format(*values));
  fuzz::require(again.has_value());
  fuzz::require(again->size() == values->size());
}

void require_stricter_checks(const TextTemplate& form, const std::string& line) {
  const bool fits = form.match(line).has_value(), fits_with_point = form.match(line, NumberCheck::point).has_value();
  fuzz::require(fits || !fits_with_point);
  fuzz::require(fits_with_point || !form.match(line, NumberCheck::all_decimals));
}

}  // namespace

FUZZ_TARGET(text_template, const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (const auto made = TextTemplate::parse(bytes, TextEncoding::latin1)) {
    (void)made->match(made->format({}));
    (void)made->ends_with_open_number();
  }
  const auto form = TextTemplate::parse(kTemplates[data[0] % kTemplates.size()], TextEncoding::latin1);
  fuzz::require(form.has_value());
  require_round_trip(*form, bytes);
  require_stricter_checks(*form, bytes);
  const TextFrame frame{.high_bit = data[0] % 2 == 1, .checksum = FrameChecksum::exclusive_or};
  if (const auto text = from_frame(frame, bytes)) fuzz::require(to_frame(frame, *text) == bytes);
  return 0;
}

}  // namespace gyrotherm::drivers
