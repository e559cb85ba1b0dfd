// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/dataset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "acquisition/record/record.hpp"
#include "acquisition/record/run_info.hpp"

namespace gyrotherm::data {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

Eigen::Index row_count(const record::Record& record) { return static_cast<Eigen::Index>(record.time_s.size()); }

/// Returns a column of the record, or all NaN if an imported record does not have it.
Eigen::VectorXd column(const std::vector<double>& values, Eigen::Index rows) {
  if (values.empty()) return Eigen::VectorXd::Constant(rows, kMissing);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), rows);
}

Eigen::VectorXd sample_times(const record::Record& record) {
  if (record.info.imported) return column(record.time_s, row_count(record));
  Eigen::VectorXd seconds(row_count(record));
  for (Eigen::Index i = 0; i < seconds.size(); ++i) seconds(i) = static_cast<double>(record.slot[i]);
  return seconds;
}

/// Selected axis and its location in the record.
struct AxisLocation {
  const record::UnitInfo& unit;
  const record::AxisInfo& axis;
  const record::UnitColumns& columns;
  std::size_t index;  ///< index of the axis
};

/// Returns whether users may refer to an axis by this name: "x", "imu.x", or a column name that ends in "_x", such as
/// "gyro_x".
bool is_called(const AxisChoice& axis, const std::string& name) {
  if (axis.axis == name || qualified_name(axis) == name) return true;
  return !axis.axis.empty() && name.ends_with("_" + axis.axis);
}

/// Finds an axis in the record. choose_axis() has checked that it exists.
AxisLocation locate_axis(const record::Record& record, const AxisChoice& of) {
  const auto& units = record.info.units;
  const auto unit = std::ranges::find(units, of.unit, &record::UnitInfo::name);
  const auto axis = std::ranges::find(unit->axes, of.axis, &record::AxisInfo::name);
  return {*unit, *axis, record.units[static_cast<std::size_t>(unit - units.begin())],
          static_cast<std::size_t>(axis - unit->axes.begin())};
}

bool is_one_of(const std::string& name, const std::vector<std::string>& names) {
  return std::ranges::count(names, name) > 0;
}

/// Returns the uncertainty of a value reported by the unit itself. A constant error of the sensor is a property of the
/// unit and is not included; the drift of the sensor is. A temperature drifts like a thermometer with unknown
/// uncertainty; any other value is assumed to drift by 1 % of its range in this record per year.
record::ThermometerUncertainty own_value_uncertainty(bool is_temperature, const Eigen::VectorXd& values) {
  constexpr double kDriftFractionPerYear = 0.01, kMinDrift = 1e-12;
  record::ThermometerUncertainty known{.calibration = Kelvins{}};
  if (is_temperature) return known;
  std::vector<double> finite;
  for (const double value : values)
    if (std::isfinite(value)) finite.push_back(value);
  const auto [low, high] = std::ranges::minmax_element(finite);
  const double range = finite.empty() ? 0 : *high - *low;
  known.drift_in_a_year = Kelvins{std::max(kMinDrift, kDriftFractionPerYear * range)};
  return known;
}

/// Adds names and columns of all model inputs: the calibrated thermometers and the values of the unit itself.
void add_inputs(Dataset& dataset, const record::Record& record, const AxisLocation& at) {
  const Eigen::Index rows = row_count(record);
  std::vector<Eigen::VectorXd> columns;
  const auto& channels = record.info.thermometers;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (!record::serves(channels[c], at.unit)) continue;
    dataset.thermometers.push_back(channels[c].name);
    dataset.thermometer_uncertainty.push_back(channels[c].uncertainty);
    dataset.input_units.emplace_back("°C");
    columns.push_back(column(record.thermometers_c[c], rows).unaryExpr([&](double reading_c) {
      return calibrated(channels[c], {reading_c}).value;
    }));
  }
  if (dataset.gradients.empty()) dataset.gradients = dataset.thermometers;
  bool has_self = false;
  for (std::size_t i = 0; i < at.unit.values.size(); ++i) {
    const auto& value = at.unit.values[i];
    const bool is_self = value.is_temperature && !std::exchange(has_self, has_self || value.is_temperature);
    dataset.thermometers.push_back(is_self ? std::string(kSelf) : std::string(kAux) + value.name);
    columns.push_back(column(at.columns.values[i], rows));
    dataset.thermometer_uncertainty.push_back(own_value_uncertainty(value.is_temperature, columns.back()));
    dataset.input_units.push_back(value.is_temperature ? "°C" : value.unit);
  }
  dataset.temperature_c.resize(rows, std::ssize(columns));
  for (std::size_t c = 0; c < columns.size(); ++c) dataset.temperature_c.col(static_cast<Eigen::Index>(c)) = columns[c];
}

Eigen::VectorXd rotation_deg_per_h(const record::Record& record, const AxisLocation& at) {
  const Eigen::VectorXd number = column(at.columns.rotation[at.index], row_count(record));
  if (at.axis.kind == record::GyroKind::rate) return at.axis.scale * number;
  return at.axis.scale * number.array() / column(at.columns.interval_s, row_count(record)).array();
}

/// Returns the rate of one pulse per second. Returns 0 if pulses are not counted, which means that the axis returns a
/// rate or an angle with fractions of a pulse.
double step_deg_per_h(const record::Record& record, const AxisLocation& at) {
  if (at.axis.kind != record::GyroKind::pulse_count) return 0;
  const auto is_count = [](double number) { return !std::isfinite(number) || std::floor(number) == number; };
  const Eigen::VectorXd numbers = column(at.columns.rotation[at.index], row_count(record));
  return std::ranges::all_of(numbers, is_count) ? std::abs(at.axis.scale) : 0;
}

void assign_segments(Dataset& dataset, const record::Record& record) {
  const Eigen::Index rows = row_count(record);
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

/// Removes the bias while an operator was handling the unit.
void remove_handling(Dataset& dataset, const record::Record& record) {
  for (Eigen::Index row = 0; row < dataset.bias_deg_per_h.size(); ++row)
    if (std::isnan(turned_at(record, static_cast<std::size_t>(row)))) dataset.bias_deg_per_h(row) = kMissing;
}

/// Removes bias, set point and position in the profile from the rows in which the chamber was away from the profile.
void remove_rows_away(Dataset& dataset, const record::Record& record) {
  const auto away = record::find_rows_away(record);
  const auto rows = std::min(away.size(), static_cast<std::size_t>(dataset.segment.size()));
  for (std::size_t i = 0; i < rows; ++i) {
    if (!away[i]) continue;
    const auto row = static_cast<Eigen::Index>(i);
    dataset.bias_deg_per_h(row) = dataset.set_point_c(row) = kMissing;
    dataset.segment(row) = dataset.cycle(row) = -1;
  }
}

/// Computes the mean of the first hold that has a bias. Returns NaN if none has.
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
    const bool turned = turned_at(record, static_cast<std::size_t>(row)) > 0;
    dataset.bias_deg_per_h(row) -= turned ? -earth_rate.value : earth_rate.value;
  }
}

void set_reference(Dataset& dataset, const record::Record& record, const std::optional<DegreesPerHour>& earth_rate) {
  dataset.bias_zero = kNothingRemoved;
  if (earth_rate && !(dataset.imported && earth_rate->value == 0)) {
    remove_earth_rate(dataset, record, *earth_rate);
    dataset.bias_zero = "earth rate removed";
    return;
  }
  if (dataset.imported || jumps_by_turning(dataset)) return;
  if (const double mean = mean_of_first_hold(dataset); !std::isnan(mean)) {
    dataset.bias_deg_per_h.array() -= mean;
    dataset.bias_zero = kOwnReference;
    dataset.has_own_reference = true;
  }
}

/// Sets the three thermometers of the traditional method. If the rig names no shell, G, the coldest thermometer of the
/// block, is used instead (errata 3.3).
void name_three_points(Dataset& dataset, const record::UnitInfo& unit) {
  dataset.three_point = unit.three_point;
  const auto has = [&](const char* name) { return is_one_of(name, dataset.thermometers); };
  if (!unit.three_point.empty() || !has("A") || !has("D") || !has("G")) return;
  dataset.three_point = {"A", "D", "G"};
  dataset.three_point_stand_in = true;
}

std::string make_identity(const record::RunInfo& info, const record::UnitInfo& unit) {
  if (!info.virtual_rig) return unit.serial_number;
  const bool is_one_of_several = info.units.size() > 1;
  const std::string name = unit.serial_number.empty() && is_one_of_several ? unit.name : unit.serial_number;
  return fmt::format("{}{}seed {}", name, name.empty() ? "" : ", ", info.seed);
}

/// Lists the notes of an import that begin with "warning: ", without this beginning.
std::vector<std::string> find_import_warnings(const record::Record& record) {
  constexpr std::string_view kWarning = "warning: ";
  std::vector<std::string> warnings;
  for (const record::RecordedEvent& recorded : record.events)
    if (recorded.event.kind == EventKind::note && recorded.event.text.starts_with(kWarning))
      warnings.push_back(recorded.event.text.substr(kWarning.size()));
  return warnings;
}

std::string join_names(const std::vector<AxisChoice>& axes) {
  std::string names;
  for (const AxisChoice& axis : axes) names += (names.empty() ? "" : ", ") + qualified_name(axis);
  return names;
}

}  // namespace

std::string qualified_name(const AxisChoice& choice) {
  return choice.axis.empty() ? choice.unit : choice.unit + "." + choice.axis;
}

bool is_earth_rate_removed(const Dataset& dataset) {
  return dataset.earth_rate_deg_per_h && dataset.bias_zero != kNothingRemoved;
}

bool is_own_value(std::string_view input) { return input == kSelf || input.starts_with(kAux); }
std::vector<std::string> block_thermometers(const Dataset& dataset) {
  std::vector<std::string> all = dataset.gradients;
  if (all.empty()) std::ranges::copy_if(dataset.thermometers, std::back_inserter(all), is_temperature);
  if (dataset.three_point.empty() || dataset.three_point_stand_in) return all;
  const auto last_name = [](const std::string& name) { return name.substr(name.rfind('.') + 1); };
  const std::string shell = last_name(dataset.three_point.back());
  std::vector<std::string> block;
  std::ranges::copy_if(all, std::back_inserter(block),
                       [&](const std::string& name) { return last_name(name) != shell; });
  return block.empty() ? all : block;
}

bool is_temperature(std::string_view input) { return !input.starts_with(kAux); }

std::optional<int> find_stopped_segment(const record::Record& record) {
  if (record.info.imported || record.state.empty() || !has_left_profile(record.state.back())) return std::nullopt;
  for (auto at = record.progress.rbegin(); at != record.progress.rend(); ++at)
    if (at->segment >= 0) return at->segment;
  return 0;
}

Dataset make_dataset(const record::Record& record, const std::string& path, const AxisChoice& of) {
  const record::RunInfo& info = record.info;
  const AxisLocation at = locate_axis(record, of);
  Dataset dataset;
  dataset.run_id = info.id;
  dataset.path = path;
  dataset.of = of;
  dataset.identity = make_identity(info, at.unit);
  dataset.simulated = record::is_simulated(info);
  for (const record::ProgramRelease& release : info.releases)
    if (!release.unreleased.empty()) dataset.unreleased.push_back(release.title);
  dataset.imported = info.imported;
  if (info.imported) dataset.import_warnings = find_import_warnings(record);
  dataset.profile_name = info.profile_name;
  dataset.gradients = at.unit.gradients;
  dataset.cycles = info.cycles;
  dataset.segments = info.segments;
  dataset.started_utc = info.started_utc;
  dataset.gyro_uncertainty = at.axis.uncertainty;
  dataset.direction = at.axis.direction;
  dataset.step_deg_per_h = step_deg_per_h(record, at);
  if (at.axis.earth_rate) dataset.earth_rate_deg_per_h = at.axis.earth_rate->value;
  add_inputs(dataset, record, at);
  name_three_points(dataset, at.unit);
  dataset.time_s = sample_times(record);
  dataset.moment_s = column(record.time_s, row_count(record));
  dataset.bias_deg_per_h = rotation_deg_per_h(record, at);
  dataset.true_bias_deg_per_h = column(at.columns.true_bias_deg_per_h[at.index], row_count(record));
  dataset.set_point_c = column(info.imported ? std::vector<double>{} : record.set_point_c, row_count(record));
  assign_segments(dataset, record);
  remove_handling(dataset, record);
  remove_rows_away(dataset, record);
  dataset.stopped_in = find_stopped_segment(record);
  set_reference(dataset, record, at.axis.earth_rate);
  for (const record::Gap& gap : record.gaps) {
    dataset.gaps_s.emplace_back(static_cast<double>(gap.first), static_cast<double>(gap.last + 1));
  }
  return dataset;
}

std::vector<AxisChoice> list_axes(const record::RunInfo& info) {
  std::vector<AxisChoice> axes;
  for (const auto& unit : info.units)
    for (const auto& axis : unit.axes)
      if (!is_unused(info, unit.name)) axes.push_back({unit.name, axis.name});
  return axes;
}

namespace {

/// Returns "axis x of unit u1", or only the part that was requested.
std::string describe_request(const AxisChoice& requested) {
  const std::string unit = fmt::format("unit \"{}\"", requested.unit);
  if (requested.axis.empty()) return unit;
  return fmt::format("axis \"{}\"{}", requested.axis, requested.unit.empty() ? "" : " of a " + unit);
}

}  // namespace

Result<AxisChoice> choose_axis(const record::RunInfo& info, const AxisChoice& requested, const std::string& path) {
  std::vector<AxisChoice> found = list_axes(info);
  const std::string all = join_names(found);
  const bool is_exact = std::ranges::any_of(found, [&](const AxisChoice& axis) { return axis.axis == requested.axis; });
  std::erase_if(found, [&](const AxisChoice& axis) {
    const bool is_axis =
        requested.axis.empty() || (is_exact ? axis.axis == requested.axis : is_called(axis, requested.axis));
    return (!requested.unit.empty() && axis.unit != requested.unit) || !is_axis;
  });
  if (found.size() == 1) return found.front();
  if (found.empty())
    return failure(FaultKind::usage, path, fmt::format("has no {}; it has {}", describe_request(requested), all));
  return failure(FaultKind::usage, path,
                 fmt::format("has {} axes, {}: choose one with --unit and --axis", found.size(), join_names(found)));
}

Result<Dataset> load_dataset(const record::RecordFiles& files, const AxisChoice& requested) {
  const Result<record::Record> record = record::read_record(files);
  if (!record) return failure(record.error());
  if (!record->finished) {
    return failure(FaultKind::usage, files.path, "the run has not finished; \"gyrotherm resume\" ends it");
  }
  return choose_axis(record->info, requested, files.path).map([&](const AxisChoice& of) {
    return make_dataset(*record, files.path, of);
  });
}

Result<Dataset> load_dataset(const std::string& path, const AxisChoice& requested) {
  return record::find_files_to_read(path).and_then(
      [&](const record::RecordFiles& files) { return load_dataset(files, requested); });
}

bool jumps_by_turning(const Dataset& dataset) {
  const auto turned = [](const record::RunInfo::SegmentInfo& segment) { return segment.unit.turned; };
  return !dataset.earth_rate_deg_per_h && std::ranges::any_of(dataset.segments, turned);
}

std::vector<std::string> list_programs(const std::vector<Dataset>& datasets) {
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

Result<void> check_same_gyro(const Dataset& one, const Dataset& other, std::string_view called,
                             std::string_view consequence) {
  if (may_be_same_gyro(one.identity, other.identity)) return {};
  return failure(FaultKind::usage, one.path,
                 fmt::format("belongs to a different gyro ({}) than {} ({}){}", one.identity, called, other.identity,
                             consequence));
}

Result<void> check_same_reference(const Dataset& one, std::string_view other_zero, std::string_view called) {
  if (have_same_zero(one.bias_zero, other_zero)) return {};
  if (one.bias_zero == other_zero)
    return failure(
        FaultKind::usage, one.path,
        fmt::format("its bias reference is its own mean ({}), as in {}: the offset between the two references is "
                    "unknown. Train on one of them, or add the latitude to the rig file",
                    one.bias_zero, called));
  return failure(FaultKind::usage, one.path,
                 fmt::format("different bias reference ({}) than {} ({}): a model of both would contain the difference",
                             one.bias_zero, called, other_zero));
}

}  // namespace gyrotherm::data
