#include "rig/gyro_settings.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/gyro/frame_sum.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "drivers/gyro/pumped_stream.hpp"
#include "rig/thermometer_settings.hpp"
#include "simulator/servers/stream_writer.hpp"

namespace gyrotherm {
namespace {

constexpr double kEarthRateDegPerHour = 15.041067;  // 7.292115e-5 rad/s

/// Ω on an input axis: Ω (cos φ cos az cos el + sin φ sin el); az from true north, el above the horizontal.
DegreesPerHour earth_rate(double latitude_deg, double azimuth_deg, double elevation_deg) {
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180; };
  const double phi = radians(latitude_deg), az = radians(azimuth_deg), el = radians(elevation_deg);
  return {kEarthRateDegPerHour * (std::cos(phi) * std::cos(az) * std::cos(el) + std::sin(phi) * std::sin(el))};
}

Result<GyroStream> read_stream(const TomlTable& table, const std::string& rig_file,
                               const std::optional<std::string>& known) {
  const auto axis = table.text("axis", "");
  return read_named(table, "stream", rig_file, known).and_then([&](const NamedText& named) {
    return parse_gyro_stream(named.text, named.path, axis);
  });
}

/// What one count of the frames is: they say it themselves, or they count pulses, whose weight the rig file has.
double arcsec_per_count(const TomlTable& table, const FrameFormat& frame) {
  const auto own = frame.gyro() ? gyrotherm::arcsec_per_count(frame) : std::nullopt;
  if (own) {
    if (table.has("arcsec_per_pulse"))
      table.mistake("arcsec_per_pulse", "the frames have a scale of their own; this is for those that count pulses");
    return *own;
  }
  const double weight = table.number("arcsec_per_pulse");
  if (weight == 0) table.mistake("arcsec_per_pulse", "must not be zero");
  return weight;
}

SerialFormat serial_format(const GyroSettings& settings) {
  SerialFormat format{.baud = 115200};
  if (!settings.stream) return format;
  const auto& port = settings.stream->port;
  format = {.baud = static_cast<int>(port.baud), .data_bits = port.data_bits, .stop_bits = port.stop_bits};
  if (port.parity == 'O') format.parity = SerialParity::odd;
  if (port.parity == 'E') format.parity = SerialParity::even;
  return format;
}

}  // namespace

Result<GyroSettings> read_gyro(const TomlTable& table, const std::string& rig_file,
                               const std::optional<std::string>& known) {
  GyroSettings settings;
  settings.line = table.text("line");
  check_line(table, settings.line);
  const bool located = table.has("latitude");
  const double latitude = table.number("latitude", 0), azimuth = table.number("azimuth", 0),
               elevation = table.number("elevation", 90);
  if (located) settings.info.earth_rate = earth_rate(latitude, azimuth, elevation);
  settings.info.kind = GyroKind::pulse_count;
  if (!table.has("stream")) {
    settings.frame = read_frame_format(table.table("frame"));
    settings.info.scale = arcsec_per_count(table, settings.frame);
    return settings;
  }
  if (table.has("frame")) table.mistake("frame", "the frames are those of the stream: expected one of the two");
  auto stream = read_stream(table, rig_file, known);
  if (!stream) {
    table.ignore("arcsec_per_pulse");
    return failure(std::move(stream.error()));
  }
  settings.frame = stream->frame;
  settings.stream = std::move(*stream);
  settings.info.scale = arcsec_per_count(table, settings.frame);
  return settings;
}

std::unique_ptr<Gyro> make_gyro(const GyroSettings& settings, const Line& line, Duration within, bool simulated) {
  auto stream = make_stream(line, {.serial = serial_format(settings)}, kConnectWithin);
  if (simulated) return make_simulated_gyro(settings, std::move(stream), within);
  GyroCommands commands;
  if (settings.stream) commands = {.start = settings.stream->start, .stop = settings.stream->stop};
  return make_framed_gyro(settings.frame, make_pumped(std::move(stream)), within, std::move(commands));
}

std::unique_ptr<Gyro> make_simulated_gyro(const GyroSettings& settings, std::unique_ptr<ByteStream> stream,
                                          Duration within, const Clock* clock) {
  return make_framed_gyro(at_one_frame_a_second(settings.frame), std::move(stream), within, {}, clock);
}

}  // namespace gyrotherm
