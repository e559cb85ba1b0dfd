// SPDX-License-Identifier: Apache-2.0
/// Writes the fusion of a fixture's axes as C for a navigation computer, with its gains as constants.
#include <fmt/format.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "analysis/data/distributions.hpp"
#include "analysis/fusion/rate_fusion.hpp"
#include "analysis/model/model_export.hpp"
#include "core/random.hpp"

namespace gyrotherm::model {
namespace {

constexpr const char* kFusionHeader =
    R"(/* Computes the rate vector of @axes@ gyros on one fixture by generalised least squares and detects
   contradictions between them. Order of the gyros: @order@. */
#ifndef @name@_H
#define @name@_H

#ifdef __cplusplus
extern "C" {
#endif

#define @name@_AXES @axes@
@parity_numbers@
/* Return value of each function: 0, or one of these. */
#define @name@_CONTRADICTION 1 /* the axes contradict each other by more than the limit */
#define @name@_MISSING 2       /* a reading was not finite: no fusion, the rate is 0 */
#define @name@_ALONE 4         /* no other axis measures this component: no fusion, the rate is 0 */

/* Covariance of the rate vector, (deg/h)^2, for the stated uncertainty of the readings. */
extern const double @name@_covariance[3][3];

/* Computes the rate vector in the axes of the fixture from one compensated reading per axis, both in deg/h, and the
   squared norm of the parity vector (statistic). */
int @name@_fuse(const double reading[@name@_AXES], double rate[3], double *statistic);

@parity_declarations@/* Fuses known readings. Returns 0 if all results are as expected, else 1. */
int @name@_self_test(void);

#ifdef __cplusplus
}
#endif

#endif
)";

constexpr const char* kParityNumbers =
    R"(#define @name@_PARITIES @parities@ /* components of the parity vector */
#define @name@_LIMIT @limit@ /* limit of their squared norm; false-alarm probability @probability@ */
)";

constexpr const char* kParityDeclarations =
    R"(/* Returns the axis whose fault explains the contradiction of these readings, and its bias in deg/h. Returns -1
   and bias 0 without a contradiction, if no single axis explains it, or if another axis explains it nearly as well. */
int @name@_suspect(const double reading[@name@_AXES], double *bias);

/* Fuses like @name@_fuse, but without the axis of this index (from 0). Its reading must be finite but is ignored. */
int @name@_fuse_without(const double reading[@name@_AXES], int axis, double rate[3]);

)";

constexpr const char* kFusionSource = R"(#include "@name@.h"

#include <float.h>
#include <math.h>

#if DBL_MANT_DIG < 53
#error "@name@ needs a 64-bit double; with a shorter double, as on AVR, the self-test fails"
#endif

static const double gain[3][@name@_AXES] = {@gain@};
@parity_constants@
const double @name@_covariance[3][3] = {@covariance@};

static int known(const double reading[@name@_AXES]) {
  for (int i = 0; i < @name@_AXES; ++i)
    if (!isfinite(reading[i])) return 0;
  return 1;
}

@parity_functions@int @name@_fuse(const double reading[@name@_AXES], double rate[3], double *statistic) {
  const int all = known(reading);
  *statistic = 0.0;
  for (int k = 0; k < 3; ++k) {
    rate[k] = 0.0;
    for (int i = 0; all && i < @name@_AXES; ++i) rate[k] += gain[k][i] * reading[i];
  }
  if (!all) return @name@_MISSING;
@parity_of_fuse@  return 0;
}

@suspect@static const double test_reading[][@name@_AXES] = {@test_readings@};
static const double test_rate[][3] = {@test_rates@};
static const double test_statistic[] = {@test_statistics@};

int @name@_self_test(void) {
  for (int i = 0; i < (int)(sizeof test_statistic / sizeof test_statistic[0]); ++i) {
    double rate[3], statistic;
    if (@name@_fuse(test_reading[i], rate, &statistic) == @name@_MISSING) return 1;
    for (int k = 0; k < 3; ++k)
      if (!(fabs(rate[k] - test_rate[i][k]) <= @rate_tolerance@)) return 1;
    if (!(fabs(statistic - test_statistic[i]) <= @statistic_tolerance@)) return 1;
  }
  return 0;
}
)";

constexpr const char* kParityConstants = R"(static const double parity[@name@_PARITIES][@name@_AXES] = {@parity@};
static const double square[@name@_AXES] = {@squares@}; /* squared norm of each parity column; 0: no redundancy */
)";

constexpr const char* kParityFunctions =
    R"(static double parity_of(const double reading[@name@_AXES], double vector[@name@_PARITIES]) {
  double sum = 0.0;
  for (int k = 0; k < @name@_PARITIES; ++k) {
    vector[k] = 0.0;
    for (int i = 0; i < @name@_AXES; ++i) vector[k] += parity[k][i] * reading[i];
    sum += vector[k] * vector[k];
  }
  return sum;
}

static double bias_of(const double vector[@name@_PARITIES], int axis) {
  double along = 0.0;
  for (int k = 0; k < @name@_PARITIES; ++k) along += parity[k][axis] * vector[k];
  return along / square[axis];
}

)";

constexpr const char* kParityOfFuse = R"(  double vector[@name@_PARITIES];
  *statistic = parity_of(reading, vector);
  if (*statistic > @name@_LIMIT) return @name@_CONTRADICTION;
)";

constexpr const char* kSuspectFunction = R"(int @name@_suspect(const double reading[@name@_AXES], double *bias) {
  double vector[@name@_PARITIES], first = -1.0, second = -1.0;
  int suspect = -1;
  *bias = 0.0;
  if (!known(reading)) return -1;
  const double statistic = parity_of(reading, vector);
  if (!(statistic > @name@_LIMIT)) return -1;
  for (int i = 0; i < @name@_AXES; ++i) {
    if (square[i] == 0.0) continue;
    const double size = bias_of(vector, i), taken = size * size * square[i];
    if (taken > first) {
      second = first;
      first = taken;
      suspect = i;
    } else if (taken > second) {
      second = taken;
    }
  }
  if (suspect < 0 || (second >= 0.0 && first - second < @margin@) || statistic - first > @limit_left@) return -1;
  *bias = bias_of(vector, suspect);
  return suspect;
}

int @name@_fuse_without(const double reading[@name@_AXES], int axis, double rate[3]) {
  double vector[@name@_PARITIES], statistic;
  const int result = @name@_fuse(reading, rate, &statistic);
  if (result == @name@_MISSING) return result;
  if (square[axis] == 0.0) {
    for (int k = 0; k < 3; ++k) rate[k] = 0.0;
    return @name@_ALONE;
  }
  parity_of(reading, vector);
  for (int k = 0; k < 3; ++k) rate[k] -= gain[k][axis] * bias_of(vector, axis);
  return 0;
}

)";

std::string c_rows(const Eigen::MatrixXd& matrix) {
  std::vector<std::string> rows;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) rows.push_back("\n    {" + c_list(matrix.row(i).transpose()) + "}");
  return fmt::format("{}", fmt::join(rows, ","));
}

/// Returns the squared norm of each column of V; 0 where fuse_without_axis() would fail.
Eigen::RowVectorXd column_squares(const fusion::Gains& gains) {
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(gains.rate.cols());
  Eigen::RowVectorXd squares(gains.rate.cols());
  for (Eigen::Index i = 0; i < squares.size(); ++i)
    squares(i) = fuse_without_axis(gains, nothing, i) ? gains.parity.col(i).squaredNorm() : 0;
  return squares;
}

/// A few readings of tens of °/h, with errors of about the stated uncertainty, and the results of their fusion.
struct KnownFusion {
  Eigen::MatrixXd readings, rates;  ///< one row per reading
  Eigen::RowVectorXd statistics;
};
KnownFusion known_fusion(const fusion::Geometry& geometry, const fusion::Gains& gains) {
  constexpr Eigen::Index kTestReadings = 5;
  constexpr double kRate_deg_per_h = 20;
  std::mt19937_64 random(1);
  const auto between = [&](double most) { return most * (2 * uniform(random) - 1); };
  KnownFusion known{.readings = Eigen::MatrixXd(kTestReadings, geometry.axes()),
                    .rates = Eigen::MatrixXd(kTestReadings, 3),
                    .statistics = Eigen::RowVectorXd(kTestReadings)};
  for (Eigen::Index n = 0; n < kTestReadings; ++n) {
    const Eigen::Vector3d rate(between(kRate_deg_per_h), between(kRate_deg_per_h), between(kRate_deg_per_h));
    Eigen::VectorXd reading = geometry.directions * rate;
    for (Eigen::Index i = 0; i < reading.size(); ++i) reading(i) += between(3 * std::sqrt(geometry.covariance(i, i)));
    known.readings.row(n) = reading;
    known.rates.row(n) = gains.rate * reading;
    known.statistics(n) = (gains.parity * reading).squaredNorm();
  }
  return known;
}

/// Bounds on the rounding errors of sums of N products in double, with a safety factor of 100.
struct Tolerances {
  double rate{}, statistic{};
};
Tolerances find_tolerances(const fusion::Gains& gains, const KnownFusion& known) {
  constexpr double kRelativeTolerance = 1e-14;
  const double reading = known.readings.cwiseAbs().maxCoeff(), axes = static_cast<double>(known.readings.cols());
  if (gains.parity.rows() == 0)
    return {kRelativeTolerance * axes * reading * gains.rate.cwiseAbs().maxCoeff(), kRelativeTolerance};
  const double parity = axes * reading * gains.parity.cwiseAbs().maxCoeff();
  return {kRelativeTolerance * axes * reading * gains.rate.cwiseAbs().maxCoeff(),
          kRelativeTolerance * parity * (1 + std::sqrt(known.statistics.maxCoeff())) *
              static_cast<double>(gains.parity.rows())};
}

}  // namespace

Result<CProgram> fusion_to_c(const fusion::Geometry& geometry, std::string_view name,
                             const fusion::TestOptions& options, const std::optional<fusion::Geometry>& weights) {
  if (const auto usable = check_c_name(name); !usable) return failure(usable.error());
  const fusion::Gains gains = weights ? weighted_gains(geometry, *weights) : compute_gains(geometry);
  const int parities = static_cast<int>(gains.parity.rows());
  const auto limit = [&](int freedom) {
    return freedom < 1 ? "HUGE_VAL" : c_number(data::chi_squared_limit(options.false_alarm_probability, freedom));
  };
  const KnownFusion known = known_fusion(geometry, gains);
  const Tolerances tolerances = find_tolerances(gains, known);
  CPlaceholders placeholders = {{"name", std::string(name)},
                                {"axes", fmt::format("{}", geometry.axes())},
                                {"order", c_comment(fmt::format("{}", fmt::join(geometry.names, ", ")))},
                                {"parities", fmt::format("{}", parities)},
                                {"limit", limit(parities)},
                                {"limit_left", limit(parities - 1)},
                                {"probability", fmt::format("{:.3g}", options.false_alarm_probability)},
                                {"margin", c_number(options.margin)},
                                {"gain", c_rows(gains.rate)},
                                {"covariance", c_rows(gains.covariance)},
                                {"parity", c_rows(gains.parity)},
                                {"squares", c_list(column_squares(gains).transpose())},
                                {"test_readings", c_rows(known.readings)},
                                {"test_rates", c_rows(known.rates)},
                                {"test_statistics", c_list(known.statistics.transpose())},
                                {"rate_tolerance", c_number(tolerances.rate)},
                                {"statistic_tolerance", c_number(tolerances.statistic)}};
  for (const auto& [key, text] : {std::pair{"parity_numbers", kParityNumbers},
                                  {"parity_declarations", kParityDeclarations},
                                  {"parity_constants", kParityConstants},
                                  {"parity_functions", kParityFunctions},
                                  {"parity_of_fuse", kParityOfFuse},
                                  {"suspect", kSuspectFunction}})
    placeholders[key] = parities > 0 ? c_fill(text, placeholders) : "";
  return CProgram{.header = c_fill(kFusionHeader, placeholders), .source = c_fill(kFusionSource, placeholders)};
}

}  // namespace gyrotherm::model
