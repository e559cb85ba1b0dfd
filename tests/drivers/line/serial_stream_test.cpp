// SPDX-License-Identifier: Apache-2.0
// Tests of the serial line on pseudo-terminals, which have no baud rate and no parity. tests/qemu tests these settings
// on two UARTs of an emulated machine.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/time.h>

#include <chrono>
#include <csignal>
#include <filesystem>

#include "core/deadline.hpp"
#include "drivers/line/byte_streams.hpp"
#include "tests/drivers/line/pseudo_terminal.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;
constexpr Duration kSoon = milliseconds(30), kPatient = milliseconds(2000);

Result<std::string> read_text(ByteStream& stream, Duration within) {
  std::array<std::byte, 256> buffer;
  const auto size = stream.read(buffer, within);
  if (!size) return failure(size.error());
  return std::string(reinterpret_cast<const char*>(buffer.data()), *size);
}

/// Opens the line, which then receives later bytes.
std::unique_ptr<ByteStream> opened(const std::string& device) {
  auto stream = make_serial_stream(device, {});
  EXPECT_EQ(read_text(*stream, Duration::zero()).error().kind, FaultKind::timeout);
  return stream;
}

TEST(SerialStream, CarriesEveryByteBothWays) {
  const PseudoTerminal pair;
  const auto stream = opened(pair.device());
  std::string all;
  for (int byte = 0; byte < 256; ++byte) all += static_cast<char>(byte);
  pair.say(all);
  std::string heard;
  while (heard.size() < all.size()) {
    const auto more = read_text(*stream, kPatient);
    ASSERT_TRUE(more) << text(more.error());
    heard += *more;
  }
  EXPECT_EQ(heard, all);
  EXPECT_TRUE(stream->write(tests::bytes_of(all), kPatient));
  EXPECT_EQ(pair.hear(), all);
}

TEST(SerialStream, TimesOutWithoutEndWhenPeerIsSilent) {
  const PseudoTerminal pair;
  const auto stream = opened(pair.device());
  EXPECT_EQ(read_text(*stream, kSoon).error().kind, FaultKind::timeout);
  pair.say("here");
  EXPECT_EQ(read_text(*stream, kPatient).value(), "here");
}

TEST(SerialStream, DiscardsBytesReceivedBeforeOpening) {
  const PseudoTerminal pair;
  const Descriptor keeps_it(open(pair.device().c_str(), O_RDWR | O_NOCTTY));
  pair.say("stale\n");
  const auto stream = opened(pair.device());
  pair.say("fresh");
  EXPECT_EQ(read_text(*stream, kPatient).value(), "fresh");
}

TEST(SerialStream, DisconnectsAtOnceWhenUnplugged) {
  PseudoTerminal pair;
  const auto stream = opened(pair.device());
  pair.unplug();
  const Deadline soon(kPatient / 2);
  EXPECT_EQ(read_text(*stream, kPatient).error().what, "the port was removed");
  EXPECT_EQ(read_text(*stream, kPatient).error().what, "no such device");
  EXPECT_EQ(read_text(*stream, kPatient).error().what, "no such device; next try in 0.5 s");
  stream->end_rest();
  EXPECT_EQ(read_text(*stream, kPatient).error().what, "no such device") << "tried at once";
  EXPECT_FALSE(soon.has_passed());
}

TEST(SerialStream, ReportsDisconnectionWhenWritingToUnpluggedLine) {
  PseudoTerminal pair;
  const auto stream = opened(pair.device());
  pair.unplug();
  EXPECT_EQ(stream->write(tests::bytes_of("?"), kPatient).error().kind, FaultKind::disconnected);
}

TEST(SerialStream, ResolvesLinkAgainAfterReplug) {
  const auto link = std::filesystem::temp_directory_path() / ("gyrotherm-serial-" + std::to_string(getpid()));
  auto first = std::make_unique<PseudoTerminal>();
  std::filesystem::create_symlink(first->device(), link);
  const auto stream = opened(link.string());
  const PseudoTerminal second;
  first->unplug();
  EXPECT_EQ(read_text(*stream, kPatient).error().kind, FaultKind::disconnected);
  std::filesystem::remove(link);
  std::filesystem::create_symlink(second.device(), link);
  EXPECT_EQ(read_text(*stream, Duration::zero()).error().kind, FaultKind::timeout);
  second.say("again");
  EXPECT_EQ(read_text(*stream, kPatient).value_or("nothing"), "again");
  std::filesystem::remove(link);
}

TEST(SerialStream, ExcludesSecondProgram) {
  const PseudoTerminal pair;
  const auto stream = opened(pair.device());
  const auto other = make_serial_stream(pair.device(), {});
  EXPECT_NE(read_text(*other, kSoon).error().what.find("in use by another program"), std::string::npos);
  pair.say("mine");
  EXPECT_EQ(read_text(*stream, kPatient).value(), "mine");
}

TEST(SerialStream, RespectsLockOfAnotherProgram) {
  const PseudoTerminal pair;
  const Descriptor other(open(pair.device().c_str(), O_RDWR | O_NOCTTY));
  ASSERT_EQ(flock(other.number(), LOCK_EX), 0);
  EXPECT_EQ(open_serial_port(pair.device(), {}).error().what, "in use by another program");
}

TEST(SerialStream, KeepsWaitingAfterSignal) {
  struct sigaction notice {
  }, before{};
  notice.sa_handler = [](int) {};
  sigaction(SIGALRM, &notice, &before);
  const itimerval often{{0, 2000}, {0, 2000}}, never{};
  const PseudoTerminal pair;
  const auto stream = opened(pair.device());
  setitimer(ITIMER_REAL, &often, nullptr);
  EXPECT_EQ(read_text(*stream, milliseconds(50)).error().kind, FaultKind::timeout);
  pair.say("here");
  EXPECT_EQ(read_text(*stream, kPatient).value_or("cut off"), "here");
  setitimer(ITIMER_REAL, &never, nullptr);
  sigaction(SIGALRM, &before, nullptr);
}

TEST(SerialStream, TimesOutWhenPeerDoesNotRead) {
  const PseudoTerminal pair;
  const auto stream = opened(pair.device());
  const std::vector<std::byte> much(1 << 20);
  EXPECT_EQ(stream->write(much, kSoon).error().kind, FaultKind::timeout);
}

TEST(SerialStream, DoesNotTakePluggingOrderForStableName) {
  for (const auto* device : {"/dev/ttyUSB0", "/dev/ttyUSB12", "/dev/ttyACM1"})
    EXPECT_TRUE(has_unstable_name(device)) << device;
  for (const auto* device : {"/dev/ttyS0", "/dev/serial/by-id/usb-FTDI-if00-port0", "/dev/serial/by-path/pci-1",
                             "/dev/ttyUSB", "/dev/ttyUSB_chamber", "/dev/oven"})
    EXPECT_FALSE(has_unstable_name(device)) << device;
  EXPECT_EQ(stable_name("/dev/gyrotherm-none"), "");
}

TEST(SerialStream, RefusesFileThatIsNotASerialPort) {
  EXPECT_EQ(open_serial_port("/dev/null", {}).error().kind, FaultKind::disconnected);
  EXPECT_EQ(open_serial_port("/dev/gyrotherm-none", {}).error().what, "no such device");
}

}  // namespace
}  // namespace gyrotherm::drivers
