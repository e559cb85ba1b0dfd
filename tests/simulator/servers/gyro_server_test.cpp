// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/gyro_server.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <thread>

#include "core/deadline.hpp"
#include "core/tcp_listener.hpp"
#include "drivers/gyro/frame_sum.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "drivers/line/line_address.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr Duration kSoon = std::chrono::milliseconds(200);

std::unique_ptr<drivers::ByteStream> connect(std::uint16_t port) {
  return make_stream(drivers::TcpLine{"127.0.0.1", port}, {}, kSoon);
}

std::string receive(drivers::ByteStream& line) {
  std::array<std::byte, 4096> buffer{};
  const auto size = line.read(buffer, kSoon);
  return {reinterpret_cast<const char*>(buffer.data()), size.value_or(0)};
}

/// Returns up to `count` bytes of the output of a pseudo-terminal. Waits for them, because the system delays them.
std::string take(int descriptor, std::size_t count) {
  std::string taken;
  const Deadline deadline(kSoon);
  while (taken.size() < count && wait_until_ready(descriptor, POLLIN, deadline)) {
    std::array<char, 4096> buffer{};
    const auto size = ::read(descriptor, buffer.data(), buffer.size());
    if (size <= 0) break;
    taken.append(buffer.data(), static_cast<std::size_t>(size));
  }
  return taken;
}

TEST(GyroServer, AnswersCommandsThatStartStream) {
  const auto stream = tests::shipped_stream("vectornav");
  auto listener = listen_on_loopback(0);
  ASSERT_TRUE(listener);
  const auto port = listening_port(*listener);
  GyroServer server(std::move(*listener), StreamWriter(stream.frame, {0.1}), stream.start);
  const auto line = connect(port);
  const std::string& command = stream.start.front().send;
  const auto bytes = std::as_bytes(std::span(command));
  ASSERT_TRUE(line->write(bytes.first(5), kSoon));
  server.serve_clients();
  EXPECT_EQ(receive(*line), "");
  ASSERT_TRUE(line->write(bytes.subspan(5), kSoon));
  server.serve_clients();
  EXPECT_EQ(receive(*line), stream.start.front().reply + "\r\n");
}

TEST(GyroServer, SendsEqualFramesToSerialLineAndSocket) {
  const auto stream = tests::shipped_stream("kvh-17xx-b");
  auto listener = listen_on_loopback(0);
  auto pty = open_pty();
  ASSERT_TRUE(listener && pty);
  const auto port = listening_port(*listener);
  const int other_end = ::open(pty->path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
  GyroServer server(std::move(*listener), StreamWriter(stream.frame, {0.1}));
  server.add(std::move(*pty));
  const auto line = connect(port);
  ASSERT_TRUE(line->write({}, kSoon));
  server.send(std::array{1000.0}, 1'000'000);
  const auto frame = take(other_end, stream.frame.length);
  EXPECT_EQ(frame.size(), stream.frame.length);
  EXPECT_EQ(receive(*line), frame);
  for (int i = 0; i < 1000; ++i)
    // Nothing reads the line, so it fills up. This must not cause an error.
    server.send(std::array{1000.0 + i}, 2'000'000 + i);
  while (!take(other_end, 1).empty()) continue;
  server.send(std::array{3000.0}, 4'000'000);
  EXPECT_EQ(take(other_end, stream.frame.length).size(), stream.frame.length);
  ::close(other_end);
}

TEST(GyroServer, SendsAllAxesAndHousekeeping) {
  const auto format = tests::whole_shipped_stream("kvh-17xx-b").frame;
  auto listener = listen_on_loopback(0);
  ASSERT_TRUE(listener);
  const auto port = listening_port(*listener);
  GyroServer server(std::move(*listener), StreamWriter(format, {0.1, 0.1, 0.1}));
  const auto line = connect(port);
  ASSERT_TRUE(line->write({}, kSoon));
  server.skip(std::array{10.0, 20.0, 30.0});
  server.send(std::array{20.0, 40.0, 60.0}, 1'000'000, 1, std::array{0.5, -0.5, 1.0, 41.0});
  const auto bytes = receive(*line);
  drivers::FrameDecoder decoder(format);
  decoder.feed(std::as_bytes(std::span(bytes)));
  const auto* frame = decoder.take();
  ASSERT_TRUE(frame);
  const double arcsec = arcsec_per("rad", drivers::FieldRole::increment).value();
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(frame->axes[i].value.value() * arcsec, 1.0 + static_cast<double>(i), 1e-6);
  EXPECT_EQ(frame->values, (std::vector<std::optional<double>>{0.5, -0.5, 1.0, 41.0}));
}

/// Virtual unit that sends 15 °/h in a hundred frames per second on a socket, and its driver at the other end.
class UnitAndDriver {
 public:
  UnitAndDriver(const std::string& name, GyroUnitFaults faults) : stream_(tests::shipped_stream(name)) {
    for (auto& command : stream_.start) command.wait *= kLoadedMachine;
    auto listener = listen_on_loopback(0);
    if (!listener) throw std::runtime_error(text(listener.error()));
    const auto port = listening_port(*listener);
    thread_ = std::jthread(
        [this, faults, taken = std::make_shared<Descriptor>(std::move(*listener))](const std::stop_token& stop) {
          GyroServer server(std::move(*taken), StreamWriter(stream_.frame, {0.001}), stream_.start, faults);
          for (std::int64_t frame = 1; !stop.stop_requested(); ++frame) {
            server.serve_clients();
            server.send(std::array{15.0 * static_cast<double>(frame) / kFramesASecond / 0.001},
                        frame * 1'000'000 / kFramesASecond, 1.0 / kFramesASecond);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
          }
        });
    gyro_ = make_framed_gyro(stream_.frame, make_buffered_stream(connect(port)),
                             std::chrono::milliseconds(800) * kLoadedMachine, {.start = stream_.start});
  }
  [[nodiscard]] drivers::Gyro& gyro() { return *gyro_; }
  /// Reads at least a hundred frames. Returns their mean angle in arcsec.
  [[nodiscard]] double arcsec_a_frame() {
    double arcsec = 0;
    std::uint64_t frames = 0;
    (void)gyro_->wait_for_origin();
    for (int read = 0; read < 20 && frames < 100; ++read) {
      const auto before = gyro_->frames().seen;
      const auto count = gyro_->read(std::chrono::milliseconds(50));
      if (!count) continue;
      frames += gyro_->frames().seen - before;
      arcsec += static_cast<double>(count->pulses.at(0)) * *drivers::arcsec_per_count(stream_.frame, 0);
    }
    return frames == 0 ? 0 : arcsec / static_cast<double>(frames);
  }

  static constexpr int kFramesASecond = 1000;
  /// Factor of all waiting times: on a loaded machine a reply may be late.
  static constexpr int kLoadedMachine = 3;

 private:
  drivers::GyroStream stream_;
  std::jthread thread_;
  std::unique_ptr<drivers::Gyro> gyro_;
};

TEST(GyroServer, IsConfiguredByStartCommandsFromAnotherUnit) {
  const double kDegrees = 57.29577951308232;
  for (const auto* name : {"kvh-17xx-a", "kvh-17xx-b", "kvh-17xx-c"}) {
    UnitAndDriver ends(name, {.factor = kDegrees, .factor_until = "=ROTUNITS,RAD"});
    const auto opened = ends.gyro().open();
    ASSERT_TRUE(opened) << name << ": " << text(opened.error());
    EXPECT_NEAR(ends.arcsec_a_frame(), 15.0 / UnitAndDriver::kFramesASecond, 0.002) << name;
  }
}

TEST(GyroServer, FailsToStartWhenCommandIsIgnoredOrRefused) {
  const auto kind = [](const std::string& stream, GyroUnitFaults faults) {
    UnitAndDriver ends(stream, std::move(faults));
    const auto opened = ends.gyro().open();
    return opened ? std::string("open") : std::string(gyrotherm::name(opened.error().kind));
  };
  EXPECT_EQ(kind("kvh-17xx-a", {.ignored = {"=ROTUNITS,RAD"}}), "timeout");
  EXPECT_EQ(kind("kvh-17xx-b", {.ignored = {"=ROTFMT,DELTA"}}), "timeout");
  EXPECT_EQ(kind("kvh-17xx-c", {.refused = {"=TEMPUNITS,C"}}), "refused");
  EXPECT_EQ(kind("vectornav", {.ignored = {"$VNWRG,75,1,8,01,0C01*XX"}}), "timeout");
  EXPECT_EQ(kind("vectornav", {.refused = {"$VNWRG,75,1,8,01,0C01*XX"}}), "refused");
  EXPECT_EQ(kind("stim300", {.has_other_settings = true}), "mismatch");
  EXPECT_EQ(kind("stim300", {.ignored = {"C"}}), "timeout");
  EXPECT_EQ(kind("stim300", {}), "open");
  EXPECT_EQ(kind("stim300-increment", {.has_other_settings = true}), "mismatch");
  EXPECT_EQ(kind("xsens-mti", {.ignored = {"FA FF C0 00 41"}}), "timeout");
  EXPECT_EQ(kind("xsens-mti", {.refused = {"FA FF C0 00 41"}}), "refused");
  EXPECT_EQ(kind("epson-m-g370pds0", {.ignored = {"70 00 0D"}}), "timeout");
  for (const auto* binary : {"xsens-mti", "microstrain-mip", "microstrain-gx5", "epson-m-g370pds0"})
    EXPECT_EQ(kind(binary, {}), "open");
  EXPECT_EQ(kind("vectornav", {}), "open");
}

TEST(GyroServer, SendsNoFrameInConfiguration) {
  const auto stream = tests::shipped_stream("kvh-17xx-a");
  auto listener = listen_on_loopback(0);
  ASSERT_TRUE(listener);
  const auto port = listening_port(*listener);
  GyroServer server(std::move(*listener), StreamWriter(stream.frame, {0.1}), stream.start);
  const auto line = connect(port);
  const auto say = [&](const std::string& command) {
    ASSERT_TRUE(line->write(std::as_bytes(std::span(command)), kSoon));
    server.serve_clients();
  };
  say("=CONFIG,1\r\n");
  EXPECT_EQ(receive(*line), "CONFIG,1\r\n");
  server.send(std::array{1000.0}, 1'000'000);
  EXPECT_EQ(receive(*line), "");
  say("=CONFIG,0\r\n");
  server.send(std::array{2000.0}, 2'000'000);
  EXPECT_EQ(receive(*line).size(), std::string("CONFIG,0\r\n").size() + stream.frame.length);
}

}  // namespace
}  // namespace gyrotherm::simulator
