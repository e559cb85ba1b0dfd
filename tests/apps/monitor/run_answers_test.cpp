// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/run_answers.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <sstream>
#include <string_view>
#include <thread>
#include <vector>

#include "core/clock.hpp"
#include "core/json.hpp"
#include "tests/apps/monitor/small_run.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::monitor {
namespace {

using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""s;

TEST(RunCatalogue, KeepsOnlyProfileText) {
  const tests::TestFolder folder;
  auto info = small_run_info();
  info.profile_text = "a profile's text";
  info.gyro_model_text = info.rig_text = info.chamber_map_text = std::string(400'000, 'x');
  info.analogue_map_texts = {info.rig_text};
  info.thermometer_texts = {info.rig_text};
  info.units.front().stream_text = info.rig_text;
  {
    auto store = record::Store::create(folder / "run.db", info);
    ASSERT_TRUE(store && (*store)->append(small_sample(0, false), {}) && (*store)->finish());
  }
  const auto run = found_in(folder / "");
  ASSERT_TRUE(run.info);
  EXPECT_EQ(run.info->profile_text, "a profile's text");
  for (const auto* text : {&run.info->gyro_model_text, &run.info->rig_text, &run.info->chamber_map_text,
                           &run.info->analogue_map_texts.front(), &run.info->thermometer_texts.front(),
                           &run.info->units.front().stream_text})
    EXPECT_LT(text->capacity(), 100u);
}

TEST(RunCatalogue, StopsCheckWhenStopping) {
  const tests::TestFolder folder;
  for (const auto* name : {"a.db", "b.db", "c.db"}) write_small_run(folder / name, 1);
  RunCatalogue catalogue({folder / ""});
  int asked = 0;
  catalogue.scan([&] { return ++asked == 3; });
  EXPECT_EQ(catalogue.runs().size(), 2u);
  catalogue.scan();
  EXPECT_EQ(catalogue.runs().size(), 3u);
}

/// Writes the status file of a program that has been silent for `age`, without a record.
void write_old_status(const std::string& record, Duration age) {
  record::RunStatus status;
  status.path = record;
  status.id = small_run_info().id;
  status.being_written = true;
  status.written_utc = kVirtualEpoch;
  status.written_since_boot = since_boot() - age;
  status.written_in_boot = boot_id();
  std::ofstream(record::status_path(record)) << record::to_json(status) << '\n';
}

TEST(RunCatalogue, ReportsSilenceWhileFolderHangs) {
  const tests::TestFolder folder;
  RunCatalogue catalogue({folder / ""});
  write_old_status(folder / "run.db", 3s);
  // A second check changes nothing.
  catalogue.scan();
  ASSERT_EQ(catalogue.runs().size(), 1u);
  const auto before = catalogue.runs().front();
  ASSERT_TRUE(before.is_running());
  EXPECT_FALSE(before.is_silent());
  EXPECT_TRUE(before.free_bytes);
  const auto is_silent = [&] { return catalogue.find(before.key)->is_silent(); };
  for (int i = 0; i < 2000 && !is_silent(); ++i) std::this_thread::sleep_for(10ms);
  EXPECT_TRUE(is_silent());
  EXPECT_TRUE(catalogue.runs().front().is_silent());
  EXPECT_NE(catalogue.find(before.key)->version, before.version) << "whoever watches it is told";
}

TEST(RunCatalogue, ChecksFoldersIndependently) {
  const tests::TestFolder one, other;
  write_small_run(one / "a.db", 1);
  write_small_run(other / "b.db", 1);
  RunCatalogue catalogue({one / "", other / "", one / ""});
  EXPECT_EQ(catalogue.folders().size(), 2u);
  catalogue.scan();
  ASSERT_EQ(catalogue.runs().size(), 2u);
  for (const auto& path : {one / "a.db", other / "b.db"})
    for (const auto* end : {"", ".sha256", ".status"}) std::filesystem::remove(path + end);
  catalogue.scan_folder(catalogue.folders().front(), [] { return false; });
  ASSERT_EQ(catalogue.runs().size(), 1u);
  EXPECT_EQ(catalogue.runs().front().name, "b");
  catalogue.scan_folder(catalogue.folders().back(), [] { return false; });
  EXPECT_TRUE(catalogue.runs().empty());
}

/// Writes a real run like a separate program. Its first second is delayed by `late` after the pipe becomes readable. It
/// continues until the other end of the pipe is closed.
[[noreturn]] void write_real_run(const std::string& path, Duration late, int told) {
  auto info = small_run_info();
  info.virtual_rig = false;
  auto store = record::Store::create(path, info, {.live_copy = record::LiveCopyOptions{.pause = 1ms}});
  bool fine = store && (*store)->append_event({.at = {}, .kind = EventKind::started, .text = "begins"});
  pollfd word{.fd = told, .events = POLLIN, .revents = 0};
  for (char read_byte{}; fine && ::poll(&word, 1, 100) >= 0;) {
    if (word.revents != 0) {
      if (::read(told, &read_byte, 1) != 1) break;
      auto sample = small_sample(0, false);
      sample.at.utc += late;
      fine = (*store)->append(sample, {}).has_value();
    }
    fine = fine && (*store)->sync();
  }
  if (store) store->reset();
  ::_exit(0);
}

TEST(RunCatalogue, ReadsStartOfRealRunFromFirstSecond) {
  const tests::TestFolder folder;
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const auto writer = ::fork();
  if (writer == 0) {
    ::close(ends[1]);
    write_real_run(folder / "run.db", 7s, ends[0]);
  }
  ::close(ends[0]);
  RunCatalogue catalogue({folder / ""});
  const auto comes_to = [&](Duration start) {
    for (int i = 0; i < 2000; ++i) {
      catalogue.scan();
      const auto runs = catalogue.runs();
      if (!runs.empty() && runs.front().info && runs.front().info->started_utc == start) return true;
      std::this_thread::sleep_for(10ms);
    }
    return false;
  };
  EXPECT_TRUE(comes_to(kVirtualEpoch));
  EXPECT_EQ(::write(ends[1], "!", 1), 1);
  EXPECT_TRUE(comes_to(kVirtualEpoch + 7s));
  ::close(ends[1]);
  ::waitpid(writer, nullptr, 0);
}

/// Returns all messages for a watcher until no more arrive.
std::string told_to(RunFeed::Watch& watch, RunFeed& feed, FeedPosition& position) {
  std::string told;
  for (int i = 0; i < 20; ++i) {
    feed.read();
    told += watch.wait_for_messages(position, 1ms);
  }
  return told;
}

TEST(RunFeed, SendsEveryEventOfEndedRun) {
  const tests::TestFolder folder;
  constexpr int kEvents = 1000;
  {
    auto store = record::Store::create(folder / "run.db", small_run_info());
    ASSERT_TRUE(store);
    std::vector<Event> events(kEvents, Event{.at = {}, .kind = EventKind::note, .text = "a note"});
    ASSERT_TRUE((*store)->append(small_sample(0, false), events) && (*store)->finish());
  }
  RunCatalogue catalogue({folder / ""});
  catalogue.scan();
  RunFeed feed(catalogue);
  RunFeed::Watch watch(feed, catalogue.runs().front().key);
  FeedPosition position;
  const auto told = told_to(watch, feed, position);
  std::multiset<std::string> numbers;
  for (std::size_t at = 0; (at = told.find("\"number\":", at)) != std::string::npos; ++at)
    numbers.insert(told.substr(at, told.find(',', at) - at));
  EXPECT_EQ(numbers.size(), std::set(numbers.begin(), numbers.end()).size()) << "each once";
  const auto all = read_events_after(catalogue.runs().front(), -1, 5000);
  ASSERT_TRUE(all);
  EXPECT_GE(all->size(), std::size_t{kEvents});
  EXPECT_EQ(numbers.size(), all->size());
}

/// Returns the answer to a request about the only run of a catalogue.
Json ask_run(RunCatalogue& catalogue, const std::string& path, std::map<std::string, std::string> query = {}) {
  RunFeed feed(catalogue);
  RunAnswers answers(catalogue, feed, [] { return false; });
  WebRequest request;
  for (const auto& [name, value] : query) request.head.query[name] = value;
  const auto answer = answers.answer(request, "/" + catalogue.runs().front().key + path, [] { return true; });
  EXPECT_EQ(answer.status, 200) << answer.body;
  return Json::parse(answer.body, nullptr, false);
}

TEST(ImportedRun, HasTimesOfItsRows) {
  const tests::TestFolder folder;
  write_imported_run(folder / "run.db", 360);
  RunCatalogue catalogue({folder / ""});
  catalogue.scan();
  const auto status = ask_run(catalogue, "");
  EXPECT_EQ(status["length_s"], 3590 + 3600);
  EXPECT_TRUE(status["started_ms"].is_null()) << "the file has no date";
  const auto event = ask_run(catalogue, "/events")["events"].back();
  EXPECT_EQ(event["time_s"], 3590 + 3600);
  const auto series = ask_run(catalogue, "/series", {{"channels", "A"}, {"from", "500"}, {"to", "4700"}});
  EXPECT_EQ(series["from"], 50);
  EXPECT_EQ(series["times_s"].front(), 500);
  EXPECT_EQ(series["times_s"].back(), 4700);
  EXPECT_EQ(series["times_s"].size(), series["count"]);
  const auto whole = ask_run(catalogue, "/series", {{"channels", "A"}, {"buckets", "10"}});
  EXPECT_EQ(whole["last"], 359) << "the default is the end of the record";
  EXPECT_EQ(whole["times_s"].size(), whole["count"]);
}

TEST(ImportedRun, NamesChannelsWithoutValues) {
  const tests::TestFolder folder;
  write_imported_run(folder / "run.db", 20, kVirtualEpoch);
  RunCatalogue catalogue({folder / ""});
  catalogue.scan();
  const auto status = ask_run(catalogue, "");
  EXPECT_EQ(status["started_ms"], kVirtualEpoch.count() / 1'000'000);
  std::map<std::string, bool> has_values;
  for (const auto& channel : status["channels"]) has_values[channel["name"]] = channel["has_values"];
  EXPECT_EQ(has_values, (std::map<std::string, bool>{{"A", true},
                                                     {"rate", true},
                                                     {"set_point_c", false},
                                                     {"chamber_air_c", false},
                                                     {"chamber_set_point_c", false}}));
}

TEST(OrdinaryRun, HasLengthUpToEndOfLastSecond) {
  const tests::TestFolder folder;
  write_small_run(folder / "run.db", 600, 100, 199);
  RunCatalogue catalogue({folder / ""});
  catalogue.scan();
  const auto status = ask_run(catalogue, "");
  EXPECT_EQ(status["slot"], 599);
  EXPECT_EQ(status["length_s"], 600);
  for (const auto& channel : status["channels"]) EXPECT_TRUE(channel["has_values"]) << channel["name"];
  const auto series = ask_run(catalogue, "/series", {{"channels", "A"}, {"from", "50"}, {"to", "60"}});
  EXPECT_EQ(series["from"], 50);
  EXPECT_FALSE(series.contains("times_s"));
  EXPECT_FALSE(ask_run(catalogue, "/events")["events"].front().contains("time_s"));
}

std::vector<int> slots_in(const std::string& told) {
  constexpr std::string_view kBefore = "event: sample\nid: ";
  std::vector<int> slots;
  for (std::size_t at = 0; (at = told.find(kBefore, at)) != std::string::npos; ++at)
    slots.push_back(std::stoi(told.substr(at + kBefore.size(), 10)));
  return slots;
}

void write_noted_run(const std::string& path, const std::string& id, int seconds) {
  auto info = small_run_info();
  info.id = id;
  auto store = record::Store::create(path, info);
  ASSERT_TRUE(store);
  ASSERT_TRUE((*store)->append_event({.at = {}, .kind = EventKind::note, .text = "of " + id}));
  for (int slot = 0; slot < seconds; ++slot) ASSERT_TRUE((*store)->append(small_sample(slot, false), {}));
  ASSERT_TRUE((*store)->finish());
}

TEST(RunFeed, RestartsWhenRecordIsReplaced) {
  const std::string first(32, 'a'), second(32, 'b');
  for (const bool nothing_was_seen_there : {false, true}) {
    const tests::TestFolder folder, elsewhere;
    write_noted_run(folder / "run.db", first, 200);
    write_noted_run(elsewhere / "run.db", second, 100);
    RunCatalogue catalogue({folder / ""});
    catalogue.scan();
    RunFeed feed(catalogue);
    RunFeed::Watch watch(feed, catalogue.runs().front().key);
    FeedPosition position;
    EXPECT_EQ(slots_in(told_to(watch, feed, position)).size(), 200u);
    if (nothing_was_seen_there) {
      std::filesystem::remove(folder / "run.db");
      std::filesystem::remove(folder / "run.db.status");
      catalogue.scan();
      ASSERT_TRUE(catalogue.runs().empty());
      EXPECT_EQ(told_to(watch, feed, position), "");
    }
    std::filesystem::rename(elsewhere / "run.db", folder / "run.db");
    catalogue.scan();
    const auto told = told_to(watch, feed, position);
    EXPECT_NE(told.find(R"("id":")" + second), std::string::npos) << "its status";
    EXPECT_NE(told.find("of " + second), std::string::npos) << "its event";
    std::vector<int> all(100);
    std::iota(all.begin(), all.end(), 0);
    EXPECT_EQ(slots_in(told), all);
  }
}

/// Covers a run that grows faster than the feed reads it.
TEST(RunFeed, OmitsOldSamplesForWatcherOfPresentValues) {
  const std::string id(32, 'a');
  const tests::TestFolder folder, elsewhere;
  write_noted_run(folder / "run.db", id, 100);
  write_noted_run(elsewhere / "run.db", id, 2000);
  RunCatalogue catalogue({folder / ""});
  catalogue.scan();
  RunFeed feed(catalogue);
  const auto key = catalogue.runs().front().key;
  RunFeed::Watch watch(feed, key), patient(feed, key);
  FeedPosition position{.skips_old_samples = true}, all_positions;
  EXPECT_EQ(slots_in(told_to(watch, feed, position)).size(), 100u);
  auto all = slots_in(told_to(patient, feed, all_positions));
  std::filesystem::rename(elsewhere / "run.db", folder / "run.db");
  catalogue.scan();
  feed.read();
  const auto first = slots_in(watch.wait_for_messages(position, 1ms));
  ASSERT_FALSE(first.empty());
  EXPECT_GT(first.front(), 1700) << "the present values, in the first answer";
  EXPECT_EQ(first.back(), 1999);
  EXPECT_EQ(first.size(), static_cast<std::size_t>(1999 - first.front() + 1)) << "without gaps";
  EXPECT_TRUE(slots_in(told_to(watch, feed, position)).empty()) << "each once";
  const auto rest = slots_in(told_to(patient, feed, all_positions));
  all.insert(all.end(), rest.begin(), rest.end());
  std::vector<int> every(2000);
  std::iota(every.begin(), every.end(), 0);
  EXPECT_EQ(all, every) << "every sample for another watcher";
}

TEST(StatusText, HasTimeOfItsSlotOnTheClockOfTheSamples) {
  constexpr auto kMs = std::chrono::milliseconds(1);
  const auto utc_ms = [&](bool is_virtual, bool is_running, Duration since_start, std::int64_t slot) {
    auto info = small_run_info();
    info.virtual_rig = is_virtual;
    FoundRun run;
    run.status.slot = slot;
    run.status.being_written = is_running;
    run.status.written_utc = since_start == Duration{} ? Duration{} : kVirtualEpoch + since_start;
    run.info = std::make_shared<record::RunInfo>(std::move(info));
    return Json::parse(status_text(run))["utc_ms"].get<std::int64_t>() - kVirtualEpoch / kMs;
  };
  EXPECT_EQ(utc_ms(false, true, 100s + 300 * kMs, 99), 100'000) << "does not follow the time of writing";
  EXPECT_EQ(utc_ms(false, true, 3700s, 99), 3'700'000) << "the clock was set";
  EXPECT_EQ(utc_ms(false, true, -3500s, 99), -3'500'000);
  EXPECT_EQ(utc_ms(true, true, 3700s, 99), 100'000) << "the run has a virtual clock";
  EXPECT_EQ(utc_ms(false, false, 3700s, 99), 100'000) << "the file was written later";
  EXPECT_EQ(utc_ms(false, true, Duration{}, 99), 100'000);
  EXPECT_EQ(utc_ms(false, true, 1s, -1), 0);
  EXPECT_EQ(Json::parse(status_text({}))["utc_ms"], nullptr);
}

/// Writes the status file of a program that has been silent since `ago`, without a readable record.
void leave_status(const std::string& path, Duration ago) {
  record::RunStatus status;
  status.path = path;
  status.id = std::string(32, 'a');
  status.written_utc = kVirtualEpoch;
  status.written_since_boot = since_boot() - ago;
  status.written_in_boot = boot_id();
  std::ofstream(record::status_path(path)) << record::to_json(status) << "\n";
}

TEST(RunCatalogue, ReportsAgeAndSafeTraceOfInterruptedRun) {
  const tests::TestFolder folder;
  const auto path = folder / "run.db";
  auto info = small_run_info();
  info.id = std::string(32, 'a');
  {
    auto store = record::Store::create(path, info);
    ASSERT_TRUE(store) << text(store.error());
    for (int slot = 0; slot < 3; ++slot) ASSERT_TRUE((*store)->append(small_sample(slot, false), {}));
  }
  leave_status(path, 100s);
  RunCatalogue catalogue({folder / ""});
  catalogue.scan();
  auto run = catalogue.runs().at(0);
  ASSERT_TRUE(run.is_abandoned());
  EXPECT_GE(run.age_s.value_or(0), 100);
  EXPECT_FALSE(run.is_silent());
  EXPECT_EQ(ask_run(catalogue, "")["made_safe"], nullptr);
  const std::string trace =
      "schema = \"gyrotherm-made-safe/1\"\nat = \"2026-03-01T00:00:00Z\"\nutc_ns = 1772323200000000000\n"
      "because = \"the program that drove it has ended\"\nset_point_c = 20.5\nconfirmed = true\n"
      "details = \"set point 20.5 °C\"\n";
  std::ofstream(path + ".made-safe") << trace;
  const auto version = run.version;
  catalogue.scan();
  EXPECT_NE(catalogue.runs().at(0).version, version) << "the page receives it";
  EXPECT_EQ(ask_run(catalogue, "")["made_safe"],
            Json({{"utc_ms", 1772323200000}, {"set_point_c", 20.5}, {"confirmed", true}, {"given_up", false}}));
  std::ofstream(path + ".made-safe", std::ios::app) << "given_up = \"ada (uid 0): no power\"\n";
  catalogue.scan();
  EXPECT_EQ(ask_run(catalogue, "")["made_safe"]["given_up"], true);
  for (const auto& unreadable : {std::string("schema = 1"), trace + "more = 1\n", std::string("\xff")}) {
    std::ofstream(path + ".made-safe") << unreadable;
    catalogue.scan();
    EXPECT_EQ(ask_run(catalogue, "")["made_safe"], nullptr) << unreadable;
  }
}

TEST(RunCatalogue, HasNoAgeFromStatusFileOfAnotherRun) {
  const tests::TestFolder folder;
  { auto store = record::Store::create(folder / "run.db", small_run_info()); }
  leave_status(folder / "run.db", 100s);
  write_small_run(folder / "ended.db", 3);
  RunCatalogue catalogue({folder / ""});
  catalogue.scan();
  ASSERT_EQ(catalogue.runs().size(), 2u);
  for (const auto& run : catalogue.runs()) EXPECT_FALSE(run.age_s) << run.name;
}

TEST(RunFeed, SendsPresentAgeToLateWatcher) {
  const tests::TestFolder folder;
  RunCatalogue catalogue({folder / ""});
  const auto comes_to = [&](bool (FoundRun::*state)() const) {
    catalogue.scan();
    const auto runs = catalogue.runs();
    return !runs.empty() && (runs.front().*state)();
  };
  for (int i = 0; i < 100 && !comes_to(&FoundRun::is_running); ++i) leave_status(folder / "run.db", 4800ms);
  for (int i = 0; i < 200 && !comes_to(&FoundRun::is_silent); ++i) std::this_thread::sleep_for(10ms);
  ASSERT_TRUE(comes_to(&FoundRun::is_silent));
  RunFeed feed(catalogue);
  const auto key = catalogue.runs().front().key;
  const auto age_told = [&] {
    RunFeed::Watch watch(feed, key);
    FeedPosition position;
    const auto told = told_to(watch, feed, position);
    const std::string before = R"("age_s":)";
    const auto at = told.find(before);
    EXPECT_NE(at, std::string::npos) << told;
    return at == std::string::npos ? -1 : std::stod(told.substr(at + before.size()));
  };
  RunFeed::Watch stays(feed, key);
  const auto then = age_told();
  EXPECT_GT(then, 5);
  std::this_thread::sleep_for(50ms);
  catalogue.scan();
  EXPECT_GE(age_told(), then + 0.05);
}

/// Covers a run before its first second, and a run continued in another file before that file has a row.
TEST(RunFeed, SendsEventsBeforeFirstRow) {
  const tests::TestFolder folder;
  const auto path = folder / "run.db";
  const Event started{.at = {}, .kind = EventKind::started, .text = "a profile"};
  const record::StoreOptions options{.background = true, .retry = 20ms};
  {
    auto store = record::Store::create(path, small_run_info(), options);
    ASSERT_TRUE(store);
    ASSERT_TRUE((*store)->append_event(started));
    ASSERT_TRUE((*store)->append(small_sample(0, false), {}) && (*store)->settle(20s));
  }
  {
    auto store = record::Store::reopen(path, options);
    ASSERT_TRUE(store);
    std::filesystem::remove(path + "-wal");
    ASSERT_TRUE((*store)->append(small_sample(1, false), {}) && (*store)->finish());
    EXPECT_EQ((*store)->health().parts, 2);
  }
  const auto run = found_in(folder / "");
  const auto events = read_events_after(run, 0, 100);
  ASSERT_TRUE(events) << text(events.error());
  ASSERT_EQ(events->size(), 2u);
  EXPECT_NE(events->front().text.find("a profile"), std::string::npos) << events->front().text;
  EXPECT_NE(events->back().text.find("continues in run.2.db"), std::string::npos) << events->back().text;
  EXPECT_LT(events->front().number, events->back().number);
  const auto rows = read_samples_after(run, -1, 100);
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->size(), 2u) << "each once";
}

/// Writes a record file with this text and returns it as a run that has ended.
FoundRun run_of(const std::string& path, const std::string& text) {
  std::ofstream(path) << text;
  FoundRun run;
  run.path = path;
  return run;
}

TEST(ProfileAnswer, HasPromptsOfExecutedProfile) {
  FoundRun run;
  auto info = small_run_info();
  info.profile_text = R"(schema = "gyrotherm-profile/1"
name = "switched"
[[segment]]
kind = "hold"
at = "20 °C"
time = "60 s"
[[segment]]
kind = "hold"
time = "60 s"
power = "off"
[[segment]]
kind = "hold"
time = "60 s"
power = "on"
)";
  const auto prompts = [&] {
    run.info = std::make_shared<const record::RunInfo>(info);
    std::vector<std::string> found;
    const auto answer = Json::parse(profile_answer(run).body);
    for (const auto& segment : answer["segments"]) found.push_back(segment["prompt"].get<std::string>());
    return found;
  };
  info.segments.clear();
  EXPECT_EQ(prompts(), (std::vector<std::string>{"", "switch the unit off", "switch the unit on"}));
  // A supply switches the unit off; a person switches it on.
  const record::RunInfo::SegmentInfo hold{"hold 20 °C", true, Celsius{20}};
  info.segments = {hold, hold, hold};
  info.segments.back().prompt = "switch it on";
  EXPECT_EQ(prompts(), (std::vector<std::string>{"", "", "switch it on"}));
}

TEST(Files, ExcludeNamesThatCannotBeRequested) {
  const tests::TestFolder folder;
  const auto listed = [&](const std::string& name) {
    const auto run = run_of(folder / name, "a record");
    return Json::parse(files_answer(run).body)["files"].size();
  };
  for (const auto* name : {"run.db", "a\"b.db", "per%41 cent.db", "ü.db", "..db"}) EXPECT_EQ(listed(name), 1u) << name;
  for (const auto* name : {"a\\b.db", "a\nb.db", "a\x7f.db", "\xff.db"}) EXPECT_EQ(listed(name), 0u) << name;
}

TEST(Files, HaveNameInContentDisposition) {
  const tests::TestFolder folder;
  const auto run = run_of(folder / "a\"b ü.db", "a record");
  const auto answer = file_answer(run, "a\"b ü.db");
  ASSERT_EQ(answer.headers.size(), 1u);
  EXPECT_EQ(answer.headers.front().second, R"(attachment; filename="a\"b _.db"; filename*=UTF-8''a%22b%20%C3%BC.db)");
}

/// Returns the names of the downloadable files.
std::set<std::string> names_of(const FoundRun& run) {
  std::set<std::string> names;
  const auto told = Json::parse(files_answer(run).body);
  for (const auto& file : told["files"]) names.insert(file["name"].get<std::string>());
  return names;
}

TEST(Files, IgnorePathsInStatusFile) {
  const tests::TestFolder folder, other;
  auto run = run_of(folder / "run.db", "a record");
  for (const auto* name : {"run.2.db", "run.3.db", "run.5.db", "other.2.db", "notes.txt"})
    std::ofstream(folder / name) << "a text";
  std::ofstream(other / "users.json") << "a text";
  run.status.parts = {folder / "run.2.db",  folder / "run.5.db",  folder / "other.2.db",
                      folder / "notes.txt", other / "users.json", "/etc/hostname"};
  EXPECT_EQ(names_of(run), (std::set<std::string>{"run.db", "run.2.db", "run.5.db"}));
  EXPECT_EQ(file_answer(run, "users.json").status, 404);
  EXPECT_EQ(file_answer(run, "hostname").status, 404);
}

TEST(Files, ExcludeLinks) {
  const tests::TestFolder folder, other;
  auto run = run_of(folder / "run.db", "a record");
  for (const auto& path : {other / "users.json", other / "report.html"}) std::ofstream(path) << "a text";
  std::filesystem::create_symlink(other / "users.json", folder / "run.2.db");
  std::filesystem::create_symlink(other / "users.json", folder / "run.db.sha256");
  std::filesystem::create_directory_symlink(other / "", folder / "report");
  std::filesystem::create_directory(folder / "calibration");
  std::ofstream(folder / "calibration/report.html") << "a report";
  run.status.parts = {folder / "run.2.db"};
  EXPECT_EQ(names_of(run), (std::set<std::string>{"run.db", "calibration-report.html"}));
}

TEST(Files, FailWhenFileShrinks) {
  const tests::TestFolder folder;
  const auto run = run_of(folder / "run.db", std::string(1'000'000, 'x'));
  const auto answer = file_answer(run, "run.db");
  ASSERT_TRUE(answer.stream);
  std::size_t sent = 0;
  EXPECT_FALSE(answer.stream([&](std::string_view piece) {
    sent += piece.size();
    std::filesystem::resize_file(run.path, 1000);
    return true;
  }));
  EXPECT_LT(sent, 100'000u);
  const auto whole = file_answer(run, "run.db");
  EXPECT_TRUE(whole.stream([](std::string_view) { return true; }));
}

/// Returns an active run on a rig.
FoundRun run_on(const std::string& rig, const std::string& name) {
  auto info = small_run_info();
  info.rig_name = rig;
  FoundRun run;
  run.name = name;
  run.info = std::make_shared<const record::RunInfo>(info);
  run.status.being_written = true;
  run.status.set_point = run.status.chamber_air = Celsius{20};
  run.status.thermometers = {{"A", Celsius{20}}};
  run.age_s = 0.5;
  run.free_bytes = 5'000'000'000;
  return run;
}

/// Returns an ended run on a rig.
FoundRun ended_on(const std::string& rig, const std::string& name, RunState state, std::size_t alarms) {
  auto run = run_on(rig, name);
  run.status.being_written = false;
  run.status.finished = true;
  run.status.overview.state = state;
  run.status.alarms.resize(alarms);
  run.age_s.reset();
  return run;
}

std::string compute_figures(const std::vector<FoundRun>& runs) { return metrics_text(runs, {}); }

/// Returns the names of the metrics of a run.
std::set<std::string> figures_with(const std::string& text, const std::string& run) {
  std::set<std::string> names;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.find("{run=\"" + run + "\"") != std::string::npos) names.insert(line.substr(0, line.find('{')));
  return names;
}

const std::set<std::string> kEnd{"gyrotherm_run_alarms", "gyrotherm_run_state"};

TEST(Metrics, IncludeLastRunOfRigThatEndedBadly) {
  const auto text = compute_figures(
      {run_on("three", "goes on"), ended_on("one", "aborted", RunState::aborted, 1),
       ended_on("one", "before it", RunState::aborted, 1), ended_on("two", "alarmed", RunState::complete, 2),
       ended_on("three", "before that", RunState::aborted, 1), ended_on("four", "well", RunState::complete, 0)});
  EXPECT_EQ(figures_with(text, "aborted"), kEnd);
  EXPECT_EQ(figures_with(text, "alarmed"), kEnd);
  for (const auto* old : {"before it", "before that", "well"}) EXPECT_TRUE(figures_with(text, old).empty()) << old;
  const auto has_line = [&](const std::string& name, const std::string& rest) {
    return text.find(name + ",rig=\"one\",profile=\"a profile\",simulated=\"0\"" + rest + "\n") != std::string::npos;
  };
  EXPECT_TRUE(has_line("gyrotherm_run_alarms{run=\"aborted\"", "} 1")) << text;
  EXPECT_TRUE(has_line("gyrotherm_run_state{run=\"aborted\"", ",state=\"aborted\"} 1")) << text;
  EXPECT_NE(text.find("gyrotherm_runs_going_on 1\n"), std::string::npos);
}

TEST(Metrics, ExcludeLastValuesOfSilentProgram) {
  auto silent = run_on("one", "silent"), left = run_on("two", "left");
  silent.age_s = 60;
  left.status.being_written = false;
  left.age_s.reset();
  left.status.overview.state = RunState::held;
  ASSERT_TRUE(silent.is_silent() && left.is_abandoned());
  const auto text = compute_figures({run_on("three", "goes on"), silent, left});
  const std::set<std::string> known{"gyrotherm_run_up", "gyrotherm_run_second", "gyrotherm_run_alarms",
                                    "gyrotherm_run_shelved_alarms"};
  EXPECT_EQ(figures_with(text, "left"), known);
  auto with_age = known;
  with_age.insert("gyrotherm_run_status_age_seconds");
  EXPECT_EQ(figures_with(text, "silent"), with_age);
  const auto all = figures_with(text, "goes on");
  for (const auto* name :
       {"gyrotherm_run_state", "gyrotherm_run_set_point_celsius", "gyrotherm_run_chamber_air_celsius",
        "gyrotherm_run_thermometer_celsius", "gyrotherm_disk_free_bytes"})
    EXPECT_TRUE(all.contains(name)) << name;
}

TEST(Metrics, CountShelvedAlarmsOfUnfinishedRuns) {
  auto run = run_on("one", "goes on"), over = ended_on("two", "aborted", RunState::aborted, 2);
  run.status.alarms.resize(3);
  run.status.alarms[1].acknowledged = true;
  run.status.alarms[1].shelved_by = over.status.alarms[0].shelved_by = "ada (uid 1000)";
  const auto text = compute_figures({run, over});
  EXPECT_NE(text.find("gyrotherm_run_shelved_alarms{run=\"goes on\",rig=\"one\""), std::string::npos) << text;
  EXPECT_NE(text.find("gyrotherm_run_alarms{run=\"goes on\",rig=\"one\",profile=\"a profile\",simulated=\"0\"} 2\n"),
            std::string::npos)
      << "a shelved alarm does not await an acknowledgement:\n"
      << text;
  EXPECT_FALSE(figures_with(text, "aborted").contains("gyrotherm_run_shelved_alarms"));
}

TEST(Metrics, DeclareTotalsAsCounters) {
  const auto text = compute_figures({run_on("one", "goes on")});
  EXPECT_NE(text.find("# TYPE gyrotherm_run_faults_total counter\n"), std::string::npos) << text;
  EXPECT_NE(text.find("# TYPE gyrotherm_run_faults_now gauge\n"), std::string::npos) << text;
}

TEST(Metrics, AreValidUtf8ForAnyRecordName) {
  FoundRun run;
  run.name = "b\xff\"ü\n\\";
  run.status.being_written = true;
  FoundRun left;
  left.name = "left";
  ASSERT_TRUE(left.is_abandoned());
  left.status.overview.state = RunState::aborted;
  EXPECT_FALSE(left.is_abandoned()) << "that was its end";
  left.status.overview.state = RunState::aborting;
  ASSERT_TRUE(left.is_abandoned()) << "nobody knows whether the chamber was made safe";
  const auto text = metrics_text({run, left}, {.watchers = 0, .cache_bytes = 0});
  EXPECT_NE(text.find("gyrotherm_runs_going_on 1\n"), std::string::npos) << "nobody carries the other out";
  EXPECT_NE(text.find("{run=\"b\uFFFD\\\"ü\\n\\\\\",rig=\"\""), std::string::npos) << text.substr(0, 400);
}

}  // namespace
}  // namespace gyrotherm::monitor
