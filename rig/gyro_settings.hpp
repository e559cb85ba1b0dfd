/// The [gyro] of a rig file: its line, its frames, what they count and how it is mounted.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "acquisition/record/run_info.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/gyro/frame_stream.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/line_address.hpp"

namespace gyrotherm {

struct GyroSettings {
  std::string line;
  FrameFormat frame;
  std::optional<GyroStream> stream;  ///< where the rig file names one; its frame is `frame`
  GyroInfo info;
};

/// Either [gyro.frame], or `stream`, a description's path relative to `rig_file`, with the `axis` wanted;
/// `arcsec_per_pulse` where the frames do not say it; `latitude`, `azimuth`, `elevation` of the input axis in degrees.
/// `known`: the description's text where it is known already. Mistakes of the rig file are noted in the table; fails
/// with bad_file if the description cannot be read or has mistakes of its own.
[[nodiscard]] Result<GyroSettings> read_gyro(const TomlTable& table, const std::string& rig_file,
                                             const std::optional<std::string>& known);

/// The driver on `line`; one read may take `within`. A real gyro is sent the stream's commands, and its line is read
/// all the time; a simulated one sends one frame a second by itself.
[[nodiscard]] std::unique_ptr<Gyro> make_gyro(const GyroSettings& settings, const Line& line, Duration within,
                                              bool simulated);
/// The driver of a simulated one whose wire is there already; `clock`: of a wire with a time of its own.
[[nodiscard]] std::unique_ptr<Gyro> make_simulated_gyro(const GyroSettings& settings,
                                                        std::unique_ptr<ByteStream> stream, Duration within,
                                                        const Clock* clock = nullptr);

}  // namespace gyrotherm
