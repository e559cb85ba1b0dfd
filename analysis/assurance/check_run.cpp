// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/check_run.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace gyrotherm::assurance {
namespace {

constexpr double kMeanSeconds = 100;
constexpr auto kMeans = static_cast<Eigen::Index>(kPlateauSeconds / kMeanSeconds);
/// Degree of the polynomial through the means of a plateau, which represents the slow approach to equilibrium.
constexpr Eigen::Index kPolynomialDegree = 3;
constexpr double kResidualDegrees = static_cast<double>(kMeans - kPolynomialDegree - 1);
/// Share of the seconds of each mean that must have a reading.
constexpr double kFewestReadings = 0.9;

/// The last 30 min of a hold.
struct Plateau {
  std::string label;
  double at_c{};
  bool turned{};
  double from_s{};
};

double end_of_segment(const data::Dataset& run, int segment) {
  double end = -1;
  for (Eigen::Index row = 0; row < run.segment.size(); ++row)
    if (run.segment(row) == segment) end = run.time_s(row);
  return end;
}

double start_of_segment(const data::Dataset& run, int segment) {
  for (Eigen::Index row = 0; row < run.segment.size(); ++row)
    if (run.segment(row) == segment) return run.time_s(row);
  return std::numeric_limits<double>::infinity();
}

std::vector<Plateau> find_plateaus(const data::Dataset& run) {
  std::vector<Plateau> plateaus;
  std::map<std::string, int> seen;
  for (std::size_t i = 0; i < run.segments.size(); ++i) {
    const auto& segment = run.segments[i];
    const int index = static_cast<int>(i);
    const double after = end_of_segment(run, index) + 1;
    if (!segment.hold || after - start_of_segment(run, index) < kPlateauSeconds) continue;
    auto label = fmt::format("{:g} °C", segment.target.value);
    if (segment.unit.turned) label += ", turned";
    if (const int before = seen[label]++; before > 0) label += fmt::format(" ({})", before + 1);
    plateaus.push_back({label, segment.target.value, segment.unit.turned, after - kPlateauSeconds});
  }
  return plateaus;
}

/// Mean over a plateau, and the scatter of its 100-s means about a polynomial.
struct PlateauMean {
  double mean{};
  double squares{};  ///< sum of the squared residuals, with kResidualDegrees degrees of freedom
  [[nodiscard]] double u() const { return std::sqrt(squares / (kResidualDegrees * kMeans)); }
};

Result<PlateauMean> average(const data::Dataset& run, const Eigen::Ref<const Eigen::VectorXd>& values,
                            const Plateau& plateau, const std::string& what) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(kMeans), counts = Eigen::VectorXd::Zero(kMeans);
  for (Eigen::Index row = 0; row < values.size(); ++row) {
    const auto mean = static_cast<Eigen::Index>(std::floor((run.time_s(row) - plateau.from_s) / kMeanSeconds));
    if (mean < 0 || mean >= kMeans || !std::isfinite(values(row))) continue;
    sums(mean) += values(row);
    counts(mean) += 1;
  }
  if (counts.minCoeff() < kFewestReadings * kMeanSeconds)
    return failure(
        FaultKind::usage, run.path,
        fmt::format("{} has missing readings on the plateau at {}; repeat the check run", what, plateau.label));
  const Eigen::VectorXd means = sums.cwiseQuotient(counts);
  const Eigen::ArrayXd times = Eigen::ArrayXd::LinSpaced(kMeans, -1, 1);
  Eigen::MatrixXd powers(kMeans, kPolynomialDegree + 1);
  for (Eigen::Index power = 0; power <= kPolynomialDegree; ++power)
    powers.col(power) = times.pow(static_cast<double>(power));
  const Eigen::VectorXd residual = means - powers * powers.householderQr().solve(means);
  return PlateauMean{means.mean(), residual.squaredNorm()};
}

Result<void> check_reference(const data::Dataset& run) {
  if (run.earth_rate_deg_per_h) return {};
  return failure(FaultKind::usage, run.path,
                 "the Earth rate on the axis is unknown, so the bias of different runs cannot be compared; the rig "
                 "file needs the latitude and the direction of the axis");
}

/// Measures one axis: its biases and what follows from them.
class AxisMeasurement {
 public:
  AxisMeasurement(const data::Dataset& run, const std::vector<Plateau>& plateaus) : run_(run), plateaus_(plateaus) {}

  [[nodiscard]] Result<std::vector<CheckResult>> measure() && {
    for (const Plateau& plateau : plateaus_) {
      const auto mean = average(run_, run_.bias_deg_per_h, plateau, "the bias");
      if (!mean) return failure(mean.error());
      biases_.push_back(*mean);
      add({.kind = CheckKind::bias,
           .plateau = plateau.label,
           .at_c = plateau.at_c,
           .turned = plateau.turned,
           .value = mean->mean,
           .u = mean->u(),
           .unit = "°/h"});
    }
    if (auto added = add_temperature_coefficient(); !added) return failure(added.error());
    add_earth_rate();
    add_scatter();
    return std::move(results_);
  }

 private:
  void add(CheckResult result) {
    result.axis = qualified_name(run_.of);
    results_.push_back(std::move(result));
  }

  Result<double> block_temperature(const Plateau& plateau) const {
    double sum = 0;
    for (const std::string& name : run_.gradients) {
      const auto at = std::ranges::find(run_.thermometers, name) - run_.thermometers.begin();
      const auto mean = average(run_, run_.temperature_c.col(at), plateau, name);
      if (!mean) return failure(mean.error());
      sum += mean->mean;
    }
    return sum / static_cast<double>(run_.gradients.size());
  }

  Result<void> add_temperature_coefficient() {
    const auto by_temperature = [](const Plateau& a, const Plateau& b) { return a.at_c < b.at_c; };
    const auto [cold, hot] = std::ranges::minmax_element(plateaus_, by_temperature);
    if (run_.gradients.empty() || hot->at_c - cold->at_c < 1) return {};
    const auto at_hot = block_temperature(*hot), at_cold = block_temperature(*cold);
    if (!at_hot || !at_cold) return failure(at_hot ? at_cold.error() : at_hot.error());
    const PlateauMean& hot_bias = biases_[static_cast<std::size_t>(hot - plateaus_.begin())];
    const PlateauMean& cold_bias = biases_[static_cast<std::size_t>(cold - plateaus_.begin())];
    const double kelvins = *at_hot - *at_cold;
    add({.kind = CheckKind::temperature_coefficient,
         .value = (hot_bias.mean - cold_bias.mean) / kelvins,
         .u = std::hypot(hot_bias.u(), cold_bias.u()) / std::abs(kelvins),
         .unit = "°/h/K"});
    return {};
  }

  /// Compares each turned plateau with the mean of the plateaus as mounted at the same set point.
  void add_earth_rate() {
    for (std::size_t t = 0; t < plateaus_.size(); ++t) {
      if (!plateaus_[t].turned) continue;
      double sum = 0, variance = 0, count = 0;
      for (std::size_t m = 0; m < plateaus_.size(); ++m) {
        if (plateaus_[m].turned || plateaus_[m].at_c != plateaus_[t].at_c) continue;
        sum += biases_[m].mean;
        variance += biases_[m].u() * biases_[m].u();
        count += 1;
      }
      if (count == 0) continue;
      add({.kind = CheckKind::earth_rate,
           .plateau = plateaus_[t].label,
           .at_c = plateaus_[t].at_c,
           .turned = true,
           .value = (sum / count - biases_[t].mean) / 2,
           .u = std::sqrt(variance / (count * count) + biases_[t].u() * biases_[t].u()) / 2,
           .unit = "°/h"});
    }
  }

  void add_scatter() {
    double squares = 0;
    for (const PlateauMean& one : biases_) squares += one.squares;
    const double degrees = kResidualDegrees * static_cast<double>(biases_.size());
    const double scatter = std::sqrt(squares / degrees);
    add({.kind = CheckKind::scatter, .value = scatter, .u = scatter / std::sqrt(2 * degrees), .unit = "°/h"});
  }

  const data::Dataset& run_;
  const std::vector<Plateau>& plateaus_;
  std::vector<PlateauMean> biases_;
  std::vector<CheckResult> results_;
};

/// Adds the difference of each thermometer of a unit from the mean of the others, on each plateau.
Result<void> add_thermometers(const data::Dataset& run, const std::vector<Plateau>& plateaus,
                              std::vector<CheckResult>& results) {
  std::vector<std::size_t> columns;
  for (std::size_t i = 0; i < run.thermometers.size(); ++i)
    if (!data::is_own_value(run.thermometers[i])) columns.push_back(i);
  if (columns.size() < 2) return {};
  const auto others = static_cast<double>(columns.size() - 1);
  for (const Plateau& plateau : plateaus) {
    std::vector<PlateauMean> means;
    double sum = 0, variance = 0;
    for (const std::size_t column : columns) {
      const auto mean =
          average(run, run.temperature_c.col(static_cast<Eigen::Index>(column)), plateau, run.thermometers[column]);
      if (!mean) return failure(mean.error());
      means.push_back(*mean);
      sum += mean->mean;
      variance += mean->u() * mean->u();
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const double own = means[i].u() * means[i].u();
      results.push_back({.kind = CheckKind::thermometer,
                         .axis = run.of.unit,
                         .thermometer = run.thermometers[columns[i]],
                         .plateau = plateau.label,
                         .at_c = plateau.at_c,
                         .turned = plateau.turned,
                         .value = means[i].mean - (sum - means[i].mean) / others,
                         .u = std::sqrt(own + (variance - own) / (others * others)),
                         .unit = "K"});
    }
  }
  return {};
}

}  // namespace

std::string name(CheckKind kind) {
  return enumerator_text<CheckKind::thermometer>(
      {"bias", "temperature_coefficient", "scatter", "earth_rate", "thermometer"}, kind);
}

std::string label(const CheckResult& result) {
  std::string text = name(result.kind) + " ";
  text += result.kind == CheckKind::thermometer ? result.thermometer : result.axis;
  return result.plateau.empty() ? text : text + " " + result.plateau;
}

Result<std::vector<CheckResult>> measure_check_run(const std::vector<data::Dataset>& axes) {
  std::vector<CheckResult> results;
  std::vector<std::string> units;
  for (const data::Dataset& run : axes) {
    if (auto known = check_reference(run); !known) return failure(known.error());
    const auto plateaus = find_plateaus(run);
    if (plateaus.empty())
      return failure(FaultKind::usage, run.path, "has no hold of 30 min, expected a run of the profile check-standard");
    auto measured = AxisMeasurement(run, plateaus).measure();
    if (!measured) return failure(measured.error());
    results.insert(results.end(), measured->begin(), measured->end());
    if (std::ranges::count(units, run.of.unit) > 0) continue;
    units.push_back(run.of.unit);
    if (auto added = add_thermometers(run, plateaus, results); !added) return failure(added.error());
  }
  return results;
}

}  // namespace gyrotherm::assurance
