// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/dataset.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acquisition/record/record.hpp"
#include "acquisition/record/run_info.hpp"

namespace gyrotherm::data {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

Eigen::Index rows_of(const record::Record& record) { return static_cast<Eigen::Index>(record.time_s.size()); }

/// A column of the record, or all NaN if a foreign record has none.
Eigen::VectorXd column(const std::vector<double>& values, Eigen::Index rows) {
  if (values.empty()) return Eigen::VectorXd::Constant(rows, kMissing);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), rows);
}

Eigen::VectorXd times_of(const record::Record& record) {
  if (record.info.imported) return column(record.time_s, rows_of(record));
  Eigen::VectorXd seconds(rows_of(record));
  for (Eigen::Index i = 0; i < seconds.size(); ++i) seconds(i) = static_cast<double>(record.slot[i]);
  return seconds;
}

Eigen::MatrixXd calibrated_temperatures(const record::Record& record) {
  const auto& channels = record.info.thermometers;
  Eigen::MatrixXd temperature(rows_of(record), static_cast<Eigen::Index>(channels.size()));
  for (std::size_t c = 0; c < channels.size(); ++c) {
    temperature.col(static_cast<Eigen::Index>(c)) =
        column(record.thermometers_c[c], rows_of(record)).unaryExpr([&](double reading_c) {
          return calibrated(channels[c], {reading_c}).value;
        });
  }
  return temperature;
}

Eigen::VectorXd rotation_deg_per_h(const record::Record& record) {
  const record::GyroInfo& gyro = record.info.gyro;
  const Eigen::VectorXd number = column(record.gyro, rows_of(record));
  if (gyro.kind == record::GyroKind::rate) return gyro.scale * number;
  return gyro.scale * number.array() / column(record.gyro_interval_s, rows_of(record)).array();
}

void place_in_profile(Dataset& dataset, const record::Record& record) {
  const Eigen::Index rows = rows_of(record);
  dataset.segment = Eigen::VectorXi::Constant(rows, -1);
  dataset.cycle = Eigen::VectorXi::Constant(rows, -1);
  const auto segments = static_cast<int>(dataset.segments.size());
  const auto cycles = static_cast<int>(dataset.cycles.size());
  for (std::size_t i = 0; i < record.progress.size(); ++i) {
    const ProfilePosition& at = record.progress[i];
    const auto row = static_cast<Eigen::Index>(i);
    if (at.segment >= 0 && at.segment < segments) dataset.segment(row) = at.segment;
    if (at.cycle >= 0 && at.cycle < cycles) dataset.cycle(row) = at.cycle;
  }
}

/// Until the clock of a segment with a prompt runs, the unit is in people's hands.
void drop_handling(Dataset& dataset, const record::Record& record) {
  for (std::size_t i = 0; i < record.progress.size(); ++i) {
    const auto* segment = segment_at(record, i);
    if (segment == nullptr || segment->prompt.empty() || record.progress[i].in_segment != Duration{}) continue;
    dataset.bias_deg_per_h(static_cast<Eigen::Index>(i)) = kMissing;
  }
}

/// Of the first hold that has a bias; NaN if none has.
double mean_of_first_hold(const Dataset& dataset) {
  int first = -1, count = 0;
  double sum = 0;
  for (Eigen::Index i = 0; i < dataset.segment.size(); ++i) {
    const int segment = dataset.segment(i);
    if (segment < 0 || std::isnan(dataset.bias_deg_per_h(i))) continue;
    if (first < 0 && dataset.segments[static_cast<std::size_t>(segment)].hold) first = segment;
    if (segment != first) continue;
    sum += dataset.bias_deg_per_h(i);
    ++count;
  }
  return count > 0 ? sum / count : kMissing;
}

void remove_earth_rate(Dataset& dataset, const record::Record& record, DegreesPerHour earth_rate) {
  for (Eigen::Index row = 0; row < dataset.bias_deg_per_h.size(); ++row) {
    const auto* segment = segment_at(record, static_cast<std::size_t>(row));
    const bool turned = segment != nullptr && segment->unit.turned;
    dataset.bias_deg_per_h(row) -= turned ? -earth_rate.value : earth_rate.value;
  }
}

void set_zero(Dataset& dataset, const record::Record& record) {
  dataset.bias_zero = "nothing removed";
  if (const auto& earth_rate = record.info.gyro.earth_rate) {
    remove_earth_rate(dataset, record, *earth_rate);
    dataset.bias_zero = "earth rate removed";
    return;
  }
  const auto turned = [](const record::RunInfo::SegmentInfo& segment) { return segment.unit.turned; };
  if (dataset.imported || std::ranges::any_of(dataset.segments, turned)) return;
  if (const double mean = mean_of_first_hold(dataset); !std::isnan(mean)) {
    dataset.bias_deg_per_h.array() -= mean;
    dataset.bias_zero = "mean of the first hold removed";
    dataset.zero_is_its_own = true;
  }
}

/// Errata 3.3: a rig that names no shell has G, the coldest of the block, in its place.
void name_three_points(Dataset& dataset, const record::RunInfo& info) {
  dataset.three_point = info.three_point;
  const auto has = [&](const char* name) { return std::ranges::count(dataset.thermometers, name) > 0; };
  if (!info.three_point.empty() || !has("A") || !has("D") || !has("G")) return;
  dataset.three_point = {"A", "D", "G"};
  dataset.three_point_stand_in = true;
}

}  // namespace

Dataset make_dataset(const record::Record& record, const std::string& path) {
  const record::RunInfo& info = record.info;
  Dataset dataset;
  dataset.run_id = info.id;
  dataset.path = path;
  dataset.simulated = info.simulated;
  dataset.imported = info.imported;
  dataset.profile_name = info.profile_name;
  dataset.gradients = info.gradients;
  dataset.cycles = info.cycles;
  dataset.segments = info.segments;
  dataset.started_utc = info.started_utc;
  dataset.gyro_uncertainty = info.gyro.uncertainty;
  if (info.gyro.earth_rate) dataset.earth_rate_deg_per_h = info.gyro.earth_rate->value;
  for (const record::Channel& channel : info.thermometers) {
    dataset.thermometers.push_back(channel.name);
    dataset.thermometer_uncertainty.push_back(channel.uncertainty);
  }
  if (dataset.gradients.empty()) dataset.gradients = dataset.thermometers;
  name_three_points(dataset, info);
  dataset.time_s = times_of(record);
  dataset.temperature_c = calibrated_temperatures(record);
  dataset.bias_deg_per_h = rotation_deg_per_h(record);
  dataset.true_bias_deg_per_h = column(record.true_bias_deg_per_h, rows_of(record));
  dataset.set_point_c = column(info.imported ? std::vector<double>{} : record.set_point_c, rows_of(record));
  place_in_profile(dataset, record);
  drop_handling(dataset, record);
  set_zero(dataset, record);
  for (const record::Gap& gap : record.gaps) {
    dataset.gaps_s.emplace_back(static_cast<double>(gap.first), static_cast<double>(gap.last + 1));
  }
  return dataset;
}

Result<Dataset> load_dataset(const std::string& path) {
  const Result<record::Record> record = record::read_record(path);
  if (!record) return failure(record.error());
  if (!record->finished) {
    return failure(FaultKind::usage, path, "the run has not finished; \"gyrotherm resume\" ends it");
  }
  return make_dataset(*record, path);
}

std::vector<std::string> programs_of(const std::vector<Dataset>& datasets) {
  std::vector<std::string> programs;
  for (const Dataset& dataset : datasets) programs.push_back(dataset.profile_name);
  return programs;
}

double sample_interval_s(const Dataset& dataset) {
  if (!dataset.imported || dataset.time_s.size() < 2) return 1;
  const Eigen::Index steps = dataset.time_s.size() - 1;
  Eigen::VectorXd step = dataset.time_s.tail(steps) - dataset.time_s.head(steps);
  std::nth_element(step.begin(), step.begin() + steps / 2, step.end());
  return step(steps / 2);
}

}  // namespace gyrotherm::data
