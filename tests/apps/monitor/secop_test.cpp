// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

#include "apps/monitor/secop_node.hpp"
#include "apps/monitor/secop_run.hpp"
#include "apps/monitor/secop_server.hpp"
#include "apps/monitor/series_channels.hpp"
#include "core/clock.hpp"
#include "core/json.hpp"
#include "tests/apps/monitor/small_run.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::monitor {
namespace {

constexpr double kNow = 1505396348.876;

/// The node of the specification's examples (chapter "Messages").
SecopNode example_node() {
  return {.equipment_id = "MLZ_ccr12",
          .description = "an example",
          .firmware = "none",
          .modules = {{.name = "t1",
                       .description = "a temperature",
                       .group = {},
                       .parameters = {{.name = "value",
                                       .description = "the temperature",
                                       .datainfo = R"({"type":"double","unit":"K"})",
                                       .value = "295.13",
                                       .trouble = {},
                                       .t = 1505396348.188,
                                       .measured = true},
                                      {.name = "status",
                                       .description = "its state",
                                       .datainfo = R"({"type":"string"})",
                                       .value = R"([400,"heater broken or disconnected"])",
                                       .trouble = {},
                                       .t = 1505396348.288},
                                      {.name = "_heaterpower",
                                       .description = "of the heater",
                                       .datainfo = R"({"type":"double","unit":"W"})",
                                       .value = "HardwareError",
                                       .trouble = "heater broken or disconnected",
                                       .t = 1505396349.2}}},
                      {.name = "ts", .description = "another", .group = {}, .parameters = {}}}};
}

SecopState example() {
  auto node = example_node();
  auto structure = structure_of(node);
  return {std::move(node), std::move(structure)};
}

std::string ask(const std::string& line, SecopSession session = {}) {
  return answer_secop(example(), session, line, kNow);
}

TEST(Secop, AnswersAsTheSpecificationsExamples) {
  EXPECT_EQ(ask("*IDN?"), "ISSE&SINE2020,SECoP,V2019-09-16,v1.0\n");
  EXPECT_EQ(ask("read t1:value"), "reply t1:value [295.13,{\"t\":1505396348.188}]\n");
  EXPECT_EQ(ask("read t1:status"),
            "reply t1:status [[400,\"heater broken or disconnected\"],{\"t\":1505396348.288}]\n");
  EXPECT_EQ(ask("ping 123"), "pong 123 [null,{\"t\":1505396348.876}]\n");
  EXPECT_EQ(ask("ping"), "pong  [null,{\"t\":1505396348.876}]\n");
  EXPECT_EQ(
      ask("activate"),
      "update t1:value [295.13,{\"t\":1505396348.188}]\n"
      "update t1:status [[400,\"heater broken or disconnected\"],{\"t\":1505396348.288}]\n"
      "error_update t1:_heaterpower [\"HardwareError\",\"heater broken or disconnected\",{\"t\":1505396349.200}]\n"
      "active\n");
  EXPECT_EQ(ask("deactivate"), "inactive\n");
  EXPECT_EQ(ask("meas:volt?"), "error_meas:volt?  [\"ProtocolError\",\"unknown action\",{}]\n");
}

TEST(Secop, RefusesByTheClassOfTheError) {
  const auto refused = [](const std::string& line, const std::string& beginning, const std::string& kind) {
    const auto reply = ask(line);
    EXPECT_TRUE(reply.starts_with(beginning + " [\"" + kind + "\",\"") && reply.ends_with(",{}]\n")) << reply;
  };
  refused("read tx:target", "error_read tx:target", "NoSuchModule");
  refused("change ts:target 12", "error_change ts:target", "NoSuchParameter");
  refused("read ts:target", "error_read ts:target", "NoSuchParameter");
  refused("change t1:value 12", "error_change t1:value", "ReadOnly");
  refused("change t1:value", "error_change t1:value", "ReadOnly");
  refused("change t1:value {", "error_change t1:value", "BadJSON");
  refused("change tx:value 12", "error_change tx:value", "NoSuchModule");
  refused("do t1:stop", "error_do t1:stop", "NoSuchCommand");
  refused("do t1:stop null", "error_do t1:stop", "NoSuchCommand");
  refused("do t1:stop nul", "error_do t1:stop", "BadJSON");
  refused("do tx:stop", "error_do tx:stop", "NoSuchModule");
  refused("activate tx", "error_activate tx", "NoSuchModule");
  refused("deactivate tx", "error_deactivate tx", "NoSuchModule");
  refused("read", "error_read ", "ProtocolError");
  refused("read t1", "error_read t1", "ProtocolError");
  refused("", "error_ ", "ProtocolError");
  refused("idn", "error_idn ", "ProtocolError");
  refused("logging t1 \"debug\"", "error_logging t1", "ProtocolError");
  refused("GET / HTTP/1.1", "error_GET /", "ProtocolError");
  refused("re\x1b[2J\xff", "error_re\\x1b[2J\\xff ", "ProtocolError");
}

/// What a later version may add is not understood, and does no harm ("Compatibility").
TEST(Secop, IgnoresWhatLaterVersionsMayAdd) {
  EXPECT_EQ(ask("read t1:value:deeper"), "reply t1:value:deeper [295.13,{\"t\":1505396348.188}]\n");
  EXPECT_TRUE(ask("activate t1:value").ends_with("active t1\n"));
  EXPECT_EQ(ask("describe . {}"), ask("describe"));
}

TEST(Secop, DescribesItself) {
  const auto text = ask("describe");
  const std::string beginning = "describing . ";
  ASSERT_TRUE(text.starts_with(beginning) && text.ends_with("\n"));
  const auto report = Json::parse(text.substr(beginning.size()));
  EXPECT_EQ(report["equipment_id"], "MLZ_ccr12");
  const auto& value = report["modules"]["t1"]["accessibles"]["value"];
  EXPECT_EQ(value["datainfo"]["type"], "double");
  EXPECT_EQ(value["readonly"], true);
  EXPECT_EQ(report["modules"]["t1"]["interface_classes"], Json::array({"Readable"}));
}

TEST(Secop, TellsWhatIsNewToWhomItConcerns) {
  auto now = example_node();
  now.modules[0].parameters[0].t += 1;         // measured anew, the same value
  now.modules[0].parameters[1].t += 1;         // said again: no news
  now.modules[0].parameters[2].value = "2.5";  // the heater is back
  now.modules[0].parameters[2].trouble.clear();
  const std::string news =
      "update t1:value [295.13,{\"t\":1505396349.188}]\n"
      "update t1:_heaterpower [2.5,{\"t\":1505396349.200}]\n";
  SecopSession session;
  EXPECT_EQ(secop_news(example_node(), now, session), "");
  (void)answer_secop(example(), session, "activate", kNow);
  EXPECT_EQ(secop_news(example_node(), now, session), news);
  EXPECT_EQ(answer_secop(example(), session, "deactivate t1", kNow), "inactive t1\n");
  EXPECT_EQ(secop_news(example_node(), now, session), "");
  EXPECT_TRUE(session.hears("ts"));
  (void)answer_secop(example(), session, "activate t1", kNow);
  EXPECT_EQ(secop_news(example_node(), now, session), news);
  (void)answer_secop(example(), session, "*IDN?", kNow);
  EXPECT_FALSE(session.is_active());
}

TEST(Secop, NamesAreIdentifiersAndUniqueInSmallLetters) {
  std::set<std::string> taken;
  EXPECT_EQ(secop_name("A", taken), "A");
  EXPECT_EQ(secop_name("a", taken), "a_2");
  EXPECT_EQ(secop_name("gyro 1.rate", taken), "gyro_1_rate");
  EXPECT_EQ(secop_name("1st", taken), "n1st");
  EXPECT_EQ(secop_name("_own", taken), "n_own");
  EXPECT_EQ(secop_name("", taken), "n");
  const auto longest = secop_name(std::string(200, 'x'), taken);
  EXPECT_LE(longest.size(), 63u);
  EXPECT_LE(secop_name(std::string(200, 'x'), taken).size(), 63u);
}

constexpr double kFault = std::numeric_limits<double>::quiet_NaN();

/// A run that a program carries out now, as far as a node can see.
FoundRun going_on() {
  FoundRun run;
  run.name = "soak";
  run.info = std::make_shared<const record::RunInfo>(small_run_info());
  run.status.being_written = true;
  run.age_s = 0.5;
  return run;
}

std::string told(const SecopNode& node, const std::string& line) {
  SecopSession session;
  return answer_secop({node, structure_of(node)}, session, line, kNow);
}

TEST(SecopRun, ShowsEachQuantityWithItsUnit) {
  const auto run = going_on();
  const LastSample sample{.slot = 7, .utc_s = 100, .values = {20.0, 20.5, kFault, 0.07, 3.25}};
  const auto node = secop_node_of({.run = &run, .sample = sample, .utc_s = kNow});
  EXPECT_EQ(told(node, "read chamber_air_c:value"), "reply chamber_air_c:value [20.5,{\"t\":100.000}]\n");
  EXPECT_EQ(told(node, "read A:value"), "reply A:value [0.07,{\"t\":100.000}]\n");
  EXPECT_TRUE(told(node, "read A:status").starts_with("reply A:status [[100,\"execute\"],"));
  EXPECT_TRUE(told(node, "read run:value").starts_with("reply run:value [0,"));
  EXPECT_TRUE(told(node, "read run:status").starts_with("reply run:status [[300,\"execute\"],"));
  EXPECT_TRUE(told(node, "read run:_record").starts_with("reply run:_record [\"soak\","));
  const auto channels = series_channels(small_run_info());
  EXPECT_EQ(node.modules.size(), channels.size() + 1);
  const auto report = Json::parse(structure_of(node));
  EXPECT_EQ(report["modules"]["A"]["accessibles"]["value"]["datainfo"]["unit"], "°C");
  EXPECT_EQ(structure_of(node).find('\xc2'), std::string::npos) << "the wire has ASCII alone";
}

TEST(SecopRun, AFaultIsNoValue) {
  const auto run = going_on();
  const LastSample sample{.slot = 7, .utc_s = 100, .values = {20.0, 20.5, kFault, 0.07, 3.25}};
  const auto node = secop_node_of({.run = &run, .sample = sample, .utc_s = kNow});
  EXPECT_TRUE(told(node, "read chamber_set_point_c:value")
                  .starts_with("error_read chamber_set_point_c:value [\"HardwareError\","));
  EXPECT_TRUE(told(node, "read chamber_set_point_c:status").starts_with("reply chamber_set_point_c:status [[400,"));
}

TEST(SecopRun, NeverShowsAnOldNumber) {
  const LastSample sample{.slot = 7, .utc_s = 100, .values = {20.0, 20.5, 20.0, 0.07, 3.25}};
  const auto expect = [&](const FoundRun& run, bool stale, const std::string& kind, int status) {
    const auto node = secop_node_of({.run = &run, .sample = sample, .stale = stale, .utc_s = kNow});
    const auto reply = told(node, "read A:value");
    EXPECT_TRUE(reply.starts_with("error_read A:value [\"" + kind + "\",")) << reply;
    EXPECT_TRUE(told(node, "read A:status").starts_with("reply A:status [[" + std::to_string(status) + ","));
  };
  const auto expect_of_run = [&](const FoundRun* run, const std::string& kind) {
    const auto node = secop_node_of({.run = run, .sample = sample, .utc_s = kNow});
    for (const auto* name : {"value", "_left"}) {
      const auto place = std::string("run:") + name;
      EXPECT_TRUE(told(node, "read " + place).starts_with("error_read " + place + " [\"" + kind + "\",")) << name;
    }
    if (run != nullptr) {
      EXPECT_TRUE(told(node, "read run:_record").starts_with("reply run:_record [\"soak\",")) << "which one it was";
    }
  };
  auto run = going_on();
  run.status.standing.time_left = std::chrono::hours(1);
  EXPECT_TRUE(told(secop_node_of({.run = &run, .sample = sample, .utc_s = kNow}), "read run:_left")
                  .starts_with("reply run:_left [3600"));
  expect(run, true, "CommunicationFailed", 400);
  run.age_s = 60;
  expect(run, false, "CommunicationFailed", 400);
  expect_of_run(&run, "CommunicationFailed");
  run.status.being_written = false;
  expect(run, false, "Disabled", 0);
  expect_of_run(&run, "Disabled");
  expect_of_run(nullptr, "Disabled");
  EXPECT_TRUE(told(secop_node_of({.utc_s = kNow}), "read run:status").starts_with("reply run:status [[0,"));
}

TEST(SecopRun, TheStructureIsTheRigsAlone) {
  auto run = going_on();
  const auto before = structure_of(secop_node_of({.run = &run, .utc_s = kNow}));
  run.name = "another";
  run.status.being_written = false;
  EXPECT_EQ(structure_of(secop_node_of({.run = &run, .utc_s = kNow + 1})), before);
}

TEST(SecopRun, ReadsTheLastSecondOfARecord) {
  const tests::TestFolder folder;
  write_small_run(folder / "small.db", 20);
  const auto run = found_in(folder / "");
  const auto last = read_last_sample(run);
  ASSERT_TRUE(last && *last);
  EXPECT_EQ((*last)->slot, 19);
  EXPECT_DOUBLE_EQ((*last)->utc_s, to_seconds(kVirtualEpoch) + 19);
  EXPECT_EQ((*last)->values.at(3), 0.19);
}

TEST(SecopRun, WhatIsToldOfARunIsNotOlderThanThatItIsThere) {
  const tests::TestFolder folder;
  RunCatalogue catalogue({folder / ""});
  VirtualClock clock;
  SecopRun run(catalogue, "", clock);
  const auto told_since = [&] {
    catalogue.look();
    run.look();
    return run.state().node.find("run")->parameters.front().t;
  };
  write_small_run(folder / "first.db", 5);
  const auto first = told_since();
  clock.advance(std::chrono::hours(1));
  EXPECT_EQ(told_since(), first) << "nothing has changed";
  for (const char* file : {"first.db", "first.db.status"}) std::filesystem::remove(folder / file);
  write_small_run(folder / "second.db", 5);
  EXPECT_NEAR(told_since() - first, 3600, 1);
}

TEST(SecopServer, AllowsSoMuchAtOnceAndSoMuchASecond) {
  Allowance allowance(2, 10, std::chrono::seconds(0));
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(allowance.has_one({}));
    allowance.take();
  }
  EXPECT_FALSE(allowance.has_one({}));
  EXPECT_TRUE(allowance.has_one(std::chrono::milliseconds(100)));
  allowance.take();
  EXPECT_FALSE(allowance.has_one(std::chrono::milliseconds(150)));
}

}  // namespace
}  // namespace gyrotherm::monitor
