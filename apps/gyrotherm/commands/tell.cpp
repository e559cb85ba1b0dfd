// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/status.hpp"
#include "apps/console/command.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "sequencer/control/control_socket.hpp"

namespace gyrotherm::app {
namespace {

constexpr Duration kAnswerTimeout = std::chrono::seconds(5);

struct TellArguments {
  std::string run;
  std::string word;
  std::vector<std::string> texts;
};

/// Names the cause of a fault if the file is not the record of a run in progress.
Fault explain_fault(const std::string& run, const Fault& fault) {
  if (fault.kind != FaultKind::usage) return fault;
  if (const auto original = record::record_of_copy(run); original != run)
    return {FaultKind::usage, run, fmt::format("is the live copy of a record, expected {}", original)};
  if (const auto info = record::read_info(run); info && info->imported)
    return {FaultKind::usage, run, "is an imported record, which no program runs"};
  if (record::path_exists(run) && !begins_with(run, kSqliteBeginning).value_or(false))
    return {FaultKind::bad_file, run, "is not a record, expected the record of the run, RUN.db"};
  const auto status = record::read_status(run);
  if (!status || !status->finished) return fault;
  return {
      FaultKind::usage, run,
      fmt::format("this run has finished ({}) and its record is closed: no request can be sent, and its alarms need "
                  "no acknowledgement",
                  status->ended_by)};
}

Result<Exit> send_request(Console& console, const TellArguments& options) {
  if (!record::path_exists(options.run) && record::path_exists(options.word))
    return failure(FaultKind::usage, "tell",
                   fmt::format("the record comes before the request: gyrotherm tell {} {}", options.word, options.run));
  const auto request = control::make_request(options.word, fmt::format("{}", fmt::join(options.texts, " ")));
  if (!request) return failure(request.error());
  const auto answer = control::send_request(options.run, *request, kAnswerTimeout);
  if (!answer) return failure(explain_fault(options.run, answer.error()));
  if (!answer->done) return failure(FaultKind::refused, options.run, answer->text);
  if (console.json)
    console.print(json_text(Json{{"done", answer->text}}) + "\n");
  else
    console.print_message(options.run + ": " + answer->text);
  return Exit::done;
}

}  // namespace

void add_tell(Program& program) {
  auto [command, options] = add_command(
      program, "tell",
      "Sends a request to the program that is running a run; each request is recorded with time and "
      "user.\n\n"
      "pause: stops the clock of the profile and keeps the set point until resume.\n"
      "resume: continues; if the profile has prompted the operator, the text is the answer.\n"
      "stop: ends the run and leaves the chamber in the state that the rig file defines; the text is the reason.\n"
      "abort: ends the run and makes the chamber safe; the text is the reason.\n"
      "drop UNIT: ends recording and monitoring of this unit, with a reason; the run continues for the "
      "others.\n"
      "return UNIT: puts it back into the run.\n"
      "acknowledge ALARMS: acknowledges alarms by their numbers in status, such as 12 or 12,15,40, or all, with a "
      "comment.\n"
      "shelve ALARM TIME: does not announce a warning for this time, at most 24 h, with a reason: shelve 12 \"2 h\" "
      "\"the fan is being replaced\".\n"
      "unshelve ALARM: announces it again.\n"
      "note: adds a line of text to the record.",
      "gyrotherm tell random.db note \"door opened to look at the cable\"", send_request);
  command.add_option("run", options.run, "the record")->type_name(value::kRecord)->required();
  command
      .add_option("word", options.word,
                  "pause, resume, stop, abort, drop, return, acknowledge, shelve, unshelve or note")
      ->type_name("WORD:{pause,resume,stop,abort,drop,return,acknowledge,shelve,unshelve,note}")
      ->required();
  command
      .add_option(
          "text", options.texts,
          "text of the note; for resume the answer; for stop and abort the reason; for drop and return the "
          "unit and the reason; for acknowledge the alarms and a comment; for shelve the alarm, the time and the "
          "reason")
      ->type_name("TEXT");
}

}  // namespace gyrotherm::app
