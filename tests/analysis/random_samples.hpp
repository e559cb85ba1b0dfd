// SPDX-License-Identifier: Apache-2.0
/// Random samples with fixed seeds for tests of the regression methods.
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "analysis/methods/method.hpp"

namespace gyrotherm::data {

[[nodiscard]] inline SampleMatrix normal_matrix(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  return SampleMatrix::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

[[nodiscard]] inline Eigen::VectorXd normal_vector(Eigen::Index size, std::uint64_t seed) {
  return normal_matrix(size, 1, seed).col(0);
}

/// Returns the temperature terms A, B, C, ….
[[nodiscard]] inline std::vector<Term> letters(Eigen::Index count) {
  std::vector<Term> terms;
  for (Eigen::Index j = 0; j < count; ++j)
    terms.push_back(temperature_term(std::string(1, static_cast<char>('A' + j))));
  return terms;
}

/// Owns the samples to which a FitInput refers.
struct Samples {
  SampleMatrix x;
  Eigen::VectorXd y;
  std::vector<Term> terms;
  [[nodiscard]] methods::FitInput set() const { return {x, y, terms}; }
};

/// Returns samples whose y is a smooth non-linear function of the first two inputs, plus noise.
[[nodiscard]] inline Samples bent_samples(Eigen::Index rows, Eigen::Index columns, double noise, std::uint64_t seed) {
  Samples samples{normal_matrix(rows, columns, seed), {}, letters(columns)};
  samples.y = samples.x.col(0).array().tanh() + 0.5 * samples.x.col(0).array() * samples.x.col(1).array() +
              noise * normal_vector(rows, seed + 1000).array();
  return samples;
}

/// Returns samples with little noise whose y is curved in the first two inputs and steep in the third.
[[nodiscard]] inline Samples bent_plane(Eigen::Index rows, std::uint64_t seed) {
  Samples samples = bent_samples(rows, 3, 0.05, seed);
  samples.y += 4 * samples.x.col(2);
  return samples;
}

/// Splits samples into folds. Each sample is held out once.
[[nodiscard]] inline std::vector<methods::Fold> folds_of(const Samples& samples, Eigen::Index count) {
  std::vector<methods::Fold> folds;
  for (Eigen::Index f = 0; f < count; ++f) {
    std::vector<Eigen::Index> inside, outside;
    for (Eigen::Index i = 0; i < samples.y.size(); ++i)
      (i * count / samples.y.size() == f ? inside : outside).push_back(i);
    folds.push_back({{.train_x = samples.x(outside, Eigen::all),
                      .train_y = samples.y(outside),
                      .test_x = samples.x(inside, Eigen::all),
                      .test_y = samples.y(inside),
                      .target_scale = 1},
                     samples.terms});
  }
  return folds;
}

}  // namespace gyrotherm::data
