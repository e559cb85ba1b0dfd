// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/import.hpp"

#include <fmt/format.h>

#include "app/command.hpp"
#include "app/value.hpp"
#include "core/clock.hpp"
#include "core/shipped.hpp"

namespace gyrotherm::app {
namespace {

struct ImportArguments {
  std::string table, map, out;
};

Result<Exit> import(Console& console, const ImportArguments& options) {
  const auto map = path_of(options.map, kShippedImportMap);
  if (!map) return failure(map.error());
  const auto summary = exchange::import_record(options.table, *map, options.out, GYROTHERM_VERSION);
  if (!summary) return failure(summary.error());
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
      add_command(program, "import", "Makes a record of a foreign text table, as a column map says.",
                  "gyrotherm import table.csv --map freeimu --out freeimu.db", import);
  command.add_option("csv", options.table, "the table")->type_name(value::kTable)->required();
  command.add_option("--map", options.map, "which column is what")->type_name(value::kMap)->required();
  command.add_option("--out", options.out, "the record")->type_name(value::kRecord)->required();
}

}  // namespace gyrotherm::app
