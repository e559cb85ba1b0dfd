// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/model_export.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "analysis/model/export_parts.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::model {
namespace {

constexpr const char* kHeader = R"(/*
@provenance@ */
#ifndef @name@_H
#define @name@_H

#ifdef __cplusplus
extern "C" {
#endif

#define @name@_THERMOMETERS @thermometers@
#define @name@_SECONDS @seconds@
@lag_count@
/* Return value of each function: 0, or a sum of these. */
#define @name@_OUTSIDE 1 /* an input was outside the trained range: the plane is extrapolated, other parts bounded */
#define @name@_MISSING 2 /* a reading was not finite: no prediction, the bias is 0 */
#define @name@_NOT_YET 4 /* too few readings so far: no prediction, the bias is 0 */

/* Predicts the bias at these temperatures, in degrees per hour. Subtract it from the rate of the gyro. mean_c: means
   of the thermometers over the last @name@_SECONDS seconds; before_c: means over the same time before that@before@.
   Both are in degrees Celsius, in this order: @order@.@lag_order@ */
int @name@_predict(const double mean_c[@name@_THERMOMETERS], const double before_c[@name@_THERMOMETERS],
    @lag_parameter@double *bias_deg_per_h);

/* Returns the largest excess of an input over its trained range, as a fraction of that range; 0 inside. */
double @name@_excess(const double mean_c[@name@_THERMOMETERS],
    const double before_c[@name@_THERMOMETERS]@lag_last@);

/* Predicts from one reading per second. The stream contains the whole state of a gyro; @latency@ */
typedef struct {
  double block[@name@_SECONDS][@name@_THERMOMETERS];    /* readings of this block of seconds */
  double ends[@name@_SECONDS + 1][@name@_THERMOMETERS]; /* sums of the previous block, from each second to its end */
  double begun[@name@_THERMOMETERS];                    /* sum of this block so far */
@past@@past_biases@@lag_ring@  int at;                                               /* seconds in this block */
  int known;                                            /* seconds so far, at most the number needed */
  double excess;                                        /* excess of the last predicted second */
} @name@_stream;

void @name@_start(@name@_stream *stream);
int @name@_push(@name@_stream *stream, const double temperature_c[@name@_THERMOMETERS], double *bias_deg_per_h);

@uncertainty@@tracking@/* Predicts for known temperatures. Returns 0 if all results are as expected, else 1. */
int @name@_self_test(void);

#ifdef __cplusplus
}
#endif

#endif
)";

constexpr const char* kSource = R"(#include "@name@.h"

#include <float.h>
#include <math.h>
#if DBL_MANT_DIG < 53
#error "@name@ needs a 64-bit double; with a shorter double, as on AVR, the self-test fails"
#endif

#define INPUTS @inputs@

/* Trained range of each input, and its mean and standard deviation in training. */
@low@@high@@mean@@deviation@
/* Computes f(z). z: the inputs minus their means, in standard deviations. */
@function@
static void inputs_of(const double t[], const double before[], @lag_input@double x[]) {
@terms@}

/* Returns the largest excess of an input, as a fraction of its range. Ignores the rounding of a mean. */
static double excess_of(const double x[]) {
  double worst = 0.0;
  for (int k = 0; k < INPUTS; ++k) {
    const double range = high[k] - low[k];
    const double beyond = low[k] - x[k] > x[k] - high[k] ? low[k] - x[k] : x[k] - high[k];
    if (beyond > 1e-9 * range && beyond / range > worst) worst = beyond / range;
  }
  return worst;
}
@bounding@

int @name@_predict(const double mean_c[@name@_THERMOMETERS], const double before_c[@name@_THERMOMETERS],
    @lag_parameter@double *bias_deg_per_h) {
  double x[INPUTS], bounded[INPUTS];
  int outside;
  *bias_deg_per_h = 0.0;
  inputs_of(mean_c, before_c, @lag_argument@x);
  for (int k = 0; k < INPUTS; ++k) {
    if (!isfinite(x[k])) return @name@_MISSING;
  }
  outside = excess_of(x) > 0.0 ? @name@_OUTSIDE : 0;
  for (int k = 0; k < INPUTS; ++k) bounded[k] = x[k];
@bound@  for (int k = 0; k < INPUTS; ++k) {
    x[k] = (x[k] - mean[k]) / deviation[k];
    bounded[k] = (bounded[k] - mean[k]) / deviation[k];
  }
  *bias_deg_per_h = function_of(x, bounded) * @target_std@ + @target_mean@;
  return outside;
}

double @name@_excess(const double mean_c[@name@_THERMOMETERS],
    const double before_c[@name@_THERMOMETERS]@lag_last@) {
  double x[INPUTS];
  inputs_of(mean_c, before_c, @lag_argument@x);
  return excess_of(x);
}

void @name@_start(@name@_stream *stream) {
  for (int j = 0; j < @name@_THERMOMETERS; ++j) {
    for (int i = 0; i <= @name@_SECONDS; ++i) stream->ends[i][j] = 0.0;
    stream->begun[j] = 0.0;
  }
@lag_start@  stream->at = 0;
  stream->known = 0;
  stream->excess = 0.0;
@lead_start@}
@lags_of@
/* Adds a reading. A window is the end of the previous block and the start of this one. Nothing is ever subtracted
   from a sum. Sums therefore do not drift, and a non-finite reading has no effect after its window. */
int @name@_push(@name@_stream *stream, const double temperature_c[@name@_THERMOMETERS], double *bias_deg_per_h) {
  const int at = stream->at;
  double means[@name@_THERMOMETERS];
  int result = @name@_NOT_YET;
  *bias_deg_per_h = 0.0;
  for (int j = 0; j < @name@_THERMOMETERS; ++j) {
    stream->block[at][j] = temperature_c[j];
    stream->begun[j] += temperature_c[j];
    means[j] = (stream->begun[j] + stream->ends[at + 1][j]) / @name@_SECONDS;
  }
  if (stream->known < @windows@ * @name@_SECONDS) ++stream->known;
@lag_push@  if (stream->known == @windows@ * @name@_SECONDS) {
    result = @name@_predict(means, @before_means@, @lag_pushed@bias_deg_per_h);
    stream->excess = result == @name@_OUTSIDE ? @name@_excess(means, @before_means@@lag_pushed_last@) : 0.0;
  }
@lead@@keep@  stream->at = at + 1;
  if (stream->at < @name@_SECONDS) return result;
  for (int j = 0; j < @name@_THERMOMETERS; ++j) {
    stream->ends[@name@_SECONDS][j] = 0.0;
    for (int i = @name@_SECONDS - 1; i >= 0; --i) {
      stream->ends[i][j] = stream->ends[i + 1][j] + stream->block[i][j];
    }
    stream->begun[j] = 0.0;
  }
  stream->at = 0;
  return result;
}

@uncertainty@@tracking@@test_mean@@test_before@@test_lag@@test_bias@static const int test_result[] = {@test_result@};

int @name@_self_test(void) {
@test_uncertainty@  for (int i = 0; i < (int)(sizeof test_result / sizeof test_result[0]); ++i) {
    double bias;
    if (@name@_predict(test_mean[i], test_before[i], @lag_tested@&bias) != test_result[i]) return 1;
    if (!(fabs(bias - test_bias[i]) <= @tolerance@)) return 1;
  }
@test_tracking@  return 0;
}
)";

constexpr const char* kPastMembers =
    R"(  double past[@name@_SECONDS][@name@_THERMOMETERS];     /* means of the last seconds, as a ring */
)";

/// Returns the names of the thermometers that a model needs, sorted.
std::vector<std::string> needed_thermometers(const Model& model) {
  std::set<std::string> names;
  for (const data::Term& term : model.terms) {
    for (const data::Factor& factor : term.factors) {
      names.insert(factor.first);
      if (factor.kind == data::FactorKind::gradient) names.insert(factor.second);
    }
  }
  return {names.begin(), names.end()};
}

/// Fails with usage if a constant or a known answer is not finite: C has no constant for it, and the self-test would
/// not detect it.
Result<void> check_finite(const Model& model, const KnownAnswers& answers) {
  const data::Scaling& scaling = model.scaling;
  const struct {
    bool is_finite;
    const char* what;
  } parts[] = {{model.input_min.allFinite() && model.input_max.allFinite(), "the trained range of its inputs"},
               {scaling.mean.allFinite() && scaling.std.allFinite() && scaling.std.cwiseInverse().allFinite(),
                "the scaling of its inputs"},
               {std::isfinite(model.target_mean_deg_per_h) && std::isfinite(model.target_std_deg_per_h),
                "the scaling of the target"},
               {has_finite_constants(model.function), "its function"},
               {answers.mean_c.allFinite() && answers.before_c.allFinite() && answers.lag_k.allFinite() &&
                    answers.bias_deg_per_h.allFinite() && std::isfinite(c_tolerance_deg_per_h(model)),
                "its predictions"}};
  for (const auto& part : parts)
    if (!part.is_finite)
      return failure(FaultKind::usage, "C export",
                     fmt::format("the model contains a value that is not finite: {}", part.what));
  return {};
}

/// Returns a factor as a C expression.
std::string c_expression(const Model& model, const data::Factor& factor, const std::vector<std::string>& names) {
  const auto first = index_in(names, factor.first);
  switch (factor.kind) {
    case data::FactorKind::temperature: return fmt::format("t[{}]", first);
    case data::FactorKind::gradient: return fmt::format("(t[{}] - t[{}])", first, index_in(names, factor.second));
    case data::FactorKind::rate:
      return fmt::format("((t[{0}] - before[{0}]) * {1})", first, c_number(kSecondsPerMinute / model.cluster_length_s));
    case data::FactorKind::lag: return fmt::format("lag[{}]", index_in(data::lags_in(model.terms), factor));
  }
  return {};
}

/// Returns the assignments of the inputs, one line each.
std::string c_assignments(const Model& model, const std::vector<std::string>& names) {
  std::string lines;
  for (std::size_t i = 0; i < model.terms.size(); ++i) {
    std::string product;
    for (const data::Factor& factor : model.terms[i].factors) {
      product += (product.empty() ? "" : " * ") + c_expression(model, factor, names);
    }
    lines += fmt::format("  x[{}] = {}; /* {} */\n", i, product, c_comment(to_string(model.terms[i])));
  }
  return lines;
}

CPlaceholders header_placeholders(const Model& model, std::string_view name, const std::vector<std::string>& names,
                                  bool rates) {
  CPlaceholders placeholders = lag_placeholders(model, name, names);
  placeholders.merge(lead_placeholders(model, name));
  placeholders.insert({{"name", std::string(name)},
                       {"provenance", c_provenance(model)},
                       {"thermometers", fmt::format("{}", names.size())},
                       {"seconds", fmt::format("{}", rows_in_cluster(model))},
                       {"before", rates ? " (for the rates)" : " (unused by this model: may be null)"},
                       {"order", c_comment(fmt::format("{}", fmt::join(names, ", ")))},
                       {"past", rates ? c_fill(kPastMembers, {{"name", std::string(name)}}) : ""}});
  return placeholders;
}

CPlaceholders source_placeholders(const Model& model, const KnownAnswers& answers, std::string_view name,
                                  const std::vector<std::string>& names, bool rates) {
  const std::string keep =
      fmt::format("  for (int j = 0; j < {}_THERMOMETERS; ++j) stream->past[at][j] = means[j];\n", name);
  CPlaceholders placeholders = lag_placeholders(model, name, names);
  placeholders.merge(lead_placeholders(model, name));
  placeholders.merge(self_test_placeholders(answers));
  placeholders.insert({{"name", std::string(name)},
                       {"inputs", fmt::format("{}", model.terms.size())},
                       {"low", c_vector("low", model.input_min.transpose())},
                       {"high", c_vector("high", model.input_max.transpose())},
                       {"mean", c_vector("mean", model.scaling.mean.transpose())},
                       {"deviation", c_vector("deviation", model.scaling.std.transpose())},
                       {"function", c_function(model.function)},
                       {"bounding", bounding_in_c(model)},
                       {"bound", bounding_in_c(model).empty() ? "" : "  if (outside) bound(bounded);\n"},
                       {"terms", (rates ? "" : "  (void)before;\n") + c_assignments(model, names)},
                       {"target_std", c_number(model.target_std_deg_per_h)},
                       {"target_mean", c_number(model.target_mean_deg_per_h)},
                       {"windows", rates ? "2" : "1"},
                       {"before_means", rates ? "stream->past[at]" : "means"},
                       {"keep", rates ? keep : ""},
                       {"tolerance", c_number(c_tolerance_deg_per_h(model))}});
  return placeholders;
}

}  // namespace

Result<CProgram> to_c(const Model& model, std::string_view name, const std::optional<tracking::BiasNoise>& noise) {
  if (const auto usable = check_c_name(name); !usable) return failure(usable.error());
  const std::vector<std::string> names = needed_thermometers(model);
  const bool rates = std::ranges::any_of(model.terms, data::has_rate);
  const KnownAnswers answers = known_answers(model, names);
  if (const auto finite = check_finite(model, answers); !finite) return failure(finite.error());
  const Result<CPart> tracking = noise ? tracking_in_c(*noise, rows_in_cluster(model), name) : CPart{};
  if (!tracking) return failure(tracking.error());
  const auto uncertainty = uncertainty_in_c(model, name);
  if (!uncertainty) return failure(uncertainty.error());
  CPlaceholders in_header = header_placeholders(model, name, names, rates);
  CPlaceholders in_source = source_placeholders(model, answers, name, names, rates);
  in_header.insert({{"tracking", tracking->declarations}, {"uncertainty", uncertainty->declarations}});
  in_source.insert({{"tracking", tracking->definitions},
                    {"test_tracking", tracking->test},
                    {"uncertainty", uncertainty->definitions},
                    {"test_uncertainty", uncertainty->test}});
  return CProgram{c_fill(kHeader, in_header), c_fill(kSource, in_source)};
}

double c_tolerance_deg_per_h(const Model& model) {
  constexpr double kRelativeTolerance = 1e-12, kUsualSumOfWeights = 1000;
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * std::abs(model.target_mean_deg_per_h);
  return kRelativeTolerance * model.target_std_deg_per_h *
             std::max(1.0, sum_of_weights(model.function) / kUsualSumOfWeights) +
         rounding;
}

}  // namespace gyrotherm::model
