// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "apps/console/command.hpp"
#include "apps/gyrotherm/new_rig/interview.hpp"
#include "apps/gyrotherm/new_rig/new_files.hpp"
#include "apps/gyrotherm/new_rig/rig_copy.hpp"
#include "apps/gyrotherm/new_rig/rig_probe.hpp"
#include "apps/gyrotherm/new_rig/rig_questions.hpp"
#include "apps/gyrotherm/new_rig/rig_text.hpp"
#include "apps/gyrotherm/output_file.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::app {
namespace {

struct AnswerOption {
  const char* name;
  const char* type;
  const char* description;
};

constexpr std::array kAnswerOptions{
    AnswerOption{"--chamber", "NAME",
                 "shipped map or description of the chamber, or the path of one; other-modbus or "
                 "other-text for a chamber without"},
    AnswerOption{"--chamber-line", "LINE", "tcp://A.B.C.D:PORT or serial:/dev/NAME?9600,8N1"},
    AnswerOption{"--chamber-unit", "N", "number of the controller on the Modbus (default: that of the map)"},
    AnswerOption{"--lowest", "T", "lowest set point, °C, for chamber and unit together"},
    AnswerOption{"--highest", "T", "highest set point, °C"},
    AnswerOption{"--fastest", "RATE", "fastest rate of heating and cooling, °C/min"},
    AnswerOption{"--safe", "T", "safe set point, °C (default: 20)"},
    AnswerOption{"--air", "\"T T\"",
                 "lowest and highest air temperature at which a run ends, °C (default: 10 K beyond "
                 "the set points, or halfway to the limiter if that is nearer)"},
    AnswerOption{"--limiter", "TEXT",
                 "class and settings of the chamber's own limiter, \"3.3 -50 75\" (default: "
                 "unknown)"},
    AnswerOption{"--gyro", "NAME", "shipped stream of the gyro, or the path of one; other for a gyro without"},
    AnswerOption{"--gyro-line", "LINE", "tcp://A.B.C.D:PORT or serial:/dev/NAME?115200,8N1"},
    AnswerOption{"--gyro-axis", "AXIS", "axis of a stream with several (default: that of the stream)"},
    AnswerOption{"--arcsec-per-pulse", "X", "angle of one pulse, for frames that count pulses"},
    AnswerOption{"--latitude", "DEG", "latitude, degrees, north positive, or unknown"},
    AnswerOption{"--azimuth", "DEG", "input axis from true north, degrees (default: 0)"},
    AnswerOption{"--elevation", "DEG", "input axis above the horizontal, degrees (default: 90, up)"},
    AnswerOption{"--serial-number", "TEXT", "serial number of the unit (default: none; the program asks at each run)"},
    AnswerOption{"--title", "TEXT", "title of the rig"}};

struct NewRigArguments {
  std::string file;
  std::array<std::string, kAnswerOptions.size()> answers;
  std::vector<std::string> scanners;
  std::string like;
  bool yes = false;
  bool no_probe = false;
};

GivenAnswers given_answers(const NewRigArguments& options) {
  GivenAnswers given{.values = {}, .scanners = options.scanners};
  for (std::size_t i = 0; i < kAnswerOptions.size(); ++i)
    if (!options.answers[i].empty()) given.values.emplace(kAnswerOptions[i].name, options.answers[i]);
  return given;
}

/// Returns what a person must still fill in in a text, one per line; empty if nothing.
std::string list_to_fill_in(const std::string& text, const std::string& path) {
  const auto table = TomlTable::parse(text, path);
  return table ? "" : gyrotherm::text(table.error());
}

/// The rig file and the probes of its instruments.
struct Draft {
  std::vector<NewFile> files;
  std::vector<Probe> probes;
  std::string to_fill_in;
};

/// Writes the texts of a rig whose chamber, scanner or gyro has no description yet.
Draft draft_incomplete(const RigAnswers& answers) {
  Draft draft;
  if (const auto path = chamber_file_path(answers); !path.empty())
    draft.files.push_back({path, write_chamber_text(answers)});
  draft.files.push_back({answers.file, write_rig_text(answers, {})});
  for (const auto& [path, text] : draft.files)
    if (auto lines = list_to_fill_in(text, path); !lines.empty())
      draft.to_fill_in += (draft.to_fill_in.empty() ? "" : "\n") + lines;
  return draft;
}

Result<rig::RigFile> parse_draft(const RigAnswers& answers) {
  auto rig = rig::parse_rig(write_rig_text(answers, {}), answers.file);
  if (rig) return rig;
  return failure(FaultKind::usage, "new rig", "the answers do not fit together: " + text(rig.error()));
}

/// Parses the text of the rig, probes its instruments, and adds the findings to the text.
Result<Draft> draft_complete(RigAnswers answers, bool probes) {
  auto rig = parse_draft(answers);
  if (!rig) return failure(rig.error());
  Draft draft;
  std::vector<InstrumentNote> notes;
  if (probes) {
    answers.word_order = find_other_word_order(*rig);
    if (answers.word_order) rig = parse_draft(answers);
    if (!rig) return failure(rig.error());
    draft.probes = probe_instruments(*rig);
    for (const auto& probe : draft.probes) notes.push_back({probe.title, probe.text});
  }
  draft.files.push_back({answers.file, write_rig_text(answers, notes)});
  return draft;
}

bool is_incomplete(const RigAnswers& answers) {
  bool has_other_scanner = false;
  for (const auto& scanner : answers.scanners) has_other_scanner = has_other_scanner || scanner.kind == kOther;
  return !answers.map || !answers.stream || has_other_scanner;
}

void report_draft(Console& console, const Draft& draft, const std::string& file) {
  if (console.json) {
    Json json{{"file", file}, {"to_fill_in", draft.to_fill_in}, {"instruments", Json::array()}};
    for (const auto& probe : draft.probes)
      json["instruments"].push_back({{"title", probe.title}, {"answers", probe.answers}, {"text", probe.text}});
    return console.print(json_text(json) + "\n");
  }
  std::size_t silent = 0;
  for (const auto& probe : draft.probes) {
    console.print(fmt::format("  {}: {}\n", probe.title, probe.text));
    silent += probe.answers ? 0 : 1;
  }
  for (const auto& written : draft.files) console.print(fmt::format("{}: written\n", written.path));
  if (!draft.to_fill_in.empty()) {
    console.print(draft.to_fill_in + "\n");
    return console.print(
        fmt::format("complete these, as docs/adding-an-instrument.md describes, then run: gyrotherm "
                    "check --rig {}\n",
                    rig_argument(file)));
  }
  if (silent > 0) console.print(fmt::format("{} of {} instruments were not identified\n", silent, draft.probes.size()));
  console.print(fmt::format("next: gyrotherm check --rig {} --connect\n", rig_argument(file)));
}

Result<Draft> draft_copy(const NewRigArguments& options) {
  const auto given = given_answers(options);
  if (!given.values.empty() || !given.scanners.empty())
    return failure(FaultKind::usage, "--like", "not valid with answers; edit the copy instead");
  auto text = copy_rig_text(options.like, options.file);
  if (!text) return failure(text.error());
  return Draft{.files = {{options.file, std::move(*text)}}, .probes = {}, .to_fill_in = ""};
}

/// Collects the answers, and drafts a rig from them.
Result<Draft> draft_from_answers(Console& console, const NewRigArguments& options) {
  Person person;
  if (!options.yes && console.can_ask())
    person = {.tell = [&](const std::string& line) { console.print_message(line); },
              .ask = [&](const std::string& question) { return console.ask(question); }};
  const auto answers = collect_answers(options.file, given_answers(options), person);
  if (!answers) return failure(answers.error());
  if (is_incomplete(*answers)) return draft_incomplete(*answers);
  return draft_complete(*answers, !options.no_probe);
}

Result<Exit> make_new_rig(Console& console, const NewRigArguments& options) {
  if (auto possible = check_can_create(options.file); !possible) return failure(possible.error());
  if (read_file_state(options.file).is_there()) return refuse_to_overwrite(options.file);
  const auto draft = options.like.empty() ? draft_from_answers(console, options) : draft_copy(options);
  if (!draft) return failure(draft.error());
  if (auto written = create_files(draft->files); !written) return failure(written.error());
  report_draft(console, *draft, options.file);
  return Exit::done;
}

}  // namespace

void add_new(Program& program) {
  auto& parent = add_command(program, "new", "Writes a new file from the answers to a few questions.",
                             "gyrotherm new rig rig.toml");
  parent.require_subcommand(1);
  auto [command, options] = add_subcommand(
      program, parent, "rig",
      "Writes a rig file from answers, and probes the instruments with questions only. Asks for each answer that no "
      "option gives.",
      "gyrotherm new rig rig.toml", make_new_rig);
  command.add_option("file", options.file, "the rig file to write")
      ->type_name(value::kToml)
      ->required()
      ->check(reject_dash());
  for (std::size_t i = 0; i < kAnswerOptions.size(); ++i) {
    const auto& [name, type, description] = kAnswerOptions[i];
    command.add_option(name, options.answers[i], description)->type_name(type);
  }
  command
      .add_option(kThermometerOption, options.scanners,
                  "kind, line and channels of a scanner, \"lakeshore_218 tcp://10.0.0.6:4001 A B C\"; for dcon also "
                  "addresses=1,2 and type=T. May be repeated")
      ->type_name("TEXT")
      ->allow_extra_args(false);
  command.add_option("--like", options.like, "copy this rig, such as virtual, instead of asking")
      ->type_name(value::kRig);
  command.add_flag("--yes", options.yes, "ask nothing; use the default of each option that is not given");
  command.add_flag("--no-probe", options.no_probe, "contact no instrument");
}

}  // namespace gyrotherm::app
