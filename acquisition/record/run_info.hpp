// SPDX-License-Identifier: Apache-2.0
/// The description of a run, written before its first sample. The record needs no other file to be analysed or resumed.
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

/// The name of the unit under test if the rig file does not name one.
inline constexpr const char* kOnlyUnit = "gyro";

/// The uncertainties of a thermometer, as stated in the rig file. They are standard uncertainties, k = 1.
struct ThermometerUncertainty {
  /// The standard uncertainty of the certificate's values.
  std::optional<Kelvins> calibration{};
  /// The certificate states limits instead of an uncertainty. The standard uncertainty is then half their width divided
  /// by √3.
  bool rectangular{};
  /// The standard uncertainty of the drift after one year. The drift is a random walk, so it grows with the square root
  /// of time.
  std::optional<Kelvins> drift_in_a_year{};
  /// The day of the calibration.
  std::optional<std::chrono::sys_days> calibrated{};
  bool operator==(const ThermometerUncertainty&) const = default;
};

/// The file of a digital calibration certificate from which the calibration of a channel was read.
struct CertificateFile {
  std::string name{};    ///< without its folder
  std::string sha256{};  ///< digest of the file
  std::string issuer{};  ///< the calibration laboratory
  /// The subject of the certificate whose key signed the file (RFC 2253).
  std::string signer{};
  /// The largest expanded uncertainty that the certificate states, and its coverage factor.
  Kelvins expanded{};
  double coverage_factor{};
  /// The range of the calibrated temperatures.
  Celsius lowest{}, highest{};
  bool operator==(const CertificateFile&) const = default;
};

/// A channel that is read once a second.
struct Channel {
  /// "A" … "H", "shell", or the name in an imported record.
  std::string name;
  /// A description of the instrument.
  std::string instrument;
  /// The correction that the analysis adds to each reading. Stored readings are raw.
  Kelvins offset;
  /// The coefficients c_i of a correction that replaces the offset: temperature = Σ c_i reading^i, both in °C.
  std::vector<double> polynomial{};
  /// The number of the certificate; may be empty.
  std::string certificate{};
  /// The last day on which the calibration is valid.
  std::optional<std::chrono::sys_days> due{};
  std::string unit = "°C";  ///< unit of the stored reading
  /// The unit under test that the channel belongs to; empty for the rig.
  std::string unit_under_test = kOnlyUnit;
  ThermometerUncertainty uncertainty{};
  std::optional<CertificateFile> certificate_file{};
};

enum class GyroKind { pulse_count, rate };

/// The direction of the input axis, and the uncertainties of the direction and of the gyro, as stated in the rig file.
/// All are standard uncertainties, k = 1.
struct GyroUncertainty {
  /// Azimuth from true north, elevation above the horizontal.
  std::optional<double> latitude_deg{}, azimuth_deg{}, elevation_deg{};
  std::optional<double> latitude_uncertainty_deg{}, azimuth_uncertainty_deg{}, tilt_uncertainty_deg{};
  /// The fixture of an axis, and the independent standard uncertainties of its elevation, its roll and the direction of
  /// the axis in the fixture. An axis in a fixture has no tilt uncertainty of its own.
  std::optional<double> fixture_azimuth_deg{}, fixture_elevation_deg{};
  std::optional<double> elevation_uncertainty_deg{}, roll_uncertainty_deg{}, direction_uncertainty_deg{};
  std::optional<double> scale_factor_uncertainty_ppm{};
  /// The standard deviation of the bias between runs.
  std::optional<double> turn_on_repeatability_deg_per_h{};
  bool operator==(const GyroUncertainty&) const = default;
};

/// One input axis of a unit under test.
struct AxisInfo {
  /// Empty if the unit has only one axis.
  std::string name{};
  GyroKind kind{};
  /// For pulse_count: arcsec per pulse. For rate: °/h per unit of the stored number.
  double scale{};
  /// The Earth rate on the input axis, which is subtracted from the bias. If it is unknown, the mean of the first hold
  /// is subtracted.
  std::optional<DegreesPerHour> earth_rate{};
  /// The unit vector of the input axis in the fixture.
  std::optional<std::array<double, 3>> direction{};
  GyroUncertainty uncertainty{};
};

/// A value of a unit other than its rotation, such as its temperature or its discharge current. The unit sends it, or
/// an analogue input measures it.
struct ValueInfo {
  std::string name;
  /// "°C" for a temperature.
  std::string unit;
  bool is_temperature{};
  /// A description of the instrument that measures the value; empty if the unit sends it.
  std::string instrument{};
  bool operator==(const ValueInfo&) const = default;
};

/// A unit under test.
struct UnitInfo {
  std::string name = kOnlyUnit;
  std::string serial_number{};
  std::string model{};
  /// A description of the instrument.
  std::string instrument{};
  /// The gyro stream file that the rig file names; empty if the rig file contains the stream.
  std::string stream_text{};
  std::vector<AxisInfo> axes{};
  std::vector<ValueInfo> values{};
  /// The thermometers whose differences are the multi-point gradients.
  std::vector<std::string> gradients{};
  /// The thermometers at cathode, anode and shell; may be empty.
  std::vector<std::string> three_point{};
};

/// The release of a text that takes part in a run: the profile, the rig file, a map or a description.
struct ProgramRelease {
  std::string title;  ///< such as "profile short"
  std::string sha256;
  std::string revision{}, released_by{}, released_at{};
  std::string signer{};      ///< subject of the signer's certificate
  std::string unreleased{};  ///< reason why the text has no valid release; empty if it has one
  bool operator==(const ProgramRelease&) const = default;
};

/// Describes a release in a line: 'profile short: revision 3, released by A. Metrologist on 2026-11-25 …', or why there
/// is none.
[[nodiscard]] std::string describe(const ProgramRelease& release);

struct RunInfo {
  /// 32 hexadecimal digits. For a dry run they are derived from profile, rig and seed.
  std::string id;
  std::string program_version;
  std::string profile_name;
  std::string profile_text;
  std::string rig_name;
  std::string rig_text;
  /// The absolute path of the rig file; empty for a virtual rig.
  std::string rig_file{};
  /// The register map that the rig file names, the map of each unit of analogue inputs, and the description of each
  /// thermometer and power supply that has one.
  std::string chamber_map_text;
  std::vector<std::string> analogue_map_texts{};
  std::vector<std::string> thermometer_texts{};
  std::vector<std::string> supply_texts{};
  /// The thermal model of a virtual gyro: its name (may be empty), the air flow around its cabinet ("chamber" or
  /// "still"), and the text of the model file.
  std::string gyro_model;
  std::string gyro_film;
  std::string gyro_model_text;
  /// The rig is virtual: all instruments belong to the run itself, and the run is in virtual time.
  bool virtual_rig{};
  /// The titles of the instruments of a real rig that identified themselves as virtual ones when the run began
  /// ("chamber", "thermometer 2"), or those of the mark of an imported file. Empty for a record of an earlier version.
  std::vector<std::string> virtual_instruments{};
  std::uint64_t seed{};
  /// The age of a virtual gyro in days.
  std::uint64_t days_later{};
  /// The rows come from a file of another program, with its times.
  bool imported{};
  /// The start of the run. For a real run, read_run_info() replaces it by the time of the first sample if there is one.
  Duration started_utc{};
  /// A description of the chamber's instrument.
  std::string chamber_instrument;
  /// The identity that each instrument reported when the run began, by its title ("chamber", "thermometer 2"). Empty
  /// for a record of 0.1.0.
  std::map<std::string, std::string> identities{};
  /// The chamber measures the relative humidity of its air, or its dew point. Each has a column in the record. A
  /// measured humidity implies a computed dew point.
  bool has_humidity{};
  bool has_dew_point{};
  /// The number of the order that the units belong to; may be empty.
  std::string order_number{};
  std::vector<Channel> thermometers;
  std::vector<UnitInfo> units;
  /// The names of the units whose positions were empty. They have no readings and no serial number.
  std::vector<std::string> unused_units{};
  std::vector<std::string> cycles;  ///< names
  struct SegmentInfo {
    std::string name;
    bool hold{};
    Celsius target;
    CelsiusPerMinute rate{};
    int cycle{-1};
    /// The request to the operators in the first second of the segment. The run is held until they have acted on it.
    std::string prompt{};
    UnitState unit{};
  };
  std::vector<SegmentInfo> segments;  ///< the expanded profile
  /// The warm-ups that the run added to the profile: the required temperature of the unit, and air and rate.
  struct WarmUpInfo {
    Celsius at_least;
    Celsius air;
    CelsiusPerMinute rate{};
    bool operator==(const WarmUpInfo&) const = default;
  };
  std::optional<WarmUpInfo> warm_up{};  ///< nothing: none was added
  /// The releases of the run's texts under the site's policy; empty if the site has no register of releases.
  std::vector<ProgramRelease> releases{};
  /// The goal of a run that ends by itself, with the texts of the files that its profile names.
  struct Goal {
    double u_deg_per_h{};
    std::string mission_name;
    std::string mission_text;
    /// The model or type prior that the profile names; empty: none.
    std::string prior_text{};
    bool operator==(const Goal&) const = default;
  };
  std::optional<Goal> goal{};
  /// The blocks that decisions have added to `segments` so far, in order. The last one is empty if the run has been
  /// decided to end: the closing segments.
  std::vector<std::string> added_blocks{};
};

/// Returns whether the results of the run are marked as SIMULATED: the rig is virtual, or some of its instruments are.
[[nodiscard]] bool is_simulated(const RunInfo& info);

/// The text before the titles in describe_simulation().
inline constexpr std::string_view kVirtualInstrumentsText = "these instruments were virtual: ";

/// Returns what was virtual in a simulated run: "the instruments were virtual", or "these instruments were virtual:
/// chamber, thermometer 2". Returns an empty text for any other run.
[[nodiscard]] std::string describe_simulation(const RunInfo& info);

/// Returns whether a decision has already ended the run, so that it adds no more segments.
[[nodiscard]] bool has_ended(const RunInfo& info);

/// Returns the first unit of that name; null if there is none.
[[nodiscard]] const UnitInfo* find_unit(const RunInfo& info, std::string_view name);

/// Returns whether the position of the unit was empty.
[[nodiscard]] bool is_unused(const RunInfo& info, std::string_view unit);

/// Returns whether a thermometer may be an input of the unit's models: it is not mounted on another unit, or the unit
/// lists it in `gradients` or `three_point`.
[[nodiscard]] bool serves(const Channel& thermometer, const UnitInfo& unit);

/// Returns the label of an axis in the record: "gyro" or "x" for a unit with a single axis, "u1.x" for one with
/// several.
[[nodiscard]] std::string axis_label(const UnitInfo& unit, std::size_t axis);

// The storage of RunInfo in the tables of a record.

/// Adds the segments of a decision and its block to the description, unless it contains them. `first` is the index of
/// the first segment.
void add_block(RunInfo& info, std::size_t first, std::span<const RunInfo::SegmentInfo> segments,
               const std::string& block);

/// Writes a segment into the table `segment`, at a position.
[[nodiscard]] Result<void> write_segment(Database& database, std::size_t position, const RunInfo::SegmentInfo& segment);

/// Returns the number of segments that the description of a file covers. Decisions of the file add the others.
[[nodiscard]] Result<std::size_t> count_described_segments(Database& database);

/// Writes the description into fresh tables, inside the caller's transaction.
[[nodiscard]] Result<void> write_run_info(Database& database, const RunInfo& info);

/// Reads the description exactly as write_run_info() wrote it, except started_utc. Fails with bad_file if it contains a
/// name that a record cannot have.
[[nodiscard]] Result<RunInfo> read_run_info(Database& database);

/// Returns the value of a key in the table `meta` as text; empty if the key is missing.
[[nodiscard]] Result<std::string> meta(Database& database, std::string_view key);

[[nodiscard]] Result<void> mark_finished(Database& database);
[[nodiscard]] Result<bool> is_finished(Database& database);

// The application of a calibration to a thermometer's readings. Dates are days of UTC.

/// Returns the calibrated temperature of a reading: reading + offset, or Σ c_i reading^i (both in °C) if the channel
/// has a polynomial.
[[nodiscard]] Celsius calibrated(const Channel& channel, Celsius reading);

/// Parses "2027-03-01". Returns nothing if the day does not exist or is outside 1678 to 2261, the whole years that
/// nanoseconds since 1970 can represent.
[[nodiscard]] std::optional<std::chrono::sys_days> parse_day(std::string_view text);
[[nodiscard]] std::string format_day(std::chrono::sys_days day);

/// Describes the certificate file of a channel: "t1.dcc.xml of Thermo Lab, signed by CN=Thermo Lab: U = 0.02 K (k = 2),
/// -40 to 60 °C, SHA-256 …".
[[nodiscard]] std::string describe_certificate_file(const CertificateFile& file);

/// Describes a calibration: "offset 0.01 K, certificate 2026-0123, due 2027-03-01", or "none".
[[nodiscard]] std::string describe_calibration(const Channel& channel);

/// Returns a line for each channel whose calibration was due before `utc`: "calibration of A (certificate 2026-0123)
/// was due 2027-03-01".
[[nodiscard]] std::vector<std::string> overdue_calibrations(std::span<const Channel> channels, Duration utc);

}  // namespace gyrotherm::record
