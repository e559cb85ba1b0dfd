#include "rig/rig_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>

#include "core/text_file.hpp"
#include "core/toml_reader.hpp"
#include "drivers/description.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm {
namespace {

constexpr double kEarthRateDegPerHour = 15.041067;  // 7.292115e-5 rad/s

/// Ω on an input axis: Ω (cos φ cos az cos el + sin φ sin el); az from true north, el above the horizontal.
DegreesPerHour earth_rate(double latitude_deg, double azimuth_deg, double elevation_deg) {
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180; };
  const double phi = radians(latitude_deg), az = radians(azimuth_deg), el = radians(elevation_deg);
  return {kEarthRateDegPerHour * (std::cos(phi) * std::cos(az) * std::cos(el) + std::sin(phi) * std::sin(el))};
}

void check_line(const TomlTable& table, const std::string& line) {
  if (line == kVirtualLine) return;
  if (const auto address = parse_line_address(line, 1); !address) table.mistake("line", address.error().what);
}

std::optional<WordOrder> word_order(const TomlTable& chamber) {
  const auto order = chamber.choice("word_order", {"default", "abcd", "cdab", "badc", "dcba"}, "default");
  if (order == "abcd") return WordOrder::abcd;
  if (order == "cdab") return WordOrder::cdab;
  if (order == "badc") return WordOrder::badc;
  if (order == "dcba") return WordOrder::dcba;
  return {};
}

void read_chamber(const TomlTable& table, RigFile& rig) {
  rig.chamber_line = table.text("line");
  check_line(table, rig.chamber_line);
  rig.chamber_limits = {
      .lowest = table.celsius("lowest"),
      .highest = table.celsius("highest"),
      .fastest_heating = table.rate("fastest_heating"),
      .fastest_cooling = table.rate("fastest_cooling"),
  };
  rig.safe_set_point = table.celsius("safe_set_point");
  if (rig.chamber_limits.lowest >= rig.chamber_limits.highest)
    table.mistake("lowest", "the lowest temperature is not below the highest");
  else if (rig.safe_set_point < rig.chamber_limits.lowest || rig.safe_set_point > rig.chamber_limits.highest)
    table.mistake("safe_set_point", "the safe set point is outside what the chamber can do");
}

Result<RegisterMap> read_map(const TomlTable& chamber, const RigFile& rig, const std::optional<std::string>& known) {
  const auto name = chamber.text("map");
  const auto order = word_order(chamber);
  const auto path = (std::filesystem::path(rig.file).parent_path() / name).lexically_normal().string();
  if (known) return parse_register_map(*known, path, order);
  const auto text = read_text_file(path);
  if (!text) return failure(FaultKind::bad_file, chamber.place("map"), text.error().where + " " + text.error().what);
  return parse_register_map(*text, path, order);
}

ThermometerEntry read_thermometer(const TomlTable& table, std::set<std::string>& seen) {
  ThermometerEntry entry{.driver = table.choice("driver", {"lakeshore_218"}),
                         .line = table.text("line"),
                         .channels = table.texts("channels"),
                         .offsets = {},
                         .place = table.place()};
  check_line(table, entry.line);
  for (const double offset : table.numbers("offsets")) entry.offsets.push_back({offset});
  if (entry.offsets.empty()) entry.offsets.resize(entry.channels.size());
  if (entry.offsets.size() != entry.channels.size())
    table.mistake("offsets", fmt::format("{} offsets for {} channels", entry.offsets.size(), entry.channels.size()));
  if (entry.channels.empty() || entry.channels.size() > 8) table.mistake("channels", "expected one to eight channels");
  for (const auto& channel : entry.channels)
    if (!seen.insert(channel).second) table.mistake("channels", fmt::format("channel \"{}\" is there twice", channel));
  return entry;
}

void read_gyro(const TomlTable& table, RigFile& rig) {
  rig.gyro_line = table.text("line");
  check_line(table, rig.gyro_line);
  rig.gyro.kind = GyroKind::pulse_count;
  rig.gyro.scale = table.number("arcsec_per_pulse");
  if (rig.gyro.scale == 0) table.mistake("arcsec_per_pulse", "must not be zero");
  const bool located = table.has("latitude");
  const double latitude = table.number("latitude", 0), azimuth = table.number("azimuth", 0),
               elevation = table.number("elevation", 90);
  if (located) rig.gyro.earth_rate = earth_rate(latitude, azimuth, elevation);
  rig.gyro_frame = read_frame_format(table.table("frame"));
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

/// A silence of no time at all would be there in every sample.
Duration read_silence(const TomlTable& table, std::string_view key, Duration fallback) {
  const auto silence = table.duration(key, fallback);
  if (silence <= Duration{}) table.mistake(key, "expected a time longer than zero");
  return silence;
}

void read_limits(const TomlTable& table, InterlockLimits& limits) {
  limits.air_lowest = table.celsius("air_lowest", limits.air_lowest);
  limits.air_highest = table.celsius("air_highest", limits.air_highest);
  limits.thermometers_lowest = table.celsius("thermometers_lowest", limits.thermometers_lowest);
  limits.thermometers_highest = table.celsius("thermometers_highest", limits.thermometers_highest);
  if (limits.air_lowest >= limits.air_highest)
    table.mistake("air_lowest", "the lowest temperature is not below the highest");
  if (limits.thermometers_lowest >= limits.thermometers_highest)
    table.mistake("thermometers_lowest", "the lowest temperature is not below the highest");
  const auto confirming = table.integer("confirming_samples", limits.confirming_samples);
  limits.confirming_samples = bounded<int>(table, "confirming_samples", confirming, 1, 3600);
  limits.suspend_after = read_silence(table, "suspend_after", limits.suspend_after);
  limits.chamber_lost = read_silence(table, "chamber_lost", limits.chamber_lost);
  limits.thermometers_lost = read_silence(table, "thermometers_lost", limits.thermometers_lost);
  limits.gyro_lost = read_silence(table, "gyro_lost", limits.gyro_lost);
}

/// All lines virtual, or none.
void settle_simulated(const TomlTable& root, RigFile& rig) {
  std::vector<std::string> lines{rig.chamber_line, rig.gyro_line};
  for (const auto& entry : rig.thermometers) lines.push_back(entry.line);
  const auto count = std::count(lines.begin(), lines.end(), kVirtualLine);
  rig.simulated = count == static_cast<std::ptrdiff_t>(lines.size());
  if (count != 0 && !rig.simulated)
    root.mistake("chamber", "some lines are \"virtual\" and some are not; a rig is wholly virtual or wholly real");
  if (rig.simulated != root.has("virtual"))
    root.mistake("virtual",
                 rig.simulated ? "a virtual rig needs a [virtual] table" : "a real rig has no [virtual] table");
}

}  // namespace

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
  for (const auto& table : root->tables("thermometer")) rig.thermometers.push_back(read_thermometer(table, seen));
  if (rig.thermometers.empty()) root->mistake("", "missing [[thermometer]], expected at least one");
  read_gyro(root->table("gyro"), rig);
  read_analysis(root->table("analysis"), seen, rig);
  read_limits(root->table("limits"), rig.limits);
  settle_simulated(*root, rig);
  auto map = read_map(chamber, rig, known.chamber_map);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  if (!map) return failure(map.error());
  rig.chamber_map = std::move(*map);
  if (!rig.simulated) return rig;
  auto gyro_model = gyro_model_of(text, file, known.gyro_model);
  if (!gyro_model) return failure(gyro_model.error());
  rig.gyro_model = std::move(*gyro_model);
  return rig;
}

Result<RigFile> read_rig(const std::string& file) {
  const auto text = read_text_file(file);
  if (!text) return failure(text.error());
  return parse_rig(*text, file);
}

std::vector<Channel> channels_of(const RigFile& rig) {
  std::vector<Channel> channels;
  for (std::size_t i = 0; i < rig.thermometers.size(); ++i) {
    const auto& entry = rig.thermometers[i];
    for (std::size_t j = 0; j < entry.channels.size(); ++j)
      channels.push_back({.name = entry.channels[j],
                          .instrument = fmt::format("{} {} at {}, input {}", entry.driver, i + 1, entry.line, j + 1),
                          .offset = entry.offsets[j]});
  }
  return channels;
}

}  // namespace gyrotherm
