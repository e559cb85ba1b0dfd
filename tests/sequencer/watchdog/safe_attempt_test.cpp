// SPDX-License-Identifier: Apache-2.0
/// Attempts to make a chamber safe: confirmation, number and duration of the attempts.
#include "sequencer/watchdog/safe_attempt.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/file.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::watchdog {
namespace {

/// A chamber that accepts set points until it is set to break. Each set point takes `slowness` of the clock. `heard`
/// has the commands.
class FakeChamber final : public drivers::Chamber {
 public:
  struct ProfileState {
    VirtualClock clock;
    Duration slowness{};
    Celsius set_point{80};
    int silent_tries = 0;  ///< unanswered tries
    FaultKind silence = FaultKind::timeout;
    bool ignores = false;  ///< acknowledges and does nothing
    bool runs_program = false, keeps_program = false;
    bool refuses_to_stop = false;
    bool drifts = false;  ///< shows another set point later
    ChamberActivity activity = ChamberActivity::running;
    int connections = 0;
    Result<std::string> who = std::string("Watlow F4T (serial_number = 111)");
    int unconfirmed = 0, unconfirmed_stops = 0;
    std::string heard;
  };
  explicit FakeChamber(ProfileState& state) : state_(state) { ++state.connections; }
  Result<std::string> identify() override { return state_.who; }
  Result<ChamberState> read() override {
    state_.heard += "look ";
    return ChamberState{
        .air = {79}, .set_point = state_.drifts ? Celsius{60} : state_.set_point, .activity = state_.activity};
  }
  Result<void> send_set_point(Celsius) override {
    ADD_FAILURE() << "would query limits and programs first";
    return {};
  }
  Result<void> send_set_point_immediately(Celsius target) override {
    state_.heard += "set ";
    state_.clock.advance(state_.slowness);
    if (state_.silent_tries-- > 0) return failure(state_.silence, "chamber", "no reply");
    if (state_.ignores || state_.runs_program)
      return failure(FaultKind::mismatch, "chamber", "reads 80 after 23 was written");
    state_.set_point = target;
    return {};
  }
  Result<void> end_program() override {
    state_.heard += "program ";
    if (state_.keeps_program) return failure(FaultKind::refused, "chamber", "no");
    state_.runs_program = false;
    return {};
  }
  Result<void> send_safe_state_unconfirmed(Celsius target, bool off) override {
    EXPECT_EQ(target, Celsius{23});
    ++state_.unconfirmed;
    if (off) ++state_.unconfirmed_stops;
    return {};
  }
  Result<void> start() override {
    state_.heard += "start ";
    state_.activity = ChamberActivity::running;
    return {};
  }
  Result<void> stop() override {
    if (state_.refuses_to_stop) return failure(FaultKind::refused, "chamber stop", "no");
    state_.heard += "off ";
    state_.activity = ChamberActivity::off;
    return {};
  }

 private:
  ProfileState& state_;
};

SafeAttempt attempt(FakeChamber::ProfileState& state, const SafeGoal& goal = {.set_point = {23}, .tolerance = {0.1}},
                    SafeTask task = SafeTask::leave_as_required) {
  return attempt_safe(goal,
                      {.connect = [&] { return std::make_unique<FakeChamber>(state); },
                       .wait = [&](Duration time) { state.clock.advance(time); },
                       .report = [](const auto&) {},
                       .clock = state.clock},
                      task);
}

const SafeGoal kOff{.set_point = {23}, .tolerance = {0.1}, .switch_off = true};

TEST(MakeSafe, SendsSetPointBeforeAnyQuery) {
  FakeChamber::ProfileState state;
  EXPECT_EQ(attempt(state).reached, SafeStage::all);
  EXPECT_EQ(state.heard, "set program set look ");
  EXPECT_EQ(state.set_point, (Celsius{23}));
}

TEST(MakeSafe, SendsNothingToAnotherInstrument) {
  const SafeGoal known{.set_point = {23},
                       .tolerance = {0.1},
                       .switch_off = true,
                       .identity = "Watlow F4T (serial_number = 111), ramp_action = off"};
  const std::vector<Result<std::string>> others{failure(FaultKind::mismatch, "part_number", "reads \"F4T…7\""),
                                                failure(FaultKind::refused, "part_number", "exception 2"),
                                                std::string("Watlow F4T (serial_number = 222)")};
  for (const auto& other : others) {
    FakeChamber::ProfileState state;
    state.who = other;
    const auto tried = attempt(state, known);
    EXPECT_EQ(tried.reached, SafeStage::nothing);
    EXPECT_EQ(state.heard, "");
    EXPECT_NE(tried.details.find("nothing is sent to another instrument"), std::string::npos) << tried.details;
    EXPECT_NE(tried.details.find("serial_number = 111"), std::string::npos) << "names the chamber of the run";
  }
  FakeChamber::ProfileState state;
  EXPECT_EQ(attempt(state, known).reached, SafeStage::all) << "with other settings it is the chamber of the run";
}

TEST(MakeSafe, SendsSetPointWhenIdentityQueryIsLost) {
  FakeChamber::ProfileState state;
  state.who = failure(FaultKind::timeout, "part_number", "no reply");
  EXPECT_EQ(attempt(state).reached, SafeStage::all);
  EXPECT_EQ(state.set_point, (Celsius{23}));
}

TEST(MakeSafe, SendsCommandsWithoutAnswerToKnownChamberThatCannotBeUnderstood) {
  for (const auto kind : {FaultKind::corrupted, FaultKind::timeout})
    for (const bool switch_off : {false, true}) {
      SafeGoal goal = switch_off ? kOff : SafeGoal{.set_point = {23}, .tolerance = {0.1}};
      goal.identity = "Watlow F4T (serial_number = 111)";
      FakeChamber::ProfileState state;
      state.who = failure(kind, "part_number", "no reply");
      state.silent_tries = 1000;
      state.silence = kind;
      const auto tried = attempt(state, goal);
      EXPECT_EQ(tried.reached, SafeStage::nothing) << "this is no evidence";
      EXPECT_GT(state.unconfirmed, 1);
      EXPECT_EQ(state.unconfirmed_stops, switch_off ? state.unconfirmed : 0);
      EXPECT_NE(tried.details.find("sent without waiting for an answer"), std::string::npos) << tried.details;
    }
}

TEST(MakeSafe, SendsNothingWithoutAnswerToUnknownOrOtherChamber) {
  FakeChamber::ProfileState state;
  state.who = failure(FaultKind::corrupted, "part_number", "no reply");
  state.silent_tries = 1000;
  (void)attempt(state);
  EXPECT_EQ(state.unconfirmed, 0) << "the run had not identified it";
  const SafeGoal known{.set_point = {23}, .tolerance = {0.1}, .identity = "Watlow F4T (serial_number = 111)"};
  for (const Result<std::string>& other :
       {Result<std::string>("Watlow F4T (serial_number = 222)"),
        Result<std::string>(failure(FaultKind::refused, "part_number", "exception 2"))}) {
    FakeChamber::ProfileState exchanged;
    exchanged.who = other;
    (void)attempt(exchanged, known);
    EXPECT_EQ(exchanged.unconfirmed, 0);
  }
}

TEST(MakeSafe, IsConfirmedOnlyByReadBack) {
  FakeChamber::ProfileState state;
  state.ignores = true;
  const auto ignored = attempt(state);
  EXPECT_EQ(ignored.reached, SafeStage::nothing);
  EXPECT_NE(ignored.details.find("reads 80 after 23 was written"), std::string::npos) << ignored.details;
  state.ignores = false;
  state.drifts = true;
  const auto lost_again = attempt(state);
  EXPECT_EQ(lost_again.reached, SafeStage::set_point) << "it answered, and no longer does";
  EXPECT_NE(lost_again.details.find("reads 60 after 23 was written"), std::string::npos) << lost_again.details;
}

TEST(MakeSafe, RetriesOnSameConnectionUnlessBroken) {
  FakeChamber::ProfileState state;
  state.silent_tries = 5;
  EXPECT_EQ(attempt(state).tries, 6);
  EXPECT_EQ(state.connections, 1);
  state.silent_tries = 2;
  state.silence = FaultKind::disconnected;
  EXPECT_EQ(attempt(state).reached, SafeStage::all);
  EXPECT_EQ(state.connections, 1 + 3);
}

TEST(MakeSafe, BeginsNoAttemptThatCouldExceedTenSeconds) {
  FakeChamber::ProfileState state;
  state.silent_tries = 99;
  state.slowness = std::chrono::milliseconds(1900);
  const auto began = state.clock.now().since_start;
  EXPECT_EQ(attempt(state).reached, SafeStage::nothing);
  EXPECT_LE(state.clock.now().since_start - began, kSafeWithin);
}

TEST(MakeSafe, EndsConditioningAndConfirmsSetPointSeparately) {
  FakeChamber::ProfileState state;
  EXPECT_EQ(attempt(state, kOff).reached, SafeStage::all);
  EXPECT_EQ(state.heard, "set program set off look ");
  state.refuses_to_stop = true;
  const auto refused = attempt(state, kOff);
  EXPECT_EQ(refused.reached, SafeStage::set_point);
  EXPECT_NE(refused.details.find("set point read back, but chamber stop: no"), std::string::npos) << refused.details;
}

TEST(MakeSafe, EndsProgramOfControllerBeforeSetPoint) {
  FakeChamber::ProfileState state;
  state.runs_program = true;
  const SafeGoal kUploaded{.set_point = {23}, .tolerance = {0.1}, .by_program = true};
  EXPECT_EQ(attempt(state, kUploaded).reached, SafeStage::all);
  EXPECT_TRUE(state.heard.starts_with("program set ")) << state.heard;
  state.keeps_program = true;
  EXPECT_EQ(attempt(state, kUploaded).reached, SafeStage::nothing);
}

TEST(MakeSafe, WritesModeThatFollowsSetPointWhenChamberShowsAnother) {
  for (const auto activity :
       {ChamberActivity::not_following, ChamberActivity::program, ChamberActivity::holding, ChamberActivity::done}) {
    FakeChamber::ProfileState state;
    state.activity = activity;
    const auto made = attempt(state);
    EXPECT_EQ(state.heard, "set program set look start look ") << name(activity);
    ASSERT_TRUE(made.state);
    EXPECT_EQ(made.state->activity, ChamberActivity::running);
  }
  for (const auto activity : {ChamberActivity::off, ChamberActivity::door_open, ChamberActivity::unknown}) {
    FakeChamber::ProfileState state;
    state.activity = activity;
    EXPECT_EQ(attempt(state).state->activity, activity) << "nothing is switched on";
    EXPECT_EQ(state.heard, "set program set look ") << name(activity);
  }
}

TEST(MakeSafe, CarriesOutActionsOfEvidence) {
  FakeChamber::ProfileState state;
  EXPECT_EQ(attempt(state, {.set_point = {23}, .tolerance = {0.1}}, SafeTask::look).state->air, Celsius{79});
  EXPECT_EQ(state.heard, "look ") << "nothing is sent";
  state.heard.clear();
  (void)attempt(state, {.set_point = {23}, .tolerance = {0.1}}, SafeTask::follow);
  EXPECT_EQ(state.heard, "set program set look start look ");
  state.heard.clear();
  (void)attempt(state, {.set_point = {23}, .tolerance = {0.1}}, SafeTask::off);
  EXPECT_EQ(state.heard, "set program set off look ");
  state.heard.clear();
  state.ignores = true;
  (void)attempt(state, {.set_point = {23}, .tolerance = {0.1}}, SafeTask::off);
  EXPECT_TRUE(state.heard.ends_with("set off look ")) << "although the set point is refused: " << state.heard;
}

TEST(MakeSafe, ReportsEachStage) {
  FakeChamber::ProfileState state;
  state.silent_tries = 1;
  std::vector<SafeStage> stages;
  (void)attempt_safe(kOff, {.connect = [&] { return std::make_unique<FakeChamber>(state); },
                            .wait = [&](Duration time) { state.clock.advance(time); },
                            .report = [&](const SafeAttempt& so_far) { stages.push_back(so_far.reached); },
                            .clock = state.clock});
  EXPECT_EQ(stages, (std::vector{SafeStage::nothing, SafeStage::set_point, SafeStage::all}));
}

TEST(MakeSafe, SafeStateFileOfEachShippedMapReachesChamber) {
  int maps = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/chambers")) {
    if (entry.path().extension() != ".toml") continue;
    ++maps;
    const auto map_text = read_text_file(entry.path().string()).value();
    const auto map = drivers::parse_register_map(map_text, entry.path().string());
    ASSERT_TRUE(map) << text(map.error());
    const SafeState safe_state{
        .record = "r.db",
        .line = map->links.front().kind == drivers::LinkKind::rtu ? "serial:/dev/ttyUSB9" : "tcp://10.0.0.7",
        .link = map->links.front().kind,
        .word_order = {},
        .safe_set_point = {23},
        .switch_off = false,
        .by_program = false,
        .written_by = own_identity(),
        .map_text = map_text};
    const auto chamber = parse_safe_state(to_text(safe_state), "text").and_then(make_safe_state_chamber);
    EXPECT_TRUE(chamber) << entry.path() << ": " << text(chamber.error());
  }
  EXPECT_GE(maps, 14);
}

TEST(MakeSafe, SafeStateFileHasRoundingOfSetPoint) {
  auto map_text = read_text_file(GYROTHERM_SOURCE_DIR "/tests/sequencer/faults/chamber.toml").value();
  const auto tolerance = [&] {
    const auto chamber = make_safe_state_chamber({.record = "r.db",
                                                  .line = "tcp://10.0.0.7",
                                                  .link = drivers::LinkKind::tcp,
                                                  .word_order = {},
                                                  .safe_set_point = {23},
                                                  .switch_off = false,
                                                  .by_program = false,
                                                  .written_by = own_identity(),
                                                  .map_text = map_text});
    EXPECT_TRUE(chamber) << text(chamber.error());
    return chamber ? chamber->goal.tolerance : Kelvins{};
  };
  EXPECT_EQ(tolerance(), Kelvins{0.1});
  const std::string set_point = "name = \"set_point\"\n";
  const auto after = map_text.find(set_point) + set_point.size();
  map_text.insert(after, "resolution = 1\n");
  EXPECT_EQ(tolerance(), Kelvins{1});
  map_text.insert(after, "tolerance = 2\n");
  EXPECT_EQ(tolerance(), Kelvins{2});
}

/// Returns the safe-state file of a run, with settings of its installation.
SafeState make_armed_state(const std::string& line, drivers::LinkKind link, const drivers::LinkSettings& settings) {
  return {.record = "r.db",
          .line = line,
          .link = link,
          .word_order = {},
          .link_settings = settings,
          .safe_set_point = {23},
          .switch_off = false,
          .by_program = false,
          .written_by = own_identity(),
          .map_text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/watlow_f4t.toml").value()};
}

TEST(MakeSafe, UsesLinkSettingsOfRun) {
  using drivers::LinkKind;
  const auto place = [](const SafeState& safe_state) {
    const auto chamber = parse_safe_state(to_text(safe_state), "text").and_then(make_safe_state_chamber);
    EXPECT_TRUE(chamber) << text(chamber.error());
    return chamber ? chamber->place : "";
  };
  const auto plain = place(make_armed_state("tcp://10.0.0.7", LinkKind::tcp, {}));
  EXPECT_EQ(place(make_armed_state("tcp://10.0.0.7", LinkKind::tcp, {.unit = 1})), plain)
      << "the unit number of the map";
  EXPECT_NE(place(make_armed_state("tcp://10.0.0.7", LinkKind::tcp, {.unit = 2})), plain)
      << "another unit has another lock";
  EXPECT_NE(place(make_armed_state("serial:/dev/ttyUSB9", LinkKind::rtu, {.unit = 3, .echo = true})), "");
  EXPECT_NE(place(make_armed_state("tcp://10.0.0.7", LinkKind::tcp, {.returns_other_transaction = true})), "");
  EXPECT_FALSE(make_safe_state_chamber(make_armed_state("tcp://10.0.0.7", LinkKind::tcp, {.echo = true})))
      << "no such link";
}

TEST(MakeSafe, RefusesLineWithoutChamber) {
  for (const auto* line : {"virtual", "hid:1", "nonsense://"})
    EXPECT_FALSE(make_safe_state_chamber({.record = "r.db",
                                          .line = line,
                                          .link = drivers::LinkKind::tcp,
                                          .word_order = {},
                                          .safe_set_point = {23},
                                          .switch_off = false,
                                          .by_program = false,
                                          .written_by = own_identity(),
                                          .map_text = ""}))
        << line;
}

TEST(MakeSafe, RefusesLinkThatDoesNotFitLine) {
  using drivers::LinkKind;
  const auto refusal = [](const char* line, LinkKind link) {
    const auto chamber = make_safe_state_chamber(make_armed_state(line, link, {}));
    return chamber ? "" : text(chamber.error());
  };
  for (const auto& [line, link] : {std::pair("serial:/dev/ttyUSB9", LinkKind::tcp),
                                   {"serial:/dev/ttyUSB9?9600,8N1", LinkKind::rtu_over_tcp},
                                   {"tcp://10.0.0.7", LinkKind::rtu},
                                   {"10.0.0.7", LinkKind::rtu}})
    EXPECT_NE(refusal(line, link).find("does not fit line"), std::string::npos) << line;
  EXPECT_EQ(refusal("serial:/dev/ttyUSB9", LinkKind::rtu), "");
  EXPECT_EQ(refusal("tcp://10.0.0.7", LinkKind::tcp), "");
}

TEST(MakeSafe, WritesTraceThatCanBeRead) {
  const tests::TestFolder folder;
  const MadeSafe trace{.at = std::chrono::seconds(1767225600),
                       .because = "the program that drove it hung",
                       .set_point = {23},
                       .confirmed = true,
                       .details = "set point read back, air 61.20 °C"};
  EXPECT_EQ(to_text(trace),
            "schema = \"gyrotherm-made-safe/1\"\nat = \"2026-01-01T00:00:00Z\"\nutc_ns = 1767225600000000000\n"
            "because = \"the program that drove it hung\"\nset_point_c = 23\nconfirmed = true\n"
            "details = \"set point read back, air 61.20 °C\"\n");
  ASSERT_TRUE(write_trace(folder / "run.db", trace));
  const auto read = read_trace(folder / "run.db");
  ASSERT_TRUE(read && *read);
  EXPECT_EQ(**read, trace);
  EXPECT_EQ(describe(trace),
            "made safe by the guard at 2026-01-01T00:00:00Z (the program that drove it hung): the chamber was sent to "
            "23 °C; set point read back, air 61.20 °C");
}

/// A write that arrived may have been carried out even if its reply was not understood.
TEST(MakeSafe, ReportsUnconfirmedWriteAsPossiblySent) {
  for (const auto* details : {"transaction of the reply is 0, expected 1", "no reply in 500 ms", "no connection"})
    EXPECT_EQ(describe(MadeSafe{.at = std::chrono::seconds(1767225600),
                                .because = "it hung",
                                .set_point = {23},
                                .confirmed = false,
                                .details = details}),
              std::string("NOT yet made safe by the guard at 2026-01-01T00:00:00Z (it hung): the chamber is NOT "
                          "confirmed to have reached its safe set point of 23 °C; ") +
                  details);
}

}  // namespace
}  // namespace gyrotherm::watchdog
