// SPDX-License-Identifier: Apache-2.0
#include "apps/site/live/live_rig.hpp"

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <variant>

#include "acquisition/record/run_finder.hpp"
#include "acquisition/record/run_source.hpp"
#include "core/clock.hpp"
#include "core/json.hpp"

namespace gyrotherm::site {

namespace {

constexpr Duration kRepeat = std::chrono::seconds(10);
constexpr std::int64_t kMostEvents = 100;  // at once; who wants all reads the record

Json message(const LiveRig::Name& name, std::uint64_t number) {
  return {{"schema", kLiveSchema},
          {"site", name.site},
          {"rig", name.rig},
          {"number", number},
          {"utc", civil_time(SteadyClock().now().utc)}};
}

/// What is on the rig. Of several runs it is the one that was heard of last, of its own before virtual ones.
struct RunsOfRig {
  std::optional<record::RunStatus> now{};   ///< goes on
  std::optional<record::RunStatus> left{};  ///< where none does: the last one, if it is not done with
};

bool comes_before(const record::RunStatus& a, const std::optional<record::RunStatus>& b) {
  return !b || std::pair(!a.simulated, a.written_utc) > std::pair(!b->simulated, b->written_utc);
}

/// A run whose program died, hangs or has aborted it is left, and so is one that ended with alarms: nobody can
/// acknowledge them any more, and the next run takes its place.
RunsOfRig runs_of(const std::vector<std::string>& records) {
  RunsOfRig runs;
  for (const auto& path : records) {
    auto status = record::told_status(path);
    if (!status) continue;
    status->being_written = record::is_fresh(*status);
    auto& place = status->being_written ? runs.now : runs.left;
    if (comes_before(*status, place)) place = std::move(status);
  }
  const auto& left = runs.left;
  if (left && (runs.now || (left->finished && record::count_unacknowledged(left->alarms) == 0))) runs.left.reset();
  return runs;
}

/// What of a status does not change each second.
std::string stable_of(const std::optional<record::RunStatus>& status) {
  if (!status) return "none";
  return fmt::format("{} {} {} {} {} {}", status->id, name(status->standing.state), status->standing.cause,
                     status->segment_index, status->alarms.size(), record::count_unacknowledged(status->alarms));
}

std::string json_of_run(const std::optional<record::RunStatus>& status) {
  return status ? record::to_json(*status) : "null";
}

Json json_of_cell(const record::Cell& cell) {
  if (const auto* whole = std::get_if<std::int64_t>(&cell)) return *whole;
  if (const auto* number = std::get_if<double>(&cell)) return *number;
  if (const auto* text = std::get_if<std::string_view>(&cell)) return std::string(*text);
  return nullptr;
}

}  // namespace

std::string rig_topic(const std::string& site, const std::string& rig) {
  return fmt::format("gyrotherm/v1/{}/{}", in_topic(site), rig == "+" ? rig : in_topic(rig));
}

Result<std::unique_ptr<LiveRig>> LiveRig::connect(const BrokerAddress& address, Name name,
                                                  std::function<void(const Fault&)> complain) {
  std::unique_ptr<LiveRig> rig(new LiveRig(std::move(name)));
  auto gone = message(rig->name_, 0);
  gone["online"] = false;
  gone.erase("utc");  // when it will be said nobody knows now
  auto broker = Broker::connect(address, {.topic = rig->topic_ + "/status", .text = text_of(gone)}, {},
                                {.came = [&is_new = rig->is_new_] { is_new = true; }, .complain = std::move(complain)});
  if (!broker) return failure(broker.error());
  rig->broker_ = std::move(*broker);
  return rig;
}

LiveRig::~LiveRig() {
  if (!broker_) return;
  auto off = message(name_, ++number_);
  off["online"] = false;
  broker_->say(topic_ + "/status", text_of(off), Broker::Kept::yes);
}

void LiveRig::look(const std::vector<std::string>& records) {
  if (!broker_->is_connected()) return;
  if (is_new_.exchange(false)) said_.clear();
  const auto runs = runs_of(records);
  const auto stable = stable_of(runs.now) + " " + stable_of(runs.left);
  if (stable != said_ || repeat_.over()) {
    said_ = stable;
    repeat_ = Deadline(kRepeat);
    say_status(json_of_run(runs.now), json_of_run(runs.left));
  }
  if (runs.now) say_rows(*runs.now);
}

void LiveRig::say_status(const std::string& run, const std::string& left) {
  auto told = message(name_, ++number_);
  told["online"] = true;
  told["run"] = Json::parse(run);
  told["left"] = Json::parse(left);
  broker_->say(topic_ + "/status", text_of(told), Broker::Kept::yes);
}

void LiveRig::say_rows(const record::RunStatus& status) {
  if (status.id != run_) {
    run_ = status.id;
    slot_ = -1;
    event_.reset();
  }
  const auto files = record::source_files(status.path, true);
  if (!files || !files->back().live) return;  // there is no live copy yet
  auto copy = record::open_source(files->back());
  if (copy) static_cast<void>(say_sample(*copy).and_then([&] { return say_events(*copy); }));
}

Result<void> LiveRig::say_sample(record::Database& copy) {
  return copy.each_row(fmt::format("SELECT * FROM v1_sample WHERE slot > {} ORDER BY slot DESC LIMIT 1", slot_),
                       [&](const record::Statement& row) {
                         Json values = Json::object();
                         for (int column = 0; column < row.columns(); ++column)
                           values[row.name(column)] = json_of_cell(row.cell(column));
                         slot_ = values["slot"].get<std::int64_t>();
                         auto told = message(name_, ++number_);
                         told["run"] = run_;
                         told["values"] = std::move(values);
                         broker_->say(topic_ + "/sample", text_of(told), Broker::Kept::no);
                       });
}

/// From those on that come after the first look.
Result<void> LiveRig::say_events(record::Database& copy) {
  if (!event_) return record::into(event_.emplace(), copy.ask_integer("SELECT max(id) FROM event", 0));
  return copy.each_row(
      fmt::format("SELECT id, slot, kind, text FROM event WHERE id > {} ORDER BY id LIMIT {}", *event_, kMostEvents),
      [&](const record::Statement& row) {
        event_ = row.integer(0);
        auto told = message(name_, ++number_);
        told["run"] = run_;
        told["slot"] = row.integer(1);
        told["kind"] = std::string(row.text(2));
        told["text"] = std::string(row.text(3));
        broker_->say(topic_ + "/event", text_of(told), Broker::Kept::no);
      });
}

}  // namespace gyrotherm::site
