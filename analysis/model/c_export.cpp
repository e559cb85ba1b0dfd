#include "analysis/model/c_export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "analysis/model/c_function.hpp"
#include "analysis/model/c_provenance.hpp"
#include "analysis/model/c_self_test.hpp"
#include "analysis/model/c_text.hpp"
#include "core/quantity.hpp"

namespace gyrotherm {
namespace {

using Words = std::map<std::string, std::string, std::less<>>;

constexpr const char* kHeader = R"(/*
@provenance@ */
#ifndef @name@_H
#define @name@_H

#ifdef __cplusplus
extern "C" {
#endif

#define @name@_THERMOMETERS @thermometers@
#define @name@_SECONDS @seconds@

/* What a call returns: 0, or a sum of these. */
#define @name@_OUTSIDE 1 /* an input was outside the trained range and was moved to the nearer end */
#define @name@_MISSING 2 /* a reading was not finite: nothing is predicted, the bias is 0 */
#define @name@_NOT_YET 4 /* too few readings so far: nothing is predicted, the bias is 0 */

/* The bias that these temperatures make, in degrees per hour: subtract it from the gyro's. mean_c are the means of the
   thermometers over the last @name@_SECONDS seconds, before_c over as many before those@before@,
   both in degrees Celsius, in this order: @order@. */
int @name@_predict(const double mean_c[@name@_THERMOMETERS], const double before_c[@name@_THERMOMETERS],
    double *bias_deg_per_h);

/* The same from one reading a second. All that a gyro needs to remember is in its stream; the bias lags by half of
   @name@_SECONDS. */
typedef struct {
  double block[@name@_SECONDS][@name@_THERMOMETERS];    /* the readings of this block of seconds */
  double ends[@name@_SECONDS + 1][@name@_THERMOMETERS]; /* sums of the block before, from each second to its end */
  double begun[@name@_THERMOMETERS];                    /* sum of this block so far */
@past@  int at;                                               /* seconds in this block */
  int known;                                            /* seconds so far, as far as it matters */
} @name@_stream;

void @name@_start(@name@_stream *stream);
int @name@_push(@name@_stream *stream, const double temperature_c[@name@_THERMOMETERS], double *bias_deg_per_h);

/* Predicts for a few known temperatures. 0 if what comes out is what it should be, else 1. */
int @name@_self_test(void);

#ifdef __cplusplus
}
#endif

#endif
)";

constexpr const char* kPast =
    R"(  double past[@name@_SECONDS][@name@_THERMOMETERS];     /* means of the last seconds, as a ring */
)";

constexpr const char* kSource = R"(#include "@name@.h"

#include <math.h>

#define INPUTS @inputs@

/* Of each input: the range it was trained in, and its mean and standard deviation there. */
@low@@high@@mean@@deviation@
/* f(z) of the inputs less their means, in standard deviations. */
@function@
static void inputs_of(const double t[], const double before[], double x[]) {
@terms@}

/* Moves inputs beyond the trained range to its nearer end. What a mean's rounding may amount to is not beyond. */
static int hold_in_range(double x[]) {
  int outside = 0;
  for (int k = 0; k < INPUTS; ++k) {
    const double slack = 1e-9 * (high[k] - low[k]);
    if (low[k] - x[k] > slack || x[k] - high[k] > slack) outside = @name@_OUTSIDE;
  }
  if (!outside) return 0;
  for (int k = 0; k < INPUTS; ++k) {
    if (x[k] < low[k]) x[k] = low[k];
    if (x[k] > high[k]) x[k] = high[k];
  }
  return outside;
}

int @name@_predict(const double mean_c[@name@_THERMOMETERS], const double before_c[@name@_THERMOMETERS],
    double *bias_deg_per_h) {
  double x[INPUTS];
  int outside;
  *bias_deg_per_h = 0.0;
  inputs_of(mean_c, before_c, x);
  for (int k = 0; k < INPUTS; ++k) {
    if (!isfinite(x[k])) return @name@_MISSING;
  }
  outside = hold_in_range(x);
  for (int k = 0; k < INPUTS; ++k) x[k] = (x[k] - mean[k]) / deviation[k];
  *bias_deg_per_h = function_of(x) * @target_std@ + @target_mean@;
  return outside;
}

void @name@_start(@name@_stream *stream) {
  for (int j = 0; j < @name@_THERMOMETERS; ++j) {
    for (int i = 0; i <= @name@_SECONDS; ++i) stream->ends[i][j] = 0.0;
    stream->begun[j] = 0.0;
  }
  stream->at = 0;
  stream->known = 0;
}

/* A window is the rest of the block before and the beginning of this one. Nothing is ever subtracted, so that nothing
   drifts and a reading that was not finite leaves with its second. */
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
  if (stream->known == @windows@ * @name@_SECONDS) {
    result = @name@_predict(means, @before_means@, bias_deg_per_h);
  }
@keep@  stream->at = at + 1;
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

@test_mean@@test_before@@test_bias@static const int test_result[] = {@test_result@};

int @name@_self_test(void) {
  for (int i = 0; i < (int)(sizeof test_result / sizeof test_result[0]); ++i) {
    double bias;
    if (@name@_predict(test_mean[i], test_before[i], &bias) != test_result[i]) return 1;
    if (!(fabs(bias - test_bias[i]) <= @tolerance@)) return 1;
  }
  return 0;
}
)";

std::string of(const Factor& factor, const std::vector<std::string>& names, double length_s) {
  const auto at = [&](const std::string& name) { return std::ranges::find(names, name) - names.begin(); };
  const auto first = at(factor.first);
  switch (factor.kind) {
    case FactorKind::temperature: return fmt::format("t[{}]", first);
    case FactorKind::gradient: return fmt::format("(t[{}] - t[{}])", first, at(factor.second));
    case FactorKind::rate:
      return fmt::format("((t[{0}] - before[{0}]) * {1})", first, c_number(kSecondsPerMinute / length_s));
  }
  return {};
}

std::string terms_of(const Model& model, const std::vector<std::string>& names) {
  std::string lines;
  for (std::size_t i = 0; i < model.terms.size(); ++i) {
    std::string product;
    for (const Factor& factor : model.terms[i].factors) {
      product += (product.empty() ? "" : " * ") + of(factor, names, model.cluster_length_s);
    }
    lines += fmt::format("  x[{}] = {}; /* {} */\n", i, product, c_comment(text(model.terms[i])));
  }
  return lines;
}

std::string results_of(const KnownAnswers& answers) {
  std::vector<int> results;
  for (const bool outside : answers.outside) results.push_back(outside ? 1 : 0);
  return fmt::format("{}", fmt::join(results, ", "));
}

Words header_words(const Model& model, std::string_view name, const std::vector<std::string>& names, bool rates) {
  const Words own{{"name", std::string(name)}};
  return {{"name", std::string(name)},
          {"provenance", c_provenance(model)},
          {"thermometers", fmt::format("{}", names.size())},
          {"seconds", fmt::format("{}", std::max(1LL, std::llround(model.cluster_length_s)))},
          {"before", rates ? " (for the rates)" : " (not asked for by this model: may be null)"},
          {"order", c_comment(fmt::format("{}", fmt::join(names, ", ")))},
          {"past", rates ? c_filled(kPast, own) : ""}};
}

Words source_words(const Model& model, std::string_view name, const std::vector<std::string>& names, bool rates) {
  const KnownAnswers answers = known_answers(model);
  const std::string keep =
      fmt::format("  for (int j = 0; j < {}_THERMOMETERS; ++j) stream->past[at][j] = means[j];\n", name);
  return {{"name", std::string(name)},
          {"inputs", fmt::format("{}", model.terms.size())},
          {"low", c_vector("low", model.input_min.transpose())},
          {"high", c_vector("high", model.input_max.transpose())},
          {"mean", c_vector("mean", model.scaling.mean.transpose())},
          {"deviation", c_vector("deviation", model.scaling.std.transpose())},
          {"function", c_function(model.function)},
          {"terms", (rates ? "" : "  (void)before;\n") + terms_of(model, names)},
          {"target_std", c_number(model.target_std_deg_per_h)},
          {"target_mean", c_number(model.target_mean_deg_per_h)},
          {"windows", rates ? "2" : "1"},
          {"before_means", rates ? "stream->past[at]" : "means"},
          {"keep", rates ? keep : ""},
          {"test_mean", c_table("test_mean", answers.mean_c)},
          {"test_before", c_table("test_before", answers.before_c)},
          {"test_bias", c_vector("test_bias", answers.bias_deg_per_h)},
          {"test_result", results_of(answers)},
          {"tolerance", c_number(c_tolerance_deg_per_h(model))}};
}

}  // namespace

Result<CProgram> to_c(const Model& model, std::string_view name) {
  if (name != c_name(name)) {
    return failure(FaultKind::usage, "C export",
                   fmt::format("\"{}\" cannot begin the names of a C program; \"{}\" can", name, c_name(name)));
  }
  const std::vector<std::string> names = thermometers_of(model);
  const bool rates = std::ranges::any_of(model.terms, has_rate);
  return CProgram{c_filled(kHeader, header_words(model, name, names, rates)),
                  c_filled(kSource, source_words(model, name, names, rates))};
}

double c_tolerance_deg_per_h(const Model& model) {
  constexpr double kPart = 1e-12, kWeights = 1000;
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * std::abs(model.target_mean_deg_per_h);
  return kPart * model.target_std_deg_per_h * std::max(1.0, sum_of_weights(model.function) / kWeights) + rounding;
}

std::string c_name(std::string_view text) {
  std::string name;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    name += byte < 0x80 && std::isalnum(byte) != 0 ? c : '_';
  }
  if (name.empty() || std::isalpha(static_cast<unsigned char>(name.front())) == 0) name.insert(0, 1, 'm');
  return name;
}

}  // namespace gyrotherm
