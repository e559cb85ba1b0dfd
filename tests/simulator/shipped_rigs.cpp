// SPDX-License-Identifier: Apache-2.0
#include "tests/simulator/shipped_rigs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "core/file.hpp"

namespace gyrotherm::simulator {
namespace {

/// Returns the value. Ends the test program if a shipped file cannot be read.
template <class T>
T must(Result<T> result) {
  if (result) return std::move(*result);
  std::cerr << text(result.error()) << '\n';
  std::abort();
}

/// Set points, one per second. A second has the set point of the program at its beginning.
struct Program {
  double at_c = 20;
  std::vector<double> set_points_c;

  void ramp(double target_c, int duration_s) {
    for (int i = 0; i < duration_s; ++i) set_points_c.push_back(at_c + (target_c - at_c) * i / duration_s);
    at_c = target_c;
  }
  void hold(int duration_s) { set_points_c.insert(set_points_c.end(), static_cast<std::size_t>(duration_s), at_c); }
};

struct Leg {
  double target_c;
  int ramp_s;
  int hold_s;
};

constexpr std::array<Leg, 29> kRandomLegs{
    {{22.5, 33, 5719},   {-17.5, 1296, 6365}, {-39.5, 314, 5860}, {6.8, 1489, 2437},  {-14.5, 510, 3930},
     {15.3, 359, 5831},  {22.2, 83, 2021},    {-24.0, 851, 890},  {-36.4, 265, 3676}, {51.7, 1587, 3993},
     {9.7, 1562, 677},   {-20.8, 505, 1924},  {-3.0, 2056, 6078}, {-24.6, 757, 6410}, {11.0, 494, 4822},
     {34.2, 1526, 4171}, {10.8, 317, 2984},   {19.8, 707, 3158},  {-7.7, 1403, 5987}, {-2.1, 69, 4493},
     {20.5, 401, 5064},  {-24.9, 1098, 2181}, {0.2, 1614, 6987},  {-18.5, 319, 2582}, {47.4, 1136, 1468},
     {44.5, 36, 6565},   {17.0, 1430, 1870},  {52.8, 719, 1791},  {48.4, 77, 4359}}};

}  // namespace

std::string rig_path(const std::string& name) {
  return std::string(GYROTHERM_SOURCE_DIR) + "/profiles/rigs/" + name + ".toml";
}

std::string rig_text(const std::string& name) { return must(read_text_file(rig_path(name))); }

LaboratoryParameters laboratory_of_rig(const std::string& name) {
  return must(parse_laboratory(rig_text(name), rig_path(name)));
}

LumpedGyroParameters lumped_of_rig(const std::string& name) {
  return std::get<LumpedGyroParameters>(laboratory_of_rig(name).body);
}

ReducedGyroParameters reduced_of_rig(const std::string& name) {
  return std::get<ReducedGyroParameters>(laboratory_of_rig(name).body);
}

drivers::FrameFormat gyro_of_rig(const std::string& name) {
  return drivers::read_frame_format(must(TomlTable::parse(rig_text(name), name)).table("gyro").table("frame"));
}

std::vector<VirtualGyroLine> gyro_lines_of_rig(const std::string& name) {
  const auto root = must(TomlTable::parse(rig_text(name), name));
  std::vector<VirtualGyroLine> lines;
  for (const auto& gyro : root.tables("gyro")) {
    VirtualGyroLine line;
    std::vector<std::string> fields;
    for (const auto& axis : gyro.tables("axis")) {
      line.axes.push_back({gyro.text("name"), axis.text("name", "")});
      if (axis.has("name")) fields.push_back(axis.text("name"));
    }
    if (gyro.has("stream"))
      line.frame =
          must(drivers::parse_gyro_stream(must(read_named(gyro, "stream", rig_path(name), kShippedGyroStream, {})).text,
                                          gyro.text("stream"), fields))
              .frame;
    else
      line.frame = drivers::read_frame_format(gyro.table("frame"), fields);
    lines.push_back(std::move(line));
  }
  return lines;
}

std::vector<VirtualThermometer> thermometers_of_rig(const std::string& name) {
  std::vector<VirtualThermometer> thermometers;
  for (const auto& one : must(TomlTable::parse(rig_text(name), name)).tables("thermometer"))
    thermometers.push_back({.channels = one.texts("channels")});
  return thermometers;
}

drivers::RegisterMap chamber_map(const std::string& name) {
  const auto path = std::string(GYROTHERM_SOURCE_DIR) + "/profiles/chambers/" + name + ".toml";
  return must(drivers::parse_register_map(must(read_text_file(path)), path));
}

std::vector<std::string> shipped_chambers() {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/chambers"))
    if (file.path().extension() == ".toml") names.push_back(file.path().stem());
  std::ranges::sort(names);
  return names;
}

std::vector<double> rate_cycle_c(double rate_c_per_min) {
  constexpr int kHold = 7200;
  Program program;
  program.hold(kHold);
  for (const double target_c : {-40.0, 60.0, -40.0, 60.0, 20.0}) {
    const double distance_k = std::abs(target_c - program.at_c);
    program.ramp(target_c, static_cast<int>(std::lround(distance_k / rate_c_per_min * 60)));
    program.hold(kHold);
  }
  return program.set_points_c;
}

std::vector<double> random_profile_c() {
  Program program;
  program.hold(7200);
  for (const auto& leg : kRandomLegs) {
    program.ramp(leg.target_c, leg.ramp_s);
    program.hold(leg.hold_s);
  }
  program.set_points_c.resize(144000);
  return program.set_points_c;
}

}  // namespace gyrotherm::simulator
