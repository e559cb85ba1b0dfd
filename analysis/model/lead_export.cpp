// SPDX-License-Identifier: Apache-2.0
/// Writes the part of an exported model that extrapolates the predictions of a stream by its lag.
#include <fmt/format.h>

#include <string>

#include "analysis/model/export_parts.hpp"

namespace gyrotherm::model {
namespace {

constexpr const char* kPastBiases =
    R"(  double past_bias[@name@_SECONDS];                     /* predictions of the last seconds, as a ring */
  int has_past[@name@_SECONDS];
)";

constexpr const char* kLead = R"(  {
    const double now = *bias_deg_per_h;
    const int is_known = result < @name@_MISSING;
    if (is_known && stream->has_past[at]) *bias_deg_per_h = now + 0.5 * (now - stream->past_bias[at]);
    stream->past_bias[at] = now;
    stream->has_past[at] = is_known;
  }
)";

constexpr const char* kLeadStart = R"(  for (int i = 0; i < @name@_SECONDS; ++i) {
    stream->past_bias[i] = 0.0;
    stream->has_past[i] = 0;
  }
)";

/// Describes the lag of a stream.
std::string latency_in_c(const Model& model, std::string_view name) {
  if (!is_led(model)) return fmt::format("the bias lags by half of\n   {}_SECONDS.", name);
  return fmt::format(
      "the means lag by half of\n   {}_SECONDS. The bias is extrapolated by the same time. Error in training, rms: "
      "{:.2g} deg/h;\n   without the extrapolation {:.2g}.",
      name, model.latency->led_rms_deg_per_h, model.latency->lagging_rms_deg_per_h);
}

}  // namespace

CPlaceholders lead_placeholders(const Model& model, std::string_view name) {
  const CPlaceholders own{{"name", std::string(name)}};
  const auto if_led = [&](const char* text) { return is_led(model) ? c_fill(text, own) : std::string(); };
  return {{"latency", latency_in_c(model, name)},
          {"past_biases", if_led(kPastBiases)},
          {"lead", if_led(kLead)},
          {"lead_start", if_led(kLeadStart)}};
}

}  // namespace gyrotherm::model
