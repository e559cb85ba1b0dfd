#include "analysis/stream.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace gyrotherm {

Result<CompensationStream> CompensationStream::open(const Model& model, std::vector<std::string> columns) {
  CompensationStream stream(model, std::move(columns));
  if (const auto inputs = evaluate(model.terms, stream.latest_); !inputs) return failure(inputs.error());
  return stream;
}

CompensationStream::CompensationStream(const Model& model, std::vector<std::string> columns)
    : model_(model),
      length_(std::max<Eigen::Index>(1, std::llround(model.cluster_length_s))),
      rates_(std::ranges::any_of(model.terms, [](const Term& term) { return term.kind == TermKind::rate; })) {
  const auto count = static_cast<Eigen::Index>(columns.size());
  window_.setZero(2 * length_, count);
  latest_.length_s = model.cluster_length_s;
  latest_.thermometers = std::move(columns);
  latest_.temperature_c.setZero(1, count);
  latest_.rate_c_per_min.setZero(1, count);
}

/// Summed anew each time: a running sum would gather rounding, and keep a NaN for ever.
Eigen::RowVectorXd CompensationStream::mean_of(Eigen::Index first_row) const {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(window_.cols());
  for (Eigen::Index row = first_row; row < first_row + length_; ++row) sum += window_.row(row % window_.rows());
  return sum / static_cast<double>(length_);
}

double CompensationStream::push(const std::vector<double>& temperatures_c, double bias_deg_per_h) {
  assert(static_cast<Eigen::Index>(temperatures_c.size()) == window_.cols());
  window_.row(pushed_ % window_.rows()) = Eigen::Map<const Eigen::RowVectorXd>(temperatures_c.data(), window_.cols());
  ++pushed_;
  if (pushed_ < (rates_ ? 2 : 1) * length_) return std::numeric_limits<double>::quiet_NaN();

  latest_.temperature_c = mean_of(pushed_ - length_);
  if (rates_) {
    constexpr double kSecondsPerMinute = 60;
    const Eigen::RowVectorXd change = latest_.temperature_c - mean_of(pushed_ - 2 * length_);
    latest_.rate_c_per_min = change * (kSecondsPerMinute / latest_.length_s);
  }
  const auto predicted = predict(model_, latest_);
  assert(predicted);
  return bias_deg_per_h - (*predicted)(0);
}

}  // namespace gyrotherm
