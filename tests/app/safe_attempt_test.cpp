/// Making a chamber safe: what counts as confirmed, how often and how long it is tried.
#include "app/guard/safe_attempt.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "app/guard/made_safe_file.hpp"
#include "core/text_file.hpp"
#include "tests/app/folder.hpp"

namespace gyrotherm {
namespace {

/// A chamber that takes set points until it is told to break. Each call takes `slowness` of the clock.
class FakeChamber final : public Chamber {
 public:
  struct State {
    VirtualClock clock;
    Duration slowness{};
    Celsius set_point{80};
    bool off = false;
    int silent_tries = 0;  ///< that go by before it answers
    bool ignores = false;  ///< acknowledges and does nothing
    bool coarse = false;   ///< keeps whole kelvins
    bool refuses_to_stop = false;
    int connections = 0;
  };
  explicit FakeChamber(State& state) : state_(state) { ++state.connections; }
  Result<std::string> identify() override { return std::string("fake"); }
  Result<ChamberState> read() override { return ChamberState{.air = {79}, .set_point = state_.set_point}; }
  Result<void> head_for(Celsius target) override {
    state_.clock.advance(state_.slowness);
    if (state_.silent_tries-- > 0) return failure(FaultKind::timeout, "chamber", "no reply");
    if (!state_.ignores) state_.set_point = {state_.coarse ? std::round(target.value) : target.value};
    return {};
  }
  Result<void> start() override { return {}; }
  Result<void> stop() override {
    if (state_.refuses_to_stop) return failure(FaultKind::refused, "chamber stop", "no");
    state_.off = true;
    return {};
  }

 private:
  State& state_;
};

SafeAttempt attempt(FakeChamber::State& state, const SafeGoal& goal) {
  return attempt_safe(goal, {.connect = [&] { return std::make_unique<FakeChamber>(state); },
                             .wait = [&](Duration time) { state.clock.advance(time); },
                             .clock = state.clock});
}
SafeAttempt attempt(FakeChamber::State& state, bool switch_off = false) {
  return attempt(state, {.set_point = {23}, .tolerance = {0.1}, .switch_off = switch_off});
}

TEST(MakeSafe, IsConfirmedOnlyByReadBack) {
  FakeChamber::State state;
  EXPECT_TRUE(attempt(state).confirmed);
  EXPECT_EQ(state.set_point, (Celsius{23}));
  state.set_point = {80};
  state.ignores = true;
  const auto ignored = attempt(state);
  EXPECT_FALSE(ignored.confirmed);
  EXPECT_EQ(ignored.tries, 3);
  EXPECT_NE(ignored.details.find("reads 80 after 23 was written"), std::string::npos) << ignored.details;
}

TEST(MakeSafe, ARoundedSetPointIsConfirmedWhereTheMapSaysThatItIsRounded) {
  FakeChamber::State state;
  state.coarse = true;
  EXPECT_FALSE(attempt(state, {.set_point = {23.4}, .tolerance = {0.1}}).confirmed);
  const auto rounded = attempt(state, {.set_point = {23.4}, .tolerance = {1}});
  EXPECT_TRUE(rounded.confirmed);
  EXPECT_EQ(rounded.tries, 1);
  state.ignores = true;
  state.set_point = {25};
  EXPECT_FALSE(attempt(state, {.set_point = {23.4}, .tolerance = {1}}).confirmed);
}

TEST(MakeSafe, TriesThreeTimesOnAConnectionOfItsOwnEach) {
  FakeChamber::State state;
  state.silent_tries = 2;
  const auto third = attempt(state);
  EXPECT_TRUE(third.confirmed);
  EXPECT_EQ(third.tries, 3);
  EXPECT_EQ(state.connections, 3);
  state.silent_tries = 3;
  EXPECT_FALSE(attempt(state).confirmed);
}

TEST(MakeSafe, NoTryBeginsThatCouldNotEndWithinTenSeconds) {
  FakeChamber::State state;
  state.silent_tries = 99;
  state.slowness = std::chrono::milliseconds(2500);
  const auto began = state.clock.now().since_start;
  const auto slow = attempt(state);
  EXPECT_FALSE(slow.confirmed);
  EXPECT_EQ(slow.tries, 2);
  EXPECT_LE(state.clock.now().since_start - began, kSafeWithin);
}

TEST(MakeSafe, EndsConditioningWhereTheRigWantsIt) {
  FakeChamber::State state;
  EXPECT_TRUE(attempt(state, true).confirmed);
  EXPECT_TRUE(state.off);
  EXPECT_EQ(state.set_point, (Celsius{23}));
  state.refuses_to_stop = true;
  EXPECT_FALSE(attempt(state, true).confirmed);
}

TEST(MakeSafe, AnArmedFileOfAnyShippedMapLeadsToItsChamber) {
  for (const auto& entry : std::filesystem::directory_iterator(GYROTHERM_SOURCE_DIR "/profiles/chambers")) {
    if (entry.path().extension() != ".toml") continue;
    const auto map_text = read_text_file(entry.path().string()).value();
    const auto map = parse_register_map(map_text, entry.path().string());
    ASSERT_TRUE(map) << text(map.error());
    const Armed armed{.record = "r.db",
                      .line = map->links.front().kind == LinkKind::rtu ? "serial:/dev/ttyUSB9" : "tcp://10.0.0.7",
                      .link = map->links.front().kind,
                      .word_order = {},
                      .safe_set_point = {23},
                      .switch_off = false,
                      .armed_by = own_identity(),
                      .map_text = map_text};
    const auto chamber = parse_armed(to_text(armed), "text").and_then(chamber_of);
    EXPECT_TRUE(chamber) << entry.path() << ": " << text(chamber.error());
  }
}

TEST(MakeSafe, TheArmedMapSaysHowFarASetPointIsRounded) {
  auto map_text = read_text_file(GYROTHERM_SOURCE_DIR "/tests/rig/faults/chamber.toml").value();
  const auto tolerance = [&] {
    const auto chamber = chamber_of({.record = "r.db",
                                     .line = "tcp://10.0.0.7",
                                     .link = LinkKind::tcp,
                                     .word_order = {},
                                     .safe_set_point = {23},
                                     .switch_off = false,
                                     .armed_by = own_identity(),
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

TEST(MakeSafe, ALineWithoutAChamberIsRefused) {
  for (const auto* line : {"virtual", "hid:1", "nonsense://"})
    EXPECT_FALSE(chamber_of({.record = "r.db",
                             .line = line,
                             .link = LinkKind::tcp,
                             .word_order = {},
                             .safe_set_point = {23},
                             .switch_off = false,
                             .armed_by = own_identity(),
                             .map_text = ""}))
        << line;
}

TEST(MakeSafe, LeavesATraceThatReadsBack) {
  const TestFolder folder;
  const MadeSafe trace{.at = std::chrono::seconds(1767225600),
                       .because = "the program that drove it hung",
                       .set_point = {23},
                       .confirmed = true,
                       .details = "set point read back, air 61.20 °C"};
  EXPECT_EQ(to_text(trace),
            "gyrotherm-made-safe/1\nat: 2026-01-01T00:00:00Z\nutc_ns: 1767225600000000000\n"
            "because: the program that drove it hung\nset_point_c: 23\nconfirmed: yes\n"
            "details: set point read back, air 61.20 °C\n");
  ASSERT_TRUE(leave_trace(folder / "run.db", trace));
  const auto read = read_trace(folder / "run.db");
  ASSERT_TRUE(read && *read);
  EXPECT_EQ(**read, trace);
  EXPECT_EQ(in_words(trace),
            "made safe by the guard at 2026-01-01T00:00:00Z (the program that drove it hung): the chamber was sent to "
            "23 °C; set point read back, air 61.20 °C");
}

}  // namespace
}  // namespace gyrotherm
