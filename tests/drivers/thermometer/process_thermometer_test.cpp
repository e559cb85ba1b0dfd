// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/process_thermometer.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "drivers/line/process_stream.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/slept.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono_literals::operator""s;
using std::chrono_literals::operator""ms;

TEST(ProcessProtocol, HasGoldenLines) {
  const auto question = split_numbered_line("12 gyrotherm-thermometer/1 2 Acme T-2 0815\r");
  ASSERT_TRUE(question);
  EXPECT_EQ(question->number, 12u);
  const auto greeting = decode_process_greeting(question->rest);
  ASSERT_TRUE(greeting) << text(greeting.error());
  EXPECT_EQ(*greeting, (ProcessGreeting{2, "Acme T-2 0815"}));
  EXPECT_EQ(encode_process_greeting(*greeting), "gyrotherm-thermometer/1 2 Acme T-2 0815");
  const auto readings = decode_process_readings("23.456 - -4e1", 3);
  ASSERT_TRUE(readings) << text(readings.error());
  EXPECT_EQ((*readings)[0].value(), Celsius{23.456});
  EXPECT_EQ(text((*readings)[1].error()), "input 2: the program reports no reading");
  EXPECT_EQ((*readings)[2].value(), Celsius{-40});
  EXPECT_EQ(encode_process_readings(std::vector<std::optional<double>>{23.456, std::nullopt}), "23.456000 -");
}

TEST(ProcessProtocol, IsStrict) {
  for (const auto* line : {"", "x 1", "-1 2", " 1", "1x 2", "99999999999999999999 2"})
    EXPECT_FALSE(split_numbered_line(line)) << line;
  for (const auto* text :
       {"", "1", "1 2 3", "1  2", "1 2 ", " 1 2", "1 nan", "1 inf", "1 0x10", "1 2,5", "1 --", "1 +-2"})
    EXPECT_EQ(decode_process_readings(text, 2).error().kind, FaultKind::corrupted) << text;
  EXPECT_EQ((*decode_process_readings("1 1e9", 2))[1].error().kind, FaultKind::out_of_range);
  EXPECT_EQ((*decode_process_readings("1 -274", 2))[1].error().kind, FaultKind::out_of_range);
  for (const auto* text : {"gyrotherm-thermometer/2 2 A", "gyrotherm-gyro/1 2 A", "hello", ""})
    EXPECT_EQ(decode_process_greeting(text).error().kind, FaultKind::mismatch) << text;
  for (const auto* text : {"gyrotherm-thermometer/1", "gyrotherm-thermometer/1 0 A", "gyrotherm-thermometer/1 65 A",
                           "gyrotherm-thermometer/1 2", "gyrotherm-thermometer/1 two A"})
    EXPECT_EQ(decode_process_greeting(text).error().kind, FaultKind::corrupted) << text;
}

constexpr const char* kGreeting = "gyrotherm-thermometer/1 2 Acme T-2 0815\n";

/// An in-memory program that follows the protocol.
class ProcessThermometerTest : public testing::Test {
 protected:
  ProcessThermometerTest() {
    auto made = std::make_unique<tests::FakeStream>();
    line = made.get();
    line->instrument = [this](std::string_view query) { return answer(query); };
    bank =
        make_process_thermometer(std::move(made), "thermometer 1", {.channels = 2, .end_program = [this] { ++ends; }});
  }
  std::string answer(std::string_view query) const {
    const auto question = split_numbered_line(query.substr(0, query.size() - 1));
    const auto number = std::to_string(question->number) + " ";
    return number + (question->rest == "hello" ? kGreeting : readings);
  }
  std::string fault() {
    const auto all = bank->read();
    EXPECT_EQ(all.size(), 2u);
    return all[0] ? "" : text(all[0].error());
  }
  tests::FakeStream* line{};
  std::unique_ptr<Thermometer> bank;
  std::string readings = "23.5 24.5\n";
  int ends{};
};

TEST_F(ProcessThermometerTest, GreetsOnceAndAsksEachSecond) {
  EXPECT_EQ(bank->read()[1].value(), Celsius{24.5});
  EXPECT_EQ(bank->read()[0].value(), Celsius{23.5});
  EXPECT_EQ(line->heard, (std::vector<std::string>{"1 hello\n", "2 read\n", "3 read\n"}));
  EXPECT_EQ(bank->identify().value(), "Acme T-2 0815");
}

TEST_F(ProcessThermometerTest, AcceptsAnswerInPieces) {
  line->limit_read_size(1);
  EXPECT_TRUE(bank->read()[1]);
}

TEST_F(ProcessThermometerTest, DoesNotTakeLateAnswerForNext) {
  EXPECT_TRUE(bank->read()[0]);
  line->instrument = [this](std::string_view query) { return "2 99 99\n" + answer(query); };
  EXPECT_EQ(bank->read()[0].value(), Celsius{23.5});
}

TEST_F(ProcessThermometerTest, ReportsInvalidAnswer) {
  EXPECT_TRUE(bank->read()[0]);
  line->instrument = [](std::string_view) { return std::string("Reading the sensor…\n"); };
  EXPECT_EQ(fault(), "thermometer 1: \"Reading the sensor…\" is not an answer to a request");
  line->instrument = [](std::string_view) { return std::string("77 1 2\n"); };
  EXPECT_EQ(fault(), "thermometer 1: \"77 1 2\" is not an answer to a request");
  line->instrument = [this](std::string_view query) { return answer(query); };
  EXPECT_EQ(fault(), "");
}

TEST_F(ProcessThermometerTest, AnotherProtocolOrTooFewInputsAreMismatches) {
  line->instrument = [](std::string_view query) {
    return std::string(query.substr(0, query.find(' '))) + " gyrotherm-thermometer/2 2 Acme\n";
  };
  EXPECT_EQ(fault(), "thermometer 1 hello: received \"gyrotherm-thermometer/2\", expected gyrotherm-thermometer/1");
  line->instrument = [](std::string_view query) {
    return std::string(query.substr(0, query.find(' '))) + " gyrotherm-thermometer/1 1 Acme\n";
  };
  EXPECT_EQ(fault(), "thermometer 1 hello: the program has 1 inputs, but the rig file names 2 channels");
}

TEST_F(ProcessThermometerTest, StopsProgramAfterTenFailedQuestions) {
  readings = "23.5\n";
  for (int i = 0; i < 9; ++i) EXPECT_EQ(fault(), "thermometer 1 read: \"23.5\" is not 2 readings");
  EXPECT_EQ(ends, 0);
  (void)fault();
  EXPECT_EQ(ends, 1);
  readings = "23.5 24.5\n";
  line->heard.clear();
  EXPECT_EQ(fault(), "");
  EXPECT_EQ(line->heard.front(), "12 hello\n") << "the new one is greeted";
}

/// Returns the result of one reading from a real, misbehaving program. Fails the test if the reading sleeps for longer
/// than `most`.
std::string reading_of(const std::string& script, Duration most = 900ms) {
  const std::string good =
      "answer() { case $2 in hello) echo \"$1 gyrotherm-thermometer/1 2 Acme T-2\";; read) echo \"$1 1.5 2.5\";; esac; "
      "}\n";
  auto stream = std::make_unique<ProcessStream>(ProgramCommand{.words = {"/bin/sh", "-c", good + script}});
  const auto bank = make_process_thermometer(std::move(stream), "t", {.channels = 2});
  const auto who = bank->identify();
  const tests::SleepMeter meter;
  const auto readings = bank->read();
  EXPECT_LT(meter.slept(), most) << script;
  EXPECT_EQ(readings.size(), 2u);
  return readings[0] ? "good" : name(readings[0].error().kind);
}

TEST(ProcessThermometerHostile, ReadsGoodProgram) {
  EXPECT_EQ(reading_of("while read n word; do answer $n $word; done"), "good");
}
TEST(ProcessThermometerHostile, OneThatIsSilentIsATimeout) {
  EXPECT_EQ(reading_of("read n word; answer $n $word; sleep 1000"), "timeout");
}
TEST(ProcessThermometerHostile, GarbageIsCorrupted) {
  EXPECT_EQ(reading_of("read n word; answer $n $word; head -c 3000 /dev/urandom; echo; sleep 1000"), "corrupted");
}
TEST(ProcessThermometerHostile, RejectsEndlessLine) {
  EXPECT_EQ(reading_of("read n word; answer $n $word; tr '\\0' x < /dev/zero"), "corrupted");
}
TEST(ProcessThermometerHostile, RejectsFloodOfLines) {
  EXPECT_EQ(reading_of("read n word; answer $n $word; yes"), "corrupted");
}
TEST(ProcessThermometerHostile, RejectsFloodOfOldAnswers) {
  EXPECT_EQ(reading_of("read n word; answer $n $word; yes '1 1.5 2.5'"), "corrupted");
}
TEST(ProcessThermometerHostile, OneThatDiesIsDisconnected) {
  EXPECT_EQ(reading_of("read n word; answer $n $word; read n word; exit 1"), "disconnected");
}
TEST(ProcessThermometerHostile, OneThatStoppedReadingIsATimeout) {
  EXPECT_EQ(reading_of("read n word; answer $n $word; kill -STOP $$"), "timeout");
}

}  // namespace
}  // namespace gyrotherm::drivers
