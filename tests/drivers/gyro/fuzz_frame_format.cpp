// SPDX-License-Identifier: Apache-2.0
/// Fuzzes the description of gyro frames with any text, alone and inside a valid description. An accepted description
/// is used to decode frames.
#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "drivers/gyro/frame_sum.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "tests/support/frame_streams.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::drivers {

namespace {

const std::vector<std::string>& good_texts() {
  static const auto all = [] {
    std::vector<std::string> found;
    for (const auto& name : tests::shipped_streams()) found.push_back(tests::shipped_stream(name).text);
    return found;
  }();
  return all;
}

void use(const GyroStream& stream) {
  const auto& format = stream.frame;
  if (format.gyros().empty() || format.gyros().size() != format.axes.size()) std::abort();
  FrameDecoder decoder(format);
  FrameSum sum(format);
  FrameMeans means(format);
  FrameTally tally;
  const auto one = encode_frame(format, {.axes = std::vector(format.axes.size(), AxisReading{5, 0.5}),
                                         .sequence = 1,
                                         .timestamp = 2,
                                         .values = std::vector<std::optional<double>>(format.values().size(), 1e9)});
  for (int i = 0; i < 3; ++i) decoder.feed(one);
  while (const auto* frame = decoder.take()) {
    (void)decoder.broken_rules();
    sum.add(*frame, tally);
    means.add(*frame);
  }
  if (means.values().size() != list_housekeeping(format).size()) std::abort();
}

/// Uses an accepted description with its default axis and with all axes.
void use_text(std::string_view text) {
  const auto stream = parse_gyro_stream(text, "fuzz");
  if (!stream) return;
  use(*stream);
  const auto whole = parse_gyro_stream(text, "fuzz", stream->frame.all_axes);
  if (whole) use(*whole);
}

/// Returns a valid description with one of its numbers or keywords replaced.
std::string edited_description(const std::uint8_t* data, std::size_t size) {
  auto text = good_texts()[data[0] % good_texts().size()];
  const std::size_t place = (data[1] * 256u + data[2]) % text.size();
  const auto begin = text.find("= ", place);
  if (begin == std::string::npos) return text;
  const auto end = std::min(text.find('\n', begin), text.size());
  return text.replace(begin + 2, end - begin - 2, reinterpret_cast<const char*>(data + 3), size - 3);
}

}  // namespace

FUZZ_TARGET(frame_format, const std::uint8_t* data, std::size_t size) {
  if (size < 4) return 0;
  use_text({reinterpret_cast<const char*>(data), size});
  if (data[3] % 2 == 0) {
    use_text(edited_description(data, std::min<std::size_t>(size, 16)));
    return 0;
  }
  // Small numbers are typical of descriptions.
  const auto number = std::to_string(static_cast<std::int8_t>(data[3]));
  std::vector<std::uint8_t> bytes(data, data + 3);
  bytes.insert(bytes.end(), number.begin(), number.end());
  use_text(edited_description(bytes.data(), bytes.size()));
  return 0;
}

}  // namespace gyrotherm::drivers
