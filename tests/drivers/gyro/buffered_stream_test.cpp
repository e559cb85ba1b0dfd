// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>
#include <string>

#include "drivers/gyro/framed_gyro.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr Duration kLong = std::chrono::seconds(5);

/// One end of a socket pair as a line. The other end is the instrument.
class PairStream final : public ByteStream {
 public:
  explicit PairStream(int descriptor) : descriptor_(descriptor) {}
  ~PairStream() override { ::close(descriptor_); }
  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    ++reads;
    pollfd waiting{descriptor_, POLLIN, 0};
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(within).count();
    if (::poll(&waiting, 1, static_cast<int>(ms)) == 0) return failure(FaultKind::timeout, "", "nothing");
    const auto size = ::recv(descriptor_, buffer.data(), buffer.size(), 0);
    if (size <= 0) return failure(FaultKind::disconnected, "", "gone");
    return static_cast<std::size_t>(size);
  }
  Result<void> write(std::span<const std::byte> bytes, Duration) override {
    if (bytes.empty()) return {};
    if (::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0)
      return failure(FaultKind::disconnected, "", "gone");
    return {};
  }
  std::atomic<int> reads{};

 private:
  int descriptor_;
};

class BufferedStream : public testing::Test {
 protected:
  BufferedStream() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0);
    instrument = ends[1];
    auto made = std::make_unique<PairStream>(ends[0]);
    line = made.get();
    buffered = make_buffered_stream(std::move(made));
  }
  ~BufferedStream() override { hang_up(); }
  void say(const std::string& text) const { ASSERT_EQ(::send(instrument, text.data(), text.size(), 0), text.size()); }
  void hang_up() {
    if (instrument >= 0) ::close(instrument);
    instrument = -1;
  }
  std::string read(std::size_t size) {
    std::string text;
    while (text.size() < size) {
      std::array<std::byte, 256> buffer{};
      const auto got = buffered->read(std::span(buffer).first(std::min(buffer.size(), size - text.size())), kLong);
      if (!got) break;
      text.append(reinterpret_cast<const char*>(buffer.data()), *got);
    }
    return text;
  }
  /// Opens the line by its first use.
  void begin() {
    std::array<std::byte, 16> nothing{};
    (void)buffered->read(nothing, Duration{});
  }
  int instrument = -1;
  PairStream* line{};
  std::unique_ptr<ByteStream> buffered;
};

TEST_F(BufferedStream, ReturnsBytesInOrder) {
  begin();
  std::string sent;
  for (int i = 0; i < 2000; ++i) {
    const auto piece = std::to_string(i) + " ";
    say(piece);
    sent += piece;
  }
  EXPECT_EQ(read(sent.size()), sent);
}

TEST_F(BufferedStream, ReportsArrivalTimeOfBytesReadLate) {
  const auto now = [] { return Duration(std::chrono::steady_clock::now().time_since_epoch()); };
  begin();
  const auto before = now();
  say("ab");
  EXPECT_EQ(read(1), "a");
  const auto after = now();
  const auto came = buffered->arrival_time();
  ASSERT_TRUE(came);
  EXPECT_GE(*came, before);
  EXPECT_LE(*came, after);
  while (now() < after + std::chrono::milliseconds(1)) continue;
  EXPECT_EQ(read(1), "b");
  EXPECT_EQ(buffered->arrival_time(), came);
}

TEST_F(BufferedStream, BuffersMoreThanTheSystem) {
  begin();
  const std::string second(92'160, 'x');  // one second at 921600 baud
  std::size_t done = 0;
  pollfd writable{instrument, POLLOUT, 0};
  while (done < second.size() && ::poll(&writable, 1, 5000) == 1) {
    const auto size = ::send(instrument, second.data() + done, std::min<std::size_t>(4096, second.size() - done), 0);
    done += static_cast<std::size_t>(size);
  }
  EXPECT_EQ(read(second.size()), second);
}

TEST_F(BufferedStream, OpensLineAtFirstUse) { EXPECT_EQ(line->reads, 0); }

TEST_F(BufferedStream, WritesWhileReading) {
  const std::string command = "=CONFIG,1\r\n";
  ASSERT_TRUE(buffered->write(std::as_bytes(std::span(command)), kLong));
  std::array<char, 64> heard{};
  EXPECT_EQ(::recv(instrument, heard.data(), heard.size(), 0), static_cast<long>(command.size()));
  EXPECT_STREQ(heard.data(), command.c_str());
}

TEST_F(BufferedStream, TimesOutWithoutBytes) {
  std::array<std::byte, 16> buffer{};
  EXPECT_EQ(buffered->read(buffer, std::chrono::milliseconds(1)).error().kind, FaultKind::timeout);
}

TEST_F(BufferedStream, ReportsBrokenLineAfterLastBytesAndRetries) {
  say("last");
  hang_up();
  EXPECT_EQ(read(4), "last");
  std::array<std::byte, 16> buffer{};
  for (int i = 0; i < 3; ++i) EXPECT_EQ(buffered->read(buffer, kLong).error().kind, FaultKind::disconnected);
}

}  // namespace
}  // namespace gyrotherm::drivers
