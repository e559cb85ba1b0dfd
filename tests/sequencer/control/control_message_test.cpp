// SPDX-License-Identifier: Apache-2.0
/// Messages of other programs to the program that carries out a run.
#include "sequencer/control/control_message.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gyrotherm::control {
namespace {

TEST(ControlRequest, SurvivesMessageUnchanged) {
  for (const auto* word : {"pause", "resume", "stop", "abort"}) {
    const auto request = make_request(word, "");
    ASSERT_TRUE(request) << word;
    const auto parsed = parse_request(to_message(*request));
    ASSERT_TRUE(parsed) << text(parsed.error());
    EXPECT_EQ(*parsed, *request);
  }
  const auto note = make_request("note", "Tür geöffnet, \"Kabel\" geprüft");
  ASSERT_TRUE(note);
  EXPECT_EQ(parse_request(to_message(*note)), *note);
  const auto answer = make_request("resume", "turned by hand");
  ASSERT_TRUE(answer);
  EXPECT_EQ(parse_request(to_message(*answer)), *answer);
  EXPECT_EQ(to_message(*make_request("pause", "")), "gyrotherm-tell/1 pause ");
  for (const auto& [word, text] :
       std::vector<std::pair<std::string, std::string>>{{"acknowledge", "12 seen, the door was open"},
                                                        {"acknowledge", "all seen"},
                                                        {"acknowledge", "12,15,40 the cable"},
                                                        {"shelve", "12 7200 s the fan is being replaced"},
                                                        {"unshelve", "12"},
                                                        {"stop", "the coolant is low"},
                                                        {"abort", "smell of burning"},
                                                        {"told", "mailto:anna@lab: rule \"night\", alarm 12"}}) {
    const auto request = make_request(word, text);
    ASSERT_TRUE(request) << text;
    EXPECT_EQ(parse_request(to_message(*request)), *request) << text;
    EXPECT_EQ(command_keyword(*request), word);
    EXPECT_EQ(command_text(*request), text);
  }
}

TEST(ControlRequest, NamesUserOfMonitor) {
  auto request = *make_request("acknowledge", "7 seen");
  request.for_user = "anna.b@lab-2";
  EXPECT_EQ(to_message(request), "gyrotherm-tell/1 for=anna.b@lab-2 acknowledge 7 seen");
  EXPECT_EQ(parse_request(to_message(request)), request);
}

TEST(ControlRequest, RestrictsCharactersOfUserNames) {
  for (const auto* good : {"a", "anna", "A.B_c-d@e", "0"}) EXPECT_TRUE(is_user_name(good)) << good;
  EXPECT_TRUE(is_user_name(std::string(64, 'x')));
  for (const auto& bad : {std::string(), std::string(65, 'x'), std::string("an na"), std::string("änna"),
                          std::string("a(b"), std::string("a\n")}) {
    EXPECT_FALSE(is_user_name(bad)) << bad;
    EXPECT_FALSE(parse_request("gyrotherm-tell/1 for=" + bad + " pause ")) << bad;
  }
}

TEST(ControlRequest, AcknowledgesAlarmByNumberWithComment) {
  const auto one = make_request("acknowledge", "12  seen: it was the fuse");
  ASSERT_TRUE(one) << text(one.error());
  EXPECT_EQ(one->acknowledgement->alarms, std::vector<std::int64_t>{12});
  EXPECT_EQ(one->note, "seen: it was the fuse");
  EXPECT_EQ(make_request("acknowledge", "all of them seen")->acknowledgement->alarms, std::vector<std::int64_t>{});
  for (const auto* wrong :
       {"", " ", "12", "12 ", "all", "0 seen", "-1 seen", "1.5 seen", "seen", "99999999999999999999 x"})
    EXPECT_FALSE(make_request("acknowledge", wrong)) << wrong;
}

TEST(ControlRequest, ShelvesOneAlarmForTimeWithReason) {
  using std::chrono_literals::operator""s;
  for (const auto& [text, time] : std::vector<std::pair<std::string, Duration>>{{"12 2 h the fan", 7200s},
                                                                                {"12  90 min  the fan", 5400s},
                                                                                {"12 2h the fan", 7200s},
                                                                                {"12 1h30min the fan", 5400s},
                                                                                {"12 1 d the fan", 86400s},
                                                                                {"12 24 h the fan", 86400s},
                                                                                {"12 1.5 h the fan", 5400s},
                                                                                {"12 1500 ms the fan", 2s},
                                                                                {"12 1 s the fan", 1s}}) {
    const auto request = make_request("shelve", text);
    ASSERT_TRUE(request) << text;
    EXPECT_EQ(request->shelving->alarm, 12) << text;
    EXPECT_EQ(request->shelving->time, time) << text;
    EXPECT_EQ(request->note, "the fan") << text;
    EXPECT_EQ(parse_request(to_message(*request)), *request) << text;
  }
  const auto unshelving = make_request("unshelve", "12");
  ASSERT_TRUE(unshelving);
  EXPECT_EQ(unshelving->shelving->alarm, 12);
  EXPECT_FALSE(unshelving->shelving->time);
}

TEST(ControlRequest, RefusesShelvingWithoutNumberTimeOrReason) {
  for (const auto* wrong : {"",
                            " ",
                            "12",
                            "12 ",
                            "all 2 h the fan",
                            "12,15 2 h the fan",
                            "0 2 h the fan",
                            "-1 2 h the fan",
                            "x 2 h the fan",
                            "12 2 h",
                            "12 2 h ",
                            "12 the fan",
                            "12 2 the fan",
                            "12 h the fan",
                            "12 2 hours the fan",
                            "12 0 s the fan",
                            "12 0 h the fan",
                            "12 500 ms the fan",
                            "12 -2 h the fan",
                            "12 - 2 h the fan",
                            "12 25 h the fan",
                            "12 24.001 h the fan",
                            "12 2 d the fan",
                            "12 86401 s the fan",
                            "12 nan h the fan",
                            "12 inf h the fan",
                            "12 1e30 h the fan",
                            "12 1 h 30 min the fan",
                            "12 1 h 30 min",
                            "99999999999999999999 2 h the fan"}) {
    const auto request = make_request("shelve", wrong);
    ASSERT_FALSE(request) << wrong;
    EXPECT_EQ(request.error().kind, FaultKind::usage) << wrong;
    EXPECT_FALSE(parse_request(std::string("gyrotherm-tell/1 shelve ") + wrong)) << wrong;
  }
  for (const auto* wrong : {"", " ", "all", "12,15", "0", "x", "12 the fan", "12 2 h the fan"})
    EXPECT_FALSE(make_request("unshelve", wrong)) << wrong;
}

TEST(ControlRequest, RefusesUnknownKeyword) {
  for (const auto& [word, note] : std::vector<std::pair<std::string, std::string>>{{"go", ""},
                                                                                   {"", ""},
                                                                                   {"pause", "now"},
                                                                                   {"resume", "two\nlines"},
                                                                                   {"note", ""},
                                                                                   {"note", "two\nlines"},
                                                                                   {"note",
                                                                                    "20 \xB0"
                                                                                    "C"},
                                                                                   {"note", std::string(2001, 'x')},
                                                                                   {"told", ""},
                                                                                   {"told", std::string(2001, 'x')}}) {
    const auto request = make_request(word, note);
    ASSERT_FALSE(request) << word;
    EXPECT_EQ(request.error().kind, FaultKind::usage);
  }
}

}  // namespace
}  // namespace gyrotherm::control
