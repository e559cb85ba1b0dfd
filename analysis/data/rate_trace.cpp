// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/rate_trace.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

namespace gyrotherm::data {

namespace {

constexpr std::size_t kMaxMeans = 4096;
constexpr Eigen::Index kFewestWindows = 40;
/// Levels of a mean in a trace. The level after the last one marks a missing mean.
constexpr int kLevels = 4095;
constexpr std::string_view kBase64 = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

double middle_value(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Returns the standard deviation that the median of the absolute values suggests, or their RMS if the median is 0.
double robust_scatter(const std::vector<double>& values) {
  constexpr double kStdPerMedian = 1.4826;
  std::vector<double> absolute;
  double sum = 0;
  for (const double value : values)
    if (std::isfinite(value)) {
      absolute.push_back(std::abs(value));
      sum += value * value;
    }
  if (absolute.empty()) return 0;
  const double usual = kStdPerMedian * middle_value(absolute);
  return usual > 0 ? usual : std::sqrt(sum / static_cast<double>(absolute.size()));
}

/// The integral of a rate over time, and the covered time, at the bounds of its rows.
class RateIntegral {
 public:
  /// Adds a row from `time_s` on, for `length_s`. Ignores a row without a rate.
  void add(double time_s, double length_s, double rate) {
    if (!std::isfinite(rate) || !(length_s > 0)) return;
    if (bounds_.empty() || time_s > bounds_.back().time_s)
      bounds_.push_back({time_s, angle(), bounds_.empty() ? 0 : bounds_.back().covered_s});
    bounds_.push_back(
        {bounds_.back().time_s + length_s, angle() + rate * length_s, bounds_.back().covered_s + length_s});
  }
  [[nodiscard]] bool is_empty() const { return bounds_.empty(); }
  [[nodiscard]] double begin_s() const { return bounds_.front().time_s; }
  [[nodiscard]] double end_s() const { return bounds_.back().time_s; }

  /// Returns the means over consecutive windows from `from_s` on; NaN for a window that is not covered.
  [[nodiscard]] std::vector<double> means(double from_s, double window_s) const {
    constexpr double kLeastCovered = 0.9, kRounding = 1e-6;
    std::vector<double> means;
    std::size_t at = 0;
    Bound before = value_at(from_s, at);
    for (std::size_t i = 1; from_s + static_cast<double>(i) * window_s <= end_s() + kRounding * window_s; ++i) {
      const Bound after = value_at(from_s + static_cast<double>(i) * window_s, at);
      const double covered = after.covered_s - before.covered_s;
      means.push_back(covered >= kLeastCovered * window_s ? (after.angle - before.angle) / covered : NAN);
      before = after;
    }
    return means;
  }

 private:
  struct Bound {
    double time_s{}, angle{}, covered_s{};
  };
  [[nodiscard]] double angle() const { return bounds_.empty() ? 0 : bounds_.back().angle; }
  /// Interpolates between the bounds. `at` is a bound before the time, and is advanced.
  [[nodiscard]] Bound value_at(double time_s, std::size_t& at) const {
    while (at + 1 < bounds_.size() && bounds_[at + 1].time_s <= time_s) ++at;
    const Bound& low = bounds_[at];
    if (at + 1 == bounds_.size() || time_s <= low.time_s) return {time_s, low.angle, low.covered_s};
    const Bound& high = bounds_[at + 1];
    const double part = (time_s - low.time_s) / (high.time_s - low.time_s);
    return {time_s, low.angle + part * (high.angle - low.angle),
            low.covered_s + part * (high.covered_s - low.covered_s)};
  }

  std::vector<Bound> bounds_{};
};

/// Rates as a function of time, with the spacing of the rows.
struct Rates {
  RateIntegral integral{};
  double spacing_s{};
};

std::optional<Rates> read_rates(const Dataset& dataset, double from_s, double to_s) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index row = 0; row < dataset.time_s.size(); ++row)
    if (dataset.time_s(row) >= from_s && dataset.time_s(row) < to_s) rows.push_back(row);
  if (std::ssize(rows) < kFewestWindows) return std::nullopt;
  std::vector<double> steps;
  for (std::size_t i = 1; i < rows.size(); ++i) steps.push_back(dataset.time_s(rows[i]) - dataset.time_s(rows[i - 1]));
  Rates rates{.spacing_s = middle_value(steps)};
  if (!(rates.spacing_s > 0)) return std::nullopt;
  constexpr double kLongestStep = 1.5;
  const bool is_reduced = dataset.bias_zero != kNothingRemoved;
  const double removed = is_reduced ? dataset.earth_rate_deg_per_h.value_or(0) : 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double step = i < steps.size() ? steps[i] : rates.spacing_s;
    const double length = step > kLongestStep * rates.spacing_s ? rates.spacing_s : step;
    rates.integral.add(dataset.time_s(rows[i]), length, dataset.bias_deg_per_h(rows[i]) + removed);
  }
  return rates.integral.is_empty() ? std::nullopt : std::optional(std::move(rates));
}

/// Returns the least of 1, 2, 5, 10, 20, … that divides `count` rows into at most kMaxMeans parts.
double rows_per_mean(double count) {
  for (double decade = 1;; decade *= 10)
    for (const double digit : {1.0, 2.0, 5.0})
      if (count <= decade * digit * static_cast<double>(kMaxMeans)) return decade * digit;
}

/// Fills the trace; leaves it empty if the means do not vary.
void encode_means(const std::vector<double>& means, RateTrace& trace) {
  constexpr double kStepsOfScatter = 8;
  std::vector<double> differences;
  for (std::size_t i = 1; i < means.size(); ++i) differences.push_back(means[i] - means[i - 1]);
  const double step = robust_scatter(differences) / std::sqrt(2.0) / kStepsOfScatter;
  const auto first = std::ranges::find_if(means, [](double mean) { return std::isfinite(mean); });
  if (!(step > 0) || first == means.end()) return;
  trace.first_deg_per_h = *first;
  trace.step_deg_per_h = step;
  for (const double mean : means) {
    const double level = std::round((mean - *first) / step);
    const bool is_known = std::isfinite(level) && std::abs(level) < 1e15;
    const auto code =
        static_cast<std::size_t>(is_known ? std::fmod(std::fmod(level, kLevels) + kLevels, kLevels) : double{kLevels});
    trace.means += kBase64[code / kBase64.size()];
    trace.means += kBase64[code % kBase64.size()];
  }
}

/// Returns the rates of a trace; nothing if the text is not one.
std::optional<Rates> decode(const RateTrace& trace) {
  if (!(trace.interval_s > 0) || !(trace.step_deg_per_h > 0) || trace.means.size() % 2 != 0) return std::nullopt;
  Rates rates{.spacing_s = trace.interval_s};
  double level = 0;
  for (std::size_t i = 0; i + 1 < trace.means.size(); i += 2) {
    const auto high = kBase64.find(trace.means[i]), low = kBase64.find(trace.means[i + 1]);
    if (high == std::string_view::npos || low == std::string_view::npos) return std::nullopt;
    const auto code = static_cast<double>(high * kBase64.size() + low);
    if (code >= kLevels) continue;
    level += std::remainder(code - level, double{kLevels});  // the nearest level with this code
    rates.integral.add(static_cast<double>(i / 2) * trace.interval_s, trace.interval_s,
                       trace.first_deg_per_h + level * trace.step_deg_per_h);
  }
  return rates.integral.is_empty() ? std::nullopt : std::optional(std::move(rates));
}

constexpr std::size_t kReach = 2;  ///< neighbours on each side in a fourth difference

/// Means over windows of equal length.
struct Windows {
  std::vector<double> means{};
  /// The fourth differences of the means, limited to four times their scatter; 0 where a mean is missing. Element i
  /// belongs to mean i + kReach. Empty if all are 0.
  Eigen::VectorXf noise{};
  /// The standard deviation of a mean.
  double scatter{};
};

Windows make_windows(std::vector<double> means) {
  constexpr double kLimit = 4, kNoiseGain = 8.3666;  // √(1 + 16 + 36 + 16 + 1)
  std::vector<double> noise;
  for (std::size_t i = kReach; i + kReach < means.size(); ++i)
    noise.push_back(means[i - 2] - 4 * means[i - 1] + 6 * means[i] - 4 * means[i + 1] + means[i + 2]);
  const double scatter = robust_scatter(noise);
  if (!(scatter > 0)) return {};
  Eigen::VectorXf limited(std::ssize(noise));
  for (std::size_t i = 0; i < noise.size(); ++i)
    limited(static_cast<Eigen::Index>(i)) =
        std::isfinite(noise[i]) ? static_cast<float>(std::clamp(noise[i] / scatter, -kLimit, kLimit)) : 0.0F;
  return {std::move(means), std::move(limited), scatter / kNoiseGain};
}

using Noise = Eigen::Ref<const Eigen::VectorXf>;

double correlation(const Noise& one, const Noise& other) {
  const double norms = static_cast<double>(one.squaredNorm()) * static_cast<double>(other.squaredNorm());
  return norms > 0 ? static_cast<double>(one.dot(other)) / std::sqrt(norms) : 0;
}

/// Returns the correlation of values that are `lag` apart.
double autocorrelation(const Eigen::VectorXf& noise, Eigen::Index lag) {
  const auto count = noise.size() - lag;
  return static_cast<double>(noise.head(count).dot(noise.tail(count))) / static_cast<double>(noise.squaredNorm());
}

/// Returns the variance of the correlation of independent noise times the number of its values: 1 + 2 Σ ρ_k σ_k, with
/// the autocorrelations ρ and σ (Bartlett, J. R. Stat. Soc. 98 (1935) 536). A gyro with few pulses in a second may have
/// the same pattern of pulses in any two runs, so the variance is not always that of white noise.
double correlated_variance(const Eigen::VectorXf& one, const Eigen::VectorXf& other) {
  // For fourth differences of white noise, with the autocorrelations −0.8, 0.4, −0.114, 0.014.
  constexpr double kOfWhiteNoise = 2.63;
  constexpr Eigen::Index kMostLags = 64, kShare = 4;
  double variance = 1;
  for (Eigen::Index lag = 1; lag <= std::min(kMostLags, one.size() / kShare); ++lag)
    variance += 2 * autocorrelation(one, lag) * autocorrelation(other, lag);
  return std::max(kOfWhiteNoise, variance);
}

/// Counts the different values of a noise.
std::ptrdiff_t count_levels(const Eigen::VectorXf& noise) {
  return std::ssize(std::set<float>(noise.begin(), noise.end()));
}

/// Returns whether the correlation of two noises cannot be that of independent noise. Considers only the elements that
/// are known in both.
bool is_same_noise(const Noise& one, const Noise& other) {
  constexpr double kLeast = 0.7, kDeviations = 7;
  // Fewer independent values may be equal by chance in a regular pattern of pulses, but not if the values are many.
  constexpr double kFewestIndependent = 10, kOfCopy = 0.99;
  const Eigen::VectorXf a = (other.array() != 0).select(one, 0.0F), b = (one.array() != 0).select(other, 0.0F);
  const auto known = (a.array() != 0).count();
  const double found = correlation(a, b);
  if (found < kLeast || known < kFewestWindows) return false;
  const double independent = static_cast<double>(known) / correlated_variance(a, b);
  // A trace has fewer levels than the rates from which it was taken.
  const bool is_copy = found >= kOfCopy && 2 * std::max(count_levels(a), count_levels(b)) >= known;
  return (is_copy || independent >= kFewestIndependent) &&
         std::atanh(std::min(found, 1 - 1e-12)) * std::sqrt(independent) > kDeviations;
}

/// Returns whether the means agree on average within what rounding may change.
bool has_same_level(const Windows& one, Eigen::Index from_one, const Windows& other, Eigen::Index from_other,
                    Eigen::Index count) {
  constexpr double kScatters = 3, kShare = 0.005;
  double difference = 0, level = 0, known = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double a = one.means[static_cast<std::size_t>(from_one + i) + kReach];
    const double b = other.means[static_cast<std::size_t>(from_other + i) + kReach];
    if (!std::isfinite(a) || !std::isfinite(b)) continue;
    difference += a - b;
    level += std::abs(a);
    ++known;
  }
  return known > 0 && std::abs(difference) <= kScatters * one.scatter * known + kShare * level;
}

/// Returns whether the noises are the same in `count` elements, or in all elements that they have in common at this
/// shift. A piece of a regular pattern may be too short for a decision.
bool is_same_noise_at(const Eigen::VectorXf& one, Eigen::Index from_one, const Eigen::VectorXf& other,
                      Eigen::Index from_other, Eigen::Index count) {
  if (is_same_noise(one.segment(from_one, count), other.segment(from_other, count))) return true;
  constexpr double kLeastInPiece = 0.9;
  if (correlation(one.segment(from_one, count), other.segment(from_other, count)) < kLeastInPiece) return false;
  const auto back = std::min(from_one, from_other);
  const auto all = std::min(one.size() - from_one, other.size() - from_other) + back;
  return is_same_noise(one.segment(from_one - back, all), other.segment(from_other - back, all));
}

/// Returns whether any piece of `one` has the noise and the level of `other`, at any shift.
bool has_common_piece(const Windows& one, const Windows& other) {
  const auto &pieces = one.noise, &whole = other.noise;
  constexpr Eigen::Index kPiece = 128, kFirstLook = 32;
  constexpr double kLeastAtFirst = 0.5;
  for (Eigen::Index first = 0; first + kFewestWindows <= pieces.size(); first += kPiece) {
    const auto remains = pieces.size() - first;
    const auto length = remains < kPiece + kFewestWindows ? remains : kPiece;
    for (Eigen::Index shift = kFewestWindows - length; shift + kFewestWindows <= whole.size(); ++shift) {
      const auto from = std::max<Eigen::Index>(0, -shift);
      const auto count = std::min(length, whole.size() - shift) - from;
      const auto at = first + from, at_other = shift + from;
      if (correlation(pieces.segment(at, kFirstLook), whole.segment(at_other, kFirstLook)) < kLeastAtFirst) continue;
      if (is_same_noise_at(pieces, at, whole, at_other, count) && has_same_level(one, at, other, at_other, count))
        return true;
    }
    if (length > kPiece) break;
  }
  return false;
}

}  // namespace

RateTrace trace_rates(const Dataset& dataset, double from_s, double to_s) {
  const auto rates = read_rates(dataset, from_s, to_s);
  if (!rates) return {};
  const auto& integral = rates->integral;
  const double interval = rates->spacing_s * rows_per_mean((integral.end_s() - integral.begin_s()) / rates->spacing_s);
  RateTrace trace{.interval_s = interval};
  encode_means(integral.means(integral.begin_s(), interval), trace);
  return trace.means.empty() ? RateTrace{} : trace;
}

bool has_rates_of(const Dataset& dataset, const RateTrace& trace, double from_s, double to_s) {
  const auto known = decode(trace);
  const auto rates = read_rates(dataset, from_s, to_s);
  if (!known || !rates) return false;
  const bool is_coarser = rates->spacing_s >= known->spacing_s;
  const Rates &coarse = is_coarser ? *rates : *known, &fine = is_coarser ? *known : *rates;
  const double ratio = coarse.spacing_s / fine.spacing_s;
  constexpr double kMaxRatio = 10'000, kNearWhole = 0.01, kFinePerWindow = 4;
  if (ratio > kMaxRatio) return false;
  // A window that divides rows is wide enough that the divided rows at its ends do not matter.
  const bool divides_rows = std::abs(ratio - std::round(ratio)) > kNearWhole * ratio;
  const double window = coarse.spacing_s * (divides_rows ? std::ceil(kFinePerWindow / ratio) : 1);
  const auto pieces = make_windows(coarse.integral.means(coarse.integral.begin_s(), window));
  if (pieces.noise.size() < kFewestWindows) return false;
  // Half a row, because the time of a mean may be its start or its middle.
  const double step = std::max(fine.spacing_s / 2, window / 64);
  for (double phase = 0; phase < window - step / 2; phase += step) {
    const auto whole = make_windows(fine.integral.means(fine.integral.begin_s() + phase, window));
    constexpr double kMostRatio = 2;
    const double scatters = whole.scatter > 0 ? pieces.scatter / whole.scatter : 0;
    const bool are_alike = scatters > 1 / kMostRatio && scatters < kMostRatio;
    if (are_alike && whole.noise.size() >= kFewestWindows && has_common_piece(pieces, whole)) return true;
  }
  return false;
}

}  // namespace gyrotherm::data
