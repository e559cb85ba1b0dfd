/// A gyro's whole description: a TOML file under profiles/gyro-streams, with the port's settings, what to send before
/// and after, and the frames.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm {

struct GyroPort {
  std::uint32_t baud{};
  int data_bits = 8;
  char parity = 'N';  ///< N, E, O
  int stop_bits = 1;
};

/// What is sent, how long to wait then, and what must have come by then (empty: anything).
struct GyroCommand {
  std::string send;
  Duration wait{};
  std::string reply;
};

struct GyroStream {
  std::string name;
  std::string vendor;
  std::string source;      ///< where its facts come from
  std::string confidence;  ///< "verified" (against published frames), "manual", "secondary" (someone's driver)
  GyroPort port;
  std::vector<GyroCommand> start;  ///< makes it send; in order
  std::vector<GyroCommand> stop;
  FrameFormat frame;
  std::string text;  ///< the file, as read
};

/// Fails with bad_file, every mistake with its place. `axis`: the gyro wanted, instead of the file's own choice.
[[nodiscard]] Result<GyroStream> parse_gyro_stream(std::string_view text, const std::string& file,
                                                   const std::string& axis = "");

}  // namespace gyrotherm
