// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/voting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "core/result.hpp"

namespace gyrotherm::fusion {
namespace {

/// "in accord (χ² 3.1 of 5, limit 36.2)"
std::string describe(const Finding& finding) {
  if (finding.freedom == 0) return "not seen against each other";
  return fmt::format("{} (χ² {:.3g} of {}, limit {:.3g})", finding.fault ? "at odds" : "in accord", finding.statistic,
                     finding.freedom, finding.limit);
}

std::string names_of(const FaultTest& test, const Isolation& isolation) {
  std::string names = test.candidates[static_cast<std::size_t>(isolation.likeliest)];
  for (const Eigen::Index rival : isolation.rivals) names += ", " + test.candidates[static_cast<std::size_t>(rival)];
  return names;
}

/// Whether the likeliest and all its rivals are of one kind.
bool of_one_kind(const Isolation& isolation, Eigen::Index axes) {
  const bool axis = isolation.likeliest < axes;
  return std::ranges::all_of(isolation.rivals, [&](Eigen::Index rival) { return (rival < axes) == axis; });
}

std::string reason_of(const Verdict& verdict, const FaultTest& test) {
  const std::string parts =
      fmt::format("axes {}, thermometers {}", describe(verdict.of_axes), describe(verdict.of_thermometers));
  if (!verdict.joint.fault) return parts;
  if (!verdict.joint.isolation) return parts + "; nothing that is known explains it";
  const Isolation& isolation = *verdict.joint.isolation;
  const char* unit = verdict.kind == VerdictKind::broken_thermometer ? "K" : "°/h";
  if (!verdict.who.empty())
    return fmt::format("{} is off by {:.3g} ± {:.2g} {} (k = 1), ahead of any other explanation by {:.3g}: {}",
                       verdict.who, verdict.size, verdict.size_std, unit, isolation.margin, parts);
  if (!isolation.explains)
    return fmt::format("no fault of one alone explains it, {} least badly, which leaves χ² {:.3g}: {}",
                       test.candidates[static_cast<std::size_t>(isolation.likeliest)], isolation.left, parts);
  return fmt::format("one of {}, which cannot be told apart: {}", names_of(test, isolation), parts);
}

}  // namespace

const char* name(VerdictKind kind) {
  return word_in<VerdictKind::undecided>({"accord", "gyro_hop", "broken_thermometer", "undecided"}, kind);
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
  Eigen::VectorXd vector(test.freedom());
  vector << voters.whitening * departures_deg_per_h, voters.thermometers.vector(temperature_c);
  Verdict verdict{.joint = examine(test, vector, options),
                  .of_axes = examine({voters.axes, voters.whitening}, vector.head(voters.whitening.rows()), options),
                  .of_thermometers =
                      examine(voters.thermometers.test(), vector.tail(voters.thermometers.whitening.rows()), options)};
  if (verdict.joint.fault) {
    const auto axes = static_cast<Eigen::Index>(voters.axes.size());
    const auto& isolation = verdict.joint.isolation;
    const bool decided = isolation && isolation->explains && of_one_kind(*isolation, axes);
    verdict.kind = !decided                      ? VerdictKind::undecided
                   : isolation->likeliest < axes ? VerdictKind::gyro_hop
                                                 : VerdictKind::broken_thermometer;
    if (isolation && isolation->candidate) {
      verdict.who = test.candidates[static_cast<std::size_t>(*isolation->candidate)];
      verdict.size = isolation->size;
      verdict.size_std = isolation->size_std;
    }
  }
  verdict.reason = reason_of(verdict, test);
  return verdict;
}

}  // namespace gyrotherm::fusion
