// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/model_export.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cctype>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <set>
#include <utility>

#include "analysis/model/lag_export.hpp"
#include "analysis/model/range_export.hpp"
#include "analysis/model/tracking_export.hpp"
#include "analysis/model/uncertainty_export.hpp"
#include "core/quantity.hpp"
#include "core/random.hpp"

namespace gyrotherm::model {
namespace {

using Words = std::map<std::string, std::string, std::less<>>;

constexpr std::size_t kWidth = 100;

/// The values between braces, over as many lines as they need.
std::string braced(const Eigen::Ref<const Eigen::VectorXd>& values, std::string_view indent) {
  std::string text = "{";
  std::size_t line = indent.size() + 1;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const std::string number = c_number(values(i));
    if (i > 0) text += ',';
    if (line + number.size() + 2 > kWidth) {
      text += fmt::format("\n{} ", indent);
      line = indent.size() + 1;
    } else if (i > 0) {
      text += ' ';
    }
    text += number;
    line += number.size() + 2;
  }
  return text + "}";
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != text.npos; at = text.find(from, at + 1)) {
    text.replace(at, from.size(), to);
  }
}

/// "static const double NAME[n] = {…};"
std::string c_vector(std::string_view name, const Eigen::Ref<const Eigen::VectorXd>& values) {
  return fmt::format("static const double {}[{}] = {};\n", name, values.size(), braced(values, "  "));
}

/// "static const double NAME[rows][columns] = {…};", a line per row.
std::string c_table(std::string_view name, const Eigen::Ref<const data::SampleMatrix>& values) {
  std::string text = fmt::format("static const double {}[{}][{}] = {{\n", name, values.rows(), values.cols());
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    const Eigen::VectorXd row = values.row(i);
    text += "  " + braced(row, "   ") + (i + 1 < values.rows() ? ",\n" : "\n");
  }
  return text + "};\n";
}

// What the additions of a sum lose is kept beside it, since weights of thousands cancel.
constexpr const char* kAdd = R"(/* Adds a term; what the sum loses goes to its rest. */
static double added(double sum, double term, double *rest) {
  const double next = sum + term;
  const double back = next - sum;
  *rest += (sum - (next - back)) + (term - back);
  return next;
}

)";

constexpr const char* kConstant = R"(static double function_of(const double z[], const double bounded[]) {
  (void)z;
  (void)bounded;
  return @b@;
}
)";

constexpr const char* kLinear = R"(@weight@
static double function_of(const double z[], const double bounded[]) {
  (void)bounded;
  double sum = @b@;
  for (int k = 0; k < @inputs@; ++k) sum += weight[k] * z[k];
  return sum;
}
)";

// Lengths are in the centres already.
constexpr const char* kGaussians = R"(/* sum of weight * exp(narrowness * |@scaled@ - centre|^2), and a constant */
@tables@
static double function_of(const double z[], const double bounded[]) {
@unused@  double sum = @b@, rest = 0.0;
  for (int i = 0; i < @terms@; ++i) {
    double square = 0.0;
    for (int k = 0; k < @inputs@; ++k) {
      const double apart = @scaled_k@ - centre[i][k];
      square += apart * apart;
    }
    sum = added(sum, weight[i] * exp(@narrowness@ * square), &rest);
  }
@plane@  return sum + rest;
}
)";

constexpr const char* kNetwork = R"(/* sum of weight * tanh(inward * z + offset), and a constant */
@inward@@offset@@weight@
static double function_of(const double z[], const double bounded[]) {
  (void)z;
  double sum = @b@, rest = 0.0;
  for (int i = 0; i < @terms@; ++i) {
    double arrives = offset[i];
    for (int k = 0; k < @inputs@; ++k) arrives += inward[i][k] * bounded[k];
    sum = added(sum, weight[i] * tanh(arrives), &rest);
  }
  return sum + rest;
}
)";

constexpr const char* kPlane = R"(  for (int k = 0; k < @inputs@; ++k) sum = added(sum, slope[k] * z[k], &rest);
)";

constexpr const char* kUnusedPlane = "  (void)z;\n";

std::string count(Eigen::Index number) { return fmt::format("{}", number); }

std::string constant(double b) { return c_filled(kConstant, {{"b", c_number(b)}}); }

std::string text_of(const methods::LinearModel& linear) {
  return c_filled(kLinear, {{"weight", c_vector("weight", linear.weights)},
                            {"inputs", count(linear.weights.size())},
                            {"b", c_number(linear.b)}});
}

std::string text_of(const methods::SvrModel& svr) {
  if (svr.beta.size() == 0) return constant(svr.b);
  const double sigma = svr.parameters.sigma;
  return kAdd +
         c_filled(kGaussians,
                  {{"plane", ""},
                   {"unused", kUnusedPlane},
                   {"scaled", "z"},
                   {"scaled_k", "bounded[k]"},
                   {"narrowness", "narrowness"},
                   {"tables", fmt::format("static const double narrowness = {};\n", c_number(-0.5 / (sigma * sigma))) +
                                  c_table("centre", svr.support_vectors) + c_vector("weight", svr.beta)},
                   {"terms", count(svr.beta.size())},
                   {"inputs", count(svr.support_vectors.cols())},
                   {"b", c_number(svr.b)}});
}

std::string text_of(const methods::ExpansionModel& expansion) {
  const bool plane = expansion.slope.size() > 0;
  if (expansion.weights.size() == 0) {
    return plane ? text_of(methods::LinearModel{expansion.slope, expansion.b}) : constant(expansion.b);
  }
  const data::SampleMatrix centres = expansion.centres.array().rowwise() / expansion.lengths.array();
  const Eigen::VectorXd narrowness = -0.5 * expansion.widths.array().square().inverse();
  return kAdd + c_filled(kGaussians,
                         {{"plane", plane ? c_filled(kPlane, {{"inputs", count(centres.cols())}}) : ""},
                          {"unused", plane ? "" : kUnusedPlane},
                          {"scaled", "z / length"},
                          {"scaled_k", "bounded[k] / length[k]"},
                          {"narrowness", "narrowness[i]"},
                          {"tables", c_vector("length", expansion.lengths.transpose()) + c_table("centre", centres) +
                                         c_vector("narrowness", narrowness) + c_vector("weight", expansion.weights) +
                                         (plane ? c_vector("slope", expansion.slope) : "")},
                          {"terms", count(expansion.weights.size())},
                          {"inputs", count(centres.cols())},
                          {"b", c_number(expansion.b)}});
}

std::string text_of(const methods::NetworkModel& network) {
  if (network.out.size() == 0) return constant(network.b);
  return kAdd + c_filled(kNetwork, {{"inward", c_table("inward", network.weights)},
                                    {"offset", c_vector("offset", network.offsets)},
                                    {"weight", c_vector("weight", network.out)},
                                    {"terms", count(network.out.size())},
                                    {"inputs", count(network.weights.cols())},
                                    {"b", c_number(network.b)}});
}

double weights_of(const methods::LinearModel& linear) { return linear.weights.lpNorm<1>(); }
double weights_of(const methods::SvrModel& svr) { return svr.beta.lpNorm<1>(); }
double weights_of(const methods::ExpansionModel& expansion) {
  return expansion.weights.lpNorm<1>() + expansion.slope.lpNorm<1>();
}
double weights_of(const methods::NetworkModel& network) { return network.out.lpNorm<1>(); }

bool is_finite(const methods::LinearModel& linear) { return linear.weights.allFinite() && std::isfinite(linear.b); }
bool is_finite(const methods::SvrModel& svr) {
  const double sigma = svr.parameters.sigma;
  return std::isfinite(1 / (sigma * sigma)) && svr.support_vectors.allFinite() && svr.beta.allFinite() &&
         std::isfinite(svr.b);
}
bool is_finite(const methods::ExpansionModel& expansion) {
  return expansion.lengths.allFinite() && expansion.lengths.cwiseInverse().allFinite() &&
         expansion.widths.cwiseAbs2().cwiseInverse().allFinite() && expansion.centres.allFinite() &&
         expansion.weights.allFinite() && expansion.slope.allFinite() && std::isfinite(expansion.b);
}
bool is_finite(const methods::NetworkModel& network) {
  return network.weights.allFinite() && network.offsets.allFinite() && network.out.allFinite() &&
         std::isfinite(network.b);
}

/// Tables and "static double function_of(const double z[], const double bounded[])".
std::string c_function(const methods::Function& function) {
  return std::visit([](const auto& form) { return text_of(form); }, function);
}

/// The sum of the weights of what the function adds up: it says how much the rounding of that sum can amount to.
double sum_of_weights(const methods::Function& function) {
  return std::visit([](const auto& form) { return weights_of(form); }, function);
}

std::string figures(const data::Figures& f) {
  return fmt::format("std {:.5g}, mean {:.3g}, rmse {:.5g}, max {:.4g} deg/h over {} means", f.std, f.mean, f.rmse,
                     f.max_abs, f.count);
}

std::string trained_on(const TrainingRecord& record) {
  return fmt::format("Trained on {}{}{} (run {}, profile {}), {} means of {:.0f} to {:.0f} s.",
                     record.simulated ? "SIMULATED data: " : "",
                     is_named(record.of) ? in_words(record.of) + " of " : "", record.path, record.run_id,
                     record.profile_name, record.clusters, record.from_s, record.to_s);
}

std::string reduced(const ReducedSetSummary& reduction) {
  return fmt::format(
      "Reduced from {} to {} vectors: changes of at most {:.3g} deg/h, rms {:.3g}, on {} training means, never more "
      "than {:.3g}; the figures are those of the full function.",
      reduction.vectors_before, reduction.vectors, reduction.max_change_deg_per_h, reduction.rms_change_deg_per_h,
      reduction.clusters, reduction.bound_deg_per_h);
}

std::string range(const Model& model, Eigen::Index input) {
  const bool rate = has_rate(model.terms[static_cast<std::size_t>(input)]);
  return fmt::format("  {}: {:.6g} to {:.6g}{}", to_string(model.terms[static_cast<std::size_t>(input)]),
                     model.input_min(input), model.input_max(input), rate ? " (rates in degC/min)" : "");
}

/// What is known of a model as lines of a block comment, each begun with a space and ended: what it computes, from
/// what it was trained and whether that was simulated, its figures, and the trained range of each input.
std::string c_provenance(const Model& model) {
  std::vector<std::string> lines;
  lines.push_back("Compensation of a gyro's temperature bias, written by gyrotherm " + model.program_version + ".");
  const bool simulated = std::ranges::any_of(model.trained_on, &TrainingRecord::simulated);
  if (simulated) lines.emplace_back("SIMULATED: no real gyro was measured for this model.");
  lines.push_back(fmt::format("Method {}, inputs {}; means of {:g} s.{}", model.method, model.inputs,
                              model.cluster_length_s, model.quick ? " Tuned with a small swarm, for a try." : ""));
  if (model.reduction) lines.push_back(reduced(*model.reduction));
  for (const TrainingRecord& record : model.trained_on) lines.push_back(trained_on(record));
  lines.push_back("Bias as trained: mean " +
                  fmt::format("{:.6g}, std {:.6g} deg/h.", model.target_mean_deg_per_h, model.target_std_deg_per_h));
  lines.push_back("Residual in-sample (no verification): " + figures(model.in_sample) + ".");
  lines.push_back(fmt::format("Residual held out, {}: {}.", model.folds, figures(model.leave_cycle_out)));
  for (const std::string& warning : model.warnings) lines.push_back("Warning: " + warning + ".");
  if (const auto block = trained_block(model.trained_on))
    lines.push_back(fmt::format("Trained range of the block: {:.1f} to {:.1f} degC.", block->low_c, block->high_c));
  lines.emplace_back("Trained range of each input, degC:");
  for (Eigen::Index i = 0; i < model.input_min.size(); ++i) lines.push_back(range(model, i));
  std::string text;
  for (const std::string& line : lines) text += ' ' + c_comment(line) + '\n';
  return text;
}

/// Known answers for the self-test of an exported model: temperatures and what the model predicts from them.
struct KnownAnswers {
  data::SampleMatrix mean_c,
      before_c;                    ///< means of the last cluster length and of the one before; columns are thermometers
  data::SampleMatrix lag_k;        ///< columns are the model's lags
  Eigen::VectorXd bias_deg_per_h;  ///< predicted, as Outside::continued does
  std::vector<bool> outside;       ///< an input was
};

constexpr Eigen::Index kInside = 6, kBeyond = 2;
constexpr double kRoom_c = 20;

Eigen::Index place_of(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) - names.begin();
}

Eigen::Index place_of(const std::vector<data::Factor>& lags, const data::Factor& lag) {
  return std::ranges::find(lags, lag) - lags.begin();
}

/// Of the terms with one factor: what each is of the temperatures, the rates and the lags, side by side. Zero rows for
/// others.
Eigen::MatrixXd slopes_of(const Model& model, const std::vector<std::string>& names) {
  const auto count = static_cast<Eigen::Index>(names.size());
  const std::vector<data::Factor> lags = data::lags_in(model.terms);
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(model.terms.size()),
                                                 2 * count + static_cast<Eigen::Index>(lags.size()));
  for (Eigen::Index i = 0; i < slopes.rows(); ++i) {
    const auto& factors = model.terms[static_cast<std::size_t>(i)].factors;
    if (factors.size() != 1) continue;
    const data::Factor& factor = factors.front();
    const Eigen::Index thermometer = place_of(names, factor.first);
    const bool rate = factor.kind == data::FactorKind::rate, lag = factor.kind == data::FactorKind::lag;
    slopes(i, lag ? 2 * count + place_of(lags, factor) : rate ? count + thermometer : thermometer) = 1;
    if (factor.kind == data::FactorKind::gradient) slopes(i, place_of(names, factor.second)) -= 1;
  }
  return slopes;
}

/// Centres of the function, scaled; none if it has no centres.
data::SampleMatrix centres_of(const methods::Function& function) {
  if (const auto* svr = std::get_if<methods::SvrModel>(&function)) return svr->support_vectors;
  if (const auto* expansion = std::get_if<methods::ExpansionModel>(&function)) return expansion->centres;
  return {};
}

/// Unscaled inputs like those of the training: near the function's centres, or anywhere in the trained range.
data::SampleMatrix wanted_inputs(const Model& model, Eigen::Index rows) {
  std::mt19937_64 generator(1);
  const auto below_one = [&] { return uniform(generator); };
  const data::SampleMatrix centres = centres_of(model.function);
  data::SampleMatrix inputs(rows, model.input_min.size());
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto from = Eigen::RowVectorXd::NullaryExpr(inputs.cols(), below_one).eval();
    if (centres.rows() == 0) {
      inputs.row(i) = model.input_min.array() + from.array() * (model.input_max - model.input_min).array();
    } else {
      const Eigen::Index centre = i * centres.rows() / rows;
      const Eigen::RowVectorXd near = centres.row(centre).array() + 0.1 * (from.array() - 0.5);
      inputs.row(i) = near.array() * model.scaling.std.array() + model.scaling.mean.array();
    }
  }
  return inputs;
}

/// Short enough to be read in a table, and exact in it.
double rounded(double value) {
  constexpr double kParts = 1024;
  return std::round(value * kParts) / kParts;
}

/// The names of the thermometers that a model needs, sorted.
std::vector<std::string> thermometers_of(const Model& model) {
  std::set<std::string> names;
  for (const data::Term& term : model.terms) {
    for (const data::Factor& factor : term.factors) {
      names.insert(factor.first);
      if (factor.kind == data::FactorKind::gradient) names.insert(factor.second);
    }
  }
  return {names.begin(), names.end()};
}

/// What the model predicts from these means and lags.
void answer(const Model& model, const std::vector<std::string>& names, KnownAnswers& answers) {
  data::Clusters clusters;
  clusters.length_s = model.cluster_length_s;
  clusters.thermometers = names;
  for (const data::Factor& lag : data::lags_in(model.terms)) clusters.thermometers.push_back(lag_name(lag));
  clusters.temperature_c.resize(answers.mean_c.rows(), static_cast<Eigen::Index>(clusters.thermometers.size()));
  clusters.temperature_c << answers.mean_c, answers.lag_k;
  clusters.rate_c_per_min = (answers.mean_c - answers.before_c) * (kSecondsPerMinute / model.cluster_length_s);
  std::vector<data::Term> terms = model.terms;
  std::ranges::transform(model.terms, terms.begin(), data::with_lags_as_temperatures);
  auto inputs = evaluate(terms, clusters);
  assert(inputs);
  Model with_lags = model;
  with_lags.terms = terms;
  const RangedInputs ranged = within_range(with_lags, std::move(*inputs), Outside::continued);
  answers.bias_deg_per_h = predict(with_lags, ranged);
  answers.outside.assign(static_cast<std::size_t>(answers.mean_c.rows()), false);
  for (const Eigen::Index row : ranged.rows) answers.outside[static_cast<std::size_t>(row)] = true;
}

/// Six answers near what the model was trained on and two farther out; the same each time.
KnownAnswers known_answers(const Model& model) {
  const std::vector<std::string> names = thermometers_of(model);
  const auto count = static_cast<Eigen::Index>(names.size());
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> slopes(slopes_of(model, names));
  const data::SampleMatrix wanted = wanted_inputs(model, kInside + kBeyond);
  Eigen::VectorXd room = Eigen::VectorXd::Zero(slopes.cols());
  room.head(count).setConstant(kRoom_c);
  const Eigen::VectorXd at_room = slopes_of(model, names) * room;
  KnownAnswers answers;
  answers.mean_c.resize(wanted.rows(), count);
  answers.before_c.resize(wanted.rows(), count);
  answers.lag_k.resize(wanted.rows(), slopes.cols() - 2 * count);
  for (Eigen::Index i = 0; i < wanted.rows(); ++i) {
    const double reach = i < kInside ? 1 : 3;
    const Eigen::VectorXd away = slopes.solve(reach * (wanted.row(i).transpose() - at_room));
    const Eigen::VectorXd state = room + away;  // temperatures, then rates, then lags
    const double minutes = model.cluster_length_s / kSecondsPerMinute;
    answers.mean_c.row(i) = state.head(count).transpose().unaryExpr(&rounded);
    const Eigen::VectorXd before = state.head(count) - state.segment(count, count) * minutes;
    answers.before_c.row(i) = before.transpose().unaryExpr(&rounded);
    answers.lag_k.row(i) = state.tail(answers.lag_k.cols()).transpose().unaryExpr(&rounded);
  }
  answer(model, names, answers);
  return answers;
}

/// C has no constant for a number that is not finite, and no self-test finds one.
Result<void> check_is_finite(const Model& model, const KnownAnswers& answers) {
  const data::Scaling& scaling = model.scaling;
  const struct {
    bool is_finite;
    const char* what;
  } parts[] = {
      {model.input_min.allFinite() && model.input_max.allFinite(), "the trained range of its inputs"},
      {scaling.mean.allFinite() && scaling.std.allFinite() && scaling.std.cwiseInverse().allFinite(),
       "the scaling of its inputs"},
      {std::isfinite(model.target_mean_deg_per_h) && std::isfinite(model.target_std_deg_per_h), "the target's scaling"},
      {std::visit([](const auto& form) { return is_finite(form); }, model.function), "its function"},
      {answers.mean_c.allFinite() && answers.before_c.allFinite() && answers.lag_k.allFinite() &&
           answers.bias_deg_per_h.allFinite() && std::isfinite(c_tolerance_deg_per_h(model)),
       "what it predicts"}};
  for (const auto& part : parts)
    if (!part.is_finite)
      return failure(FaultKind::usage, "C export", fmt::format("of this model {} is not finite", part.what));
  return {};
}

constexpr const char* kHeader = R"(/*
@provenance@ */
#ifndef @name@_H
#define @name@_H

#ifdef __cplusplus
extern "C" {
#endif

#define @name@_THERMOMETERS @thermometers@
#define @name@_SECONDS @seconds@
@lags_number@
/* What a call returns: 0, or a sum of these. */
#define @name@_OUTSIDE 1 /* an input was outside the trained range: the plane continues, all else is bounded */
#define @name@_MISSING 2 /* a reading was not finite: nothing is predicted, the bias is 0 */
#define @name@_NOT_YET 4 /* too few readings so far: nothing is predicted, the bias is 0 */

/* The bias that these temperatures make, in degrees per hour: subtract it from the gyro's. mean_c are the means of the
   thermometers over the last @name@_SECONDS seconds, before_c over as many before those@before@,
   both in degrees Celsius, in this order: @order@.@lag_order@ */
int @name@_predict(const double mean_c[@name@_THERMOMETERS], const double before_c[@name@_THERMOMETERS],
    @lag_parameter@double *bias_deg_per_h);

/* How far the worst of the inputs that these make is outside the trained range, as a part of its range; 0 inside. */
double @name@_excess(const double mean_c[@name@_THERMOMETERS],
    const double before_c[@name@_THERMOMETERS]@lag_last@);

/* The same from one reading a second. All that a gyro needs to remember is in its stream; @latency@ */
typedef struct {
  double block[@name@_SECONDS][@name@_THERMOMETERS];    /* the readings of this block of seconds */
  double ends[@name@_SECONDS + 1][@name@_THERMOMETERS]; /* sums of the block before, from each second to its end */
  double begun[@name@_THERMOMETERS];                    /* sum of this block so far */
@past@@told@@lag_ring@  int at;                                               /* seconds in this block */
  int known;                                            /* seconds so far, as far as it matters */
  double excess;                                        /* of the last second that was predicted */
} @name@_stream;

void @name@_start(@name@_stream *stream);
int @name@_push(@name@_stream *stream, const double temperature_c[@name@_THERMOMETERS], double *bias_deg_per_h);

@uncertainty@@tracking@/* Predicts for a few known temperatures. 0 if what comes out is what it should be, else 1. */
int @name@_self_test(void);

#ifdef __cplusplus
}
#endif

#endif
)";

constexpr const char* kPast =
    R"(  double past[@name@_SECONDS][@name@_THERMOMETERS];     /* means of the last seconds, as a ring */
)";

constexpr const char* kTold =
    R"(  double told[@name@_SECONDS];                          /* predictions of the last seconds, as a ring */
  int is_told[@name@_SECONDS];
)";

constexpr const char* kLead = R"(  {
    const double now = *bias_deg_per_h;
    const int is_known = result < @name@_MISSING;
    if (is_known && stream->is_told[at]) *bias_deg_per_h = now + 0.5 * (now - stream->told[at]);
    stream->told[at] = now;
    stream->is_told[at] = is_known;
  }
)";

constexpr const char* kLeadStart = R"(  for (int i = 0; i < @name@_SECONDS; ++i) {
    stream->told[i] = 0.0;
    stream->is_told[i] = 0;
  }
)";

constexpr const char* kSource = R"(#include "@name@.h"

#include <float.h>
#include <math.h>
#if DBL_MANT_DIG < 53
#error "@name@ needs a double of 64 bits: with fewer, as AVR has, its predictions do not pass its self-test"
#endif

#define INPUTS @inputs@

/* Of each input: the range it was trained in, and its mean and standard deviation there. */
@low@@high@@mean@@deviation@
/* f(z) of the inputs less their means, in standard deviations. */
@function@
static void inputs_of(const double t[], const double before[], @lag_input@double x[]) {
@terms@}

/* How far the worst input is outside, as a part of its range. What a mean's rounding may amount to is not outside. */
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

std::string of(const Model& model, const data::Factor& factor, const std::vector<std::string>& names) {
  const auto first = place_of(names, factor.first);
  switch (factor.kind) {
    case data::FactorKind::temperature: return fmt::format("t[{}]", first);
    case data::FactorKind::gradient: return fmt::format("(t[{}] - t[{}])", first, place_of(names, factor.second));
    case data::FactorKind::rate:
      return fmt::format("((t[{0}] - before[{0}]) * {1})", first, c_number(kSecondsPerMinute / model.cluster_length_s));
    case data::FactorKind::lag: return fmt::format("lag[{}]", place_of(data::lags_in(model.terms), factor));
  }
  return {};
}

std::string terms_of(const Model& model, const std::vector<std::string>& names) {
  std::string lines;
  for (std::size_t i = 0; i < model.terms.size(); ++i) {
    std::string product;
    for (const data::Factor& factor : model.terms[i].factors) {
      product += (product.empty() ? "" : " * ") + of(model, factor, names);
    }
    lines += fmt::format("  x[{}] = {}; /* {} */\n", i, product, c_comment(to_string(model.terms[i])));
  }
  return lines;
}

std::string results_of(const KnownAnswers& answers) {
  std::vector<int> results;
  for (const bool outside : answers.outside) results.push_back(outside ? 1 : 0);
  return fmt::format("{}", fmt::join(results, ", "));
}

/// Describes the lag of a stream.
std::string latency_in_c(const Model& model, std::string_view name) {
  if (!is_led(model)) return fmt::format("the bias lags by half of\n   {}_SECONDS.", name);
  return fmt::format(
      "means lag by half of\n   {}_SECONDS; the bias is extrapolated by as much, which leaves {:.2g} deg/h (rms, in "
      "training)\n   where the lag would leave {:.2g}.",
      name, model.latency->led_rms_deg_per_h, model.latency->lagging_rms_deg_per_h);
}

Words header_words(const Model& model, std::string_view name, const std::vector<std::string>& names, bool rates) {
  const Words own{{"name", std::string(name)}};
  Words words = lag_words(model, name, names);
  words.insert({{"name", std::string(name)},
                {"provenance", c_provenance(model)},
                {"thermometers", fmt::format("{}", names.size())},
                {"seconds", fmt::format("{}", rows_in_cluster(model))},
                {"before", rates ? " (for the rates)" : " (not asked for by this model: may be null)"},
                {"order", c_comment(fmt::format("{}", fmt::join(names, ", ")))},
                {"past", rates ? c_filled(kPast, own) : ""},
                {"told", is_led(model) ? c_filled(kTold, own) : ""},
                {"latency", latency_in_c(model, name)}});
  return words;
}

Words source_words(const Model& model, const KnownAnswers& answers, std::string_view name,
                   const std::vector<std::string>& names, bool rates) {
  const std::string keep =
      fmt::format("  for (int j = 0; j < {}_THERMOMETERS; ++j) stream->past[at][j] = means[j];\n", name);
  Words words = lag_words(model, name, names);
  words.insert({{"name", std::string(name)},
                {"inputs", fmt::format("{}", model.terms.size())},
                {"low", c_vector("low", model.input_min.transpose())},
                {"high", c_vector("high", model.input_max.transpose())},
                {"mean", c_vector("mean", model.scaling.mean.transpose())},
                {"deviation", c_vector("deviation", model.scaling.std.transpose())},
                {"function", c_function(model.function)},
                {"bounding", bounding_in_c(model)},
                {"bound", bounding_in_c(model).empty() ? "" : "  if (outside) bound(bounded);\n"},
                {"terms", (rates ? "" : "  (void)before;\n") + terms_of(model, names)},
                {"target_std", c_number(model.target_std_deg_per_h)},
                {"target_mean", c_number(model.target_mean_deg_per_h)},
                {"windows", rates ? "2" : "1"},
                {"before_means", rates ? "stream->past[at]" : "means"},
                {"keep", rates ? keep : ""},
                {"lead", is_led(model) ? c_filled(kLead, {{"name", std::string(name)}}) : ""},
                {"lead_start", is_led(model) ? c_filled(kLeadStart, {{"name", std::string(name)}}) : ""},
                {"test_mean", c_table("test_mean", answers.mean_c)},
                {"test_before", c_table("test_before", answers.before_c)},
                {"test_lag", answers.lag_k.cols() > 0 ? c_table("test_lag", answers.lag_k) : ""},
                {"test_bias", c_vector("test_bias", answers.bias_deg_per_h)},
                {"test_result", results_of(answers)},
                {"tolerance", c_number(c_tolerance_deg_per_h(model))}});
  return words;
}

/// " 1:v1 2:v2 …", each value exact.
void append_row(std::string& out, const Eigen::Ref<const Eigen::RowVectorXd>& row) {
  for (Eigen::Index j = 0; j < row.size(); ++j) fmt::format_to(std::back_inserter(out), " {}:{:.17g}", j + 1, row(j));
  out += '\n';
}

}  // namespace

std::string c_number(double value) {
  std::string digits = fmt::format("{:.17g}", value);
  if (digits.find_first_of(".e") == digits.npos) digits += ".0";
  return digits;
}

std::string c_comment(std::string_view text) {
  std::string safe;
  for (const char c : text) safe += static_cast<unsigned char>(c) < ' ' || c == '\x7f' ? ' ' : c;
  replace_all(safe, "*/", "* /");
  replace_all(safe, "/*", "/ *");
  replace_all(safe, "??", "? ?");
  if (safe.ends_with('\\')) safe += ' ';
  return safe;
}

std::string c_filled(std::string_view text, const std::map<std::string, std::string, std::less<>>& words) {
  std::string filled;
  while (true) {
    const std::size_t begin = text.find('@');
    filled += text.substr(0, begin);
    if (begin == text.npos) return filled;
    const std::size_t end = text.find('@', begin + 1);
    const auto word = words.find(text.substr(begin + 1, end - begin - 1));
    assert(end != text.npos && word != words.end());
    filled += word->second;
    text.remove_prefix(end + 1);
  }
}

Result<CProgram> to_c(const Model& model, std::string_view name, const std::optional<tracking::BiasNoise>& noise) {
  if (name != c_name(name)) {
    return failure(FaultKind::usage, "C export",
                   fmt::format("\"{}\" cannot begin the names of a C program; \"{}\" can", name, c_name(name)));
  }
  const std::vector<std::string> names = thermometers_of(model);
  const bool rates = std::ranges::any_of(model.terms, data::has_rate);
  const KnownAnswers answers = known_answers(model);
  if (const auto finite = check_is_finite(model, answers); !finite) return failure(finite.error());
  const Result<TrackingInC> tracking = noise ? tracking_in_c(*noise, rows_in_cluster(model), name) : TrackingInC{};
  if (!tracking) return failure(tracking.error());
  const auto uncertainty = uncertainty_in_c(model, name);
  if (!uncertainty) return failure(uncertainty.error());
  Words of_header = header_words(model, name, names, rates);
  Words of_source = source_words(model, answers, name, names, rates);
  of_header.insert({{"tracking", tracking->declarations}, {"uncertainty", uncertainty->declarations}});
  of_source.insert({{"tracking", tracking->definitions},
                    {"test_tracking", tracking->test},
                    {"uncertainty", uncertainty->definitions},
                    {"test_uncertainty", uncertainty->test}});
  return CProgram{c_filled(kHeader, of_header), c_filled(kSource, of_source)};
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

Result<std::string> to_libsvm(const Model& model) {
  const auto* svr = std::get_if<methods::SvrModel>(&model.function);
  if (svr == nullptr)
    return failure(FaultKind::usage, "LIBSVM export", "needs an svr model, this one is " + model.method);
  const double sigma = svr->parameters.sigma;
  std::string out =
      fmt::format("svm_type epsilon_svr\nkernel_type rbf\ngamma {:.17g}\nnr_class 2\ntotal_sv {}\nrho {:.17g}\nSV\n",
                  1 / (2 * sigma * sigma), svr->beta.size(), -svr->b);
  for (Eigen::Index i = 0; i < svr->beta.size(); ++i) {
    fmt::format_to(std::back_inserter(out), "{:.17g}", svr->beta(i));
    append_row(out, svr->support_vectors.row(i));
  }
  return out;
}

Result<std::string> to_libsvm_data(const Model& model, const data::Clusters& clusters) {
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  const data::SampleMatrix scaled = apply(model.scaling, *inputs);
  std::string out;
  for (Eigen::Index k = 0; k < scaled.rows(); ++k) {
    if (!scaled.row(k).allFinite()) continue;
    const double target = (clusters.bias_deg_per_h(k) - model.target_mean_deg_per_h) / model.target_std_deg_per_h;
    fmt::format_to(std::back_inserter(out), "{:.17g}", target);
    append_row(out, scaled.row(k));
  }
  return out;
}

}  // namespace gyrotherm::model
