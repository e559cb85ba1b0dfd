// SPDX-License-Identifier: Apache-2.0
/// Shipped gyro streams and a decoder for tests of them.
#pragma once

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/gyro/framed_gyro.hpp"

namespace gyrotherm::tests {

/// Returns the sorted names of the shipped streams. Throws if there are fewer than expected.
[[nodiscard]] inline std::vector<std::string> shipped_streams() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/gyro-streams"))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  constexpr std::size_t kFewest = 21;
  if (names.size() < kFewest) throw std::runtime_error("a shipped stream is missing");
  return names;
}

[[nodiscard]] inline drivers::GyroStream shipped_stream(const std::string& name,
                                                        const std::vector<std::string>& axes = {}) {
  std::ifstream file(GYROTHERM_SOURCE_DIR "/profiles/gyro-streams/" + name + ".toml");
  std::stringstream text;
  text << file.rdbuf();
  auto stream = drivers::parse_gyro_stream(text.str(), name + ".toml", axes);
  if (!stream) throw std::runtime_error(gyrotherm::text(stream.error()));
  return *stream;
}

/// Returns the shipped stream with all of its axes selected.
[[nodiscard]] inline drivers::GyroStream whole_shipped_stream(const std::string& name) {
  return shipped_stream(name, shipped_stream(name).frame.all_axes);
}

/// Parses "FE 81 …"; other characters are ignored.
[[nodiscard]] inline std::vector<std::byte> from_hex(std::string_view text) {
  std::vector<std::byte> bytes;
  std::string digits;
  for (const char c : text) {
    if (std::isxdigit(static_cast<unsigned char>(c))) digits += c;
    if (digits.size() < 2) continue;
    bytes.push_back(static_cast<std::byte>(std::stoi(digits, nullptr, 16)));
    digits.clear();
  }
  return bytes;
}

/// Frames, values and complaints that a decoder returns for the given bytes.
class DecodedStream {
 public:
  DecodedStream(const drivers::FrameFormat& format, const std::vector<std::byte>& bytes)
      : format_(format), decoder_(format) {
    decoder_.feed(bytes);
    while (const auto* frame = decoder_.take()) {
      frames.push_back(*frame);
      values_.push_back(decoder_.values());
      broken_rules.push_back(decoder_.broken_rules());
    }
    rejected = decoder_.rejected_bytes();
  }
  /// Returns the field of this name in a frame, or NaN if it is missing.
  [[nodiscard]] double value(const std::string& name, std::size_t frame = 0) const {
    for (std::size_t i = 0; i < format_.fields.size(); ++i)
      if (format_.fields[i].name == name && values_.at(frame)[i]) return *values_.at(frame)[i];
    return std::numeric_limits<double>::quiet_NaN();
  }
  /// Returns the housekeeping value of this name in a frame, or NaN if it is missing.
  [[nodiscard]] double housekeeping(const std::string& name, std::size_t frame = 0) const {
    const auto all = drivers::list_housekeeping(format_);
    const auto& values = frames.at(frame).values;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (all.at(i).name == name && values[i]) return *values[i];
    return std::numeric_limits<double>::quiet_NaN();
  }
  std::vector<drivers::GyroFrame> frames;
  std::vector<std::vector<std::string>> broken_rules;
  std::uint64_t rejected{};

 private:
  drivers::FrameFormat format_;
  drivers::FrameDecoder decoder_;
  std::vector<std::vector<std::optional<double>>> values_;
};

}  // namespace gyrotherm::tests
