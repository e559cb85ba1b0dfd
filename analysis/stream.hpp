/// Compensation as a stream: 1-Hz rows in, compensated bias out, memory bounded.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/model.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Inputs are trailing means over the model's cluster length, one row a second (causal; lag: half of it), rates the
/// difference of two neighbouring means. At the end of each whole cluster they are that cluster's.
class CompensationStream {
 public:
  /// `columns`: the thermometers of each row, in order. Fails with usage if the model needs another one.
  [[nodiscard]] static Result<CompensationStream> open(const Model& model, std::vector<std::string> columns);
  /// One row: temperatures in °C in the order of `columns` (one each), raw bias in °/h. Returns the compensated bias;
  /// NaN until a whole mean (two, where a rate is an input) has been seen, and while one holds a NaN.
  [[nodiscard]] double push(const std::vector<double>& temperatures_c, double bias_deg_per_h);

 private:
  CompensationStream(const Model& model, std::vector<std::string> columns);
  [[nodiscard]] Eigen::RowVectorXd mean_of(Eigen::Index first_row) const;
  Model model_;
  Eigen::Index length_{};  ///< rows of a mean
  bool rates_{};           ///< the model asks for them
  SampleMatrix window_;    ///< the last two means' rows, as a ring
  Eigen::Index pushed_{};  ///< rows in all
  Clusters latest_;        ///< one row: the means of now
};

}  // namespace gyrotherm
