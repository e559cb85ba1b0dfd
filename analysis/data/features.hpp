/// The inputs of a model as numbers: terms evaluated over clusters, and their scaling.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/term.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Rows are samples, row-major so that a sample is contiguous.
using SampleMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// All pairs i before j of the named thermometers: 28 for A…H.
[[nodiscard]] std::vector<Term> all_gradients(const std::vector<std::string>& names);

/// Clusters × terms, unscaled. Fails with usage if a thermometer is not in the clusters.
[[nodiscard]] Result<SampleMatrix> evaluate(const std::vector<Term>& terms, const Clusters& clusters);

/// Rank of the terms as polynomials of the temperatures and their rates (13 gradients that contain all of A have rank
/// 7).
[[nodiscard]] int rank_of(const std::vector<Term>& terms);

/// Zero mean and unit STD on the data it was fitted to.
struct Scaling {
  Eigen::RowVectorXd mean;
  Eigen::RowVectorXd std;
};
/// Fails with usage, naming the term, if a column does not vary.
[[nodiscard]] Result<Scaling> fit_scaling(const SampleMatrix& values, const std::vector<Term>& terms);
[[nodiscard]] SampleMatrix apply(const Scaling& scaling, const SampleMatrix& values);

}  // namespace gyrotherm
