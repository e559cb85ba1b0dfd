// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/outliers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/count_text.hpp"

namespace gyrotherm::data {

namespace {

constexpr double kMadToSigma = 1.4826;
constexpr std::size_t kShownValues = 5;

double median(std::span<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Text list of values with their times: "-1000 °/h at 120 s".
class ValueList {
 public:
  void add(double value_deg_per_h, double time_s) {
    if (count_++ < kShownValues)
      text_ += fmt::format("{}{:.4g} °/h at {:.6g} s", text_.empty() ? "" : ", ", value_deg_per_h, time_s);
  }
  [[nodiscard]] std::string text() const { return text_ + (count_ > kShownValues ? ", …" : ""); }

 private:
  std::string text_{};
  std::size_t count_{};
};

}  // namespace

std::vector<Eigen::Index> find_outliers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  constexpr std::size_t kMinValues = 8;
  std::vector<double> known;
  for (const double value : values)
    if (std::isfinite(value)) known.push_back(value);
  if (known.size() < kMinValues) return {};
  const double middle = median(known);
  for (double& value : known) value = std::abs(value - middle);
  const double sigma = kMadToSigma * median(known);
  std::vector<Eigen::Index> found;
  for (Eigen::Index i = 0; i < values.size() && sigma > 0; ++i)
    if (std::abs(values(i) - middle) > kOutlierSigmas * sigma) found.push_back(i);
  return found;
}

std::vector<Spike> find_spikes(const Dataset& dataset) {
  constexpr Eigen::Index kHalfWindowRows = 7;
  const Eigen::VectorXd& bias = dataset.bias_deg_per_h;
  Eigen::VectorXd difference = Eigen::VectorXd::Constant(bias.size(), std::numeric_limits<double>::quiet_NaN());
  std::array<double, 2 * kHalfWindowRows + 1> around{};
  for (Eigen::Index i = 0; i < bias.size(); ++i) {
    if (!std::isfinite(bias(i))) continue;
    const Eigen::Index first = std::clamp<Eigen::Index>(
        i - kHalfWindowRows, 0, std::max<Eigen::Index>(bias.size() - 2 * kHalfWindowRows - 1, 0));
    std::size_t count = 0;
    for (Eigen::Index j = first; j < std::min(first + 2 * kHalfWindowRows + 1, bias.size()); ++j)
      if (std::isfinite(bias(j))) around[count++] = bias(j);
    difference(i) = bias(i) - median(std::span(around).first(count));
  }
  std::vector<Spike> spikes;
  for (const Eigen::Index row : find_outliers(difference))
    spikes.push_back({row, dataset.time_s(row), difference(row)});
  return spikes;
}

void remove(Dataset& dataset, const std::vector<Spike>& spikes) {
  for (const Spike& spike : spikes) dataset.bias_deg_per_h(spike.row) = std::numeric_limits<double>::quiet_NaN();
}

std::string describe(const std::vector<Spike>& spikes) {
  ValueList list;
  for (const Spike& spike : spikes) list.add(spike.size_deg_per_h, spike.time_s);
  return fmt::format("{} of the bias {}: {}", format_count(spikes.size(), "sample"),
                     spikes.size() == 1 ? "is an outlier" : "are outliers", list.text());
}

std::string describe_outlying_clusters(const Clusters& clusters,
                                       const Eigen::Ref<const Eigen::VectorXd>& residual_deg_per_h) {
  ValueList list;
  const auto rows = find_outliers(residual_deg_per_h);
  for (const Eigen::Index row : rows) list.add(residual_deg_per_h(row), clusters.start_s(row));
  if (rows.empty()) return "";
  return fmt::format("{} clusters have an outlying held-out residual: {}", rows.size(), list.text());
}

}  // namespace gyrotherm::data
