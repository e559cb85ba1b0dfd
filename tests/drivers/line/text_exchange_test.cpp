// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/text_exchange.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <random>

#include "drivers/line/byte_streams.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A line with its own clock, which only waiting advances. The instrument answers the n-th question with "answer n".
class SlowStream final : public ByteStream {
 public:
  Duration delay{};
  /// Delay of a second copy of the answer; none if zero.
  Duration echo{};
  /// Number of bytes of an answer that arrive.
  std::size_t cut = SIZE_MAX;
  std::string before, behind;      ///< noise around an answer
  bool returns_questions = false;  ///< the adapter echoes
  std::vector<std::string> heard;

  [[nodiscard]] std::string answer() const { return "answer " + std::to_string(heard.size()); }
  void let_pass(Duration time) { now_ += time; }

  Result<std::size_t> read(std::span<std::byte> buffer, Duration limit) override {
    if (coming_.empty() || coming_.begin()->first > now_ + limit) {
      now_ += limit;
      return failure(FaultKind::timeout, "slow", "nothing came");
    }
    const auto next = coming_.extract(coming_.begin());
    now_ = std::max(now_, next.key());
    std::ranges::copy(tests::bytes_of(next.mapped()), buffer.begin());
    return next.mapped().size();
  }
  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    heard.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (returns_questions) coming_.emplace(now_, before + heard.back());
    const auto line = before + (answer() + "\n").substr(0, cut) + behind;
    if (line.empty()) return {};
    coming_.emplace(now_ + delay, line);
    if (echo != Duration::zero()) coming_.emplace(now_ + delay + echo, line);
    return {};
  }

 private:
  std::multimap<Duration, std::string> coming_;
  Duration now_{};
};

const TextExchangeOptions kOptions{
    .question_end = "\r", .answer_end = "\n", .within = milliseconds(500), .pause = milliseconds(10)};

TEST(TextExchange, ReturnsOneLine) {
  auto made = std::make_unique<SlowStream>();
  auto& line = *made;
  TextExchange exchange(std::move(made), kOptions);
  EXPECT_EQ(exchange.query("one").value(), "answer 1");
  EXPECT_EQ(exchange.query("two").value(), "answer 2");
  EXPECT_EQ(line.heard, (std::vector<std::string>{"one\r", "two\r"}));
}

TEST(TextExchange, IgnoresBytesOfAnIdleBusAroundALine) {
  for (const auto& noise : {std::string("\xFF"), std::string(1, '\0'), std::string("\xFF\xFF") + '\0'}) {
    auto made = std::make_unique<SlowStream>();
    auto& line = *made;
    TextExchange exchange(std::move(made), kOptions);
    line.before = noise;
    EXPECT_EQ(exchange.query("one").value(), "answer 1");
    line.behind = noise;
    EXPECT_EQ(exchange.query("two").value(), "answer 2");
    line.before = "?";
    EXPECT_EQ(exchange.query("three").value(), "?answer 3") << "a character is no noise";
  }
}

TEST(TextExchange, ReadsItsQuestionBackFromALineThatEchoes) {
  for (const std::string noise : {"", "\xFF"})
    for (const auto delay : {milliseconds(0), milliseconds(60)}) {
      auto made = std::make_unique<SlowStream>();
      auto& line = *made;
      line.returns_questions = true;
      line.before = noise;
      line.delay = delay;
      TextExchange exchange(make_echo_stream(std::move(made)), kOptions);
      EXPECT_EQ(exchange.query("$012").value(), "answer 1");
      EXPECT_EQ(exchange.query("#01").value(), "answer 2");
      line.returns_questions = false;
      EXPECT_EQ(exchange.query("#01").error().kind, FaultKind::corrupted) << "the answer is none of its echo";
    }
}

TEST(TextExchange, IgnoresUnsolicitedLineBeforeEcho) {
  for (const bool has_room : {false, true}) {
    auto made = std::make_unique<SlowStream>();
    auto& line = *made;
    line.returns_questions = true;
    line.before = "EVT 17 COMPRESSOR\n";
    TextExchange exchange(make_echo_stream(std::move(made), nullptr, has_room ? 256 : 8), kOptions);
    const auto answer = exchange.query("$012");
    if (has_room) line.before.clear();
    if (has_room) {
      EXPECT_EQ(exchange.query("#01").value(), "answer 2");
    } else {
      EXPECT_NE(answer.error().what.find("received \"EVT 17 COMPRESSOR"), std::string::npos) << answer.error().what;
    }
  }
}

TEST(TextExchange, QuotesLastLineThatWasNoAnswer) {
  auto made = std::make_unique<SlowStream>();
  auto& line = *made;
  TextExchange exchange(std::move(made), kOptions);
  line.cut = 4;
  EXPECT_NE(exchange.query("one").error().what.find("; received \"answ\""), std::string::npos);
  line.cut = 0;
  const ResyncQuery resync{.question = "who", .answer_begins = "me"};
  line.cut = SIZE_MAX;
  const auto other = exchange.query("two", resync);
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().what.find("; received \"answer 2\""), std::string::npos) << other.error().what;
  EXPECT_NE(exchange.query("three", resync).error().what.find("waiting after lost answers; received \"answer 2\""),
            std::string::npos);
  line.before = "\x1b[2J";
  exchange.end_rest();
  EXPECT_NE(exchange.query("four", resync).error().what.find("\\x1b[2J"), std::string::npos)
      << "control characters are escaped";
}

TEST(TextExchange, DoesNotAcceptLateAnswerForNextQuestion) {
  for (const auto late : {milliseconds(505), milliseconds(600), milliseconds(990)}) {
    auto made = std::make_unique<SlowStream>();
    auto& line = *made;
    TextExchange exchange(std::move(made), kOptions);
    line.delay = late;
    EXPECT_EQ(exchange.query("one").error().kind, FaultKind::timeout);
    line.delay = milliseconds(1);
    EXPECT_EQ(exchange.query("two").value(), "answer 2") << late.count() << " ms";
  }
}

// Answers, one question per second, that are late (by less than the limit), lost, truncated or duplicated.
TEST(TextExchange, NeverAcceptsOldAnswer) {
  constexpr unsigned kSeed = 3;
  std::mt19937 random(kSeed);
  const auto up_to = [&](int ms) { return milliseconds(random() % ms); };
  auto made = std::make_unique<SlowStream>();
  auto& line = *made;
  TextExchange exchange(std::move(made), kOptions);
  int good = 0, refused = 0;
  for (int round = 0; round < 100'000; ++round) {
    line.delay = random() % 3 == 0 ? up_to(990) : up_to(20);
    line.echo = random() % 4 == 0 ? up_to(400) : milliseconds(0);
    line.cut = random() % 5 == 0 ? random() % 12 : SIZE_MAX;
    const auto answer = exchange.query("?");
    answer ? ++good : ++refused;
    if (answer) {
      ASSERT_EQ(*answer, line.answer()) << "seed " << kSeed << " round " << round;
    }
    line.heard.assign(line.heard.size() % 1000, "");  // keeps the numbers short
    line.let_pass(milliseconds(1000));
  }
  EXPECT_GT(good, 50'000);
  EXPECT_GT(refused, 10'000);
}

/// An instrument that answers in order and knows its name. Only waiting advances its clock.
class InOrder final : public ByteStream {
 public:
  Duration delay{};
  bool is_deaf_in_odd_seconds = false;
  VirtualClock clock{Duration{}};
  int asked = 0;
  Result<std::size_t> read(std::span<std::byte> buffer, Duration limit) override {
    const auto now = clock.now().since_start;
    if (coming_.empty() || coming_.front().first > now + limit) {
      clock.advance(limit);
      return failure(FaultKind::timeout, "in order", "nothing came");
    }
    const auto [when, line] = coming_.front();
    coming_.pop_front();
    clock.advance(std::max(when - now, Duration{}));
    std::ranges::copy(tests::bytes_of(line), buffer.begin());
    return line.size();
  }
  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    const bool who = bytes.size() > 1 && bytes[0] == std::byte{'w'};
    if (!who) ++asked;
    if (is_deaf_in_odd_seconds && clock.now().since_start % seconds(2) >= seconds(1)) return {};
    free_ = std::max(free_, clock.now().since_start) + delay;
    coming_.emplace_back(free_, who ? "me\n" : "answer " + std::to_string(asked) + "\n");
    return {};
  }

 private:
  Duration free_{};  ///< end of the last answer
  std::deque<std::pair<Duration, std::string>> coming_;
};
const ResyncQuery kWho{.question = "who", .answer_begins = "me"};

struct OneInstrument {
  explicit OneInstrument(bool alone) {
    auto options = kOptions;
    options.is_only_instrument = alone;
    options.clock = &line.clock;
    exchange.emplace(std::move(made), options);
  }
  std::unique_ptr<InOrder> made = std::make_unique<InOrder>();
  InOrder& line = *made;
  std::optional<TextExchange> exchange;
};

// Answers with any delay, to questions that the instrument answers in order.
TEST(TextExchange, NeverAcceptsLateAnswerWithResync) {
  constexpr unsigned kSeed = 4;
  for (const bool alone : {false, true}) {
    std::mt19937 random(kSeed);
    OneInstrument one(alone);
    int good = 0;
    for (int round = 0; round < 20'000; ++round) {
      one.line.delay = milliseconds(random() % 20 == 0 ? random() % 3000 : random() % 50);
      const bool is_who = alone && random() % 5 == 0;
      const auto answer = one.exchange->query(is_who ? kWho.question : "?", kWho);
      if (answer) {
        ++good;
        const auto right = is_who ? kWho.answer_begins : "answer " + std::to_string(one.line.asked);
        ASSERT_EQ(*answer, right) << "seed " << kSeed << " round " << round;
      }
      one.line.clock.advance(milliseconds(1000));
    }
    EXPECT_GT(good, 12'000);
  }
}

TEST(TextExchange, TracksOutstandingResyncAnswer) {
  for (int who = 600; who < 3000; who += 20)
    for (int next = 600; next < 3000; next += 20) {
      OneInstrument one(true);
      int round = 0;
      for (const int delay : {who, next, 20, 20, 20, 20}) {
        one.line.delay = milliseconds(delay);
        const auto answer = one.exchange->query(round++ == 0 ? kWho.question : "?", kWho);
        if (answer) {
          ASSERT_EQ(*answer, "answer " + std::to_string(one.line.asked)) << who << " ms, then " << next << " ms";
        }
        one.line.clock.advance(seconds(1));
      }
    }
}

// The instrument receives nothing in every other second, and is queried once per second at various phases.
TEST(TextExchange, RecoversFromIntermittentFaults) {
  for (const bool alone : {false, true})
    for (int moment = 0; moment < 1000; moment += 50) {
      OneInstrument one(alone);
      one.line.is_deaf_in_odd_seconds = true;
      int good = 0;
      for (Duration tick = milliseconds(moment); tick < seconds(60); tick += seconds(1)) {
        const auto now = one.line.clock.now().since_start;
        if (now > tick) continue;
        one.line.clock.advance(tick - now);
        good += one.exchange->query("?", kWho).has_value() ? 1 : 0;
      }
      EXPECT_GE(good, alone ? 30 : 15) << moment << " ms";
    }
}

TEST(TextExchange, RejectsTwoAnswers) {
  auto made = std::make_unique<tests::FakeStream>();
  auto& line = *made;
  TextExchange exchange(std::move(made), kOptions);
  line.instrument = [](std::string_view) { return std::string("old\nnew\n"); };
  EXPECT_EQ(exchange.query("?").error().kind, FaultKind::corrupted);
  line.instrument = [](std::string_view) { return std::string("new\n"); };
  EXPECT_EQ(exchange.query("?").value(), "new");
}

TEST(TextExchange, RejectsLineThatNeverFallsSilent) {
  class Chatter final : public ByteStream {
    Result<std::size_t> read(std::span<std::byte> buffer, Duration) override { return buffer.size(); }
    Result<void> write(std::span<const std::byte>, Duration) override { return {}; }
  };
  auto options = kOptions;
  options.within = milliseconds(5);
  TextExchange exchange(std::make_unique<Chatter>(), options);
  EXPECT_EQ(exchange.query("?").error().what, "the line does not become silent");
}

}  // namespace
}  // namespace gyrotherm::drivers
