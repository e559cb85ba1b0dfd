// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/voting.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>

#include "analysis/data/statistics.hpp"
#include "core/number_text.hpp"

namespace gyrotherm::fusion {
namespace {

/// Formats a finding: "consistent (χ² 3.1 of 5, limit 36.2)".
std::string describe(const Finding& finding) {
  if (finding.freedom == 0) return "not tested";
  return fmt::format("{} (χ² {:.3g} of {}, limit {:.3g})", finding.fault ? "inconsistent" : "consistent",
                     finding.statistic, finding.freedom, finding.limit);
}

std::string candidate_names(const FaultTest& test, const Isolation& isolation) {
  std::string names = test.candidates[static_cast<std::size_t>(isolation.likeliest)];
  for (const Eigen::Index rival : isolation.rivals) names += ", " + test.candidates[static_cast<std::size_t>(rival)];
  return names;
}

/// Returns true if the likeliest candidate and all its rivals are of the same kind.
bool are_one_kind(const Isolation& isolation, Eigen::Index axes) {
  const bool axis = isolation.likeliest < axes;
  return std::ranges::all_of(isolation.rivals, [&](Eigen::Index rival) { return (rival < axes) == axis; });
}

std::string make_reason(const Verdict& verdict, const FaultTest& test) {
  const std::string parts =
      fmt::format("axes {}, thermometers {}", describe(verdict.of_axes), describe(verdict.of_thermometers));
  if (!verdict.joint.fault) return parts;
  if (!verdict.joint.isolation) return parts + "; no known fault explains it";
  const Isolation& isolation = *verdict.joint.isolation;
  const char* unit = verdict.kind == VerdictKind::broken_thermometer ? "K" : "°/h";
  if (!verdict.who.empty())
    return fmt::format("{} is off by {} {} (k = 1), ahead of any other explanation by {:.3g}: {}", verdict.who,
                       format_with_error(verdict.size, verdict.size_std), unit, isolation.margin, parts);
  if (!isolation.explains)
    return fmt::format("no single fault explains it; the best candidate is {}, with a residual χ² of {:.3g}: {}",
                       test.candidates[static_cast<std::size_t>(isolation.likeliest)], isolation.left, parts);
  return fmt::format("one of {}, not distinguishable: {}", candidate_names(test, isolation), parts);
}

}  // namespace

Result<ThermometerParity> learn_thermometer_parity(const Eigen::Ref<const Eigen::MatrixXd>& temperature_c,
                                                   const std::vector<std::string>& names,
                                                   const Eigen::Ref<const Eigen::VectorXd>& uncertainty_k, int modes) {
  constexpr int kRowsOfEach = 10, kLeastLeft = 2;
  const auto refuse = [](std::string what) {
    return failure(FaultKind::usage, "agreement of thermometers", std::move(what));
  };
  const Eigen::Index count = temperature_c.cols();
  if (static_cast<Eigen::Index>(names.size()) != count || uncertainty_k.size() != count)
    return refuse(
        fmt::format("{} names and {} uncertainties for {} thermometers", names.size(), uncertainty_k.size(), count));
  if (modes < 1 || count - modes < kLeastLeft)
    return refuse(fmt::format("{} thermometers with {} common modes, expected at least {} more thermometers than modes",
                              count, modes, kLeastLeft));
  if (!(uncertainty_k.minCoeff() > 0) || !uncertainty_k.allFinite())
    return refuse("the uncertainty of a thermometer is not above 0");
  const std::vector<Eigen::Index> rows = data::finite_rows(temperature_c);
  if (static_cast<Eigen::Index>(rows.size()) < kRowsOfEach * count)
    return refuse(fmt::format("{} rows are complete, at least {} are needed", rows.size(), kRowsOfEach * count));
  const Eigen::MatrixXd known = temperature_c(rows, Eigen::all);
  const Eigen::RowVectorXd mean = known.colwise().mean();
  const Eigen::MatrixXd centred = known.rowwise() - mean;
  Eigen::MatrixXd covariance = centred.transpose() * centred / static_cast<double>(rows.size() - 1);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> components(covariance);
  const Eigen::MatrixXd others = components.eigenvectors().leftCols(count - modes).transpose();
  covariance.diagonal() += uncertainty_k.cwiseAbs2();
  const Eigen::MatrixXd spread = others * covariance * others.transpose();
  return ThermometerParity{.names = names, .mean_c = mean, .whitening = spread.llt().matrixL().solve(others)};
}

const char* name(VerdictKind kind) {
  return enumerator_text<VerdictKind::undecided>({"accord", "gyro_hop", "broken_thermometer", "undecided"}, kind);
}

FaultTest joint_test(const Voters& voters) {
  const Eigen::MatrixXd& of_axes = voters.whitening;
  const Eigen::MatrixXd& of_thermometers = voters.thermometers.whitening;
  assert(voters.sensitivity_deg_per_h_per_k.rows() == of_axes.cols());
  assert(voters.sensitivity_deg_per_h_per_k.cols() == of_thermometers.cols());
  FaultTest test{.candidates = voters.axes,
                 .effects = Eigen::MatrixXd::Zero(of_axes.rows() + of_thermometers.rows(),
                                                  of_axes.cols() + of_thermometers.cols())};
  test.candidates.insert(test.candidates.end(), voters.thermometers.names.begin(), voters.thermometers.names.end());
  test.effects.topLeftCorner(of_axes.rows(), of_axes.cols()) = of_axes;
  test.effects.topRightCorner(of_axes.rows(), of_thermometers.cols()) = -of_axes * voters.sensitivity_deg_per_h_per_k;
  test.effects.bottomRightCorner(of_thermometers.rows(), of_thermometers.cols()) = of_thermometers;
  return test;
}

Verdict vote(const Voters& voters, const Eigen::Ref<const Eigen::VectorXd>& departures_deg_per_h,
             const Eigen::Ref<const Eigen::RowVectorXd>& temperature_c, const TestOptions& options) {
  const FaultTest test = joint_test(voters);
  Eigen::VectorXd vector(test.degrees_of_freedom());
  vector << voters.whitening * departures_deg_per_h, voters.thermometers.vector(temperature_c);
  Verdict verdict{.joint = examine(test, vector, options),
                  .of_axes = examine({voters.axes, voters.whitening}, vector.head(voters.whitening.rows()), options),
                  .of_thermometers =
                      examine(voters.thermometers.test(), vector.tail(voters.thermometers.whitening.rows()), options)};
  if (verdict.joint.fault) {
    const auto axes = static_cast<Eigen::Index>(voters.axes.size());
    const auto& isolation = verdict.joint.isolation;
    const bool decided = isolation && isolation->explains && are_one_kind(*isolation, axes);
    verdict.kind = !decided                      ? VerdictKind::undecided
                   : isolation->likeliest < axes ? VerdictKind::gyro_hop
                                                 : VerdictKind::broken_thermometer;
    if (isolation && isolation->candidate) {
      verdict.who = test.candidates[static_cast<std::size_t>(*isolation->candidate)];
      verdict.size = isolation->size;
      verdict.size_std = isolation->size_std;
    }
  }
  verdict.reason = make_reason(verdict, test);
  return verdict;
}

}  // namespace gyrotherm::fusion
