// SPDX-License-Identifier: Apache-2.0
#include "rig/rig_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "core/file.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/gyro/frame_sum.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "drivers/line/line_address.hpp"
#include "rig/thermometer_settings.hpp"
#include "sequencer/interlocks/limits.hpp"
#include "simulator/chamber_registers.hpp"
#include "simulator/servers/gyro_server.hpp"

namespace gyrotherm::rig {
namespace {

std::optional<Celsius> read_side(const TomlTable& table, const char* key) {
  if (!table.has(key)) return {};
  return table.celsius(key);
}

/// Ω on an input axis: Ω (cos φ cos az cos el + sin φ sin el); az from true north, el above the horizontal.
DegreesPerHour earth_rate(double latitude_deg, double azimuth_deg, double elevation_deg) {
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180; };
  const double phi = radians(latitude_deg), az = radians(azimuth_deg), el = radians(elevation_deg);
  return {kEarthRateDegPerHour * (std::cos(phi) * std::cos(az) * std::cos(el) + std::sin(phi) * std::sin(el))};
}

/// A standard uncertainty, not below zero; nothing without the key.
std::optional<double> standard_uncertainty(const TomlTable& table, const char* key) {
  if (!table.has(key)) return std::nullopt;
  const double value = table.number(key);
  if (value >= 0 && std::isfinite(value)) return value;
  table.mistake(key, "expected a standard uncertainty, which is not below zero");
  return std::nullopt;
}

/// Of the keys latitude_uncertainty, azimuth_uncertainty and tilt_uncertainty in degrees,
/// scale_factor_uncertainty_ppm and turn_on_repeatability_deg_per_h.
record::GyroUncertainty read_gyro_uncertainty(const TomlTable& table) {
  return {.latitude_uncertainty_deg = standard_uncertainty(table, "latitude_uncertainty"),
          .azimuth_uncertainty_deg = standard_uncertainty(table, "azimuth_uncertainty"),
          .tilt_uncertainty_deg = standard_uncertainty(table, "tilt_uncertainty"),
          .scale_factor_uncertainty_ppm = standard_uncertainty(table, "scale_factor_uncertainty_ppm"),
          .turn_on_repeatability_deg_per_h = standard_uncertainty(table, "turn_on_repeatability_deg_per_h")};
}

Result<drivers::GyroStream> read_stream(const TomlTable& table, const std::string& rig_file,
                                        const std::optional<std::string>& known) {
  const auto axis = table.text("axis", "");
  return read_named(table, "stream", rig_file, known).and_then([&](const NamedText& named) {
    return drivers::parse_gyro_stream(named.text, named.path, axis);
  });
}

/// What one count of the frames is: they say it themselves, or they count pulses, whose weight the rig file has.
double arcsec_per_count(const TomlTable& table, const drivers::FrameFormat& frame) {
  const auto own = frame.gyro() ? gyrotherm::drivers::arcsec_per_count(frame) : std::nullopt;
  if (own) {
    if (table.has("arcsec_per_pulse"))
      table.mistake("arcsec_per_pulse", "the frames have a scale of their own; this is for those that count pulses");
    return *own;
  }
  const double weight = table.number("arcsec_per_pulse");
  if (weight == 0) table.mistake("arcsec_per_pulse", "must not be zero");
  return weight;
}

void check_safe_set_point(const TomlTable& table, const char* key, const RigFile& rig) {
  if (rig.safe_set_point < rig.chamber_limits.lowest || rig.safe_set_point > rig.chamber_limits.highest)
    table.mistake(key, "the safe set point is outside what the chamber can do");
}

/// Of the table [chamber.limiter]; nothing if there is none. `lowest` and `highest` are the chamber's limits of the
/// rig: a limiter set inside them would trip in a run, and is a mistake.
std::optional<Limiter> read_limiter(const TomlTable& chamber, Celsius lowest, Celsius highest) {
  if (!chamber.has("limiter")) return {};
  const auto table = chamber.table("limiter");
  Limiter limiter{.protection_class = table.choice("class", {"1", "2", "3.1", "3.2", "3.3"}),
                  .lowest = read_side(table, "lowest"),
                  .highest = read_side(table, "highest")};
  if (!limiter.lowest && !limiter.highest) table.mistake("", "expected lowest, highest or both: what it is set to");
  if (limiter.lowest && *limiter.lowest >= lowest)
    table.mistake("lowest", "the limiter would trip at a set point that the chamber may be given");
  if (limiter.highest && *limiter.highest <= highest)
    table.mistake("highest", "the limiter would trip at a set point that the chamber may be given");
  return limiter;
}

void read_chamber(const TomlTable& table, RigFile& rig) {
  rig.chamber_line = table.text("line");
  check_line(table, rig.chamber_line);
  rig.chamber_limits = {
      .lowest = table.celsius("lowest"),
      .highest = table.celsius("highest"),
      .fastest_heating = table.positive_rate("fastest_heating"),
      .fastest_cooling = table.positive_rate("fastest_cooling"),
  };
  rig.safe_set_point = table.celsius("safe_set_point");
  rig.limiter = read_limiter(table, rig.chamber_limits.lowest, rig.chamber_limits.highest);
  if (rig.chamber_limits.lowest >= rig.chamber_limits.highest)
    table.mistake("lowest", "the lowest temperature is not below the highest");
  else
    check_safe_set_point(table, "safe_set_point", rig);
}

/// What the word at `key` stands for; nothing if it is not there or "default".
template <class T, std::size_t N>
std::optional<T> said(const Vocabulary<T, N>& words, const TomlTable& table, const char* key) {
  if (!table.has(key) || table.text(key) == "default") return std::nullopt;
  return one_of(words, table, key);
}

/// The map, on the link that suits the line.
Result<drivers::RegisterMap> read_map(const TomlTable& chamber, const RigFile& rig,
                                      const std::optional<std::string>& known) {
  const auto wanted = said(drivers::kLinkKinds, chamber, "framing");
  const auto named = read_named(chamber, "map", rig.file, known);
  if (!named) return failure(named.error());
  auto map = parse_register_map(named->text, named->path, rig.chamber_word_order);
  const auto line = drivers::parse_line(rig.chamber_line);
  if (!map || !line) return map;
  if (rig.simulated)
    if (const auto unit = simulator::read_simulated_unit(*map, named->path); !unit) return failure(unit.error());
  auto linked = on_line(std::move(*map), *line, wanted);
  if (!linked) return failure(FaultKind::bad_file, chamber.place("line"), linked.error().what);
  return linked;
}

void read_analysis(const TomlTable& table, const std::set<std::string>& channels, RigFile& rig) {
  rig.gradients = table.texts("gradients");
  rig.three_point = table.texts("three_point");
  for (const auto* key : {"gradients", "three_point"})
    for (const auto& name : key == std::string_view("gradients") ? rig.gradients : rig.three_point)
      if (!channels.contains(name))
        table.mistake(key, fmt::format("\"{}\" is no channel of this rig's thermometers", name));
  if (rig.gradients.size() < 2) table.mistake("gradients", "expected at least two thermometers");
  if (!rig.three_point.empty() && rig.three_point.size() != 3)
    table.mistake("three_point", "expected three thermometers: cathode, anode, shell");
}

/// Where an interlock leaves the chamber.
void read_safe(const TomlTable& table, RigFile& rig) {
  rig.safe_set_point = table.celsius("set_point", rig.safe_set_point);
  rig.safe_off = table.boolean("off", false);
  if (table.has("set_point")) check_safe_set_point(table, "set_point", rig);
}

std::vector<std::string> names_of(const std::vector<record::Channel>& channels) {
  std::vector<std::string> names;
  for (const auto& channel : channels) names.push_back(channel.name);
  return names;
}

/// Of the thermometers without which nothing can be trained on the record.
std::vector<std::size_t> columns_of_analysis(const RigFile& rig) {
  std::vector<std::size_t> columns;
  const auto& channels = rig.limits.channels;
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (std::ranges::count(rig.gradients, channels[i]) + std::ranges::count(rig.three_point, channels[i]) > 0)
      columns.push_back(i);
  return columns;
}

/// All lines virtual, or none.
void settle_simulated(const TomlTable& root, RigFile& rig) {
  std::vector<std::string> lines{rig.chamber_line, rig.gyro.line};
  for (const auto& settings : rig.thermometers) lines.push_back(settings.line);
  const auto count = std::count(lines.begin(), lines.end(), kVirtualLine);
  rig.simulated = count == static_cast<std::ptrdiff_t>(lines.size());
  if (count != 0 && !rig.simulated)
    root.mistake("chamber", "some lines are \"virtual\" and some are not; a rig is wholly virtual or wholly real");
  if (rig.simulated != root.has("virtual"))
    root.mistake("virtual",
                 rig.simulated ? "a virtual rig needs a [virtual] table" : "a real rig has no [virtual] table");
}

}  // namespace

std::string in_words(const Limiter& limiter) {
  auto text = "class " + limiter.protection_class;
  if (limiter.lowest) text += fmt::format(", below {:g} °C", limiter.lowest->value);
  if (limiter.highest) text += fmt::format(", above {:g} °C", limiter.highest->value);
  return text;
}

Result<GyroSettings> read_gyro(const TomlTable& table, const std::string& rig_file,
                               const std::optional<std::string>& known) {
  GyroSettings settings;
  settings.line = table.text("line");
  check_line(table, settings.line);
  const bool located = table.has("latitude");
  const double latitude = table.number("latitude", 0), azimuth = table.number("azimuth", 0),
               elevation = table.number("elevation", 90);
  settings.info.uncertainty = read_gyro_uncertainty(table);
  settings.can_be_turned = table.boolean("can_be_turned", false);
  if (located) {
    settings.info.earth_rate = earth_rate(latitude, azimuth, elevation);
    settings.info.uncertainty.latitude_deg = latitude;
    settings.info.uncertainty.azimuth_deg = azimuth;
    settings.info.uncertainty.elevation_deg = elevation;
  }
  settings.info.kind = record::GyroKind::pulse_count;
  if (!table.has("stream")) {
    settings.frame = drivers::read_frame_format(table.table("frame"));
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

std::unique_ptr<drivers::Gyro> make_gyro(const GyroSettings& settings, const drivers::Line& line, Duration within) {
  const auto serial = settings.stream ? settings.stream->port : drivers::SerialFormat{.baud = 115200};
  auto stream = make_stream(line, {.serial = serial}, kConnectWithin);
  drivers::GyroCommands commands;
  if (settings.stream) commands = {.start = settings.stream->start, .stop = settings.stream->stop};
  return make_framed_gyro(settings.frame, make_pumped(std::move(stream)), within, std::move(commands));
}

std::unique_ptr<drivers::Gyro> make_simulated_gyro(const GyroSettings& settings,
                                                   std::unique_ptr<drivers::ByteStream> stream, Duration within,
                                                   const Clock* clock) {
  return make_framed_gyro(simulator::at_one_frame_a_second(settings.frame), std::move(stream), within, {}, clock);
}

Result<RigFile> parse_rig(std::string_view text, const std::string& file, const NamedTexts& known) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  RigFile rig;
  rig.text = text;
  rig.file = file;
  root->expect("schema", "gyrotherm-rig/1");
  rig.name = root->text("name");
  rig.title = root->text("title", rig.name);
  const auto chamber = root->table("chamber");
  read_chamber(chamber, rig);
  std::set<std::string> seen;
  for (const auto& table : root->tables("thermometer"))
    rig.thermometers.push_back(read_thermometer(table, rig.thermometers.size() + 1, seen));
  if (rig.thermometers.empty()) root->mistake("", "missing [[thermometer]], expected at least one");
  auto gyro = read_gyro(root->table("gyro"), file, known.gyro_stream);
  if (gyro) rig.gyro = std::move(*gyro);
  read_analysis(root->table("analysis"), seen, rig);
  read_safe(root->table("safe"), rig);
  rig.limits = interlocks::read_limits(*root, names_of(channels_of(rig)), rig.chamber_limits);
  rig.limits.needed_thermometers = columns_of_analysis(rig);
  rig.run_limits = interlocks::read_run_limits(*root);
  if (gyro)
    settle_simulated(*root, rig);
  else
    root->ignore("virtual");
  rig.chamber_word_order = said(drivers::kWordOrders, chamber, "word_order");
  auto map = read_map(chamber, rig, known.chamber_map);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  if (!gyro) return failure(gyro.error());
  if (!map) return failure(map.error());
  rig.chamber_map = std::move(*map);
  if (!rig.simulated) return rig;
  auto gyro_model = simulator::gyro_model_of(text, file, known.gyro_model);
  if (!gyro_model) return failure(gyro_model.error());
  rig.gyro_model = std::move(*gyro_model);
  return rig;
}

Result<RigFile> read_rig(const std::string& file) {
  return read_text_file(file).and_then([&](const std::string& text) { return parse_rig(text, file); });
}

std::vector<record::Channel> channels_of(const RigFile& rig) {
  std::vector<record::Channel> channels;
  for (const auto& settings : rig.thermometers)
    channels.insert(channels.end(), settings.calibrated.begin(), settings.calibrated.end());
  return channels;
}

}  // namespace gyrotherm::rig
