// SPDX-License-Identifier: Apache-2.0
/// The file of a type prior. One description serves both writing and reading.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "analysis/population/type_prior.hpp"
#include "core/json.hpp"

namespace gyrotherm::population {
namespace {

/// One term with its scaling and its prior, grouped for readers of the file.
struct PriorTerm {
  data::Term term;
  double mean{}, std{}, min{}, max{};
  double slope_deg_per_h_per_std{}, slope_std{};
};

void describe(auto& form, Like<PriorTerm> auto& term) {
  describe(form, term.term);
  form("mean", term.mean);
  form("std", positive(term.std));
  form("min", term.min);
  form("max", term.max);
  form.expect("max", term.max >= term.min, "expected no less than min");
  form("slope_deg_per_h_per_std", term.slope_deg_per_h_per_std);
  form.derived("slope_uncertainty_deg_per_h_per_std", term.slope_std);
}

std::vector<PriorTerm> to_prior_terms(const TypePrior& prior) {
  std::vector<PriorTerm> terms;
  for (std::size_t k = 0; k < prior.terms.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double variance = prior.next_unit.covariance(i + 1, i + 1);
    terms.push_back({prior.terms[k], prior.scaling.mean(i), prior.scaling.std(i), prior.input_min(i),
                     prior.input_max(i), prior.next_unit.mean(i + 1), std::sqrt(std::max(0.0, variance))});
  }
  return terms;
}

void take_terms(const std::vector<PriorTerm>& terms, double constant, TypePrior& prior) {
  const auto count = static_cast<Eigen::Index>(terms.size());
  for (auto* row : {&prior.scaling.mean, &prior.scaling.std, &prior.input_min, &prior.input_max}) row->resize(count);
  prior.next_unit.mean.resize(count + 1);
  prior.next_unit.mean(0) = constant;
  for (Eigen::Index i = 0; i < count; ++i) {
    const PriorTerm& term = terms[static_cast<std::size_t>(i)];
    prior.terms.push_back(term.term);
    prior.scaling.mean(i) = term.mean;
    prior.scaling.std(i) = term.std;
    prior.input_min(i) = term.min;
    prior.input_max(i) = term.max;
    prior.next_unit.mean(i + 1) = term.slope_deg_per_h_per_std;
  }
}

using RowsOfNumbers = std::vector<std::vector<double>>;

RowsOfNumbers covariance_rows(const Eigen::MatrixXd& covariance) {
  RowsOfNumbers rows;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    const Eigen::RowVectorXd row = covariance.row(i);
    rows.emplace_back(row.begin(), row.end());
  }
  return rows;
}

/// Returns the matrix, or an empty one if the rows are not a covariance of this size.
Eigen::MatrixXd parse_covariance(const RowsOfNumbers& rows, std::size_t coefficients) {
  const auto count = static_cast<Eigen::Index>(coefficients);
  Eigen::MatrixXd covariance(count, count);
  if (rows.size() != coefficients) return {};
  for (std::size_t i = 0; i < coefficients; ++i) {
    if (rows[i].size() != coefficients) return {};
    covariance.row(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::RowVectorXd>(rows[i].data(), count);
  }
  constexpr double kRounding = 1e-9;
  if (!covariance.isApprox(covariance.transpose(), kRounding)) return {};
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance, Eigen::EigenvaluesOnly);
  const Eigen::VectorXd values = eigen.eigenvalues();
  if (!(values.minCoeff() >= -kRounding * values.cwiseAbs().maxCoeff())) return {};
  return covariance;
}

}  // namespace

void describe(auto& form, Like<UnexplainedNoise> auto& noise) {
  form("white_deg_per_h", positive(noise.white_deg_per_h));
  form("wander_deg_per_h", not_negative(noise.wander_deg_per_h));
  form("wander_time_s", positive(noise.wander_time_s));
  form("turn_on_deg_per_h", not_negative(noise.turn_on_deg_per_h));
}

void describe(auto& form, Like<PriorRecord> auto& record) {
  form("name", record.name);
  form("run_id", record.run_id);
  form.if_present("unit", !record.unit.empty(), record.unit);
  form.if_present("axis", !record.axis.empty(), record.axis);
  form.if_present("identity", !record.identity.empty(), record.identity);
  form.if_present("bias_zero", !record.bias_zero.empty(), record.bias_zero);
}

void describe(auto& form, Like<TypePrior> auto& prior) {
  constexpr bool kReads = !std::is_const_v<std::remove_reference_t<decltype(prior)>>;
  constexpr double kLongestClusterS = 86400;
  form.derived("schema", kTypePriorSchema);
  form("type", prior.type);
  form("units", prior.units);
  form.if_present("records", !prior.records.empty(), prior.records);
  form("simulated", prior.simulated);
  form("cluster_length_s", positive(prior.cluster_length_s, kLongestClusterS));
  form("noise", prior.noise);
  double constant = prior.next_unit.mean.size() > 0 ? prior.next_unit.mean(0) : 0;
  form("constant_deg_per_h", constant);
  auto terms = to_prior_terms(prior);
  form("terms", terms);
  form.expect("terms", !terms.empty(), "expected at least one term");
  form("correlations_worth_units", not_negative(prior.correlations_worth_units));
  auto rows = covariance_rows(prior.next_unit.covariance);
  auto spread = covariance_rows(prior.term_spread), errors = covariance_rows(prior.error_covariance);
  form("covariance_deg2_per_h2", rows);
  form("term_spread", spread);
  form("error_covariance", errors);
  if constexpr (kReads) {
    take_terms(terms, constant, prior);
    prior.next_unit.covariance = parse_covariance(rows, terms.size() + 1);
    prior.term_spread = parse_covariance(spread, terms.size());
    prior.error_covariance = parse_covariance(errors, terms.size());
  }
  const auto count = static_cast<Eigen::Index>(terms.size());
  form.expect("covariance_deg2_per_h2", prior.next_unit.covariance.rows() == count + 1,
              "expected the covariance of the constant and the terms' slopes");
  form.expect("term_spread", prior.term_spread.rows() == count, "expected a covariance of the terms");
  form.expect("error_covariance", prior.error_covariance.rows() == count, "expected a covariance of the terms");
}

std::string to_json(const TypePrior& prior) { return gyrotherm::json_text(make_json(prior), 1) + "\n"; }

Result<TypePrior> type_prior_from_json(std::string_view json, const std::string& file) {
  const auto root = JsonNode::parse(json, file, JsonNode::Nulls::are_errors);
  if (!root) return failure(root.error());
  const JsonNode schema = (*root)["schema"];
  if (schema.text() != kTypePriorSchema)
    schema.note_error(fmt::format("\"{}\", expected \"{}\"", schema.text(), kTypePriorSchema));
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  TypePrior prior;
  read_json(*root, prior);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return prior;
}

}  // namespace gyrotherm::population
