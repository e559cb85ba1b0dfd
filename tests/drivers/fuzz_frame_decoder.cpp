/// Any bytes as a gyro's stream, and as the description of its frames.
#include <cstdlib>

#include "drivers/frame_format.hpp"
#include "tests/drivers/virtual_gyro_frame.hpp"

using namespace gyrotherm;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto format = virtual_gyro_frame();
  FrameDecoder decoder(format);
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto good = encode_frame(format, {.pulses = -1, .sequence = 2, .timestamp = 3});
  std::size_t taken = 0;
  decoder.feed(bytes.first(size / 2));
  while (decoder.take()) ++taken;
  decoder.feed(bytes.subspan(size / 2));
  decoder.feed(good);
  decoder.feed(good);
  while (decoder.take()) ++taken;
  if (taken == 0) std::abort();  // noise may swallow the first good frame, never both

  if (const auto file = TomlTable::parse({reinterpret_cast<const char*>(data), size}, "fuzz")) {
    (void)read_frame_format(file->table("frame"));
    (void)file->verdict();
  }
  return 0;
}
