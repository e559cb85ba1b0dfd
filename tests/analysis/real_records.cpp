// SPDX-License-Identifier: Apache-2.0
#include "tests/analysis/real_records.hpp"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

namespace gyrotherm::data {
namespace {

constexpr int kFields = 13;
constexpr int kFirstGyro = 3, kDie = 9, kBarometer = 10, kTime = 12;
constexpr double kDegPerHourPerCount = 3600 / 16.4;

std::vector<double> numbers_of(const std::string& line) {
  std::vector<double> numbers;
  const char* at = line.c_str();
  while (*at != '\0') {
    char* end = nullptr;
    numbers.push_back(std::strtod(at, &end));
    if (end == at) break;
    at = *end == ',' ? end + 1 : end;
  }
  return numbers;
}

constexpr Eigen::Index kRowsPerCluster = 20;
constexpr int kTofuFirstGyro = 1, kTemperature = 8, kTofuFields = 9;
constexpr double kDegPerHourPerRadPerSecond = 3600 * 180 / std::numbers::pi;

/// Temperature and rotation of one row.
struct Row {
  double temperature_c{}, rate_rad_per_s{};
};

std::vector<Row> rows_of(std::istream& file, int axis) {
  std::vector<Row> rows;
  std::string line;
  std::getline(file, line);  // header line
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    double value[kTofuFields];
    for (double& field : value) fields >> field;
    rows.push_back({value[kTemperature], value[kTofuFirstGyro + axis]});
  }
  return rows;
}

}  // namespace

std::optional<Dataset> load_freeimu(FreeImuAxis axis) {
  const char* shared = std::getenv("GYROTHERM_SHARED");
  if (shared == nullptr) return std::nullopt;
  std::ifstream file(std::string(shared) + "/data/freeimu_Tempdata01-02-14.csv");
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  std::vector<std::vector<double>> rows;
  while (std::getline(file, line)) {
    if (auto row = numbers_of(line); row.size() == kFields) rows.push_back(std::move(row));
  }
  Dataset dataset;
  dataset.path = "freeimu";
  dataset.run_id = "freeimu";
  dataset.imported = true;
  dataset.thermometers = {"die", "barometer"};
  dataset.gradients = dataset.thermometers;
  const auto count = static_cast<Eigen::Index>(rows.size());
  dataset.time_s.resize(count);
  dataset.temperature_c.resize(count, 2);
  dataset.bias_deg_per_h.resize(count);
  dataset.set_point_c.setConstant(count, std::nan(""));
  dataset.segment.setConstant(count, -1);
  dataset.cycle.setConstant(count, -1);
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::vector<double>& row = rows[i];
    dataset.time_s(i) = (row[kTime] - rows[0][kTime]) / 1000;
    dataset.temperature_c(i, 0) = row[kDie] / 340 + 36.53;
    dataset.temperature_c(i, 1) = row[kBarometer];
    dataset.bias_deg_per_h(i) = row[kFirstGyro + static_cast<int>(axis)] * kDegPerHourPerCount;
  }
  return dataset;
}

std::optional<Clusters> load_tofupilot(int axis) {
  const char* shared = std::getenv("GYROTHERM_SHARED");
  if (shared == nullptr) return std::nullopt;
  std::ifstream file(std::string(shared) + "/data/tofupilot_imu_raw_data.csv");
  const std::vector<Row> rows = rows_of(file, axis);
  const Eigen::Index count = static_cast<Eigen::Index>(rows.size()) / kRowsPerCluster;
  if (count < 2) return std::nullopt;
  Clusters clusters;
  clusters.thermometers = {"T", "dT"};
  clusters.start_s = Eigen::VectorXd::LinSpaced(count, 0, clusters.length_s * static_cast<double>(count - 1));
  clusters.temperature_c.setZero(count, 2);
  clusters.rate_c_per_min.setZero(count, 2);
  clusters.bias_deg_per_h.setZero(count);
  clusters.set_point_c.setZero(count);
  clusters.segment.setConstant(count, -1);
  clusters.last_segment.setConstant(count, -1);
  clusters.cycle.setConstant(count, -1);
  clusters.samples.setConstant(count, kRowsPerCluster);
  for (Eigen::Index k = 0; k < count * kRowsPerCluster; ++k) {
    clusters.temperature_c(k / kRowsPerCluster, 0) += rows[k].temperature_c / kRowsPerCluster;
    clusters.bias_deg_per_h(k / kRowsPerCluster) +=
        rows[k].rate_rad_per_s * kDegPerHourPerRadPerSecond / kRowsPerCluster;
  }
  const auto t = clusters.temperature_c.col(0);
  auto derivative = clusters.temperature_c.col(1);
  derivative(0) = t(1) - t(0);
  derivative(count - 1) = t(count - 1) - t(count - 2);
  derivative.segment(1, count - 2) = (t.tail(count - 2) - t.head(count - 2)) / 2;
  return clusters;
}

}  // namespace gyrotherm::data
