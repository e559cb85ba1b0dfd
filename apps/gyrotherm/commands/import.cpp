// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/import.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "acquisition/exchange/guess.hpp"
#include "acquisition/record/record_files.hpp"
#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/output_file.hpp"
#include "core/clock.hpp"
#include "core/count_text.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/shipped.hpp"
#include "core/text.hpp"

namespace gyrotherm::app {
namespace {

struct ImportArguments {
  std::string file, map, out;
  bool guess = false;
};

Result<Exit> draft_map(Console& console, const ImportArguments& options) {
  if (!options.map.empty())
    return failure(FaultKind::usage, "--guess", "creates a map; not valid with --map, which names an existing map");
  if (auto named = check_is_toml(options.out, "a map"); !options.out.empty() && !named) return failure(named.error());
  const auto map = exchange::guess_map(options.file);
  if (!map) return failure(map.error());
  if (options.out.empty()) {
    console.print(*map);
    return Exit::done;
  }
  if (std::filesystem::exists(options.out))
    return failure(FaultKind::storage, options.out, "exists; a column map is never overwritten");
  if (auto written = replace_text_file(options.out, *map); !written) return failure(written.error());
  console.print_message(fmt::format("{}: draft map; check every line, then import with it", options.out));
  return Exit::done;
}

/// Returns the time of the first row, rounded to a second: a serial date has only eight decimals.
std::string format_start(Duration started) { return civil_time(std::chrono::round<std::chrono::seconds>(started)); }

/// Returns the channels whose temperatures are so high that they are probably kelvins.
std::vector<std::string> find_kelvins(const exchange::ImportSummary& summary) {
  constexpr double kLowest_k = 200, kHighest_k = 400;
  std::vector<std::string> names;
  for (const auto& channel : summary.channels)
    if (channel.unit == "°C" && channel.values > 0 && channel.least > kLowest_k && channel.greatest < kHighest_k)
      names.push_back(channel.name);
  return names;
}

/// Describes the rows of the file, their spacing, and whether they are combined.
std::string rows_line(const exchange::ImportSummary& summary) {
  const auto spacing = [](Duration step) { return fmt::format("{:g} s", to_seconds(step)); };
  const std::string file_step = summary.file_step ? spacing(*summary.file_step) : "";
  const bool has_same_times = !file_step.empty() && 2 * summary.repeated_times > summary.file_rows;
  std::string rows = format_count(summary.file_rows, "row") + " in the file";
  if (has_same_times)
    rows += fmt::format(
        ", on average {:.3g} s apart; their times have a resolution of {}, so rows with the same time are combined",
        to_seconds(summary.span + summary.step) / static_cast<double>(summary.file_rows), file_step);
  else if (!file_step.empty())
    rows += fmt::format(", usually {} apart", file_step);
  if (summary.file_rows > 1 && file_step != spacing(summary.step))
    rows += fmt::format("{} into rows of {}", has_same_times ? "" : ", combined", spacing(summary.step));
  if (summary.started) rows += ", from " + format_start(*summary.started);
  return rows;
}

/// Describes the rows and each channel for people.
std::vector<std::string> value_lines(const exchange::ImportSummary& summary) {
  constexpr std::size_t kMaxListedChannels = 40;
  std::vector<std::string> lines{rows_line(summary)};
  for (const auto& channel : summary.channels)
    if (lines.size() <= kMaxListedChannels) lines.push_back(describe(channel));
  if (summary.channels.size() > kMaxListedChannels)
    lines.push_back(
        fmt::format("and {} more channels; --json lists all", summary.channels.size() - kMaxListedChannels));
  return lines;
}

std::string json(const exchange::ImportSummary& summary) {
  Json channels = Json::array();
  for (const auto& channel : summary.channels) {
    Json object{{"name", channel.name},
                {"column", channel.column},
                {"unit", channel.unit},
                {"values", channel.values},
                {"missing", channel.missing},
                {"outside", channel.outside},
                {"missing_texts", Json::object()},
                {"least", nullptr},
                {"greatest", nullptr}};
    for (const auto& [text, count] : channel.missing_texts) object["missing_texts"][plain(text)] = count;
    if (channel.values > 0) {
      object["least"] = channel.least;
      object["greatest"] = channel.greatest;
    }
    channels.push_back(std::move(object));
  }
  Json object{{"rows", summary.rows},
              {"seconds", to_seconds(summary.span)},
              {"gaps", summary.gaps},
              {"file_rows", summary.file_rows},
              {"step_s", to_seconds(summary.step)},
              {"file_step_s", summary.file_step ? Json(to_seconds(*summary.file_step)) : Json(nullptr)},
              {"lines_left_out", summary.lines_left_out},
              {"rows_left_out", summary.rows_left_out},
              {"started_utc", summary.started ? Json(format_start(*summary.started)) : Json(nullptr)},
              {"notes", summary.notes},
              {"channels", std::move(channels)}};
  return json_text(object) + "\n";
}

Result<Exit> import(Console& console, const ImportArguments& options) {
  if (options.guess) return draft_map(console, options);
  if (options.map.empty())
    return failure(FaultKind::usage, "--map", "is missing; name a column map, or make a draft with --guess");
  if (options.out.empty()) return failure(FaultKind::usage, "--out", "is missing; name the record");
  if (auto can_create = check_can_create(options.out); !can_create) return failure(can_create.error());
  if (auto free = record::check_name_of_new_record(options.out); !free) return failure(free.error());
  const auto map = resolve_path(options.map, kShippedImportMap);
  if (!map) return failure(map.error());
  watch_for_interrupts(SecondInterrupt::ends);
  const auto summary = exchange::import_record(
      options.file, *map, options.out, GYROTHERM_VERSION, [] { return !interrupted(); }, SteadyClock().now().utc);
  if (!summary) return failure(summary.error());
  for (const std::string& name : find_kelvins(*summary))
    console.print_message(
        fmt::format("warning: {}: the values of {} look like kelvins; if they are, set offset = "
                    "-273.15 for its column in the map and import again",
                    options.file, name));
  for (const std::string& note : summary->notes) console.print_message(fmt::format("{}: {}", options.file, note));
  if (console.json) {
    console.print(json(*summary));
    return Exit::done;
  }
  console.print_message(fmt::format("{}: {} over {}, {}", options.out, format_count(summary->rows, "row"),
                                    format_duration(summary->span), format_count(summary->gaps, "gap")));
  for (const std::string& line : value_lines(*summary)) console.print_message("  " + line);
  return Exit::done;
}

}  // namespace

void add_import(Program& program) {
  auto [command, options] =
      add_command(program, "import", "Imports a table or log of another program into a record, with a column map.",
                  "gyrotherm import table.csv --map freeimu --out freeimu.db", import);
  command.add_option("file", options.file, "a text table, a PX4 or ArduPilot log, or NetCDF")
      ->type_name(value::kTable)
      ->required();
  command.add_option("--map", options.map, "column map")->type_name(value::kMap);
  command.add_option("--out", options.out, "the record, or with --guess the map")
      ->check(reject_dash())
      ->type_name(value::kRecord);
  command.add_flag("--guess", options.guess, "write a draft map of the file, to be corrected, to --out or stdout");
}

}  // namespace gyrotherm::app
