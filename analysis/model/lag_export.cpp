// SPDX-License-Identifier: Apache-2.0
/// Writes the lags of an exported model: the state that its C program keeps for them, and the function that advances
/// it.
#include <fmt/format.h>

#include <cstddef>

#include "analysis/model/export_parts.hpp"

namespace gyrotherm::model {
namespace {

constexpr const char* kLagCount = R"(#define @name@_LAGS @lags@
)";

constexpr const char* kLagRing =
    R"(  double followed[@name@_SECONDS][@name@_LAGS];          /* temperature of each lagging body, as a ring */
  int steps[@name@_SECONDS][@name@_LAGS];                /* steps since its last value; 0: no value yet */
)";

constexpr const char* kLagStart = R"(  for (int i = 0; i < @name@_SECONDS; ++i) {
    for (int k = 0; k < @name@_LAGS; ++k) {
      stream->followed[i][k] = 0.0;
      stream->steps[i][k] = 0;
    }
  }
)";

constexpr const char* kLagsOf = R"(
/* Thermometer and time constant (s) of each lag. */
static const int lag_follows[@name@_LAGS] = {@follows@};
static const double time_constant[@name@_LAGS] = {@time_constants@};

/* Computes the lag of each body behind its thermometer after a step that ends with these means. If a mean is not
   finite, the next step is longer. */
static void lags_of(@name@_stream *stream, const double means[], double lags[]) {
  for (int k = 0; k < @name@_LAGS; ++k) {
    double *const followed = &stream->followed[stream->at][k];
    int *const steps = &stream->steps[stream->at][k];
    const double mean = means[lag_follows[k]];
    lags[k] = mean;
    if (!isfinite(mean)) {
      if (*steps > 0 && *steps < 1000000) ++*steps;
      continue;
    }
    if (*steps == 0) *followed = mean;
    lags[k] = exp(-(double)*steps * @name@_SECONDS / time_constant[k]) * (mean - *followed);
    *followed = mean - lags[k];
    *steps = 1;
  }
}
)";

constexpr const char* kLagPush = R"(  double lags[@name@_LAGS] = {0.0};
  if (stream->known >= @name@_SECONDS) lags_of(stream, means, lags);
)";

}  // namespace

CPlaceholders lag_placeholders(const Model& model, std::string_view name,
                               const std::vector<std::string>& thermometers) {
  const std::vector<data::Factor> lags = data::lags_in(model.terms);
  std::vector<Eigen::Index> follows;
  std::vector<std::string> order, time_constants;
  for (const data::Factor& lag : lags) {
    time_constants.push_back(c_number(lag.time_constant_s));
    follows.push_back(index_in(thermometers, lag.first));
    order.push_back(fmt::format("{} at {} s", lag.first, lag.time_constant_s));
  }
  const CPlaceholders own{{"name", std::string(name)},
                          {"lags", fmt::format("{}", lags.size())},
                          {"follows", fmt::format("{}", fmt::join(follows, ", "))},
                          {"time_constants", fmt::format("{}", fmt::join(time_constants, ", "))}};
  CPlaceholders placeholders{
      {"lag_count", c_fill(kLagCount, own)},
      {"lag_order", "\n   lag_k: lag of a body behind the thermometer that it follows with a time constant, K: " +
                        c_comment(fmt::format("{}", fmt::join(order, ", "))) + "."},
      {"lag_parameter", fmt::format("const double lag_k[{}_LAGS], ", name)},
      {"lag_ring", c_fill(kLagRing, own)},
      {"lag_input", "const double lag[], "},
      {"lag_argument", "lag_k, "},
      {"lag_start", c_fill(kLagStart, own)},
      {"lags_of", c_fill(kLagsOf, own)},
      {"lag_push", c_fill(kLagPush, own)},
      {"lag_pushed", "lags, "},
      {"lag_pushed_last", ", lags"},
      {"lag_last", fmt::format(",\n    const double lag_k[{}_LAGS]", name)},
      {"lag_tested", "test_lag[i], "}};
  if (lags.empty())
    for (auto& [key, text] : placeholders) text.clear();
  return placeholders;
}

}  // namespace gyrotherm::model
