// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/clusters.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/quantity.hpp"

namespace gyrotherm::data {
namespace {

/// Tolerance for the rounding of time stamps, as a fraction of the cluster length.
constexpr double kTimeSlack = 1e-9;

/// Range of dataset rows, first … first + count − 1, in cluster `number`.
struct Span {
  Eigen::Index number{}, first{}, count{};
};

Eigen::Index cluster_number(double seconds, double length_s) {
  return static_cast<Eigen::Index>(std::floor(seconds / length_s + kTimeSlack));
}

std::vector<Span> cut(const Dataset& dataset, double length_s) {
  std::vector<Span> spans;
  for (Eigen::Index i = 0; i < dataset.time_s.size(); ++i) {
    const Eigen::Index number = cluster_number(dataset.time_s(i) - dataset.time_s(0), length_s);
    if (spans.empty() || spans.back().number != number) spans.push_back({number, i, 0});
    ++spans.back().count;
  }
  return spans;
}

bool has_each_second(const Dataset& dataset, const Span& span, double length_s) {
  return dataset.imported || span.count == std::llround(length_s);
}

/// Returns whether every temperature is present. Values reported by the unit itself may be missing; rows without them
/// are skipped where they are used.
bool has_each_temperature(const Dataset& dataset, const Span& span) {
  const auto rows = dataset.temperature_c.middleRows(span.first, span.count);
  for (Eigen::Index column = 0; column < rows.cols(); ++column)
    if (!is_own_value(dataset.thermometers[static_cast<std::size_t>(column)]) && !rows.col(column).allFinite())
      return false;
  return true;
}

bool is_whole(const Dataset& dataset, const Span& span, double length_s) {
  return has_each_second(dataset, span, length_s) && has_each_temperature(dataset, span) &&
         dataset.bias_deg_per_h.segment(span.first, span.count).allFinite();
}

/// Lists the thermometers that have no reading in any row, and the bias if it is missing in every row. If there is
/// none, lists the thermometers that lack readings in some rows. Returns an empty string if nothing is missing.
std::string list_missing_values(const Dataset& dataset) {
  std::vector<std::string> missing, sparse;
  for (Eigen::Index column = 0; column < dataset.temperature_c.cols(); ++column) {
    const std::string& name = dataset.thermometers[static_cast<std::size_t>(column)];
    if (is_own_value(name)) continue;
    const auto known = dataset.temperature_c.col(column).array().isFinite().count();
    if (known == 0) missing.push_back(name);
    if (known > 0 && known < dataset.temperature_c.rows()) sparse.push_back(name);
  }
  if (!dataset.bias_deg_per_h.array().isFinite().any()) missing.emplace_back("the bias");
  if (!missing.empty()) return fmt::format("; no row has a value of {}", fmt::join(missing, ", "));
  return sparse.empty() ? "" : fmt::format("; rows lack values of {}", fmt::join(sparse, ", "));
}

/// Counts a dropped cluster for each of its inputs with a missing reading.
void count_missing_inputs(const Dataset& dataset, const Span& span, std::vector<std::pair<std::string, int>>& counts) {
  const auto count = [&](const std::string& name) {
    const auto known = std::ranges::find(counts, name, &std::pair<std::string, int>::first);
    if (known != counts.end())
      ++known->second;
    else
      counts.emplace_back(name, 1);
  };
  for (Eigen::Index column = 0; column < dataset.temperature_c.cols(); ++column) {
    const std::string& name = dataset.thermometers[static_cast<std::size_t>(column)];
    if (!is_own_value(name) && !dataset.temperature_c.col(column).segment(span.first, span.count).allFinite())
      count(name);
  }
  if (!dataset.bias_deg_per_h.segment(span.first, span.count).allFinite()) count("the bias");
}

Clusters allocate_clusters(Eigen::Index rows, const std::vector<std::string>& thermometers, double length_s) {
  const auto columns = static_cast<Eigen::Index>(thermometers.size());
  Clusters clusters;
  clusters.length_s = length_s;
  clusters.thermometers = thermometers;
  clusters.start_s.resize(rows);
  clusters.temperature_c.resize(rows, columns);
  clusters.rate_c_per_min.setConstant(rows, columns, std::numeric_limits<double>::quiet_NaN());
  clusters.bias_deg_per_h.resize(rows);
  clusters.true_bias_deg_per_h.setConstant(rows, std::numeric_limits<double>::quiet_NaN());
  clusters.set_point_c.resize(rows);
  clusters.segment.resize(rows);
  clusters.last_segment.resize(rows);
  clusters.cycle.resize(rows);
  clusters.power_on.setZero(rows);
  clusters.samples.resize(rows);
  return clusters;
}

void fill(Clusters& clusters, Eigen::Index row, const Dataset& dataset, const Span& span) {
  clusters.start_s(row) = dataset.time_s(0) + static_cast<double>(span.number) * clusters.length_s;
  clusters.temperature_c.row(row) = dataset.temperature_c.middleRows(span.first, span.count).colwise().mean();
  clusters.bias_deg_per_h(row) = dataset.bias_deg_per_h.segment(span.first, span.count).mean();
  if (dataset.true_bias_deg_per_h.size() > 0)
    clusters.true_bias_deg_per_h(row) = dataset.true_bias_deg_per_h.segment(span.first, span.count).mean();
  clusters.set_point_c(row) = dataset.set_point_c.segment(span.first, span.count).mean();
  clusters.segment(row) = dataset.segment(span.first);
  clusters.last_segment(row) = dataset.segment(span.first + span.count - 1);
  clusters.cycle(row) = dataset.cycle(span.first);
  clusters.samples(row) = static_cast<int>(span.count);
}

/// Numbers the power-on of each cluster by the segments with the unit off that precede it.
void fill_power_ons(Clusters& clusters, const Dataset& dataset) {
  std::vector<int> power_on{0};  // one per segment
  for (std::size_t s = 1; s < dataset.segments.size(); ++s) {
    const bool begins = dataset.segments[s - 1].unit.off && !dataset.segments[s].unit.off;
    power_on.push_back(power_on.back() + (begins ? 1 : 0));
  }
  for (Eigen::Index k = 0; k < clusters.segment.size(); ++k) {
    const auto segment = static_cast<std::size_t>(std::max(0, clusters.segment(k)));
    clusters.power_on(k) = power_on[std::min(segment, power_on.size() - 1)];
  }
}

void fill_rates(Clusters& clusters, const std::vector<Span>& spans) {
  for (Eigen::Index k = 1; k < clusters.start_s.size(); ++k) {
    if (spans[k].number != spans[k - 1].number + 1) continue;
    clusters.rate_c_per_min.row(k) =
        (clusters.temperature_c.row(k) - clusters.temperature_c.row(k - 1)) * (kSecondsPerMinute / clusters.length_s);
  }
}

/// Stores the history of `spans`, and the row of each span of `kept` in that history. A run is assumed to start in
/// thermal equilibrium, so the time before its first cluster is infinite.
void store_history(Clusters& clusters, const Dataset& dataset, const std::vector<Span>& spans,
                   const std::vector<Span>& kept) {
  const auto rows = static_cast<Eigen::Index>(spans.size());
  clusters.history.temperature_c.resize(rows, dataset.temperature_c.cols());
  clusters.history.elapsed_s.setConstant(rows, std::numeric_limits<double>::infinity());
  for (Eigen::Index k = 0; k < rows; ++k) {
    const Span& span = spans[static_cast<std::size_t>(k)];
    clusters.history.temperature_c.row(k) = dataset.temperature_c.middleRows(span.first, span.count).colwise().mean();
    if (k > 0)
      clusters.history.elapsed_s(k) = static_cast<double>(span.number - spans[k - 1].number) * clusters.length_s;
    const std::size_t next = clusters.moments.size();
    if (next < kept.size() && span.first == kept[next].first) clusters.moments.push_back(k);
  }
}

/// Joins the histories of all parts in order. Leaves the history empty if one of the parts has none.
void join_histories(Clusters& all, const std::vector<Clusters>& parts) {
  if (!std::ranges::all_of(parts, has_history)) return;
  Eigen::Index rows = 0;
  for (const Clusters& part : parts) rows += part.history.elapsed_s.size();
  all.history.elapsed_s.resize(rows);
  all.history.temperature_c.resize(rows, all.temperature_c.cols());
  Eigen::Index first = 0;
  for (const Clusters& part : parts) {
    const Eigen::Index count = part.history.elapsed_s.size();
    all.history.elapsed_s.segment(first, count) = part.history.elapsed_s;
    all.history.temperature_c.middleRows(first, count) = part.history.temperature_c;
    for (const Eigen::Index moment : part.moments) all.moments.push_back(first + moment);
    first += count;
  }
}

/// Calls visit(array of `to`, array of `from`) for each array with one row per cluster.
template <class Visit>
void visit_arrays(Clusters& to, const Clusters& from, Visit visit) {
  visit(to.start_s, from.start_s);
  visit(to.temperature_c, from.temperature_c);
  visit(to.rate_c_per_min, from.rate_c_per_min);
  visit(to.bias_deg_per_h, from.bias_deg_per_h);
  visit(to.set_point_c, from.set_point_c);
  visit(to.segment, from.segment);
  visit(to.last_segment, from.last_segment);
  visit(to.cycle, from.cycle);
  visit(to.samples, from.samples);
}

}  // namespace

int count_power_ons(const Clusters& clusters) {
  if (clusters.power_on.size() == 0) return clusters.start_s.size() > 0 ? 1 : 0;
  return static_cast<int>(std::set<int>(clusters.power_on.begin(), clusters.power_on.end()).size());
}

bool has_history(const Clusters& clusters) {
  return static_cast<Eigen::Index>(clusters.moments.size()) == clusters.temperature_c.rows();
}

Result<Clusters> make_clusters(const Dataset& dataset, double length_s) {
  assert(length_s >= 1);
  const auto none = [&] {
    return failure(FaultKind::usage, dataset.path,
                   fmt::format("contains no complete cluster of {} s{}", length_s,
                               dataset.time_s.size() == 0 ? "" : list_missing_values(dataset)));
  };
  if (!dataset.imported && length_s != std::round(length_s))
    return failure(FaultKind::usage, dataset.path,
                   fmt::format("has one sample per second, so clusters of {:g} s differ in their number of samples; "
                               "expected a whole number of seconds",
                               length_s));
  if (dataset.time_s.size() == 0) return none();
  const double span_s = dataset.time_s(dataset.time_s.size() - 1) - dataset.time_s(0) + sample_interval_s(dataset);
  const Eigen::Index complete = cluster_number(span_s, length_s);

  std::vector<Span> kept, remembered;
  std::vector<std::pair<std::string, int>> dropped_by_input;
  int dropped_rest = 0;
  for (const Span& span : cut(dataset, length_s)) {
    if (span.number >= complete) {
      dropped_rest += static_cast<int>(span.count);
      continue;
    }
    if (has_each_second(dataset, span, length_s)) remembered.push_back(span);
    if (is_whole(dataset, span, length_s))
      kept.push_back(span);
    else if (has_each_second(dataset, span, length_s))
      count_missing_inputs(dataset, span, dropped_by_input);
  }
  if (kept.empty()) return none();

  Clusters clusters = allocate_clusters(static_cast<Eigen::Index>(kept.size()), dataset.thermometers, length_s);
  for (std::size_t k = 0; k < kept.size(); ++k) fill(clusters, static_cast<Eigen::Index>(k), dataset, kept[k]);
  fill_rates(clusters, kept);
  fill_power_ons(clusters, dataset);
  store_history(clusters, dataset, remembered, kept);
  clusters.dropped_rest = dropped_rest;
  clusters.dropped_by_input = std::move(dropped_by_input);
  clusters.dropped_gaps = static_cast<int>(complete - static_cast<Eigen::Index>(kept.size()));
  return clusters;
}

std::string describe_left_out(const Clusters& clusters) {
  constexpr double kMostUnmentioned = 0.05;
  const auto all = static_cast<double>(clusters.history.elapsed_s.size());
  std::vector<std::string> inputs;
  int most = 0;
  for (const auto& [name, count] : clusters.dropped_by_input) {
    inputs.push_back(fmt::format("{} in {} clusters ({:.1f} %)", name, count, 100 * count / all));
    most = std::max(most, count);
  }
  if (most <= kMostUnmentioned * all) return "";
  return fmt::format("a part of the record is left out because values are missing: {}", fmt::join(inputs, ", "));
}

Clusters pick_clusters(const Clusters& clusters, const std::vector<Eigen::Index>& rows) {
  Clusters picked = clusters;
  visit_arrays(picked, clusters, [&](auto& to, const auto& from) { to = from(rows, Eigen::all); });
  if (clusters.true_bias_deg_per_h.size() > 0) picked.true_bias_deg_per_h = clusters.true_bias_deg_per_h(rows);
  if (clusters.power_on.size() > 0) picked.power_on = clusters.power_on(rows);
  if (!has_history(clusters)) return picked;
  picked.moments.clear();
  for (const Eigen::Index row : rows) picked.moments.push_back(clusters.moments[static_cast<std::size_t>(row)]);
  return picked;
}

Result<Clusters> concatenate(const std::vector<Clusters>& parts) {
  if (parts.empty()) return failure(FaultKind::usage, "clusters", "there is no record");
  Eigen::Index rows = 0;
  for (const Clusters& part : parts) {
    if (part.thermometers != parts.front().thermometers || part.length_s != parts.front().length_s) {
      return failure(FaultKind::usage, "clusters", "the records differ in their thermometers or cluster length");
    }
    rows += part.start_s.size();
  }
  Clusters all = allocate_clusters(rows, parts.front().thermometers, parts.front().length_s);
  Eigen::Index target = 0;
  int power_ons = 0;
  for (const Clusters& part : parts) {
    visit_arrays(all, part, [&](auto& to, const auto& from) { to.middleRows(target, from.rows()) = from; });
    if (part.true_bias_deg_per_h.size() > 0)
      all.true_bias_deg_per_h.segment(target, part.start_s.size()) = part.true_bias_deg_per_h;
    auto numbers = all.power_on.segment(target, part.start_s.size());
    numbers.setConstant(power_ons);
    if (part.power_on.size() > 0) numbers += part.power_on;
    if (numbers.size() > 0) power_ons = numbers.maxCoeff() + 1;
    target += part.start_s.size();
    all.dropped_rest += part.dropped_rest;
    all.dropped_gaps += part.dropped_gaps;
  }
  join_histories(all, parts);
  return all;
}

bool jumps_by_turning(const Dataset& dataset, const Clusters& clusters) {
  if (!jumps_by_turning(dataset)) return false;
  std::set<bool> positions;
  const auto count = static_cast<int>(dataset.segments.size());
  for (const Eigen::VectorXi* segments : {&clusters.segment, &clusters.last_segment})
    for (const int segment : *segments)
      if (segment >= 0 && segment < count)
        positions.insert(dataset.segments[static_cast<std::size_t>(segment)].unit.turned);
  return positions.size() > 1;
}

}  // namespace gyrotherm::data
