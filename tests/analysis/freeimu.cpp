#include "tests/analysis/freeimu.hpp"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace gyrotherm {
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

}  // namespace gyrotherm
