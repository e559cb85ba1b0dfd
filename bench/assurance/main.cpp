// SPDX-License-Identifier: Apache-2.0
/// Prints a table of the simulation study of the check standard.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "tests/support/check_study.hpp"

namespace gyrotherm::bench {
namespace {

using tests::binomial_interval;
using tests::GoldenGyro;
using tests::Injected;
using tests::median;
using tests::quantile_95;
using tests::StudyOptions;
using tests::StudyResult;

double percent_of(int count, int of) { return of == 0 ? 0 : 100.0 * count / of; }

void print_row(const StudyOptions& options) {
  const StudyResult result = simulate_histories(options);
  const auto alarms = binomial_interval(result.false_alarms, std::max(result.judged_runs, 1));
  const auto named = binomial_interval(result.right, std::max(result.detected, 1));
  fmt::print("{}\t{}\t{}\t{:.2f}\t{:.2f} to {:.2f}\t{}\t{:.0f}\t{:.0f}\t{:.1f}\t{:.1f} to {:.1f}\t{:.1f}\t{:.1f}\n",
             name(options.golden), name(options.injected), result.judged_runs,
             percent_of(result.false_alarms, result.judged_runs), 100 * alarms.low, 100 * alarms.high, result.detected,
             median(result.runs_to_detection), quantile_95(result.runs_to_detection),
             percent_of(result.right, result.detected), 100 * named.low, 100 * named.high,
             percent_of(result.wrong, result.detected), percent_of(result.not_told, result.detected));
  std::fflush(stdout);
}

int run_program(int argc, char** argv) {
  StudyOptions options;
  CLI::App app{"Check runs of golden gyros with injected changes: detection, false alarms, named causes."};
  app.add_option("--seeds", options.seeds, "histories of each row");
  app.add_option("--rate", options.false_alarm_rate, "stated false alarms per check run");
  app.add_option("--repeats", options.repeats, "check runs repeated after an alarm until a cause is named");
  app.add_option("--grows-over", options.grows_over, "number of runs over which the change grows; 1: a step");
  CLI11_PARSE(app, argc, argv);
  fmt::print("golden\tchange\tjudged\tfalse %\t95 %\tdetected\tmedian\t95 % of\tright %\t95 %\twrong %\tnot told %\n");
  for (const auto golden : {GoldenGyro::single, GoldenGyro::turned, GoldenGyro::triad})
    for (const auto injected : {Injected::none, Injected::thermometer, Injected::mount, Injected::gyro}) {
      options.golden = golden;
      options.injected = injected;
      print_row(options);
    }
  return 0;
}

}  // namespace
}  // namespace gyrotherm::bench

int main(int argc, char** argv) { return gyrotherm::bench::run_program(argc, argv); }
