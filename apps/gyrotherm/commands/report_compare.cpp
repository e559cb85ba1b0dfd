// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "apps/gyrotherm/commands/report_commands.hpp"
#include "apps/gyrotherm/report/calibration_folder.hpp"
#include "report/comparison.hpp"

namespace gyrotherm::app {
namespace {

struct CompareArguments {
  std::string before, now, out;
  std::vector<std::string> languages{"en"};
};

Result<Exit> compare_two(Console& console, const CompareArguments& options) {
  const auto before = load_calibration(options.before), now = load_calibration(options.now);
  if (!before || !now) return failure(before ? now.error() : before.error());
  auto comparison = report::compare(before->report, now->report);
  if (!comparison) return failure(comparison.error());
  comparison->before_sha256 = before->sha256;
  comparison->now_sha256 = now->sha256;
  console.data(console.json ? to_json(*comparison) : describe(*comparison));
  if (options.out.empty()) return Exit::done;
  return write_comparison(console, *comparison, options.out, options.languages).map([] { return Exit::done; });
}

}  // namespace

void add_report_compare(Program& program, CLI::App& report) {
  auto [command, options] =
      add_subcommand(program, report, "compare",
                     "Says how a unit has changed between two calibrations, each change with its U and E_n.",
                     "gyrotherm report compare 2025/calibration 2026/calibration", compare_two);
  command.add_option("before", options.before, "the folder of the first report, or its calibration.json")
      ->type_name(value::kFolder)
      ->required();
  command.add_option("now", options.now, "… of the second one")->type_name(value::kFolder)->required();
  command.add_option("--out", options.out, "also write comparison.json and its page into this folder")
      ->check(not_a_dash())
      ->type_name(value::kFolder);
  add_languages(command, options.languages);
}

}  // namespace gyrotherm::app
