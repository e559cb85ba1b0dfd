// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/run_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "core/clock.hpp"
#include "core/json.hpp"

namespace gyrotherm::monitor {
namespace {

using std::chrono_literals::operator""s;

constexpr auto kKeepAlive = 15s, kAccessCheckInterval = 1s;
constexpr std::int64_t kMaxEvents = 2000;

/// Returns a parameter as an integer: `fallback` if it is empty, nothing if it is not an integer in range.
std::optional<std::int64_t> parse_integer(const std::string& text, std::int64_t fallback) {
  if (text.empty()) return fallback;
  std::int64_t value{};
  const auto* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || rest != end || value < -1 || value > 1'000'000'000) return std::nullopt;
  return value;
}

WebAnswer fault_answer(const Fault& fault) {
  const bool busy = fault.kind == FaultKind::storage;
  return refusal(busy ? 503 : 404, busy ? "the run cannot be read now: " + fault.what : fault.what);
}

/// Returns the positions of the named channels, separated by commas, or nothing if a name is unknown.
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
  for (const auto& channel : series_channels(*run.info))
    channels.push_back({{"name", channel.name}, {"unit", channel.unit}, {"unit_under_test", channel.unit_under_test}});
  return channels;
}

WebAnswer status_answer(const FoundRun& run) {
  auto json = Json::parse(status_text(run));
  json["channels"] = channels_as_json(run);
  return {.body = text_of(json)};
}

WebAnswer events_answer(const FoundRun& run, const RequestHead& head) {
  const auto after = parse_integer(head.parameter("after"), -1);
  if (!after) return refusal(400, "\"after\" is not the number of an event");
  const auto events = read_events_after(run, *after, kMaxEvents);
  if (!events) return fault_answer(events.error());
  std::string body = "{\"events\":[";
  for (const auto& event : *events) body += (body.back() == '[' ? "" : ",") + event.text;
  return {.body = body + fmt::format("],\"more\":{}}}", static_cast<std::int64_t>(events->size()) == kMaxEvents)};
}

WebAnswer alarms_answer(const FoundRun& run) {
  Json alarms = Json::array();
  for (const auto& alarm : run.status.alarms) alarms.push_back(make_json(alarm));
  return {.body = text_of(Json{{"alarms", std::move(alarms)}})};
}

}  // namespace

WebAnswer RunAnswers::list() const {
  std::string body = "{\"runs\":[";
  for (const auto& run : catalogue_.runs()) body += (body.back() == '[' ? "" : ",") + status_text(run);
  return {.body = body + "]}"};
}

WebAnswer RunAnswers::series(const FoundRun& run, const RequestHead& head) {
  if (!run.info) return refusal(503, "the run cannot be read now: " + run.trouble);
  const auto all = series_channels(*run.info);
  const auto channels = find_channels(head.parameter("channels"), all);
  if (!channels) return refusal(400, "unknown channel in \"channels\"");
  const auto from = parse_integer(head.parameter("from"), 0), to = parse_integer(head.parameter("to"), run.status.slot);
  const auto buckets = parse_integer(head.parameter("buckets"), 2000);
  if (!from || !to || *from < 0)
    return refusal(400, "expected seconds since the start of the run for \"from\" and \"to\"");
  if (!buckets || *buckets < 1 || *buckets > kMaxBuckets)
    return refusal(400, fmt::format("expected 1 to {} for \"buckets\"", kMaxBuckets));
  const SeriesRequest requested{.channels = *channels,
                                .from = *from,
                                .to = std::min(*to, std::max(run.status.slot, *from) + 60),
                                .buckets = *buckets};
  const auto made = cache_.buckets(run, requested);
  if (!made) return fault_answer(made.error());
  std::vector<SeriesChannel> named;
  for (const auto channel : *channels) named.push_back(all[channel]);
  return {.body = series_text(*made, named)};
}

WebAnswer RunAnswers::stream(const FoundRun& run, const RequestHead& head, std::function<bool()> has_access) {
  const auto last = head.header("last-event-id");
  const auto slot = parse_integer(last.empty() ? head.parameter("after") : last, run.status.slot);
  const auto event = parse_integer(head.parameter("event"), -1);
  if (!slot || !event)
    return refusal(400, "Last-Event-ID is not the number of a second, or \"event\" is not the number of an event");
  auto watch = std::make_shared<RunFeed::Watch>(feed_, run.key);
  if (feed_.watchers() > kMaxWatchers) {
    auto full = refusal(503, "too many watchers; retry in 10 s");
    full.headers.emplace_back("Retry-After", "10");
    return full;
  }
  WebAnswer answer{.type = "text/event-stream"};
  answer.headers.emplace_back("X-Accel-Buffering", "no");
  answer.stream = [watch, position = FeedPosition{.slot = *slot, .event = *event}, stopping = is_stopping_,
                   has_access = std::move(has_access)](const Send& send) mutable {
    if (!send("retry: 1000\n\n")) return false;
    auto asked = since_boot(), sent = asked;
    while (!stopping()) {
      const auto text = watch->next(position, kAccessCheckInterval);
      const auto now = since_boot();
      if (now - asked >= Duration(kAccessCheckInterval)) {
        if (!has_access()) return true;
        asked = now;
      }
      if (text.empty() && now - sent < Duration(kKeepAlive)) continue;
      if (stopping() || !send(text.empty() ? ": nothing new\n\n" : text)) return false;
      sent = now;
    }
    return true;
  };
  return answer;
}

WebAnswer RunAnswers::answer(const WebRequest& request, const std::string& rest, std::function<bool()> has_access) {
  if (rest.empty() || rest == "/") return list();
  const auto slash = std::min(rest.find('/', 1), rest.size());
  const auto run = catalogue_.find(rest.substr(1, slash - 1));
  if (!run) return refusal(404, "there is no such run");
  const auto what = rest.substr(slash);
  if (what.empty()) return status_answer(*run);
  if (what == "/series") return series(*run, request.head);
  if (what == "/events") return events_answer(*run, request.head);
  if (what == "/events-stream") return stream(*run, request.head, std::move(has_access));
  if (what == "/alarms") return alarms_answer(*run);
  if (what == "/profile") return profile_answer(*run);
  if (what == "/files") return files_answer(*run);
  constexpr std::string_view kFile = "/files/";
  if (what.starts_with(kFile)) return file_answer(*run, what.substr(kFile.size()));
  return refusal(404, "there is no such page");
}

}  // namespace gyrotherm::monitor
