// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/run_info.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "acquisition/record/row.hpp"
#include "acquisition/record/schema.hpp"
#include "acquisition/record/store.hpp"

namespace gyrotherm::record {

namespace {

constexpr const char* kRate = "rate";
constexpr const char* kPulseCount = "pulse_count";

/// The texts of the table `meta`, beside which it has numbers.
constexpr std::array<std::pair<const char*, std::string RunInfo::*>, 11> kTexts{{
    {"id", &RunInfo::id},
    {"program_version", &RunInfo::program_version},
    {"profile_name", &RunInfo::profile_name},
    {"profile_text", &RunInfo::profile_text},
    {"rig_name", &RunInfo::rig_name},
    {"rig_text", &RunInfo::rig_text},
    {"chamber_map_text", &RunInfo::chamber_map_text},
    {"gyro_stream_text", &RunInfo::gyro_stream_text},
    {"gyro_model", &RunInfo::gyro_model},
    {"gyro_film", &RunInfo::gyro_film},
    {"gyro_model_text", &RunInfo::gyro_model_text},
}};

/// What `meta` may say of the gyro's pose and uncertainty, beside its texts.
constexpr std::array<std::pair<const char*, std::optional<double> GyroUncertainty::*>, 8> kOfTheGyro{{
    {"latitude_deg", &GyroUncertainty::latitude_deg},
    {"azimuth_deg", &GyroUncertainty::azimuth_deg},
    {"elevation_deg", &GyroUncertainty::elevation_deg},
    {"latitude_uncertainty_deg", &GyroUncertainty::latitude_uncertainty_deg},
    {"azimuth_uncertainty_deg", &GyroUncertainty::azimuth_uncertainty_deg},
    {"tilt_uncertainty_deg", &GyroUncertainty::tilt_uncertainty_deg},
    {"scale_factor_uncertainty_ppm", &GyroUncertainty::scale_factor_uncertainty_ppm},
    {"turn_on_repeatability_deg_per_h", &GyroUncertainty::turn_on_repeatability_deg_per_h},
}};

Result<void> write_meta(Database& database, const RunInfo& info) {
  auto insert = database.prepare("INSERT INTO meta(key, value) VALUES(?, ?)");
  if (!insert) return failure(insert.error());
  Result<void> written;
  const auto put = [&](std::string_view key, const auto& value) {
    if (written) written = insert->run(key, value);
  };
  put("schema", kRunSchema);
  for (const auto& [key, text] : kTexts) put(key, info.*text);
  put("simulated", info.simulated);
  put("seed", std::to_string(info.seed));  // a text: SQLite's integers are signed
  put("days_later", std::to_string(info.days_later));
  put("imported", info.imported);
  put("started_utc_ns", info.started_utc.count());
  put("gyro_kind", info.gyro.kind == GyroKind::rate ? kRate : kPulseCount);
  put("gyro_scale", info.gyro.scale);
  if (info.gyro.earth_rate) put("earth_rate_deg_per_h", info.gyro.earth_rate->value);
  for (const auto& [key, number] : kOfTheGyro)
    if (const auto& value = info.gyro.uncertainty.*number) put(key, *value);
  return written;
}

std::vector<double> polynomial_of(std::string_view text) {
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

/// What is measured once a second, in the order of the sample's columns.
std::vector<Channel> all_channels(const RunInfo& info) {
  std::vector<Channel> channels;
  const auto add = [&](std::span<const Column<SampleRow>> columns) {
    for (const auto& column : columns) {
      const bool is_gyro = column.measured_by == MeasuredBy::gyro;
      if (column.measured_by == MeasuredBy::nobody) continue;
      channels.push_back({.name = column.name,
                          .instrument = is_gyro ? info.gyro.instrument : info.chamber_instrument,
                          .offset = {},
                          .unit = column.unit,
                          .unit_under_test = is_gyro ? kOnlyUnit : ""});
      if (channels.back().unit.empty())
        channels.back().unit =
            info.gyro.kind == GyroKind::pulse_count ? "pulse" : fmt::format("{:g} °/h", info.gyro.scale);
    }
  };
  add(columns_before_thermometers());
  channels.insert(channels.end(), info.thermometers.begin(), info.thermometers.end());
  add(columns_after_thermometers());
  return channels;
}

constexpr const char *kNormal = "normal", *kRectangular = "rectangular";

std::string day_or_nothing(const std::optional<std::chrono::sys_days>& day) { return day ? format_day(*day) : ""; }

/// NaN is NULL in the file.
double kelvins_or_nothing(const std::optional<Kelvins>& kelvins) {
  return kelvins ? kelvins->value : std::numeric_limits<double>::quiet_NaN();
}

/// Nothing where the file has none, or a number that no uncertainty can be.
std::optional<Kelvins> uncertainty_in(double kelvins) {
  return std::isfinite(kelvins) && kelvins >= 0 ? std::optional(Kelvins{kelvins}) : std::nullopt;
}

Result<void> write_channels(Database& database, const RunInfo& info) {
  auto insert = database.prepare(
      "INSERT INTO channel(position, name, unit, instrument, unit_under_test, offset_k, polynomial, certificate, due,"
      " calibration_uncertainty_k, distribution, drift_k_per_year, calibrated)"
      " VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  if (!insert) return failure(insert.error());
  std::size_t position = 0;
  for (const Channel& channel : all_channels(info)) {
    const ThermometerUncertainty& known = channel.uncertainty;
    const auto done = insert->run(position++, channel.name, channel.unit, channel.instrument, channel.unit_under_test,
                                  channel.offset.value, fmt::format("{}", fmt::join(channel.polynomial, " ")),
                                  channel.certificate, day_or_nothing(channel.due),
                                  kelvins_or_nothing(known.calibration), known.rectangular ? kRectangular : kNormal,
                                  kelvins_or_nothing(known.drift_in_a_year), day_or_nothing(known.calibrated));
    if (!done) return done;
  }
  return {};
}

Result<void> write_segments(Database& database, const std::vector<RunInfo::SegmentInfo>& segments) {
  auto insert = database.prepare(
      "INSERT INTO segment(name, hold, target_c, rate_c_per_min, cycle, prompt, unit_off, unit_turned, position)"
      " VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)");
  if (!insert) return failure(insert.error());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const auto& segment = segments[i];
    auto done = insert->run(segment.name, segment.hold, segment.target.value, segment.rate.value, segment.cycle,
                            segment.prompt, segment.unit.off, segment.unit.turned, i);
    if (!done) return done;
  }
  return {};
}

Result<void> write_list(Database& database, std::string_view name, const std::vector<std::string>& values) {
  auto insert = database.prepare("INSERT INTO list(name, value, position) VALUES(?, ?, ?)");
  if (!insert) return failure(insert.error());
  for (std::size_t i = 0; i < values.size(); ++i)
    if (auto done = insert->run(name, values[i], i); !done) return done;
  return {};
}

void take_whole(std::uint64_t& number, std::string_view text) {
  std::from_chars(text.data(), text.data() + text.size(), number);
}

void take(RunInfo& info, std::string_view key, const Statement& row) {
  for (const auto& [name, text] : kTexts)
    if (key == name) info.*text = row.text(1);
  for (const auto& [name, number] : kOfTheGyro)
    if (key == name && std::isfinite(row.real(1))) info.gyro.uncertainty.*number = row.real(1);
  if (key == "simulated") info.simulated = row.integer(1) != 0;
  if (key == "seed") take_whole(info.seed, row.text(1));
  if (key == "days_later") take_whole(info.days_later, row.text(1));
  if (key == "imported") info.imported = row.integer(1) != 0;
  if (key == "started_utc_ns") info.started_utc = Duration(row.integer(1));
  if (key == "gyro_kind") info.gyro.kind = row.text(1) == kRate ? GyroKind::rate : GyroKind::pulse_count;
  if (key == "gyro_scale") info.gyro.scale = row.real(1);
  if (key == "earth_rate_deg_per_h") info.gyro.earth_rate = DegreesPerHour{row.real(1)};
}

Result<void> read_channels(Database& database, RunInfo& info) {
  constexpr const char* kChannels =
      "SELECT name, unit, instrument, unit_under_test, offset_k, polynomial, certificate, due,"
      " calibration_uncertainty_k, distribution, drift_k_per_year, calibrated FROM channel ORDER BY position";
  return database.each_row(kChannels, [&](const Statement& row) {
    if (is_own_column(row.text(0))) {
      const bool is_gyro = !row.text(3).empty();
      (is_gyro ? info.gyro.instrument : info.chamber_instrument) = row.text(2);
      return;
    }
    info.thermometers.push_back({.name = std::string(row.text(0)),
                                 .instrument = std::string(row.text(2)),
                                 .offset = Kelvins{row.real(4)},
                                 .polynomial = polynomial_of(row.text(5)),
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

Result<void> read_lists(Database& database, RunInfo& info) {
  return database.each_row("SELECT name, value FROM list ORDER BY name, position", [&](const Statement& row) {
    const std::string_view list = row.text(0);
    if (list == "cycles") info.cycles.emplace_back(row.text(1));
    if (list == "gradients") info.gradients.emplace_back(row.text(1));
    if (list == "three_point") info.three_point.emplace_back(row.text(1));
  });
}

}  // namespace

Result<void> write_run_info(Database& database, const RunInfo& info) {
  return write_meta(database, info)
      .and_then([&] { return write_channels(database, info); })
      .and_then([&] { return write_segments(database, info.segments); })
      .and_then([&] { return write_list(database, "cycles", info.cycles); })
      .and_then([&] { return write_list(database, "gradients", info.gradients); })
      .and_then([&] { return write_list(database, "three_point", info.three_point); });
}

Result<RunInfo> read_run_info(Database& database) {
  RunInfo info;
  const auto read =
      database.each_row("SELECT key, value FROM meta", [&](const Statement& row) { take(info, row.text(0), row); })
          .and_then([&] { return read_channels(database, info); })
          .and_then([&] { return read_segments(database, info); })
          .and_then([&] { return read_lists(database, info); })
          .and_then([&] { return check_channel_names(info.thermometers); })
          .and_then([&]() -> Result<void> {
            if (is_possible_time(info.started_utc)) return {};
            return failure(FaultKind::bad_file, database.path(), "the run started at an impossible time");
          });
  if (!read) return failure(read.error());
  return info;
}

Result<std::string> meta(Database& database, std::string_view key) {
  return database.ask(fmt::format("SELECT value FROM meta WHERE key = '{}'", key));
}

Result<void> mark_finished(Database& database) {
  return database.execute("INSERT INTO meta(key, value) VALUES('outcome', 'finished')");
}

Result<bool> is_finished(Database& database) {
  return meta(database, "outcome").map([](const std::string& outcome) { return outcome == "finished"; });
}

namespace {

using std::chrono::sys_days;

/// All of `text` as a number without a sign.
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
  return date.ok() ? std::optional<sys_days>(date) : std::nullopt;
}

std::string format_day(sys_days day) { return fmt::format("{:%F}", day); }

std::string describe_calibration(const Channel& channel) {
  auto words = describe_correction(channel);
  const auto add = [&](const std::string& more) { words += (words.empty() ? "" : ", ") + more; };
  if (!channel.certificate.empty()) add("certificate " + channel.certificate);
  if (channel.due) add("due " + format_day(*channel.due));
  return words.empty() ? "none" : words;
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
