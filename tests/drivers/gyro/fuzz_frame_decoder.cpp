// SPDX-License-Identifier: Apache-2.0
/// Fuzzes the frame decoder. Any bytes are decoded as a gyro stream with every shipped description, and parsed as the
/// description of a stream.
#include <cstdlib>
#include <string>

#include "drivers/gyro/frame_sum.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "tests/support/frame_streams.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::drivers {

namespace {

struct Known {
  GyroStream stream;
  /// Valid frames, more than any preceding noise can hide.
  std::vector<std::byte> good;
  std::size_t frames = 0;
};

Known known(const std::string& name) {
  Known all{.stream = tests::whole_shipped_stream(name), .good = {}};
  const auto& format = all.stream.frame;
  const auto* sequence = format.find(FieldRole::sequence);
  for (; all.good.size() < 600 || all.frames < 40; ++all.frames) {
    const auto count = sequence ? all.frames * sequence->step % sequence->range : 0;
    const AxisReading reading{.pulses = all.frames % 7, .value = 1e-6 * static_cast<double>(all.frames % 5)};
    const auto one = encode_frame(format, {.axes = std::vector(format.axes.size(), reading),
                                           .sequence = static_cast<std::uint32_t>(count),
                                           .timestamp = all.frames * 1000});
    all.good.insert(all.good.end(), one.begin(), one.end());
  }
  return all;
}

const std::vector<Known>& descriptions() {
  static const auto all = [] {
    std::vector<Known> found;
    for (const auto& name : tests::shipped_streams()) found.push_back(known(name));
    return found;
  }();
  return all;
}

void decode_all(const Known& all, std::span<const std::byte> bytes, bool then_good) {
  FrameDecoder decoder(all.stream.frame);
  FrameSum sum(all.stream.frame);
  FrameMeans means(all.stream.frame);
  FrameTally tally;
  std::size_t taken = 0, fed = bytes.size();
  const auto take = [&] {
    while (const auto* frame = decoder.take()) {
      sum.add(*frame, tally);
      means.add(*frame);
      if (taken % 16 == 15) sum.drop_round();
      (void)decoder.broken_rules();
      ++taken;
    }
  };
  decoder.feed(bytes.first(bytes.size() / 2));
  take();
  decoder.feed(bytes.subspan(bytes.size() / 2));
  take();
  if (then_good) {
    const auto before = taken;
    decoder.feed(all.good);
    fed += all.good.size();
    take();
    // Noise may hide some valid frames, but never most of them.
    if (taken < before + all.frames / 2) std::abort();
  }
  if (decoder.rejected_bytes() > fed) std::abort();
  if (sum.counts(tally, tally.interval).size() != all.stream.frame.axes.size()) std::abort();
  const auto values = means.values();
  if (values.size() != list_housekeeping(all.stream.frame).size()) std::abort();
  if (!values.empty() && values[values.size() - 2] > static_cast<double>(taken)) std::abort();
}

}  // namespace

/// The first byte selects a description. If it is at least 0xF0, valid frames follow the noise.
FUZZ_TARGET(frame_decoder, const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto& all = descriptions();
  decode_all(all[data[0] % all.size()], std::as_bytes(std::span(data, size)).subspan(1), data[0] >= 0xF0);
  return 0;
}

}  // namespace gyrotherm::drivers
