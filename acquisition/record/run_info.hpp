/// What a record knows before its first sample: enough to analyse it, and to go on with it, without any other file.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"

namespace gyrotherm {

struct Channel {
  std::string name;        ///< "A" … "H", "shell", or a foreign record's own
  std::string instrument;  ///< who reads it, in words
  Kelvins offset;          ///< calibration: added to each reading when the record is analysed; stored readings are raw
  std::vector<double> polynomial{};  ///< … or, instead of the offset: temperature = Σ c_i reading^i, both in °C
  std::string certificate{};         ///< its number; may be empty
  std::optional<std::chrono::sys_days> due{};  ///< the last day on which the calibration holds
};

enum class GyroKind { pulse_count, rate };

struct GyroInfo {
  GyroKind kind{};
  double scale{};  ///< pulse_count: arcsec per pulse; rate: °/h per unit of the stored number
  std::optional<DegreesPerHour>
      earth_rate;  ///< on the input axis, removed from the bias; unknown: the first hold's mean is removed
};

struct RunInfo {
  std::string id;  ///< 32 hexadecimal digits; for a dry run derived from profile, rig and seed
  std::string program_version;
  std::string profile_name;
  std::string profile_text;
  std::string rig_name;
  std::string rig_text;
  std::string chamber_map_text;  ///< the register map that the rig file names
  std::string gyro_stream_text;  ///< the gyro's stream that the rig file names; empty: the rig file has it
  std::string gyro_model;        ///< virtual rig: the thermal model that its gyro stands on, by name; may be empty
  std::string gyro_film;         ///< … how the air moves around its cabinet: "chamber", "still"
  std::string gyro_model_text;   ///< … the model's file
  bool simulated{};
  std::uint64_t seed{};
  bool imported{};  ///< rows are a foreign record's, at its own times
  Duration started_utc{};
  std::vector<Channel> thermometers;
  GyroInfo gyro;
  std::vector<std::string> gradients;    ///< the thermometers whose differences are the multi-point gradients
  std::vector<std::string> three_point;  ///< cathode, anode, shell; may be empty
  std::vector<std::string> cycles;       ///< names
  struct SegmentInfo {
    std::string name;
    bool hold{};
    Celsius target;
    CelsiusPerMinute rate{};
    int cycle{-1};
  };
  std::vector<SegmentInfo> segments;  ///< the expanded profile
};

}  // namespace gyrotherm
