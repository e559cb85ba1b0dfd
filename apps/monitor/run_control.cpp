// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/run_control.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/json.hpp"
#include "sequencer/control/control_socket.hpp"

namespace gyrotherm::monitor {
namespace {

constexpr Duration kAnswerWithin = std::chrono::seconds(5);
constexpr std::array kVerbs{"pause", "resume", "stop", "abort", "note", "acknowledge"};

bool ends_the_run(const std::string& verb) { return verb == "stop" || verb == "abort"; }

/// The text behind the verb, as `gyrotherm tell` has it.
Result<control::ControlRequest> request_of(const std::string& verb, const std::map<std::string, std::string>& body) {
  auto text = body.at("text");
  if (verb == "acknowledge") text = fmt::format("{} {}", body.at("alarm").empty() ? "all" : body.at("alarm"), text);
  return control::request_of(verb, text);
}

}  // namespace

WebAnswer RunControl::ask_back(const Guest& guest, const FoundRun& run, const std::string& verb) {
  const auto& standing = run.status.standing;
  const auto done = run.status.slot >= 0 ? spoken(std::chrono::seconds(run.status.slot)) : std::string("nothing");
  const auto left = standing.time_left ? spoken(*standing.time_left) : std::string("an unknown time");
  const auto& chamber = verb == "abort" ? run.when_aborted : run.when_stopped;
  return {.status = 409,
          .body = text_of(
              Json{{"confirm", confirmations_.ask(guest.name(), run.key, verb)},
                   {"question", fmt::format("{} done, {} left. The run ends and {}. Sure?", done, left, chamber)},
                   {"elapsed_s", std::max<std::int64_t>(run.status.slot, 0)},
                   {"left_s", standing.time_left ? Json(to_seconds(*standing.time_left)) : Json(nullptr)}})};
}

WebAnswer RunControl::answer(const WebRequest& request, const std::string& key, const std::string& verb) {
  const auto found = door_.guest_of(request);
  if (const auto* no = std::get_if<WebAnswer>(&found)) return *no;
  const auto& guest = std::get<Guest>(found);
  if (auto no = door_.objection_to_change(guest, request, Role::conductor)) return *no;
  if (std::ranges::find(kVerbs, verb) == kVerbs.end()) return refusal(404, "a run can be asked no such thing");
  const auto run = catalogue_.find(key);
  if (!run) return refusal(404, "there is no such run");
  const auto body = read_body(request, {"text", "alarm", "confirm"});
  if (!body) return refusal(400, body.error().what);
  auto asked = request_of(verb, *body);
  if (!asked) return refusal(400, asked.error().what);
  if (ends_the_run(verb) && !confirmations_.take(body->at("confirm"), guest.name(), run->key, verb))
    return ask_back(guest, *run, verb);
  asked->for_user = guest.name();
  const auto answer = control::tell(run->path, *asked, kAnswerWithin);
  if (!answer) return refusal(503, answer.error().what);
  if (!answer->done) return refusal(409, answer->text);
  return {.body = text_of(Json{{"done", answer->text}})};
}

}  // namespace gyrotherm::monitor
