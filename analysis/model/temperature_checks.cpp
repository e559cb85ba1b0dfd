// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/temperature_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "analysis/data/statistics.hpp"
#include "analysis/model/uncertainty.hpp"

namespace gyrotherm::model {
namespace {

/// Names of the inputs from which the terms are computed.
std::set<std::string> names_in(const std::vector<data::Term>& terms) {
  std::set<std::string> names;
  for (const data::Term& term : terms)
    for (const data::Factor& factor : term.factors) {
      names.insert(factor.first);
      if (!factor.second.empty()) names.insert(factor.second);
    }
  return names;
}

/// Returns the columns of the temperatures in the terms.
std::vector<Eigen::Index> columns_in(const std::vector<data::Term>& terms, const data::Clusters& clusters) {
  const std::set<std::string> names = names_in(terms);
  std::vector<Eigen::Index> columns;
  for (std::size_t i = 0; i < clusters.thermometers.size(); ++i)
    if (names.contains(clusters.thermometers[i]) && data::is_temperature(clusters.thermometers[i]))
      columns.push_back(static_cast<Eigen::Index>(i));
  return columns;
}

/// Returns the greatest decrease of the values after an earlier value.
double greatest_decrease(const Eigen::VectorXd& values) {
  double highest = values(0), decrease = 0;
  for (const double value : values) {
    highest = std::max(highest, value);
    decrease = std::max(decrease, highest - value);
  }
  return decrease;
}

/// Returns the correlation of the mean temperature with time, or 0 if the temperature is reversed or does not vary.
double monotone_correlation(const data::Clusters& clusters, const std::vector<Eigen::Index>& columns) {
  constexpr double kReversal = 0.1;
  const Eigen::VectorXd temperature = clusters.temperature_c(Eigen::all, columns).rowwise().mean();
  const std::vector<Eigen::Index> rows = data::finite_rows(temperature);
  if (rows.size() < 3) return 0;
  const Eigen::VectorXd known = temperature(rows);
  const double correlation = data::pearson(known, clusters.start_s(rows));
  const double reversal = greatest_decrease(correlation > 0 ? known : Eigen::VectorXd(-known));
  return reversal < kReversal * (known.maxCoeff() - known.minCoeff()) ? correlation : 0;
}

}  // namespace

Fault no_thermometer_fault(const data::Dataset& dataset) {
  return {FaultKind::usage, dataset.path,
          "the record has no thermometer, so no effect of the temperature can be learnt from it"};
}

Result<void> check_temperatures_vary(const std::vector<data::Term>& terms, const std::vector<data::Dataset>& datasets,
                                     const std::vector<data::Clusters>& records) {
  constexpr double kLeastRatio = 3;
  const auto clusters = concatenate(records);
  if (!clusters) return failure(clusters.error());
  const std::vector<Eigen::Index> columns = columns_in(terms, *clusters);
  if (columns.empty() || columns.size() < names_in(terms).size()) return {};
  const Eigen::RowVectorXd noise_k = thermometer_noise_k(datasets.front(), records.front());
  double greatest_k = 0, its_noise_k = 0;
  for (const Eigen::Index column : columns) {
    const double std_k = data::compute_figures(clusters->temperature_c.col(column)).std;
    if (!(std_k < kLeastRatio * noise_k(column))) return {};
    if (std_k < greatest_k) continue;
    greatest_k = std_k;
    its_noise_k = noise_k(column);
  }
  return failure(FaultKind::usage, datasets.front().path,
                 fmt::format("the temperature does not vary: the STD of its means is {:.2g} K, their noise {:.2g} K; a "
                             "model needs a record with a change of the temperature",
                             greatest_k, its_noise_k));
}

std::optional<std::string> find_confusion_with_time(const std::vector<data::Term>& terms,
                                                    const std::vector<data::Clusters>& records) {
  constexpr double kGreatest = 0.9;
  double least = 1;
  for (const data::Clusters& clusters : records) {
    const std::vector<Eigen::Index> columns = columns_in(terms, clusters);
    if (columns.empty()) return std::nullopt;
    least = std::min(least, std::abs(monotone_correlation(clusters, columns)));
  }
  if (!(least > kGreatest)) return std::nullopt;
  return fmt::format(
      "temperature and time cannot be told apart in {}: the temperature changes in one direction only (correlation "
      "with "
      "time {:.2f}), so a drift looks like an effect of the temperature; add a record in which it returns",
      records.size() == 1 ? "this record" : "these records", least);
}

}  // namespace gyrotherm::model
