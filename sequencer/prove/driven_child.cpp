// SPDX-License-Identifier: Apache-2.0
#include "sequencer/prove/driven_child.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <thread>
#include <utility>
#include <vector>

#include "core/deadline.hpp"
#include "core/tcp_listener.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "sequencer/run/chamber_ownership.hpp"

namespace gyrotherm::prove {
namespace {

constexpr Duration kDriveWithin = std::chrono::seconds(60);
constexpr const char* kDriving = "driving";

/// Reads one line from the child; empty at its end or after the time.
std::string read_child_line(int descriptor, Duration within) {
  std::string line;
  const Deadline deadline(within);
  for (char byte = 0; wait_until_ready(descriptor, POLLIN, deadline) && ::read(descriptor, &byte, 1) == 1;) {
    if (byte == '\n') return line;
    line += byte;
  }
  return "";
}

Result<void> begin_to_drive(const rig::RigFile& rig, run::ChamberOwnership& ownership, drivers::Chamber& chamber,
                            Celsius set_point) {
  const auto identity = chamber.identify();
  if (!identity) return failure(identity.error());
  if (const auto state = chamber.inspect(); !state) return failure(state.error());
  if (const auto armed = ownership.arm(*identity, chamber.settings()); !armed) return armed;
  ownership.heartbeat({});
  if (const auto sent = chamber.send_set_point(set_point); !sent) return sent;
  (void)rig;
  return chamber.start();
}

/// Drives the chamber until this process is killed.
void drive_until_killed(const rig::RigFile& rig, const std::string& record, Celsius set_point, int to_parent) {
  for (const int number : {SIGINT, SIGHUP, SIGTERM, SIGPIPE}) ::signal(number, SIG_IGN);
  auto ownership = run::ChamberOwnership::take(rig, record);
  if (!ownership) return void(write_all(to_parent, text(ownership.error()) + "\n"));
  const auto chamber = connect_chamber(rig);
  const auto begun = begin_to_drive(rig, *ownership, *chamber, set_point);
  (void)write_all(to_parent, (begun ? kDriving : text(begun.error())) + std::string("\n"));
  // After a failure the guard makes the chamber safe, because this process ends without a good-bye.
  for (; begun; std::this_thread::sleep_for(kSecond)) {
    (void)chamber->read();
    ownership->heartbeat({});
  }
  ::_exit(1);
}

Descriptor connect_to(const drivers::TcpLine& line) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(line.port);
  if (::inet_pton(AF_INET, line.host.c_str(), &address.sin_addr) != 1) return {};
  Descriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (socket.is_open() && ::connect(socket.number(), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0)
    return socket;
  return {};
}

struct ForwardedPair {
  Descriptor near, far;
};

/// Forwards the bytes that one end has. Returns false if the connection has ended.
bool forward_some(const Descriptor& from, const Descriptor& to) {
  std::array<char, 4096> bytes;
  const auto size = ::recv(from.number(), bytes.data(), bytes.size(), 0);
  if (size < 0 && would_block()) return true;
  return size > 0 && ::send(to.number(), bytes.data(), static_cast<std::size_t>(size), MSG_NOSIGNAL) == size;
}

/// Accepts and forwards connections until this process is killed.
void forward_until_killed(const Descriptor& listener, const drivers::TcpLine& to) {
  std::vector<ForwardedPair> pairs;
  while (true) {
    std::vector<pollfd> waiting{{listener.number(), POLLIN, 0}};
    for (const auto& pair : pairs) {
      waiting.push_back({pair.near.number(), POLLIN, 0});
      waiting.push_back({pair.far.number(), POLLIN, 0});
    }
    if (::poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR) return;
    std::vector<ForwardedPair> left;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const bool near = waiting[1 + 2 * i].revents != 0, far = waiting[2 + 2 * i].revents != 0;
      if ((!near || forward_some(pairs[i].near, pairs[i].far)) && (!far || forward_some(pairs[i].far, pairs[i].near)))
        left.push_back(std::move(pairs[i]));
    }
    pairs = std::move(left);
    if (waiting.front().revents == 0) continue;
    ForwardedPair made{accept_connection(listener), connect_to(to)};
    if (made.near.is_open() && made.far.is_open()) pairs.push_back(std::move(made));
  }
}

}  // namespace

std::unique_ptr<drivers::Registers> connect_registers(const rig::RigFile& rig) {
  return make_registers(drivers::parse_line(rig.chamber_line).value(), rig.chamber_map);
}

std::unique_ptr<drivers::Chamber> connect_chamber(const rig::RigFile& rig) {
  return make_modbus_chamber(rig.chamber_map, connect_registers(rig));
}

Result<DrivenChild> DrivenChild::start(const rig::RigFile& rig, const std::string& record, Celsius set_point) {
  auto child = std::make_unique<ChildProcess>(
      [&](int to_parent) { drive_until_killed(rig, record, set_point, to_parent); });
  if (!child->has_begun()) return failure(FaultKind::refused, "child run", "the process could not be started");
  const auto line = read_child_line(child->output(), kDriveWithin);
  if (line != kDriving)
    return failure(FaultKind::refused, "child run", line.empty() ? "did not drive the chamber in 60 s" : line);
  return DrivenChild(std::move(child));
}

Result<CuttableLine> CuttableLine::open(const drivers::TcpLine& to) {
  constexpr int kWaitingConnections = 16;
  auto listener = listen_on_tcp("127.0.0.1", 0, kWaitingConnections);
  if (!listener) return failure(std::move(listener.error()));
  CuttableLine line(std::move(*listener), to);
  line.forward();
  return line;
}

std::uint16_t CuttableLine::port() const { return listening_port(listener_); }

void CuttableLine::forward() {
  forwarder_ = std::make_unique<ChildProcess>([&](int to_parent) {
    for (const int number : {SIGINT, SIGHUP, SIGTERM}) ::signal(number, SIG_IGN);
    (void)write_all(to_parent, fmt::format("{}\n", ::getpid()));
    forward_until_killed(listener_, to_);
  });
  const auto line = read_child_line(forwarder_->output(), std::chrono::seconds(5));
  pid_ = line.empty() ? -1 : static_cast<pid_t>(std::stol(line));
}

void CuttableLine::cut() {
  if (pid_ > 0) ::kill(pid_, SIGSTOP);
}

void CuttableLine::restore() {
  forwarder_.reset();
  forward();
}

}  // namespace gyrotherm::prove
