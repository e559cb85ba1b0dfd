// SPDX-License-Identifier: Apache-2.0
/// A gyro that boots after its supply was switched on.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "core/file.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "tests/support/loopback_server.hpp"

namespace gyrotherm::rig {
namespace {

/// A port that refuses connections until start() is called.
class ClosedPort {
 public:
  ClosedPort() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&here), size), 0);
    EXPECT_EQ(::getsockname(socket_, reinterpret_cast<sockaddr*>(&here), &size), 0);
    number_ = ntohs(here.sin_port);
  }
  ~ClosedPort() { ::close(socket_); }
  ClosedPort(const ClosedPort&) = delete;
  ClosedPort& operator=(const ClosedPort&) = delete;
  void start() const { EXPECT_EQ(::listen(socket_, 8), 0); }
  [[nodiscard]] std::uint16_t number() const { return number_; }

 private:
  int socket_;
  std::uint16_t number_{};
};

/// An E36312A with its outputs off at first. The gyro on output 1 opens its port some time after it has power.
class SupplyWithGyro {
 public:
  explicit SupplyWithGyro(std::chrono::milliseconds boot) : boot_(boot) {}
  ~SupplyWithGyro() {
    if (gyro_boot_.joinable()) gyro_boot_.join();
  }
  SupplyWithGyro(const SupplyWithGyro&) = delete;
  SupplyWithGyro& operator=(const SupplyWithGyro&) = delete;

  [[nodiscard]] std::uint16_t port() const { return server_.address().port; }
  [[nodiscard]] std::uint16_t gyro_port() const { return gyro_.number(); }
  [[nodiscard]] bool is_on() const { return is_on_; }

 private:
  std::string answer(std::string_view request) {
    if (request.starts_with("OUTP 1")) {
      is_on_ = true;
      gyro_boot_ = std::thread([this] {
        std::this_thread::sleep_for(boot_);
        gyro_.start();
      });
    }
    if (request.starts_with("OUTP 0")) is_on_ = false;
    if (request.find('?') == std::string_view::npos) return {};
    if (request.starts_with("*IDN?")) return "Keysight Technologies,E36312A,MY1,1\n";
    if (request.starts_with("OUTP?")) return is_on_ ? "1\n" : "0\n";
    if (request.starts_with("CURR:PROT:STAT?")) return "1\n";
    if (request.find("TRIP") != std::string_view::npos) return "0\n";
    if (request.starts_with("VOLT:PROT?")) return "26\n";
    if (request.starts_with("CURR?")) return "1\n";
    if (request.starts_with("MEAS:CURR?")) return is_on_ ? "0.5\n" : "0\n";
    return request.starts_with("VOLT?") || is_on_ ? "24\n" : "0\n";
  }

  std::chrono::milliseconds boot_;
  ClosedPort gyro_;
  std::atomic<bool> is_on_ = false;
  std::thread gyro_boot_;
  drivers::LoopbackServer server_{[this](std::span<const std::byte> request) {
    const auto text = answer({reinterpret_cast<const char*>(request.data()), request.size()});
    const auto bytes = std::as_bytes(std::span(text));
    return drivers::Answer{{bytes.begin(), bytes.end()}};
  }};
};

/// Prepares a rig with a real supply; its chamber and thermometers refuse connections. Returns the fault.
Fault fault_of_preparation(const SupplyWithGyro& supply, const std::string& boot) {
  const std::string folder = GYROTHERM_SOURCE_DIR "/profiles/rigs/";
  auto text = read_text_file(folder + "virtual-supply.toml").value();
  text.erase(text.find("# The virtual laboratory."));
  const std::string key = "\nline = \"", boot_key = "boot = \"5 s\"";
  auto at = text.find(key);
  for (const auto port : {std::uint16_t{1}, std::uint16_t{2}, std::uint16_t{3}, supply.gyro_port(), supply.port()}) {
    at += key.size();
    text.replace(at, text.find('"', at) - at, fmt::format("tcp://127.0.0.1:{}", port));
    at = text.find(key, at);
  }
  text.replace(text.find(boot_key), boot_key.size(), "boot = \"" + boot + "\"");
  const auto file = parse_rig(text, folder + "mine.toml");
  EXPECT_TRUE(file) << gyrotherm::text(file.error());
  if (!file) return {};
  const auto rig = Rig::assemble(*file, {.seed = {}, .elapsed = {}, .replay = {}});
  EXPECT_TRUE(rig) << gyrotherm::text(rig.error());
  const auto prepared = (*rig)->prepare(Celsius{20});
  EXPECT_FALSE(prepared);
  return prepared ? Fault{} : prepared.error();
}

TEST(SupplyBoot, IsAwaitedBeforeGyroMustAnswer) {
  const SupplyWithGyro supply(std::chrono::milliseconds(700));
  const auto fault = fault_of_preparation(supply, "20 s");
  EXPECT_TRUE(fault.where.starts_with("chamber: ")) << text(fault);
  EXPECT_FALSE(supply.is_on()) << "the supply was off before";
}

TEST(SupplyBoot, EndsAtItsLimit) {
  const SupplyWithGyro supply(std::chrono::milliseconds(1500));
  const auto fault = fault_of_preparation(supply, "100 ms");
  EXPECT_TRUE(fault.where.starts_with("gyro: ")) << text(fault);
  EXPECT_FALSE(supply.is_on());
}

}  // namespace
}  // namespace gyrotherm::rig
