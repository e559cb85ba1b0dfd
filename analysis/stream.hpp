/// Compensation as a stream: 1-Hz rows in, compensated bias out, memory bounded.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "analysis/model.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Inputs are trailing means over `length_s` rows (causal; lag: half of it), rates the difference of two neighbouring means.
class CompensationStream {
 public:
  /// `columns`: the thermometers of each row, in order. Fails with usage if the model needs another one.
  [[nodiscard]] static Result<CompensationStream> open(const Model& model, std::vector<std::string> columns);
  /// One row: temperatures in °C in the order of `columns`, raw bias in °/h. Returns the compensated bias; NaN until a whole
  /// mean (two, where a rate is an input) has been seen.
  [[nodiscard]] double push(const std::vector<double>& temperatures_c, double bias_deg_per_h);

 private:
  CompensationStream(const Model& model, std::vector<std::string> columns);
  Model model_;
  std::vector<std::string> columns_;
  std::deque<std::vector<double>> window_;
  std::vector<double> sum_, sum_before_;
};

}  // namespace gyrotherm
