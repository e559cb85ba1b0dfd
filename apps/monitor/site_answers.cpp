// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/site_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "apps/monitor/page.hpp"
#include "core/json.hpp"
#include "sequencer/control/control_socket.hpp"

namespace gyrotherm::monitor {
namespace {

constexpr const char *kScript = "text/javascript; charset=utf-8", *kStyle = "text/css; charset=utf-8";
constexpr std::string_view kRunsPath = "/api/v1/runs", kSitePath = "/api/v1/site";

/// A file of the page. Any client may load it, because it contains no run data.
struct PageFile {
  const char* path;
  const char* type;
  std::string_view (*text)();
};
constexpr std::array kPageFiles{
    PageFile{"/", "text/html; charset=utf-8", page_html}, PageFile{"/page.css", kStyle, page_style},
    PageFile{"/icon.svg", "image/svg+xml", page_icon},    PageFile{"/page.js", kScript, page_script},
    PageFile{"/text.js", kScript, text_script},           PageFile{"/views.js", kScript, views_script},
    PageFile{"/drawing.js", kScript, drawing_script},     PageFile{"/chart.js", kScript, chart_script},
    PageFile{"/control.js", kScript, control_script},     PageFile{"/alarms.js", kScript, alarms_script},
    PageFile{"/site.js", kScript, site_script},           PageFile{"/standard.js", kScript, standard_script},
    PageFile{"/dygraph.js", kScript, dygraphs_script},    PageFile{"/dygraph.css", kStyle, dygraphs_style}};

WebAnswer answer_page_file(const PageFile& file) {
  WebAnswer answer{.type = file.type, .body = std::string(file.text())};
  if (std::string_view(file.path) != "/") answer.headers.emplace_back("Cache-Control", "private, max-age=300");
  return answer;
}

/// Returns whether the path is `top` or below it.
bool is_below(std::string_view path, std::string_view top) {
  return path.starts_with(top) && (path.size() == top.size() || path[top.size()] == '/');
}

constexpr Duration kAnswerTimeout = std::chrono::seconds(5);
constexpr std::array kCommands{"pause", "resume", "stop", "abort", "note", "acknowledge", "shelve", "unshelve"};

constexpr const char* kStopNote =
    "A stop is final: the run cannot be resumed. To interrupt the run and go on later, pause it, or press Ctrl-C in "
    "its terminal and run gyrotherm resume.";
constexpr const char* kAbortNote =
    "After an abort, the run can go on only by gyrotherm resume with --accept, when a person has checked the chamber.";

bool is_ending_command(const std::string& verb) { return verb == "stop" || verb == "abort"; }

/// Makes the request that `gyrotherm tell` would send.
Result<control::ControlRequest> make_request(const std::string& verb, const std::map<std::string, std::string>& body) {
  auto text = body.at("text");
  if (verb == "acknowledge") text = fmt::format("{} {}", body.at("alarm").empty() ? "all" : body.at("alarm"), text);
  if (verb == "shelve") text = fmt::format("{} {} {}", body.at("alarm"), body.at("time"), text);
  if (verb == "unshelve") text = body.at("alarm");
  return control::make_request(verb, text);
}

}  // namespace

WebAnswer RunControl::request_confirmation(const Sender& sender, const FoundRun& run, const std::string& verb,
                                           bool has_confirmed) {
  const auto& overview = run.status.overview;
  const auto done = run.status.slot >= 0 ? format_duration(run.length()) : std::string("nothing");
  const auto left = overview.time_left ? format_duration(*overview.time_left) : std::string("an unknown time");
  const auto& chamber = verb == "abort" ? run.chamber_after_abort : run.chamber_after_stop;
  Json json{{"confirm", confirmations_.issue_token(sender.name(), run.key, verb)},
            {"question", fmt::format("{} done, {} left. The run ends and {}. {}", done, left, chamber,
                                     verb == "abort" ? kAbortNote : kStopNote)},
            {"elapsed_s", run.status.slot + 1},
            {"left_s", overview.time_left ? Json(to_seconds(*overview.time_left)) : Json(nullptr)}};
  if (has_confirmed)
    json["error"] = fmt::format("{} was not sent: a confirmation is valid once, within {}", verb,
                                format_duration(Confirmations::kLifetime));
  return {.status = 409, .body = json_text(json)};
}

WebAnswer RunControl::answer(const WebRequest& request, const std::string& key, const std::string& verb) {
  const auto found = access_.identify_sender(request);
  if (const auto* refused = std::get_if<WebAnswer>(&found)) return *refused;
  const auto& sender = std::get<Sender>(found);
  if (auto refused = access_.change_refusal(sender, request, Role::conductor)) return *refused;
  if (std::ranges::find(kCommands, verb) == kCommands.end()) return refusal(404, "unknown command");
  const auto run = catalogue_.find(key);
  if (!run) return refusal(404, "unknown run");
  const auto body = read_body(request, {"text", "alarm", "time", "confirm"});
  if (!body) return refusal(400, body.error().what);
  auto command = make_request(verb, *body);
  if (!command) return refusal(400, command.error().what);
  if (is_ending_command(verb) && !confirmations_.redeem(body->at("confirm"), sender.name(), run->key, verb))
    return request_confirmation(sender, *run, verb, !body->at("confirm").empty());
  command->for_user = sender.name();
  const auto answer = control::send_request(run->path, *command, kAnswerTimeout);
  if (!answer) return refusal(503, answer.error().what);
  if (!answer->done) return refusal(409, answer->text);
  return {.body = json_text(Json{{"done", answer->text}})};
}

WebAnswer SiteAnswers::answer(const WebRequest& request) {
  if (auto refused = access_.general_refusal(request)) return *refused;
  return request.head.method == "POST" ? answer_post(request) : answer_get(request);
}

WebAnswer SiteAnswers::answer_get(const WebRequest& request) {
  const auto& path = request.head.path;
  for (const auto& file : kPageFiles)
    if (path == file.path) return answer_page_file(file);
  if (path == "/api/v1/session") return access_.answer_session(request);
  const auto sender = access_.identify_sender(request);
  if (const auto* refused = std::get_if<WebAnswer>(&sender)) return *refused;
  if (path == "/api/v1/sessions") return access_.answer_sessions(request);
  if (path == "/api/v1/openapi.json") return {.body = std::string(openapi_text())};
  if (path == "/metrics")
    return {
        .type = "text/plain; version=0.0.4; charset=utf-8",
        .body = metrics_text(catalogue_.runs(), {.watchers = feed_.watchers(), .cache_bytes = runs_.cache_bytes()})};
  // The page also sends this request to a monitor without a site.
  if (path == kSitePath && site_ == nullptr) return {.body = "null"};
  if (is_below(path, kSitePath))
    return site_ != nullptr ? site_->answer(path.substr(kSitePath.size())) : refusal(404, "this monitor has no site");
  if (is_below(path, kRunsPath)) {
    auto has_access = [this, request] { return std::holds_alternative<Sender>(access_.identify_sender(request)); };
    return runs_.answer(request, path.substr(kRunsPath.size()), std::move(has_access));
  }
  return refusal(404, "unknown path");
}

WebAnswer SiteAnswers::answer_post(const WebRequest& request) {
  const auto& path = request.head.path;
  if (path == "/api/v1/login") return access_.log_in(request);
  if (path == "/api/v1/logout") return access_.log_out(request);
  if (path == "/api/v1/sessions") return access_.answer_sessions(request);
  const auto slash = path.rfind('/');
  if (!path.starts_with(std::string(kRunsPath) + "/") || slash <= kRunsPath.size()) {
    auto refused = refusal(405, "this path accepts only GET");
    refused.headers.emplace_back("Allow", "GET");
    return refused;
  }
  return control_.answer(request, path.substr(kRunsPath.size() + 1, slash - kRunsPath.size() - 1),
                         path.substr(slash + 1));
}

}  // namespace gyrotherm::monitor
