// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/import.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "acquisition/exchange/guess.hpp"
#include "acquisition/record/run_parts.hpp"
#include "app/command.hpp"
#include "app/interrupt.hpp"
#include "app/output_file.hpp"
#include "app/value.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/shipped.hpp"

namespace gyrotherm::app {
namespace {

struct ImportArguments {
  std::string file, map, out;
  bool guess = false;
};

Result<Exit> guess(Console& console, const ImportArguments& options) {
  if (!options.map.empty()) return failure(FaultKind::usage, "--guess", "makes a map; --map names one that is there");
  const auto map = exchange::guess_map(options.file);
  if (!map) return failure(map.error());
  if (options.out.empty()) {
    console.data(*map);
    return Exit::done;
  }
  if (std::filesystem::exists(options.out))
    return failure(FaultKind::storage, options.out,
                   "exists already, and a map that somebody corrected is not replaced");
  if (auto written = replace_text_file(options.out, *map); !written) return failure(written.error());
  console.say(fmt::format("{}: a first map, guessed; look at every line, then import with it", options.out));
  return Exit::done;
}

Result<Exit> import(Console& console, const ImportArguments& options) {
  if (options.guess) return guess(console, options);
  if (options.map.empty())
    return failure(FaultKind::usage, "--map", "which column is what? Name a map, or let --guess make a first one");
  if (options.out.empty()) return failure(FaultKind::usage, "--out", "where to? Name the record");
  if (auto can_be = check_can_be_made(options.out); !can_be) return failure(can_be.error());
  if (auto free = record::check_name_of_new_record(options.out); !free) return failure(free.error());
  const auto map = path_of(options.map, kShippedImportMap);
  if (!map) return failure(map.error());
  watch_for_interrupts(SecondInterrupt::ends);
  const auto summary =
      exchange::import_record(options.file, *map, options.out, GYROTHERM_VERSION, [] { return !interrupted(); });
  if (!summary) return failure(summary.error());
  for (const std::string& note : summary->notes) console.say(fmt::format("{}: {}", options.file, note));
  if (console.json)
    console.data(fmt::format("{{\"rows\": {}, \"seconds\": {:.3f}, \"gaps\": {}}}\n", summary->rows,
                             to_seconds(summary->span), summary->silences));
  else
    console.say(fmt::format("{}: {} rows over {}, {} gaps", options.out, summary->rows, spoken(summary->span),
                            summary->silences));
  return Exit::done;
}

}  // namespace

void add_import(Program& program) {
  auto [command, options] =
      add_command(program, "import", "Makes a record of a foreign table or log, as a column map says.",
                  "gyrotherm import table.csv --map freeimu --out freeimu.db", import);
  command.add_option("file", options.file, "a text table, a log of PX4 or ArduPilot, or NetCDF")
      ->type_name(value::kTable)
      ->required();
  command.add_option("--map", options.map, "which column is what")->type_name(value::kMap);
  command.add_option("--out", options.out, "the record; with --guess the map")
      ->check(not_a_dash())
      ->type_name(value::kRecord);
  command.add_flag("--guess", options.guess, "writes a first map of the file, to be corrected: to stdout, or to --out");
}

}  // namespace gyrotherm::app
