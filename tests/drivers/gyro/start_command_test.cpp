// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/start_command.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "tests/support/fakes.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;

std::string text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Sends a command to a unit with that answer.
Result<void> answered(const GyroCommand& command, const std::string& answer, const std::string& stream = "kvh-17xx-a") {
  tests::FakeStream line;
  line.instrument = [&](std::string_view) { return answer; };
  return send_command(command, tests::shipped_stream(stream).frame, line, milliseconds(10), nullptr);
}

const GyroCommand kUnits{
    .send = "=ROTUNITS,RAD\r\n", .wait = milliseconds(20), .reply = "ROTUNITS,RAD", .refusal = "INVALID"};

TEST(StartCommand, FindsReplyAmongFrames) {
  EXPECT_TRUE(answered(kUnits, "ROTUNITS,RAD\r\n"));
  EXPECT_TRUE(answered(kUnits, std::string("\xFE\x81\xFF\x55\x00", 5) + "ROTUNITS,RAD\n"));
  EXPECT_TRUE(answered(kUnits, "=ROTUNITS,RAD\r\nROTUNITS,RAD\r\n")) << "an adapter that echoes";
}

TEST(StartCommand, IsNotConfirmedByItsEcho) {
  for (const std::string send : {"=ROTUNITS,RAD\r\n", "=CONFIG,1\r\n", "=DR,1000\r\n", "?RATE\r\n"}) {
    const GyroCommand command{.send = send, .wait = milliseconds(20), .reply = first_line(send.substr(1))};
    const auto done = answered(command, send);
    ASSERT_FALSE(done) << send;
    EXPECT_EQ(done.error().kind, FaultKind::timeout) << send;
  }
}

/// A frame whose last byte is "=" makes an echo of the reply after it.
TEST(StartCommand, IsRepeatedOnceAfterFrameThatEndsLikeAnEcho) {
  tests::FakeStream line;
  int sent = 0;
  line.instrument = [&](std::string_view) {
    return std::string(++sent == 1 ? "\xFE\x81\xFF\x55=" : "") + "ROTUNITS,RAD\r\n";
  };
  EXPECT_TRUE(send_command(kUnits, tests::shipped_stream("kvh-17xx-a").frame, line, milliseconds(10), nullptr));
  EXPECT_EQ(sent, 2);
}

TEST(StartCommand, IsNotConfirmedByALongerNumber) {
  const GyroCommand rate{.send = "=DR,100\r\n", .wait = milliseconds(20), .reply = "DR,100"};
  EXPECT_TRUE(answered(rate, "DR,100\r\n"));
  EXPECT_FALSE(answered(rate, "DR,1000\r\n"));
}

TEST(StartCommand, FailsWithRefusedWhenItsUnitRefuses) {
  for (const auto* answer : {"INVALID,ROTUNITS\r\n", "noise INVALID\r\n", "\r\nINVALID,2\r\nROTUNITS,RAD\r\n"}) {
    const auto done = answered(kUnits, answer);
    ASSERT_FALSE(done) << answer;
    EXPECT_EQ(done.error().kind, FaultKind::refused) << answer;
  }
}

TEST(StartCommand, ReportsBytesReceivedInsteadOfReply) {
  EXPECT_EQ(answered(kUnits, "").error().what, "no reply \"ROTUNITS,RAD\" to \"=ROTUNITS,RAD\" in 20 ms");
  EXPECT_EQ(answered(kUnits, "ROTUNITS,DEG\r\n").error().what,
            "no reply \"ROTUNITS,RAD\" to \"=ROTUNITS,RAD\" in 20 ms; received \"ROTUNITS,DEG\"");
  EXPECT_EQ(answered(kUnits, std::string("\xFE\x81\x00", 3)).error().what,
            "no reply \"ROTUNITS,RAD\" to \"=ROTUNITS,RAD\" in 20 ms; received 3 bytes of frames or noise");
}

std::string bytes(std::string_view hexadecimal) { return text_of(tests::from_hex(hexadecimal)); }

GyroCommand go_to_configuration() {
  return {.send = bytes("FA FF 30 00 D1"),
          .wait = milliseconds(20),
          .reply = bytes("FA FF 31 00 D0"),
          .refusal = bytes("FA FF 42 01"),
          .is_binary = true};
}

TEST(StartCommand, FindsReplyInBytesAmongFrames) {
  const auto command = go_to_configuration();
  EXPECT_EQ(command_name(command), "FA FF 30 00 D1");
  EXPECT_TRUE(answered(command, bytes("36 0D 0A 00 FA FF 31 00 D0 36")));
  const auto echoed = answered(command, command.send);
  ASSERT_FALSE(echoed);
  EXPECT_EQ(echoed.error().what,
            "no reply \"FA FF 31 00 D0\" to \"FA FF 30 00 D1\" in 20 ms; received 5 bytes: FA FF 30 00 D1");
  const auto refused = answered(command, bytes("FA FF 42 01 21 9D"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::refused);
  EXPECT_EQ(refused.error().what, "refusal \"FA FF 42 01 21 9D\" received after \"FA FF 30 00 D1\"");
}

/// A byte that is the code of a digit does not continue a number.
TEST(StartCommand, AcceptsReplyInBytesThatLooksLikeNumber) {
  const GyroCommand command{
      .send = bytes("0C 00 0D"), .wait = milliseconds(20), .reply = bytes("0C F0 30"), .is_binary = true};
  EXPECT_TRUE(answered(command, bytes("0C F0 30 31")));
}

TEST(StartCommand, ReadsCommandsInBytes) {
  const auto stream = tests::shipped_stream("pulse-count");
  const auto read = [&](const std::string& keys) {
    const auto file = TomlTable::parse("[[start]]\nwait = \"1 s\"\n" + keys, "g.toml").value();
    auto commands = read_commands(file, "start", stream.frame);
    const auto verdict = file.verdict();
    return std::pair(std::move(commands), verdict ? std::string() : text(verdict.error()));
  };
  const auto [commands, mistake] =
      read("send_bytes = [0xFA, 0xFF, 0x30, 0x00, 0xD1]\nreply_bytes = [0xFA, 0xFF, 0x31]\n");
  EXPECT_EQ(mistake, "");
  ASSERT_EQ(commands.size(), 1u);
  EXPECT_TRUE(commands[0].is_binary);
  EXPECT_EQ(commands[0].send, bytes("FA FF 30 00 D1"));
  EXPECT_EQ(commands[0].reply, bytes("FA FF 31"));
  EXPECT_NE(read("send_bytes = []\n").second.find("empty"), std::string::npos);
  EXPECT_NE(read("send_bytes = [256]\n").second.find("expected bytes"), std::string::npos);
  EXPECT_NE(read("send_bytes = [1]\nreply = \"OK\"\n").second.find("unknown key"), std::string::npos);
  EXPECT_NE(read("send = \"A\"\nreply_bytes = [1]\n").second.find("unknown key"), std::string::npos);
}

TEST(StartCommand, RequiresAMessageWhoseSettingsAgree) {
  const auto stream = tests::shipped_stream("stim300");
  const auto& command = stream.start.front();
  for (const std::uint32_t id : {0xBC, 0xBD}) {
    EXPECT_TRUE(answered(command, text_of(encode_settings(stream.frame, id, false)), "stim300")) << id;
    const auto other = answered(command, text_of(encode_settings(stream.frame, id, true)), "stim300");
    ASSERT_FALSE(other) << id;
    EXPECT_EQ(other.error().kind, FaultKind::mismatch);
    EXPECT_EQ(other.error().what, "the gyro output is set to an angle, expected a rate");
  }
  const auto frame = encode_frame(stream.frame, {.axes = {{.value = 1}}});
  EXPECT_EQ(answered(command, text_of(frame), "stim300").error().kind, FaultKind::timeout);
}

/// A unit that answers each start command except one.
class ObeysAllBut {
 public:
  ObeysAllBut(GyroStream stream, std::size_t left_out, std::string instead) {
    auto made = std::make_unique<tests::FakeStream>();
    made->instrument = [this, stream, left_out, instead](std::string_view heard) -> std::string {
      for (std::size_t i = 0; i < stream.start.size(); ++i) {
        const auto& command = stream.start[i];
        if (heard != command.send) continue;
        heard_.push_back(i);
        if (i == left_out) return instead;
        return command.messages.empty() ? command.reply + "\r\n"
                                        : text_of(encode_settings(stream.frame, command.messages.front(), false));
      }
      return "";
    };
    auto start = stream.start;
    for (auto& command : start) command.wait = std::min<Duration>(command.wait, milliseconds(20));
    gyro_ = make_framed_gyro(stream.frame, std::move(made), milliseconds(10), {.start = std::move(start)});
  }
  [[nodiscard]] Gyro& gyro() { return *gyro_; }
  [[nodiscard]] const std::vector<std::size_t>& heard() const { return heard_; }

 private:
  std::vector<std::size_t> heard_;
  std::unique_ptr<Gyro> gyro_;
};

TEST(GyroStream, FailsOpeningIfStartCommandIsIgnoredOrRefused) {
  std::size_t commands = 0, refusals = 0;
  for (const auto& name : tests::shipped_streams()) {
    const auto stream = tests::shipped_stream(name);
    ObeysAllBut obedient(stream, stream.start.size(), "");
    EXPECT_TRUE(obedient.gyro().open()) << name;
    for (std::size_t i = 0; i < stream.start.size(); ++i) {
      if (!requires_answer(stream.start[i])) continue;
      ObeysAllBut ignores(stream, i, "");
      EXPECT_EQ(ignores.gyro().open().error().kind, FaultKind::timeout) << name << " " << command_name(stream.start[i]);
      EXPECT_EQ(ignores.gyro().read(kSecond).error().kind, FaultKind::timeout) << "nothing is counted of it";
      EXPECT_EQ(ignores.heard().back(), i) << "nothing is sent after it";
      ++commands;
      if (stream.start[i].refusal.empty()) continue;
      ObeysAllBut refuses(stream, i, stream.start[i].refusal + "\r\n");
      EXPECT_EQ(refuses.gyro().open().error().kind, FaultKind::refused) << name << " " << command_name(stream.start[i]);
      ++refusals;
    }
  }
  EXPECT_EQ(commands, 44u);
  EXPECT_EQ(refusals, 32u);
}

TEST(GyroStream, ListsSettingsOfEveryShippedStream) {
  std::size_t settings = 0, unverified = 0;
  for (const auto& name : tests::shipped_streams()) {
    const auto stream = tests::shipped_stream(name);
    EXPECT_FALSE(stream.settings.empty()) << name;
    for (const auto& command : stream.start) {
      const bool is_stated = std::ranges::any_of(stream.settings, [](const auto& setting) {
        return setting.evidence == SettingEvidence::nothing || setting.evidence == SettingEvidence::frame;
      });
      EXPECT_TRUE(requires_answer(command) || is_stated) << name << " " << command_name(command);
    }
    settings += stream.settings.size();
    for (const auto& setting : stream.settings)
      if (setting.evidence == SettingEvidence::nothing) ++unverified;
  }
  EXPECT_EQ(settings, 79u);
  EXPECT_EQ(unverified, 32u);
}

TEST(GyroStream, DescribesWhichOfItsSettingsAreVerified) {
  const auto settings = tests::shipped_stream("stim300").settings;
  const auto asked = describe(settings, true), unasked = describe(settings, false);
  EXPECT_TRUE(asked.starts_with("settings verified: gyro output: rate, sample rate: 250 Hz; settings NOT verified: "))
      << asked;
  EXPECT_TRUE(
      unasked.starts_with("settings verified: sample rate: 250 Hz; settings NOT verified: gyro output: rate "
                          "(the gyro was not queried)"))
      << unasked;
  EXPECT_EQ(describe({}, true), "");
}

TEST(GyroStream, RefusesUnverifiableSetting) {
  const std::string good = tests::shipped_stream("kvh-17xx-a").text;
  const auto mistake = [&](const std::string& was, const std::string& is) {
    auto changed = good;
    const auto place = changed.find(was);
    if (place == std::string::npos) return "no \"" + was + "\" in the file";
    changed.replace(place, was.size(), is);
    const auto stream = parse_gyro_stream(changed, "g.toml");
    return stream ? std::string() : text(stream.error());
  };
  EXPECT_NE(mistake("reply = \"ROTUNITS,RAD\"\n", "").find("requires an answer"), std::string::npos);
  EXPECT_NE(mistake("command = \"=ROTUNITS,RAD\"", "command = \"=ROTUNITS,DEG\"").find("requires an answer"),
            std::string::npos);
  EXPECT_NE(
      mistake("verified_by = \"reply\"\ncommand = \"=ROTUNITS,RAD\"", "verified_by = \"message\"").find("mismatch"),
      std::string::npos);
  EXPECT_NE(mistake("note = \"not set: the reply to =AXES is not known\"\n", "").find("expected the reason"),
            std::string::npos);
  EXPECT_NE(mistake("affects = \"scale\"", "affects = \"taste\"").find("\"taste\""), std::string::npos);
  EXPECT_NE(mistake("reply = \"CONFIG,0\"", "message = [7]").find("no message has the id 7"), std::string::npos);
}

TEST(GyroStream, PutsTheRateOfTheRigIntoItsCommandsAndItsSequence) {
  const auto text = tests::shipped_stream("kvh-17xx-b").text;
  const auto slow = parse_gyro_stream(text, "g.toml", {}, 100);
  ASSERT_TRUE(slow) << gyrotherm::text(slow.error());
  EXPECT_EQ(slow->frame.rate_hz, 100);
  EXPECT_EQ(slow->start[6].send, "=DR,100\r\n");
  EXPECT_EQ(slow->start[6].reply, "DR,100");
  const auto stim = tests::shipped_stream("stim300").text;
  for (const auto& [rate_hz, step] : {std::pair(125, 16u), {250, 8u}, {500, 4u}, {1000, 2u}, {2000, 1u}}) {
    const auto stream = parse_gyro_stream(stim, "g.toml", {}, rate_hz);
    ASSERT_TRUE(stream) << gyrotherm::text(stream.error());
    EXPECT_EQ(stream->frame.find(FieldRole::sequence)->step, step) << rate_hz;
  }
  EXPECT_FALSE(parse_gyro_stream(stim, "g.toml", {}, 300)) << "no whole number of ticks";
}

/// A VectorNav that answers all its commands, and the query for its serial number with `serial`.
class OnVectorNav : public testing::Test {
 protected:
  OnVectorNav() {
    auto made = std::make_unique<tests::FakeStream>();
    line = made.get();
    made->instrument = [this](std::string_view heard) -> std::string {
      if (heard == stream.start[0].send) ++starts;
      if (heard == stream.start[0].send) return stream.start[0].reply + "*XX\r\n";
      return serial.empty() ? "" : "$VNRRG,03," + serial + "*5D\r\n";
    };
    auto question = stream.identity;
    question->wait = milliseconds(20);
    gyro = make_framed_gyro(stream.frame, std::move(made), milliseconds(10),
                            {.start = stream.start, .identity = question}, &clock);
  }
  void send(int frames) {
    for (; frames > 0; --frames, ++sent, clock.advance(milliseconds(10)))
      line->say(encode_frame(stream.frame, {.axes = {{.value = 0.001}}, .timestamp = sent * 10'000'000}));
  }
  GyroStream stream = tests::shipped_stream("vectornav");
  VirtualClock clock;
  tests::FakeStream* line = nullptr;
  std::unique_ptr<Gyro> gyro;
  std::string serial = "0100011981";
  std::uint64_t sent = 1000;
  int starts = 0;
};

TEST_F(OnVectorNav, NamesItsSerialNumber) {
  ASSERT_TRUE(gyro->open());
  EXPECT_EQ(gyro->identify().value(), "vectornav 0100011981");
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  send(100);
  EXPECT_TRUE(gyro->read(kSecond));
  serial = "0100011982";
  EXPECT_EQ(gyro->identify().value(), "vectornav 0100011982");
}

TEST_F(OnVectorNav, HasNoIdentityWithoutAnswer) {
  ASSERT_TRUE(gyro->open());
  serial = "";
  EXPECT_EQ(gyro->identify().value(), "");
  serial = "7";
  EXPECT_EQ(gyro->identify().value(), "vectornav 7");
  serial = "";
  EXPECT_EQ(gyro->identify().error().kind, FaultKind::timeout);
}

TEST_F(OnVectorNav, SendsStartCommandsAfterTimeRestarts) {
  ASSERT_TRUE(gyro->open());
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  send(100);
  ASSERT_TRUE(gyro->read(kSecond));
  EXPECT_EQ(starts, 1);
  EXPECT_EQ(gyro->breaks(), 0u);
  sent = 0;
  send(100);
  EXPECT_EQ(gyro->read(kSecond).error().kind, FaultKind::corrupted);
  EXPECT_EQ(gyro->breaks(), 1u);
  (void)gyro->read(kSecond);
  EXPECT_EQ(starts, 2) << "it may be another unit, or have forgotten its settings";
}

/// At one frame per second, the read with the start commands may end before the next frame.
TEST_F(OnVectorNav, StartsOnceWhenNextFrameIsLate) {
  ASSERT_TRUE(gyro->open());
  send(1);
  ASSERT_TRUE(gyro->wait_for_origin());
  EXPECT_EQ(gyro->read(kSecond).error().kind, FaultKind::timeout);
  EXPECT_EQ(starts, 1);
  EXPECT_EQ(gyro->read(kSecond).error().kind, FaultKind::timeout);
  EXPECT_EQ(starts, 2);
  send(1);
  EXPECT_EQ(gyro->read(kSecond).error().kind, FaultKind::corrupted) << "only the origin";
  send(100);
  EXPECT_TRUE(gyro->read(kSecond));
  EXPECT_EQ(starts, 2);
}

TEST(GyroStream, RefusesAQuestionThatCannotBeAnswered) {
  const auto good = tests::shipped_stream("vectornav").text;
  for (const auto& [was, is] : std::vector<std::pair<std::string, std::string>>{
           {"begins = \"$VNRRG,03,\"", "begins = \"\""}, {"ends = \"*\"", "ends = \"\""}}) {
    auto changed = good;
    ASSERT_NE(changed.find(was), std::string::npos);
    changed.replace(changed.find(was), was.size(), is);
    EXPECT_FALSE(parse_gyro_stream(changed, "g.toml")) << is;
  }
}

}  // namespace
}  // namespace gyrotherm::drivers
