// SPDX-License-Identifier: Apache-2.0
/// What a record knows before its first sample: enough to analyse it, and to go on with it, without any other file.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/sqlite.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {

/// The unit under test of a rig file that names none.
inline constexpr const char* kOnlyUnit = "gyro";

/// How well a thermometer is known, as far as the rig file says so; uncertainties are standard ones, k = 1.
struct ThermometerUncertainty {
  std::optional<Kelvins> calibration{};      ///< of what the certificate says
  bool rectangular{};                        ///< the certificate gives limits: half their width, divided by √3
  std::optional<Kelvins> drift_in_a_year{};  ///< it has walked at random, so it grows with the square root of time
  std::optional<std::chrono::sys_days> calibrated{};  ///< the day of the calibration
  bool operator==(const ThermometerUncertainty&) const = default;
};

/// Something that is measured once a second.
struct Channel {
  std::string name;        ///< "A" … "H", "shell", or a foreign record's own
  std::string instrument;  ///< who reads it, in words
  Kelvins offset;          ///< calibration: added to each reading when the record is analysed; stored readings are raw
  std::vector<double> polynomial{};  ///< … or, instead of the offset: temperature = Σ c_i reading^i, both in °C
  std::string certificate{};         ///< its number; may be empty
  std::optional<std::chrono::sys_days> due{};  ///< the last day on which the calibration holds
  std::string unit = "°C";                     ///< of the stored reading
  std::string unit_under_test = kOnlyUnit;     ///< that it belongs to; empty: to the rig
  ThermometerUncertainty uncertainty{};
};

enum class GyroKind { pulse_count, rate };

/// Where the input axis points, and how well that and the gyro are known, as far as the rig file says so. Uncertainties
/// are standard ones, k = 1.
struct GyroUncertainty {
  std::optional<double> latitude_deg{}, azimuth_deg{}, elevation_deg{};  ///< from true north, above the horizontal
  std::optional<double> latitude_uncertainty_deg{}, azimuth_uncertainty_deg{}, tilt_uncertainty_deg{};
  /// The fixture of an axis, and the standard uncertainties of its elevation, its roll and the axis's direction in it,
  /// each by itself. Such an axis has no tilt of its own.
  std::optional<double> fixture_azimuth_deg{}, fixture_elevation_deg{};
  std::optional<double> elevation_uncertainty_deg{}, roll_uncertainty_deg{}, direction_uncertainty_deg{};
  std::optional<double> scale_factor_uncertainty_ppm{};
  std::optional<double> turn_on_repeatability_deg_per_h{};  ///< standard deviation of the bias from run to run
  bool operator==(const GyroUncertainty&) const = default;
};

/// One input axis of a unit under test.
struct AxisInfo {
  std::string name{};  ///< empty: the unit's only one
  GyroKind kind{};
  double scale{};  ///< pulse_count: arcsec per pulse; rate: °/h per unit of the stored number
  std::optional<DegreesPerHour>
      earth_rate{};  ///< on the input axis, removed from the bias; unknown: the first hold's mean is removed
  std::optional<std::array<double, 3>> direction{};  ///< of the input axis in the fixture; of length 1
  GyroUncertainty uncertainty{};
};

/// Something that a unit tells of itself, or that analogue inputs measure of it: its own temperature, its discharge
/// current.
struct ValueInfo {
  std::string name;
  std::string unit;  ///< "°C" of a temperature
  bool is_temperature{};
  std::string instrument{};  ///< who reads it, in words; empty: the unit sends it itself
  bool operator==(const ValueInfo&) const = default;
};

/// A unit under test.
struct UnitInfo {
  std::string name = kOnlyUnit;
  std::string serial_number{};
  std::string model{};
  std::string instrument{};   ///< who reads it, in words
  std::string stream_text{};  ///< the gyro stream that the rig file names; empty: the rig file has it
  std::vector<AxisInfo> axes{};
  std::vector<ValueInfo> values{};
  std::vector<std::string> gradients{};    ///< the thermometers whose differences are the multi-point gradients
  std::vector<std::string> three_point{};  ///< cathode, anode, shell; may be empty
};

struct RunInfo {
  std::string id;  ///< 32 hexadecimal digits; for a dry run derived from profile, rig and seed
  std::string program_version;
  std::string profile_name;
  std::string profile_text;
  std::string rig_name;
  std::string rig_text;
  std::string rig_file{};                         ///< absolute path; empty: virtual rig
  std::string chamber_map_text;                   ///< the register map that the rig file names
  std::vector<std::string> analogue_map_texts{};  ///< … of each unit of analogue inputs
  std::string gyro_model;       ///< virtual rig: the thermal model that its gyro stands on, by name; may be empty
  std::string gyro_film;        ///< … how the air moves around its cabinet: "chamber", "still"
  std::string gyro_model_text;  ///< … the model's file
  bool simulated{};
  std::uint64_t seed{};
  std::uint64_t days_later{};      ///< virtual rig: how much older its gyro is than on day 0
  bool imported{};                 ///< rows are a foreign record's, at its own times
  Duration started_utc{};          ///< of a real run that is read: as its first sample has it, once there is one
  std::string chamber_instrument;  ///< who reads the chamber, in words
  /// Identity that each instrument reported when the run began, by its title ("chamber", "thermometer 2"). Empty for a
  /// record of 0.1.0.
  std::map<std::string, std::string> identities{};
  std::vector<Channel> thermometers;
  std::vector<UnitInfo> units;
  std::vector<std::string> cycles;  ///< names
  struct SegmentInfo {
    std::string name;
    bool hold{};
    Celsius target;
    CelsiusPerMinute rate{};
    int cycle{-1};
    std::string prompt{};  ///< what people were asked to do in its first second, in which the run was held for them
    UnitState unit{};
  };
  std::vector<SegmentInfo> segments;  ///< the expanded profile
};

/// The first unit of that name; null if there is none.
[[nodiscard]] const UnitInfo* find_unit(const RunInfo& info, std::string_view name);

/// Whether a thermometer may be an input of the unit's models: it sits on it, on no other unit, or the unit names it
/// among its gradients or three points.
[[nodiscard]] bool serves(const Channel& thermometer, const UnitInfo& unit);

/// How an axis is called among all: "gyro", "x" of a unit that has one axis, "u1.x" of one that has several.
[[nodiscard]] std::string axis_label(const UnitInfo& unit, std::size_t axis);

// RunInfo as rows of a record, there and back.

/// Inside the caller's transaction, into fresh tables.
[[nodiscard]] Result<void> write_run_info(Database& database, const RunInfo& info);

/// What write_run_info() wrote, to the bit but for started_utc. Fails with bad_file if it could not write a name.
[[nodiscard]] Result<RunInfo> read_run_info(Database& database);

/// The value of a key of the table `meta`, as text; empty if it is not there.
[[nodiscard]] Result<std::string> meta(Database& database, std::string_view key);

[[nodiscard]] Result<void> mark_finished(Database& database);
[[nodiscard]] Result<bool> is_finished(Database& database);

// What a certificate makes of a thermometer's readings. Dates are days of UTC.

/// The temperature that a reading stands for: reading + offset, or Σ c_i reading^i (both in °C) where the channel has a
/// polynomial.
[[nodiscard]] Celsius calibrated(const Channel& channel, Celsius reading);

/// Reads "2027-03-01". Returns nothing if there is no such day, or if nanoseconds since 1970 cannot hold it, which
/// reach from 1678 to 2261.
[[nodiscard]] std::optional<std::chrono::sys_days> parse_day(std::string_view text);
[[nodiscard]] std::string format_day(std::chrono::sys_days day);

/// "offset 0.01 K, certificate 2026-0123, due 2027-03-01"; "none" without any.
[[nodiscard]] std::string describe_calibration(const Channel& channel);

/// Of each channel whose calibration was due before `utc`: "calibration of A (certificate 2026-0123) was due
/// 2027-03-01".
[[nodiscard]] std::vector<std::string> overdue_calibrations(std::span<const Channel> channels, Duration utc);

}  // namespace gyrotherm::record
