// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <set>

#include "analysis/data/hold_noise.hpp"
#include "analysis/model/characterisation.hpp"
#include "analysis/model/making.hpp"
#include "analysis/model/verification.hpp"
#include "analysis/tracking/assessment.hpp"
#include "apps/console/command.hpp"
#include "apps/gyrotherm/bias_tracking.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "core/json.hpp"
#include "report/plot/svg.hpp"

namespace gyrotherm::app {
namespace {

struct VerifyArguments {
  std::string model, clusters, outside = "continue";
  std::vector<std::string> runs;
  bool unverified = false;
  bool evaluate_stream = false;
  data::AxisChoice axis;
  BiasTrackingArguments tracking;
};

/// Formats a value, or "–" if it is unknown.
std::string format_value(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "–";
}

std::string row(std::string_view what, const data::Figures& f) {
  if (f.count == 0) return {};
  const std::string std = f.count > 1 ? format_value(f.std, 5) : "–";
  return fmt::format("  {:<22} {:>9} {:>9} {:>9.5f} {:>9} {:>9.5f} {:>9.5f} {:>7} {:>7.0f}\n", what, std,
                     format_value(standard_error_of_std(f), 5), f.mean, format_value(standard_error_of_mean(f), 5),
                     f.rmse, f.max_abs, f.count, f.effective.of_std);
}

std::string describe_floor(const model::Verification& v) {
  if (v.floor.differences == 0) return fmt::format("  noise floor of the record: none, {}\n", v.floor.statement);
  std::string text = fmt::format("  noise floor of the record: {} °/h ({}, {} differences)\n",
                                 plot::format_with_error(v.floor.deg_per_h, v.floor.error_deg_per_h), v.floor.statement,
                                 v.floor.differences);
  if (v.trained_on_this && v.effective_parameters > 0) {
    text += fmt::format("  expected in-sample std with {:.0f} effective parameters: {:.5f} °/h\n",
                        v.effective_parameters, v.expected_in_sample_std);
  }
  return text;
}

std::string describe_coverage(const model::Verification& v) {
  if (v.has_own_reference)
    return "  intervals of compensated means: not judged, because the bias reference is a mean of this record\n";
  if (!v.coverage) return "  intervals of compensated means: unknown, the model has no uncertainty budget\n";
  const model::Coverage& c = *v.coverage;
  return fmt::format(
      "  {:.0f} % intervals: ± {:.5f} °/h on average; {:.1f} % of {} means lie within their interval (n_eff "
      "{:.0f}){}\n",
      100 * c.nominal, c.mean_half_width_deg_per_h, 100 * c.seen, c.clusters, c.effective,
      v.trained_on_this ? ", in-sample" : "");
}

/// Describes the streamed compensation, averaged over the same clusters, next to predictions without its lag.
std::string describe_streamed(const model::Verification& v) {
  if (!v.streamed) return {};
  const model::StreamResult& s = *v.streamed;
  std::string text = row("as streamed", s.residual) + row("  without its lag", s.aligned);
  if (s.to_truth) text += row("  error vs. true bias", s.to_truth->figures);
  if (s.aligned_to_truth) text += row("  … without its lag", s.aligned_to_truth->figures);
  return text;
}

std::string describe(const model::RunScatter& between) {
  return fmt::format(
      "between {} unseen runs: mean of a run {:.5f} °/h, std {:.5f} °/h ({} degrees of freedom), U {:.5f} °/h\n",
      between.runs, between.mean_deg_per_h, between.std_deg_per_h, between.degrees_of_freedom,
      between.expanded_deg_per_h);
}

std::string describe(const model::TurnOn& turn_on) {
  return fmt::format("turn-on at {:g} °C, {} starts: std of the final bias {:.5f} → {:.5f} °/h\n", turn_on.set_point_c,
                     turn_on.starts, turn_on.std_before_deg_per_h, turn_on.std_after_deg_per_h);
}

/// Describes each detected noise term: "  N  angle random walk  (3.01 ± 0.02) × 10⁻⁴ °/√h, read at τ = 3600 s".
std::string describe_noise(const data::HoldNoise& noise) {
  std::string text = fmt::format("  {}\n", noise.statement);
  if (noise.curve.empty()) return text;
  for (const data::NoiseCoefficient& c : noise.fit.coefficients) {
    const data::NoiseTermInfo& about = info(c.term);
    const double read_s = c.term == data::NoiseTerm::bias_instability ? noise.fit.lowest_tau_s : about.read_off_s;
    const char* beyond = read_s > noise.curve.back().tau_s ? ", beyond the curve" : "";
    const std::string value =
        c.seen ? fmt::format("{} {}, read at τ = {:.0f} s{}", plot::format_with_error(c.value, c.error), about.unit,
                             read_s, beyond)
               : fmt::format("not detected, < {} {}", plot::format_significant(c.at_most), about.unit);
    text += fmt::format("    {} {:<18} {}\n", about.symbol, about.name, value);
  }
  return text;
}

/// Noise and characterisation of one record, before and after compensation.
struct Behaviour {
  data::HoldNoise raw, compensated;
  bool has_hold{};
  model::Characterisation characterisation;
};

std::string describe(const char* what, const char* unit, const model::BeforeAfter& figures) {
  if (!std::isfinite(figures.before.value)) return "";
  const auto number = [](const model::MeasuredValue& measured) {
    return plot::format_with_error(measured.value, measured.u);
  };
  return fmt::format("    {:<22} {} → {} {}\n", what, number(figures.before), number(figures.after), unit);
}

std::string describe(const model::Characterisation& result) {
  std::string text = fmt::format("  before → after compensation; stabilised: {}\n", result.statement);
  text += describe("temperature", "°/h/K", result.temperature) + describe("ramp", "°/h/(K/min)", result.ramp) +
          describe(("gradient " + result.gradient).c_str(), "°/h/K", result.of_gradient);
  if (!result.sensitivity_statement.empty()) text += "    " + result.sensitivity_statement + "\n";
  if (const auto* point = find_widest(result.hysteresis, &model::BeforeAfter::before))
    text +=
        describe("hysteresis, greatest", fmt::format("°/h near {:g} °C", point->temperature_c).c_str(), point->width);
  if (!result.retrace.empty())
    text += describe("retrace, last", fmt::format("°/h at {:g} °C", result.retrace.back().set_point_c).c_str(),
                     result.retrace.back().change);
  for (const model::TwoPosition& found : result.two_position) {
    text += describe("bias, both positions", fmt::format("°/h at {:g} °C", found.set_point_c).c_str(), found.bias);
    const bool is_stated = std::isfinite(found.stated_earth_rate_deg_per_h);
    text += describe("earth rate, by turning",
                     is_stated
                         ? fmt::format("°/h; the rig file states {:.5f} °/h", found.stated_earth_rate_deg_per_h).c_str()
                         : "°/h",
                     found.earth_rate);
  }
  const auto minutes = [](const model::MeasuredValue& seconds) {
    return std::isfinite(seconds.value) ? fmt::format("{:.0f} min", seconds.value / 60) : "not in this hold";
  };
  for (const model::WarmUp& found : result.warm_ups)
    text += fmt::format("    {:<22} {} → {} to within {:.5f} → {:.5f} °/h at {:g} °C, if switched on {}\n", "warm-up",
                        minutes(found.seconds.before), minutes(found.seconds.after), found.within.before.value,
                        found.within.after.value, found.set_point_c, describe_switch_on(found));
  return text;
}

/// Returns a table of the denoisers, and a test of the filter's innovations.
std::string describe(const tracking::Assessment& assessment) {
  std::string text = fmt::format(
      "  tracking of the residual bias in steps of {:g} s; {}\n  {:<22} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} "
      "{:>9} "
      "{:>9} {:>9}\n",
      assessment.interval_s, app::describe(assessment.noise), fmt::format("{} hours predicted", assessment.hours),
      "delay, s", "next hour", "±", "shuffled", "ADEV step", "ADEV hour", "step, s", "overshoot", "ramp, s",
      "overshoot");
  for (const tracking::DenoiserFigures& f : assessment.denoisers) {
    text +=
        fmt::format("  {:<22} {:>9.0f} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", f.name, f.latency_s,
                    format_value(f.next_hour_rmse, 5), format_value(f.next_hour_rmse_error, 5),
                    format_value(f.shuffled_gain, 3), format_value(f.allan_interval, 5), format_value(f.allan_hour, 5),
                    format_value(f.response.step_delay_s, 0), format_value(f.response.step_overshoot, 3),
                    format_value(f.response.ramp_delay_s, 0), format_value(f.response.ramp_overshoot_deg_per_h, 3));
  }
  const tracking::Consistency& c = assessment.consistency;
  return text + fmt::format(
                    "  steady-state Kalman gain {:.3g}; innovations: NIS {} (expected {} to {}), Ljung–Box {} of {} "
                    "lags, p = {}\n",
                    assessment.steady_gain, format_value(c.mean_square, 3), format_value(c.low, 3),
                    format_value(c.high, 3), format_value(c.whiteness.statistic, 1), c.whiteness.lags,
                    format_value(c.whiteness.probability, 4));
}

using Tracked = std::optional<tracking::Assessment>;

std::string describe(const std::string& run, const model::Verification& v, const Behaviour& behaviour,
                     const Tracked& tracked) {
  std::string text =
      fmt::format("{}{}\n  {:<22} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>7} {:>7}\n", v.simulated ? "SIMULATED " : "",
                  run, "°/h", "std", "±", "mean", "±", "rmse", "max", "n", "n_eff");
  text += row("raw bias", v.raw) + row("compensated", v.compensated) + row("  ramps", v.ramps) +
          row("  holds", v.holds) + row("  10 min after corners", v.corners);
  if (v.to_truth) text += row("error vs. true bias", v.to_truth->figures);
  if (v.to_truth && v.to_truth->mean_removed)
    text += "  bias reference: mean of this record; the mean of the error relative to the true bias is removed\n";
  text += describe_streamed(v) + describe_coverage(v) + describe_floor(v);
  if (behaviour.has_hold) text += describe_noise(behaviour.raw) + describe_noise(behaviour.compensated);
  text += describe(behaviour.characterisation);
  if (tracked) text += describe(*tracked);
  text += "  " + describe_verdict(v.verdict) + "\n";
  for (const auto& warning : v.warnings) text += "  warning: " + warning + "\n";
  return text;
}

std::string json(const std::string& run, const model::Verification& v, const Behaviour& behaviour,
                 const Tracked& tracked) {
  Json object{{"run", run},
              {"simulated", v.simulated},
              {"trained_on_this", v.trained_on_this},
              {"raw", make_json(v.raw)},
              {"compensated", make_json(v.compensated)},
              {"ramps", make_json(v.ramps)},
              {"holds", make_json(v.holds)},
              {"corners", make_json(v.corners)},
              {"to_truth", make_json(v.to_truth)},
              {"noise_floor_deg_per_h", v.floor.deg_per_h},
              {"noise_floor_error_deg_per_h", v.floor.error_deg_per_h},
              {"noise_floor_statement", v.floor.statement},
              {"effective_parameters", make_json(known(v.effective_parameters))},
              {"expected_in_sample_std_deg_per_h", v.expected_in_sample_std},
              {"allan", make_json(behaviour.raw)},
              {"allan_compensated", make_json(behaviour.compensated)},
              {"characterisation", make_json(behaviour.characterisation)},
              {"outside_trained_range", v.outside.clusters},
              {"outside", make_json(v.outside)},
              {"coverage", make_json(v.coverage)},
              {"verdict", make_json(v.verdict)},
              {"warnings", v.warnings}};
  if (v.streamed) object["evaluate_stream"] = make_json(*v.streamed);
  if (tracked) object["tracking"] = make_json(*tracked);
  return json_text(object) + "\n";
}

Result<Exit> verify_all(Console& console, const VerifyArguments& options) {
  const auto outside = model::parse_outside(options.outside);
  if (!outside) return failure(outside.error());
  const auto model = load_model(options.model);
  if (!model) return failure(model.error());
  const auto noise =
      find_tracking_noise(console, *model, options.tracking, {.unverified = options.unverified, .axis = options.axis});
  if (!noise) return failure(noise.error());
  std::vector<model::Verification> verifications;
  std::vector<model::Characterisation> starts;
  std::vector<model::ReadingsSample> sampled;
  std::set<std::string> gyros;
  for (const auto& run : options.runs) {
    const auto recorded = load_recorded_run(
        console, run, {options.clusters, options.unverified, axis_for(*model, options.axis), model->cluster_length_s});
    if (!recorded) return failure(recorded.error());
    if (auto distinct = model::check_distinct(recorded->dataset, recorded->clusters, sampled); !distinct)
      return failure(distinct.error());
    sampled.push_back(model::sample_readings(recorded->dataset, recorded->clusters));
    auto verification = verify(*model, recorded->dataset, recorded->clusters, *outside);
    if (!verification) return failure(verification.error());
    const auto& [dataset, clusters] = *recorded;
    for (std::string& warning : import_warnings(dataset, clusters))
      verification->warnings.push_back(std::move(warning));
    if (options.evaluate_stream) {
      auto streamed = evaluate_stream(*model, dataset, clusters, verification->residual_deg_per_h, *outside);
      if (!streamed) return failure(streamed.error());
      verification->streamed = *streamed;
    }
    const Behaviour behaviour{
        options.clusters.empty() ? measure_hold_noise(dataset) : measure_hold_noise(dataset, clusters),
        measure_compensated_hold_noise(dataset, clusters, verification->residual_deg_per_h), data::has_hold(dataset),
        model::characterise(dataset, clusters, verification->residual_deg_per_h)};
    Tracked tracked;
    if (*noise) {
      const auto residual = tracking::space_evenly(verification->residual_deg_per_h, clusters);
      tracked = assess(**noise, residual, clusters.length_s);
    }
    console.print_report(console.json ? json(run, *verification, behaviour, tracked)
                                      : describe(run, *verification, behaviour, tracked));
    if (!verification->identity.empty()) gyros.insert(verification->identity);
    verifications.push_back(std::move(*verification));
    starts.push_back(behaviour.characterisation);
  }
  if (const auto between = compute_run_scatter(verifications))
    console.print_report(console.json ? json_text(Json{{"between_runs", make_json(*between)}}) + "\n"
                                      : describe(*between));
  if (gyros.size() > 1) return Exit::done;  // different gyros give no repeatability
  for (const model::TurnOn& turn_on : model::turn_on_scatter(starts))
    console.print_report(console.json ? json_text(Json{{"turn_on", make_json(turn_on)}}) + "\n" : describe(turn_on));
  return Exit::done;
}

}  // namespace

void add_verify(Program& program) {
  auto [command, options] =
      add_command(program, "verify", "Verifies a model on records that were not used in its training.",
                  "gyrotherm verify model.json random.db", verify_all);
  command.add_option("model", options.model, "the model")->type_name(value::kModel)->required();
  command.add_option("runs", options.runs, "the records")->type_name(value::kRecord)->required();
  command.add_option("--clusters", options.clusters, "only these clusters of each record, like 14:21")
      ->type_name("FIRST:END");
  add_outside_option(command, options.outside, "not compensated, excluded from the statistics");
  command.add_flag("--as-streamed", options.evaluate_stream,
                   "also evaluate the second-by-second output of compensate and of the C export, which lags");
  add_tracking_options(command, options.tracking,
                       "also evaluate tracking of the residual bias while the gyro is at rest, by a Kalman filter and "
                       "by methods for comparison");
  add_axis_options(command, options.axis);
  add_unverified_flag(command, options.unverified);
}

}  // namespace gyrotherm::app
