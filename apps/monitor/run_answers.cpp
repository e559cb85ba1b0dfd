// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/run_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "core/clock.hpp"
#include "core/json.hpp"

namespace gyrotherm::monitor {
namespace {

using std::chrono_literals::operator""s;

constexpr auto kKeepAliveInterval = 15s, kAccessCheckInterval = 1s;
constexpr std::int64_t kMaxEventsPerAnswer = 2000;

/// Parses a parameter from −1 to 10⁹. Returns `fallback` for an empty text, and nothing for an invalid one.
std::optional<std::int64_t> parse_integer(const std::string& text, std::int64_t fallback) {
  if (text.empty()) return fallback;
  std::int64_t value{};
  const auto* end = text.data() + text.size();
  const auto [parsed_to, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || parsed_to != end || value < -1 || value > 1'000'000'000) return std::nullopt;
  return value;
}

WebAnswer fault_answer(const Fault& fault) {
  const bool may_retry = fault.kind == FaultKind::storage;
  return refusal(may_retry ? 503 : 404, may_retry ? "the run cannot be read now: " + fault.what : fault.what);
}

/// Returns the indices of the channels in a comma-separated list of names, or nothing if a name is unknown.
std::optional<std::vector<std::size_t>> find_channels(const std::string& names, const std::vector<SeriesChannel>& all) {
  std::vector<std::size_t> positions;
  for (std::size_t begin = 0; begin <= names.size();) {
    const auto end = std::min(names.find(',', begin), names.size());
    const auto found = std::ranges::find(all, names.substr(begin, end - begin), &SeriesChannel::name);
    if (found == all.end()) return std::nullopt;
    const auto position = static_cast<std::size_t>(found - all.begin());
    if (std::ranges::find(positions, position) == positions.end()) positions.push_back(position);
    begin = end + 1;
  }
  return positions;
}

Json channels_as_json(const FoundRun& run) {
  Json channels = Json::array();
  if (!run.info) return channels;
  const auto& empty = run.channels_without_values;
  for (const auto& channel : series_channels(*run.info))
    channels.push_back({{"name", channel.name},
                        {"unit", channel.unit},
                        {"unit_under_test", channel.unit_under_test},
                        {"has_values", std::ranges::find(empty, channel.name) == empty.end()}});
  return channels;
}

Json units_as_json(const FoundRun& run) {
  Json units = Json::array();
  if (!run.info) return units;
  for (const auto& unit : run.info->units)
    units.push_back({{"name", unit.name},
                     {"serial_number", unit.serial_number},
                     {"model", unit.model},
                     {"in_use", !is_unused(*run.info, unit.name)}});
  return units;
}

WebAnswer status_answer(const FoundRun& run) {
  auto json = Json::parse(status_text(run));
  json["channels"] = channels_as_json(run);
  json["units"] = units_as_json(run);
  json["check_standard"] = run.standard.has_value();
  json["order_number"] = run.info ? run.info->order_number : "";
  json["observe_s"] = to_seconds(run.safe_observe);
  return {.body = json_text(json)};
}

WebAnswer events_answer(const FoundRun& run, const RequestHead& head) {
  const auto after = parse_integer(head.parameter("after"), -1);
  if (!after) return refusal(400, "expected the number of an event for \"after\"");
  const auto events = read_events_after(run, *after, kMaxEventsPerAnswer);
  if (!events) return fault_answer(events.error());
  std::string body = "{\"events\":[";
  for (const auto& event : *events) body += (body.back() == '[' ? "" : ",") + event.text;
  return {.body =
              body + fmt::format("],\"more\":{}}}", static_cast<std::int64_t>(events->size()) == kMaxEventsPerAnswer)};
}

WebAnswer alarms_answer(const FoundRun& run) {
  Json alarms = Json::array();
  for (const auto& alarm : run.status.alarms) alarms.push_back(make_json(alarm));
  return {.body = json_text(Json{{"alarms", std::move(alarms)}})};
}

/// Returns the slots of the requested seconds: the same numbers, or rows if the record is imported.
Result<std::pair<std::int64_t, std::int64_t>> find_slots(const FoundRun& run, std::int64_t from, std::int64_t to) {
  if (!run.info->imported) return std::pair(from, std::min(to, std::max(run.status.slot, from) + 60));
  const auto first = find_imported_row(run, kSecond * from);
  if (!first) return failure(first.error());
  const auto last = find_imported_row(run, kSecond * to);
  if (!last) return failure(last.error());
  return std::pair(*first, *last);
}

}  // namespace

WebAnswer RunAnswers::answer_list() const {
  std::string body = "{\"runs\":[";
  for (const auto& run : catalogue_.runs()) body += (body.back() == '[' ? "" : ",") + status_text(run);
  return {.body = body + "]}"};
}

WebAnswer RunAnswers::answer_series(const FoundRun& run, const RequestHead& head) {
  if (!run.info) return refusal(503, "the run cannot be read now: " + run.read_error);
  const auto all = series_channels(*run.info);
  const auto channels = find_channels(head.parameter("channels"), all);
  if (!channels) return refusal(400, "unknown channel in \"channels\"");
  const auto end =
      run.info->imported ? static_cast<std::int64_t>(std::ceil(to_seconds(run.length()))) : run.status.slot;
  const auto from = parse_integer(head.parameter("from"), 0), to = parse_integer(head.parameter("to"), end);
  const auto buckets = parse_integer(head.parameter("buckets"), 2000);
  if (!from || !to || *from < 0)
    return refusal(400, "expected seconds since the start of the run for \"from\" and \"to\"");
  if (!buckets || *buckets < 1 || *buckets > kMaxBuckets)
    return refusal(400, fmt::format("expected 1 to {} for \"buckets\"", kMaxBuckets));
  const auto slots = find_slots(run, *from, *to);
  if (!slots) return fault_answer(slots.error());
  const auto made =
      cache_.buckets(run, {.channels = *channels, .from = slots->first, .to = slots->second, .buckets = *buckets});
  if (!made) return fault_answer(made.error());
  const auto times_s = run.info->imported ? imported_times_s(run, *made) : Result<std::vector<double>>();
  if (!times_s) return fault_answer(times_s.error());
  std::vector<SeriesChannel> named;
  for (const auto channel : *channels) named.push_back(all[channel]);
  return {.body = series_text(*made, named, *times_s)};
}

WebAnswer RunAnswers::answer_standard(const FoundRun& run, const RequestHead& head, bool as_figure) {
  if (!run.standard) return refusal(404, "the rig of this run has no check standard");
  if (!as_figure) return standard_.answer(*run.standard, std::nullopt);
  const auto width = parse_integer(head.parameter("width"), 760);
  if (!width || *width < kMinChartWidth || *width > kMaxChartWidth)
    return refusal(400, fmt::format("expected {} to {} for \"width\"", kMinChartWidth, kMaxChartWidth));
  return standard_.answer(*run.standard, static_cast<int>(*width));
}

WebAnswer RunAnswers::answer_stream(const FoundRun& run, const RequestHead& head, std::function<bool()> has_access) {
  const auto last = head.header("last-event-id");
  const auto slot = parse_integer(last.empty() ? head.parameter("after") : last, run.status.slot);
  const auto event = parse_integer(head.parameter("event"), -1);
  const auto samples = head.parameter("samples");
  if (!slot || !event)
    return refusal(400, "expected a slot for Last-Event-ID or \"after\", and the number of an event for \"event\"");
  if (!samples.empty() && samples != "latest") return refusal(400, "expected \"latest\" for \"samples\"");
  auto watch = std::make_shared<RunFeed::Watch>(feed_, run.key);
  if (feed_.watchers() > kMaxWatchers) {
    auto full = refusal(503, "too many watchers; retry in 10 s");
    full.headers.emplace_back("Retry-After", "10");
    return full;
  }
  WebAnswer answer{.type = "text/event-stream"};
  answer.headers.emplace_back("X-Accel-Buffering", "no");
  answer.stream = [watch,
                   position = FeedPosition{.slot = *slot, .event = *event, .skips_old_samples = !samples.empty()},
                   stopping = is_stopping_, has_access = std::move(has_access)](const Send& send) mutable {
    if (!send("retry: 1000\n\n")) return false;
    auto checked = since_boot(), sent = checked;
    while (!stopping()) {
      const auto text = watch->wait_for_messages(position, kAccessCheckInterval);
      const auto now = since_boot();
      if (now - checked >= Duration(kAccessCheckInterval)) {
        if (!has_access()) return true;
        checked = now;
      }
      if (text.empty() && now - sent < Duration(kKeepAliveInterval)) continue;
      if (stopping() || !send(text.empty() ? ": nothing new\n\n" : text)) return false;
      sent = now;
    }
    return true;
  };
  return answer;
}

WebAnswer RunAnswers::answer(const WebRequest& request, const std::string& subpath, std::function<bool()> has_access) {
  if (subpath.empty() || subpath == "/") return answer_list();
  const auto slash = std::min(subpath.find('/', 1), subpath.size());
  const auto run = catalogue_.find(subpath.substr(1, slash - 1));
  if (!run) return refusal(404, "unknown run");
  const auto path = subpath.substr(slash);
  if (path.empty()) return status_answer(*run);
  if (path == "/series") return answer_series(*run, request.head);
  if (path == "/events") return events_answer(*run, request.head);
  if (path == "/events-stream") return answer_stream(*run, request.head, std::move(has_access));
  if (path == "/alarms") return alarms_answer(*run);
  if (path == "/profile") return profile_answer(*run);
  if (path == "/standard") return answer_standard(*run, request.head, false);
  if (path == "/standard.svg") return answer_standard(*run, request.head, true);
  if (path == "/files") return files_answer(*run);
  constexpr std::string_view kFile = "/files/";
  if (path.starts_with(kFile)) return file_answer(*run, path.substr(kFile.size()));
  return refusal(404, "unknown path");
}

}  // namespace gyrotherm::monitor
