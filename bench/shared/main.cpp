// SPDX-License-Identifier: Apache-2.0
/// Measures the benefit of learning from several units of one type, and from several axes of one unit.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "bench/shared/sections.hpp"

namespace gyrotherm::bench {
namespace {

Result<void> measure_folder(const std::string& folder, int count, const std::string& inputs) {
  const auto units = load_units(folder, count);
  if (!units) return failure(units.error());
  if (const auto measured = measure_correlation(*units, inputs); !measured) return measured;
  return measure_units(*units, inputs);
}

int run_program(int argc, char** argv) {
  std::string folder, inputs = "seven-point,A";
  int count = 12;
  CLI::App app{"Shared learning: units of one type, and axes whose unexplained parts correlate."};
  app.require_subcommand(1);
  CLI::App* units = app.add_subcommand(
      "units", "measure the type prior on rate-N.db and random-N.db in FOLDER, for the seeds 1 … --units");
  units->add_option("folder", folder)->required();
  units->add_option("--units", count)->check(CLI::Range(4, 1000));
  units->add_option("--inputs", inputs, "keywords and terms as for train --inputs");
  const CLI::App* synthetic = app.add_subcommand("synthetic", "measure joint learning on synthetic correlated axes");
  CLI11_PARSE(app, argc, argv);
  const auto measured = synthetic->parsed() ? measure_synthetic() : measure_folder(folder, count, inputs);
  if (measured) return 0;
  fmt::print(stderr, "{}\n", text(measured.error()));
  return 1;
}

}  // namespace
}  // namespace gyrotherm::bench

int main(int argc, char** argv) { return gyrotherm::bench::run_program(argc, argv); }
