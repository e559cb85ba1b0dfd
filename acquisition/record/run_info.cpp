// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/run_info.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <utility>

#include "acquisition/record/decision.hpp"
#include "acquisition/record/row.hpp"
#include "acquisition/record/schema.hpp"
#include "acquisition/record/store.hpp"

namespace gyrotherm::record {

namespace {

constexpr const char* kRate = "rate";
constexpr const char* kPulseCount = "pulse_count";
constexpr const char* kChamberMeasures = "chamber";
constexpr const char* kRigFile = "rig_file";
constexpr const char* kOrderNumber = "order_number";

/// The texts in the table `meta`. The table also has numbers.
constexpr std::array<std::pair<const char*, std::string RunInfo::*>, 12> kTexts{{
    {"id", &RunInfo::id},
    {"program_version", &RunInfo::program_version},
    {"profile_name", &RunInfo::profile_name},
    {"profile_text", &RunInfo::profile_text},
    {"rig_name", &RunInfo::rig_name},
    {"rig_text", &RunInfo::rig_text},
    {kRigFile, &RunInfo::rig_file},
    {"chamber_map_text", &RunInfo::chamber_map_text},
    {"gyro_model", &RunInfo::gyro_model},
    {"gyro_film", &RunInfo::gyro_film},
    {"gyro_model_text", &RunInfo::gyro_model_text},
    {kOrderNumber, &RunInfo::order_number},
}};

/// Returns whether a text has no row in `meta` if it is empty: a virtual rig has no file, and many runs have no order.
bool is_optional(std::string_view key) { return key == kRigFile || key == kOrderNumber; }

/// The optional columns of the table `axis`.
constexpr std::array<std::pair<const char*, std::optional<double> GyroUncertainty::*>, 8> kAxisColumns{{
    {"latitude_deg", &GyroUncertainty::latitude_deg},
    {"azimuth_deg", &GyroUncertainty::azimuth_deg},
    {"elevation_deg", &GyroUncertainty::elevation_deg},
    {"latitude_uncertainty_deg", &GyroUncertainty::latitude_uncertainty_deg},
    {"azimuth_uncertainty_deg", &GyroUncertainty::azimuth_uncertainty_deg},
    {"tilt_uncertainty_deg", &GyroUncertainty::tilt_uncertainty_deg},
    {"scale_factor_uncertainty_ppm", &GyroUncertainty::scale_factor_uncertainty_ppm},
    {"turn_on_repeatability_deg_per_h", &GyroUncertainty::turn_on_repeatability_deg_per_h},
}};

/// The lines of the list `fixture` for an axis. These values are not columns of the table `axis`, because a new column
/// would make older records unreadable.
constexpr std::array<std::pair<const char*, std::optional<double> GyroUncertainty::*>, 5> kFixtureKeys{{
    {"fixture_azimuth_deg", &GyroUncertainty::fixture_azimuth_deg},
    {"fixture_elevation_deg", &GyroUncertainty::fixture_elevation_deg},
    {"elevation_uncertainty_deg", &GyroUncertainty::elevation_uncertainty_deg},
    {"roll_uncertainty_deg", &GyroUncertainty::roll_uncertainty_deg},
    {"direction_uncertainty_deg", &GyroUncertainty::direction_uncertainty_deg},
}};

/// Returns the name of an axis in the list `fixture`: the position of the unit and the position of the axis.
std::string list_key(std::size_t unit, std::size_t axis) { return fmt::format("{}.{}", unit, axis); }

Result<void> write_meta(Database& database, const RunInfo& info) {
  auto insert = database.prepare("INSERT INTO meta(key, value) VALUES(?, ?)");
  if (!insert) return failure(insert.error());
  Result<void> written;
  const auto put = [&](std::string_view key, const auto& value) {
    if (written) written = insert->run(key, value);
  };
  put("schema", kRunSchema);
  for (const auto& [key, text] : kTexts)
    if (!is_optional(key) || !(info.*text).empty()) put(key, info.*text);
  put("simulated", info.virtual_rig);
  put("seed", std::to_string(info.seed));  // text: SQLite integers are signed
  put("days_later", std::to_string(info.days_later));
  put("imported", info.imported);
  put("started_utc_ns", info.started_utc.count());
  return written;
}

std::vector<double> parse_polynomial(std::string_view text) {
  std::vector<double> coefficients;
  const auto* const end = text.data() + text.size();
  for (const auto* at = text.data(); at < end;) {
    double coefficient{};
    const auto [next, error] = std::from_chars(at, end, coefficient);
    if (error != std::errc{}) break;
    coefficients.push_back(coefficient);
    at = next < end ? next + 1 : next;
  }
  return coefficients;
}

/// A row of the table `channel`, in the order of the sample's columns.
struct MeasuredChannel {
  Channel channel;
  const char* measures;
};

std::string column_unit(const ChannelColumn& column, const RunInfo& info) {
  if (is_of_chamber(column.measures)) return column.measures == Measures::humidity ? "%" : "°C";
  const UnitInfo& unit = info.units[column.unit];
  switch (column.measures) {
    case Measures::rotation: {
      const AxisInfo& axis = unit.axes[column.index];
      return axis.kind == GyroKind::pulse_count ? "pulse" : fmt::format("{:g} °/h", axis.scale);
    }
    case Measures::interval: return "ns";
    case Measures::value: return unit.values[column.index].unit;
    case Measures::true_bias: return "°/h";
    case Measures::humidity:
    case Measures::dew_point:
    case Measures::temperature: break;
  }
  return "°C";
}

const std::string& column_instrument(const ChannelColumn& column, const UnitInfo& unit) {
  if (column.measures != Measures::value || unit.values[column.index].instrument.empty()) return unit.instrument;
  return unit.values[column.index].instrument;
}

std::vector<MeasuredChannel> all_channels(const RunInfo& info) {
  std::vector<MeasuredChannel> channels;
  for (const auto& column : columns_before_channels())
    if (*column.unit != '\0')
      channels.push_back({{.name = column.name,
                           .instrument = info.chamber_instrument,
                           .offset = {},
                           .unit = column.unit,
                           .unit_under_test = ""},
                          kChamberMeasures});
  for (const auto& column : channel_columns(info)) {
    if (column.measures == Measures::temperature) {
      channels.push_back({info.thermometers[column.index], name(column.measures)});
      continue;
    }
    if (is_of_chamber(column.measures)) {
      channels.push_back({{.name = column.name,
                           .instrument = info.chamber_instrument,
                           .offset = {},
                           .unit = column_unit(column, info),
                           .unit_under_test = ""},
                          name(column.measures)});
      continue;
    }
    const UnitInfo& unit = info.units[column.unit];
    channels.push_back({{.name = column.name,
                         .instrument = column_instrument(column, unit),
                         .offset = {},
                         .unit = column_unit(column, info),
                         .unit_under_test = unit.name},
                        name(column.measures)});
  }
  return channels;
}

constexpr const char *kNormal = "normal", *kRectangular = "rectangular";

std::string day_or_nothing(const std::optional<std::chrono::sys_days>& day) { return day ? format_day(*day) : ""; }

/// Returns NaN, stored as NULL, for a missing value.
double kelvins_or_nothing(const std::optional<Kelvins>& kelvins) { return kelvins ? kelvins->value : kMissing; }

/// Returns an uncertainty; nothing if the file has none or an impossible value.
std::optional<Kelvins> uncertainty_in(double kelvins) {
  return std::isfinite(kelvins) && kelvins >= 0 ? std::optional(Kelvins{kelvins}) : std::nullopt;
}

Result<void> write_channels(Database& database, const RunInfo& info) {
  auto insert = database.prepare(
      "INSERT INTO channel(position, name, measures, unit, instrument, unit_under_test, offset_k, polynomial,"
      " certificate, due, calibration_uncertainty_k, distribution, drift_k_per_year, calibrated)"
      " VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  if (!insert) return failure(insert.error());
  std::size_t position = 0;
  for (const auto& [channel, measures] : all_channels(info)) {
    const ThermometerUncertainty& known = channel.uncertainty;
    const auto done = insert->run(
        position++, channel.name, measures, channel.unit, channel.instrument, channel.unit_under_test,
        channel.offset.value, fmt::format("{}", fmt::join(channel.polynomial, " ")), channel.certificate,
        day_or_nothing(channel.due), kelvins_or_nothing(known.calibration), known.rectangular ? kRectangular : kNormal,
        kelvins_or_nothing(known.drift_in_a_year), day_or_nothing(known.calibrated));
    if (!done) return done;
  }
  return {};
}

constexpr const char* kInsertSegment =
    "INSERT INTO segment(name, hold, target_c, rate_c_per_min, cycle, prompt, unit_off, unit_turned, position)"
    " VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)";

Result<void> write_segments(Database& database, const std::vector<RunInfo::SegmentInfo>& segments) {
  auto insert = database.prepare(kInsertSegment);
  if (!insert) return failure(insert.error());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const auto& segment = segments[i];
    auto done = insert->run(segment.name, segment.hold, segment.target.value, segment.rate.value, segment.cycle,
                            segment.prompt, segment.unit.off, segment.unit.turned, i);
    if (!done) return done;
  }
  return {};
}

constexpr const char *kCycles = "cycles", *kGradients = "gradients", *kThreePoint = "three_point",
                     *kAnalogueMaps = "analogue_map_texts", *kThermometers = "thermometer_texts",
                     *kSupplies = "supply_texts", *kIdentities = "identities", *kFixture = "fixture",
                     *kVirtualInstruments = "virtual_instruments", *kWarmUp = "warm_up", *kUnusedUnits = "unused_units",
                     *kGoal = "goal", *kAddedBlocks = "added_blocks", *kReleases = "releases",
                     *kCertificateFile = "certificate_file";
/// The values of the list `goal`. `segments` is the number of segments that the description covers.
constexpr const char *kGoalU = "u_deg_per_h", *kMissionName = "mission_name", *kMissionText = "mission_text",
                     *kPriorText = "prior_text", *kDescribedSegments = "segments";

/// The members of a release in the order of the list `releases`, whose `of` is the position of the release.
constexpr std::string ProgramRelease::*kReleaseMembers[] = {
    &ProgramRelease::title,       &ProgramRelease::sha256, &ProgramRelease::revision,  &ProgramRelease::released_by,
    &ProgramRelease::released_at, &ProgramRelease::signer, &ProgramRelease::unreleased};

/// Takes a value of the list `releases`. The values of a release follow each other.
void take_release(RunInfo& info, std::int64_t position, std::string_view value) {
  if (position == 0) info.releases.emplace_back();
  if (info.releases.empty() || position < 0 || position >= std::ssize(kReleaseMembers)) return;
  info.releases.back().*kReleaseMembers[position] = value;
}

/// Parses the numbers that write_lists() stores for a warm-up. Returns nothing for any other text.
std::optional<RunInfo::WarmUpInfo> parse_warm_up(std::string_view text) {
  const auto numbers = parse_polynomial(text);
  if (numbers.size() != 3 || !std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); }))
    return std::nullopt;
  if (!(numbers[1] > numbers[0] && numbers[2] > 0)) return std::nullopt;
  return RunInfo::WarmUpInfo{.at_least = {numbers[0]}, .air = {numbers[1]}, .rate = {numbers[2]}};
}

/// Returns the values of the list of a certificate file, in the order that parse_certificate_file() expects.
std::vector<std::string> certificate_values(const CertificateFile& file) {
  return {file.name, file.sha256, file.issuer, file.signer,
          fmt::format("{} {} {} {}", file.expanded.value, file.coverage_factor, file.lowest.value, file.highest.value)};
}

/// Parses certificate_values(). Returns nothing for other values.
std::optional<CertificateFile> parse_certificate_file(std::span<const std::string> values) {
  if (values.size() != 5) return std::nullopt;
  const auto numbers = parse_polynomial(values[4]);
  if (numbers.size() != 4 || !std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); }))
    return std::nullopt;
  return CertificateFile{.name = values[0],
                         .sha256 = values[1],
                         .issuer = values[2],
                         .signer = values[3],
                         .expanded = {numbers[0]},
                         .coverage_factor = numbers[1],
                         .lowest = {numbers[2]},
                         .highest = {numbers[3]}};
}

/// Returns "key number" for each known value.
std::vector<std::string> fixture_lines(const GyroUncertainty& known) {
  std::vector<std::string> lines;
  for (const auto& [key, number] : kFixtureKeys)
    if (known.*number) lines.push_back(fmt::format("{} {}", key, *(known.*number)));
  return lines;
}

/// Parses a line of fixture_lines(). Ignores any other line.
void take_fixture_line(std::string_view line, GyroUncertainty& known) {
  const auto blank = line.find(' ');
  if (blank == line.npos) return;
  for (const auto& [key, number] : kFixtureKeys) {
    if (line.substr(0, blank) != key) continue;
    double value{};
    const auto read = std::from_chars(line.data() + blank + 1, line.data() + line.size(), value);
    if (read.ec == std::errc{} && std::isfinite(value)) known.*number = value;
  }
}

Result<void> write_lists(Database& database, const RunInfo& info) {
  auto insert = database.prepare("INSERT INTO list(name, of, value, position) VALUES(?, ?, ?, ?)");
  if (!insert) return failure(insert.error());
  Result<void> written;
  const auto put = [&](std::string_view name, std::string_view of, const std::vector<std::string>& values) {
    for (std::size_t i = 0; i < values.size() && written; ++i) written = insert->run(name, of, values[i], i);
  };
  put(kCycles, "", info.cycles);
  put(kAnalogueMaps, "", info.analogue_map_texts);
  put(kThermometers, "", info.thermometer_texts);
  if (const auto& added = info.warm_up)
    put(kWarmUp, "", {fmt::format("{} {} {}", added->at_least.value, added->air.value, added->rate.value)});
  put(kUnusedUnits, "", info.unused_units);
  for (const auto& channel : info.thermometers)
    if (channel.certificate_file) put(kCertificateFile, channel.name, certificate_values(*channel.certificate_file));
  put(kSupplies, "", info.supply_texts);
  if (const auto& goal = info.goal) {
    put(kGoal, kGoalU, {fmt::format("{}", goal->u_deg_per_h)});
    put(kGoal, kMissionName, {goal->mission_name});
    put(kGoal, kMissionText, {goal->mission_text});
    put(kGoal, kPriorText, {goal->prior_text});
    put(kGoal, kDescribedSegments, {std::to_string(info.segments.size())});
    put(kAddedBlocks, "", info.added_blocks);
  }
  for (std::size_t i = 0; i < info.releases.size(); ++i) {
    std::vector<std::string> values;
    for (const auto member : kReleaseMembers) values.push_back(info.releases[i].*member);
    put(kReleases, fmt::format("{:04}", i), values);
  }
  for (const auto& [title, identity] : info.identities) put(kIdentities, title, {identity});
  put(kVirtualInstruments, "", info.virtual_instruments);
  for (const UnitInfo& unit : info.units) {
    put(kGradients, unit.name, unit.gradients);
    put(kThreePoint, unit.name, unit.three_point);
  }
  for (std::size_t i = 0; i < info.units.size(); ++i)
    for (std::size_t axis = 0; axis < info.units[i].axes.size(); ++axis)
      put(kFixture, list_key(i, axis), fixture_lines(info.units[i].axes[axis].uncertainty));
  return written;
}

/// Returns NaN, stored as NULL, for a missing value.
double number_or_nothing(const std::optional<double>& number) { return number.value_or(kMissing); }

std::string axis_columns() {
  std::string columns =
      "unit, position, name, kind, scale, earth_rate_deg_per_h, direction_x, direction_y, direction_z";
  for (const auto& [key, number] : kAxisColumns) columns += fmt::format(", {}", key);
  return columns;
}

Result<void> write_axes(Database& database, const UnitInfo& unit, std::size_t position) {
  std::string placeholders = "?";
  for (std::size_t i = 1; i < 9 + kAxisColumns.size(); ++i) placeholders += ", ?";
  auto insert = database.prepare(fmt::format("INSERT INTO axis({}) VALUES({})", axis_columns(), placeholders));
  if (!insert) return failure(insert.error());
  for (std::size_t i = 0; i < unit.axes.size(); ++i) {
    const AxisInfo& axis = unit.axes[i];
    const auto direction = axis.direction.value_or(std::array{kMissing, kMissing, kMissing});
    const auto uncertainty_at = [&](std::size_t k) {
      return number_or_nothing(axis.uncertainty.*kAxisColumns[k].second);
    };
    auto done = insert->run(position, i, axis.name, axis.kind == GyroKind::rate ? kRate : kPulseCount, axis.scale,
                            axis.earth_rate ? axis.earth_rate->value : kMissing, direction[0], direction[1],
                            direction[2], uncertainty_at(0), uncertainty_at(1), uncertainty_at(2), uncertainty_at(3),
                            uncertainty_at(4), uncertainty_at(5), uncertainty_at(6), uncertainty_at(7));
    if (!done) return done;
  }
  return {};
}

Result<void> write_values(Database& database, const UnitInfo& unit, std::size_t position) {
  auto insert = database.prepare(
      "INSERT INTO unit_value(unit, position, name, unit_of_value, is_temperature) VALUES(?, ?, ?, ?, ?)");
  if (!insert) return failure(insert.error());
  for (std::size_t i = 0; i < unit.values.size(); ++i) {
    const ValueInfo& value = unit.values[i];
    if (auto done = insert->run(position, i, value.name, value.unit, value.is_temperature); !done) return done;
  }
  return {};
}

Result<void> write_units(Database& database, const RunInfo& info) {
  auto insert = database.prepare(
      "INSERT INTO unit(position, name, serial_number, model, instrument, stream_text) VALUES(?, ?, ?, ?, ?, ?)");
  if (!insert) return failure(insert.error());
  for (std::size_t i = 0; i < info.units.size(); ++i) {
    const UnitInfo& unit = info.units[i];
    auto done = insert->run(i, unit.name, unit.serial_number, unit.model, unit.instrument, unit.stream_text)
                    .and_then([&] { return write_axes(database, unit, i); })
                    .and_then([&] { return write_values(database, unit, i); });
    if (!done) return done;
  }
  return {};
}

void take_whole(std::uint64_t& number, std::string_view text) {
  std::from_chars(text.data(), text.data() + text.size(), number);
}

void take(RunInfo& info, std::string_view key, const Statement& row) {
  for (const auto& [name, text] : kTexts)
    if (key == name) info.*text = row.text(1);
  if (key == "simulated") info.virtual_rig = row.integer(1) != 0;
  if (key == "seed") take_whole(info.seed, row.text(1));
  if (key == "days_later") take_whole(info.days_later, row.text(1));
  if (key == "imported") info.imported = row.integer(1) != 0;
  if (key == "started_utc_ns") info.started_utc = Duration(row.integer(1));
}

Result<void> read_channels(Database& database, RunInfo& info) {
  constexpr const char* kChannels =
      "SELECT name, unit, instrument, unit_under_test, offset_k, polynomial, certificate, due,"
      " calibration_uncertainty_k, distribution, drift_k_per_year, calibrated, measures FROM channel ORDER BY position";
  return database.each_row(kChannels, [&](const Statement& row) {
    if (row.text(12) == kChamberMeasures) info.chamber_instrument = row.text(2);
    if (row.text(12) == name(Measures::humidity)) info.has_humidity = true;
    if (row.text(12) == name(Measures::dew_point)) info.has_dew_point = true;
    if (row.text(12) != name(Measures::temperature)) return;
    info.thermometers.push_back({.name = std::string(row.text(0)),
                                 .instrument = std::string(row.text(2)),
                                 .offset = Kelvins{row.real(4)},
                                 .polynomial = parse_polynomial(row.text(5)),
                                 .certificate = std::string(row.text(6)),
                                 .due = parse_day(row.text(7)),
                                 .unit = std::string(row.text(1)),
                                 .unit_under_test = std::string(row.text(3)),
                                 .uncertainty = {.calibration = uncertainty_in(row.real(8)),
                                                 .rectangular = row.text(9) == kRectangular,
                                                 .drift_in_a_year = uncertainty_in(row.real(10)),
                                                 .calibrated = parse_day(row.text(11))}});
  });
}

std::optional<double> real_in(const Statement& row, int column) {
  return !row.null(column) && std::isfinite(row.real(column)) ? std::optional(row.real(column)) : std::nullopt;
}

AxisInfo axis_in(const Statement& row) {
  AxisInfo axis{.name = std::string(row.text(2)),
                .kind = row.text(3) == kRate ? GyroKind::rate : GyroKind::pulse_count,
                .scale = row.real(4)};
  if (const auto rate = real_in(row, 5)) axis.earth_rate = DegreesPerHour{*rate};
  const auto x = real_in(row, 6), y = real_in(row, 7), z = real_in(row, 8);
  if (x && y && z) axis.direction = {*x, *y, *z};
  int column = 9;
  for (const auto& [key, number] : kAxisColumns) axis.uncertainty.*number = real_in(row, column++);
  return axis;
}

/// Reads the units with their axes and values. Fails with bad_file if an axis or a value refers to a missing unit.
Result<void> read_units(Database& database, RunInfo& info) {
  const auto with_unit = [&](const Statement& row, const auto& use) -> Result<void> {
    const auto unit = static_cast<std::uint64_t>(row.integer(0));
    if (unit >= info.units.size())
      return failure(FaultKind::bad_file, database.path(), "a row refers to a unit under test that does not exist");
    use(info.units[unit]);
    return {};
  };
  return database
      .each_row("SELECT name, serial_number, model, instrument, stream_text FROM unit ORDER BY position",
                [&](const Statement& row) {
                  info.units.push_back({.name = std::string(row.text(0)),
                                        .serial_number = std::string(row.text(1)),
                                        .model = std::string(row.text(2)),
                                        .instrument = std::string(row.text(3)),
                                        .stream_text = std::string(row.text(4))});
                })
      .and_then([&] {
        return database.each_row(fmt::format("SELECT {} FROM axis ORDER BY unit, position", axis_columns()),
                                 [&](const Statement& row) {
                                   return with_unit(row, [&](UnitInfo& unit) { unit.axes.push_back(axis_in(row)); });
                                 });
      })
      .and_then([&] {
        return database.each_row(
            "SELECT unit, name, unit_of_value, is_temperature FROM unit_value ORDER BY unit, position",
            [&](const Statement& row) {
              return with_unit(row, [&](UnitInfo& unit) {
                unit.values.push_back({.name = std::string(row.text(1)),
                                       .unit = std::string(row.text(2)),
                                       .is_temperature = row.integer(3) != 0});
              });
            });
      });
}

/// Reads the instrument of each value from the table `channel`, unless the unit's own instrument reads the value.
Result<void> read_instruments_of_values(Database& database, RunInfo& info) {
  const auto sql = fmt::format("SELECT name, instrument FROM channel WHERE measures = '{}'", name(Measures::value));
  return database.each_row(sql, [&](const Statement& row) {
    for (UnitInfo& unit : info.units)
      for (ValueInfo& value : unit.values)
        if (row.text(0) == unit.name + "." + value.name && row.text(1) != unit.instrument)
          value.instrument = row.text(1);
  });
}

Result<void> read_segments(Database& database, RunInfo& info) {
  constexpr const char* kSegments =
      "SELECT name, hold, target_c, rate_c_per_min, cycle, prompt, unit_off, unit_turned FROM segment"
      " ORDER BY position";
  return database.each_row(kSegments, [&](const Statement& row) {
    info.segments.push_back({.name = std::string(row.text(0)),
                             .hold = row.integer(1) != 0,
                             .target = Celsius{row.real(2)},
                             .rate = CelsiusPerMinute{row.real(3)},
                             .cycle = static_cast<int>(row.integer(4)),
                             .prompt = std::string(row.text(5)),
                             .unit = {.off = row.integer(6) != 0, .turned = row.integer(7) != 0}});
  });
}

void take_goal(RunInfo& info, std::string_view key, std::string_view value) {
  if (!info.goal) info.goal = RunInfo::Goal{};
  if (key == kGoalU)
    if (const auto numbers = parse_polynomial(value); numbers.size() == 1) info.goal->u_deg_per_h = numbers.front();
  if (key == kMissionName) info.goal->mission_name = value;
  if (key == kMissionText) info.goal->mission_text = value;
  if (key == kPriorText) info.goal->prior_text = value;
}

/// Appends the blocks of the decisions in this file whose segments the description does not cover.
Result<void> read_added_blocks(Database& database, RunInfo& info) {
  if (!info.goal) return {};
  const auto described = count_described_segments(database);
  if (!described) return failure(described.error());
  return database.each_row(
      fmt::format("SELECT channel FROM event WHERE {} AND segment >= {} ORDER BY id", kIsDecision, *described),
      [&](const Statement& row) {
        if (!has_ended(info)) info.added_blocks.emplace_back(row.text(0));
      });
}

Result<void> read_lists(Database& database, RunInfo& info) {
  std::map<std::string, std::vector<std::string>> certificates;
  const auto read = [&](const Statement& row) {
    const std::string_view list = row.text(0);
    if (list == kCertificateFile) certificates[std::string(row.text(1))].emplace_back(row.text(2));
    if (list == kCycles) info.cycles.emplace_back(row.text(2));
    if (list == kAnalogueMaps) info.analogue_map_texts.emplace_back(row.text(2));
    if (list == kThermometers) info.thermometer_texts.emplace_back(row.text(2));
    if (list == kWarmUp) info.warm_up = parse_warm_up(row.text(2));
    if (list == kUnusedUnits) info.unused_units.emplace_back(row.text(2));
    if (list == kSupplies) info.supply_texts.emplace_back(row.text(2));
    if (list == kGoal) take_goal(info, row.text(1), row.text(2));
    if (list == kReleases) take_release(info, row.integer(3), row.text(2));
    if (list == kAddedBlocks) info.added_blocks.emplace_back(row.text(2));
    if (list == kVirtualInstruments) info.virtual_instruments.emplace_back(row.text(2));
    if (list == kIdentities) info.identities.emplace(row.text(1), row.text(2));
    if (list == kFixture) {
      for (std::size_t i = 0; i < info.units.size(); ++i)
        for (std::size_t axis = 0; axis < info.units[i].axes.size(); ++axis)
          if (row.text(1) == list_key(i, axis)) take_fixture_line(row.text(2), info.units[i].axes[axis].uncertainty);
    }
    const auto unit = std::ranges::find(info.units, row.text(1), &UnitInfo::name);
    if (unit == info.units.end()) return;
    if (list == kGradients) unit->gradients.emplace_back(row.text(2));
    if (list == kThreePoint) unit->three_point.emplace_back(row.text(2));
  };
  const auto done = database.each_row("SELECT name, of, value, position FROM list ORDER BY name, of, position", read);
  for (Channel& channel : info.thermometers)
    channel.certificate_file = parse_certificate_file(certificates[channel.name]);
  return done;
}

}  // namespace

std::string describe(const ProgramRelease& release) {
  if (!release.unreleased.empty()) return fmt::format("{}: UNRELEASED: {}", release.title, release.unreleased);
  return fmt::format("{}: revision {}, released by {} on {}, signed by {}", release.title, release.revision,
                     release.released_by, release.released_at, release.signer);
}

const UnitInfo* find_unit(const RunInfo& info, std::string_view name) {
  const auto found = std::ranges::find(info.units, name, &UnitInfo::name);
  return found == info.units.end() ? nullptr : &*found;
}

bool is_unused(const RunInfo& info, std::string_view unit) {
  return std::ranges::find(info.unused_units, unit) != info.unused_units.end();
}

bool serves(const Channel& thermometer, const UnitInfo& unit) {
  const auto named_in = [&](const std::vector<std::string>& names) {
    return std::ranges::count(names, thermometer.name) > 0;
  };
  return thermometer.unit_under_test.empty() || thermometer.unit_under_test == unit.name || named_in(unit.gradients) ||
         named_in(unit.three_point);
}

std::string axis_label(const UnitInfo& unit, std::size_t axis) {
  return unit.axes.size() < 2 ? unit.name : unit.name + "." + unit.axes[axis].name;
}

bool is_simulated(const RunInfo& info) { return info.virtual_rig || !info.virtual_instruments.empty(); }

std::string describe_simulation(const RunInfo& info) {
  if (info.virtual_rig) return "the instruments were virtual";
  if (info.virtual_instruments.empty()) return {};
  return fmt::format("{}{}", kVirtualInstrumentsText, fmt::join(info.virtual_instruments, ", "));
}

bool has_ended(const RunInfo& info) { return !info.added_blocks.empty() && info.added_blocks.back().empty(); }

void add_block(RunInfo& info, std::size_t first, std::span<const RunInfo::SegmentInfo> segments,
               const std::string& block) {
  if (first < info.segments.size() || (has_ended(info) && block.empty())) return;
  info.segments.insert(info.segments.end(), segments.begin(), segments.end());
  info.added_blocks.push_back(block);
}

Result<void> write_segment(Database& database, std::size_t position, const RunInfo::SegmentInfo& segment) {
  auto insert = database.prepare(kInsertSegment);
  if (!insert) return failure(insert.error());
  return insert->run(segment.name, segment.hold, segment.target.value, segment.rate.value, segment.cycle,
                     segment.prompt, segment.unit.off, segment.unit.turned, position);
}

Result<std::size_t> count_described_segments(Database& database) {
  return database
      .query_integer(fmt::format("SELECT coalesce((SELECT CAST(value AS INTEGER) FROM list WHERE name = '{}' AND of = "
                                 "'{}'), (SELECT count(*) FROM segment))",
                                 kGoal, kDescribedSegments),
                     0)
      .map([](std::int64_t count) { return static_cast<std::size_t>(std::max<std::int64_t>(count, 0)); });
}

Result<void> write_run_info(Database& database, const RunInfo& info) {
  return write_meta(database, info)
      .and_then([&] { return write_channels(database, info); })
      .and_then([&] { return write_segments(database, info.segments); })
      .and_then([&] { return write_units(database, info); })
      .and_then([&] { return write_lists(database, info); });
}

namespace {

/// Replaces the start time by the time of the first sample. The description of a real run is written before the chamber
/// is prepared, and the clock of the run starts after the preparation. The start time in the description is therefore
/// too early.
Result<void> read_start(Database& database, RunInfo& info) {
  if (info.virtual_rig || info.imported) return {};
  const auto started = database.query_integer("SELECT utc_ns - monotonic_ns FROM sample ORDER BY slot LIMIT 1",
                                              info.started_utc.count());
  if (!started) return failure(started.error());
  if (is_possible_time(Duration(*started))) info.started_utc = Duration(*started);
  return {};
}

}  // namespace

Result<RunInfo> read_run_info(Database& database) {
  RunInfo info;
  const auto read =
      database.each_row("SELECT key, value FROM meta", [&](const Statement& row) { take(info, row.text(0), row); })
          .and_then([&] { return read_channels(database, info); })
          .and_then([&] { return read_segments(database, info); })
          .and_then([&] { return read_units(database, info); })
          .and_then([&] { return read_instruments_of_values(database, info); })
          .and_then([&] { return read_lists(database, info); })
          .and_then([&] { return read_added_blocks(database, info); })
          .and_then([&] { return check_channel_names(info); })
          .and_then([&]() -> Result<void> {
            if (is_possible_time(info.started_utc)) return {};
            return failure(FaultKind::bad_file, database.path(), "the run started at an impossible time");
          })
          .and_then([&] { return read_start(database, info); });
  if (!read) return failure(read.error());
  return info;
}

Result<std::string> meta(Database& database, std::string_view key) {
  return database.query_text(fmt::format("SELECT value FROM meta WHERE key = '{}'", key));
}

Result<void> mark_finished(Database& database) {
  return database.execute("INSERT INTO meta(key, value) VALUES('outcome', 'finished')");
}

Result<bool> is_finished(Database& database) {
  return meta(database, "outcome").map([](const std::string& outcome) { return outcome == "finished"; });
}

namespace {

using std::chrono::sys_days;

/// Parses the whole text as a number without a sign.
std::optional<unsigned> digits(std::string_view text) {
  unsigned value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::string describe_correction(const Channel& channel) {
  if (!channel.polynomial.empty()) return fmt::format("polynomial {}", fmt::join(channel.polynomial, ", "));
  return channel.offset == Kelvins{} ? "" : fmt::format("offset {:g} K", channel.offset.value);
}

}  // namespace

Celsius calibrated(const Channel& channel, Celsius reading) {
  if (channel.polynomial.empty()) return reading + channel.offset;
  return {std::accumulate(channel.polynomial.rbegin(), channel.polynomial.rend(), 0.0,
                          [&](double sum, double coefficient) { return sum * reading.value + coefficient; })};
}

std::optional<sys_days> parse_day(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  const auto year = digits(text.substr(0, 4)), month = digits(text.substr(5, 2)), day = digits(text.substr(8));
  if (!year || !month || !day) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(*year)), std::chrono::month(*month),
                                         std::chrono::day(*day)};
  constexpr std::chrono::year kFirstYear{1678}, kLastYear{2261};  // representable as Duration since 1970
  const bool is_representable = date.ok() && date.year() >= kFirstYear && date.year() <= kLastYear;
  return is_representable ? std::optional<sys_days>(date) : std::nullopt;
}

std::string format_day(sys_days day) { return fmt::format("{:%F}", day); }

std::string describe_certificate_file(const CertificateFile& file) {
  return fmt::format("{} of {}, signed by {}: U = {:g} K (k = {:g}), {:g} to {:g} °C, SHA-256 {}", file.name,
                     file.issuer, file.signer, file.expanded.value, file.coverage_factor, file.lowest.value,
                     file.highest.value, file.sha256);
}

std::string describe_calibration(const Channel& channel) {
  auto text = describe_correction(channel);
  const auto add = [&](const std::string& more) { text += (text.empty() ? "" : ", ") + more; };
  if (!channel.certificate.empty()) add("certificate " + channel.certificate);
  if (channel.due) add("due " + format_day(*channel.due));
  return text.empty() ? "none" : text;
}

std::vector<std::string> overdue_calibrations(std::span<const Channel> channels, Duration utc) {
  std::vector<std::string> lines;
  for (const auto& channel : channels) {
    if (!channel.due || utc < Duration(channel.due->time_since_epoch()) + std::chrono::days(1)) continue;
    const auto certificate = channel.certificate.empty() ? "" : fmt::format(" (certificate {})", channel.certificate);
    lines.push_back(fmt::format("calibration of {}{} was due {}", channel.name, certificate, format_day(*channel.due)));
  }
  return lines;
}

}  // namespace gyrotherm::record
