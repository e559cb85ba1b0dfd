// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/log_guess.hpp"

#include <algorithm>
#include <array>

#include "acquisition/exchange/column_names.hpp"

namespace gyrotherm::exchange {

namespace {

/// The messages of a log that have raw rates, the best first; a digit behind the name numbers the sensors of old logs.
constexpr std::array<std::string_view, 4> kMessages{"sensor_gyro", "sensor_combined", "IMU", "GYR"};

/// The fields that are a rate, axis by axis.
constexpr std::array<std::array<std::string_view, 3>, 3> kAxes{
    {{"x", "y", "z"}, {"gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]"}, {"GyrX", "GyrY", "GyrZ"}}};

std::string full_name(const LogColumn& column) {
  return name_of_series(column.message, column.instance) + "." + column.field;
}

bool is_of(const LogColumn& column, std::string_view message) {
  if (!std::string_view(column.message).starts_with(message)) return false;
  const auto behind = std::string_view(column.message).substr(message.size());
  return behind.find_first_not_of("0123456789") == std::string_view::npos;
}

std::string series_of(const LogColumn& column) { return name_of_series(column.message, column.instance); }

/// The rates of one series.
LoggedGyro gyro_in(const std::vector<LogColumn>& columns, const std::string& series) {
  LoggedGyro gyro;
  for (const auto& axes : kAxes)
    for (const std::string_view axis : axes)
      for (const LogColumn& column : columns)
        if (series_of(column) == series && column.field == axis) gyro.axes.push_back(full_name(column));
  for (const LogColumn& column : columns)
    if (series_of(column) == series && (column.field == "temperature" || column.field == "T"))
      gyro.temperature = full_name(column);
  return gyro;
}

std::vector<LoggedGyro> gyros_of(const std::vector<LogColumn>& columns, std::string_view message) {
  std::vector<LoggedGyro> gyros;
  std::vector<std::string> seen;
  for (const LogColumn& column : columns) {
    const auto series = series_of(column);
    if (!is_of(column, message) || std::ranges::find(seen, series) != seen.end()) continue;
    seen.push_back(series);
    auto gyro = gyro_in(columns, series);
    if (gyro.axes.empty()) continue;
    gyro.name = gyros.empty() ? "imu" : "imu" + std::to_string(gyros.size());
    gyros.push_back(std::move(gyro));
  }
  return gyros;
}

/// The first message whose names sound like a gyro's.
std::vector<LoggedGyro> gyros_by_name(const std::vector<LogColumn>& columns) {
  std::vector<std::string> names;
  for (const LogColumn& column : columns) names.push_back(full_name(column));
  LoggedGyro gyro{.name = "imu"};
  for (const std::size_t column : gyro_columns(names)) {
    gyro.axes.push_back(names[column]);
    for (const LogColumn& other : columns)
      if (series_of(other) == series_of(columns[column]) && is_temperature_name(other.field))
        gyro.temperature = full_name(other);
  }
  return gyro.axes.empty() ? std::vector<LoggedGyro>{} : std::vector{gyro};
}

}  // namespace

LogGuess guess_log(const std::vector<LogColumn>& published) {
  LogGuess guess;
  for (const std::string_view message : kMessages)
    if (guess.gyros.empty()) guess.gyros = gyros_of(published, message);
  if (guess.gyros.empty()) guess.gyros = gyros_by_name(published);
  for (const LogColumn& column : published) {
    const bool is_barometer = column.message == "sensor_baro" || is_of(column, "BARO");
    if (is_barometer && (column.field == "temperature" || column.field == "Temp"))
      guess.others.push_back(full_name(column));
  }
  return guess;
}

}  // namespace gyrotherm::exchange
