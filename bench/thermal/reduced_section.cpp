#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "bench/figure.hpp"
#include "bench/stopwatch.hpp"
#include "bench/thermal/sections.hpp"
#include "core/file.hpp"
#include "thermal/reduced/reduced_model.hpp"
#include "thermal/reduced/reduced_transient.hpp"

namespace gyrotherm {
namespace {

constexpr int kProgrammeSeconds = 221'600;  // four cycles at 1, 2, 3 and 5 °C/min

/// The paper's programme: 20 °C, then −40, 60, −40, 60 and 20 °C, two hours each, at each rate in turn.
std::vector<double> programme_c() {
  std::vector<double> air_c;
  double now_c = 20;
  for (const double rate_per_min : {1.0, 2.0, 3.0, 5.0}) {
    for (const double target_c : {20.0, -40.0, 60.0, -40.0, 60.0, 20.0}) {
      while (now_c != target_c) {
        const double step = rate_per_min / 60;
        now_c = now_c < target_c ? std::min(target_c, now_c + step) : std::max(target_c, now_c - step);
        air_c.push_back(now_c);
      }
      air_c.insert(air_c.end(), 7200, target_c);
    }
  }
  return air_c;
}

double seconds_of(const ReducedModel& model, const std::vector<double>& air_c, bool linear, double& coldest_c) {
  const double start = thread_seconds();
  ReducedTransient reduced(model, {.start = {20}, .linear = linear});
  coldest_c = 1e9;
  for (const double air : air_c) {
    reduced.step({air});
    coldest_c = std::min(coldest_c, reduced.outputs_c()[0]);
  }
  return thread_seconds() - start;
}

}  // namespace

Result<void> measure_reduced(const ThermalBench& bench) {
  const auto words = read_text_file(bench.reduced);
  if (!words) return failure(words.error());
  const auto model = parse_reduced_model(*words, bench.reduced);
  if (!model) return failure(model.error());
  const auto air_c = programme_c();
  say_progress(fmt::format("the programme has {} s, the paper's {}", air_c.size(), kProgrammeSeconds));
  double coldest_c = 0;
  const auto states = fmt::format("twin of {} states", model->conduction.rows());
  print_figure(states + ": whole programme, linear, s", seconds_of(*model, air_c, true, coldest_c), at_most(0.1));
  print_figure(states + ": whole programme, air following its temperature, s",
               seconds_of(*model, air_c, false, coldest_c), at_most(5));
  say_progress(fmt::format("thermometer A comes down to {:.2f} °C", coldest_c));
  print_figure(states + ": most apart from the full model on ramps, K", model->error.ramp_k, at_most(1e-3));
  print_figure(states + ": most apart from the full model when switched on, K", model->error.switch_on_k,
               at_most(1e-2));
  return {};
}

}  // namespace gyrotherm
