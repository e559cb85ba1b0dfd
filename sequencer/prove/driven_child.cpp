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
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "core/deadline.hpp"
#include "core/tcp_listener.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/pauses.hpp"
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
  if (const auto started = chamber.start(); !started) return started;
  const auto state = chamber.inspect();
  if (!state) return failure(state.error());
  if (abs(state->set_point - set_point) > set_point_tolerance(rig.chamber_map))
    return failure(FaultKind::mismatch, "child run",
                   fmt::format("the chamber did not show its set point: {:g} °C instead of {:g} °C",
                               state->set_point.value, set_point.value));
  return {};
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
  for (const auto pauses = drivers::make_real_pauses(); begun; pauses->rest(kSecond)) {
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

constexpr char kCut = 'c', kRestore = 'r', kEnd = 'q';
/// A forwarder without a parent ends after this time without traffic.
constexpr int kOrphanMs = 5 * 60 * 1000;

/// The process that forwards connections.
class Forwarder {
 public:
  Forwarder(const Descriptor& listener, int control, drivers::TcpLine to)
      : listener_(listener), control_(control), to_(std::move(to)) {}

  void run() {
    while (step()) {
    }
  }

 private:
  /// Waits for the next event. Returns false when the forwarder is to end.
  bool step() {
    std::vector<pollfd> waiting{{is_orphan_ ? -1 : control_, POLLIN, 0},
                                {is_cut_ ? -1 : listener_.number(), POLLIN, 0}};
    for (const auto& pair : pairs_)
      for (const auto* end : {&pair.near, &pair.far}) waiting.push_back({is_cut_ ? -1 : end->number(), POLLIN, 0});
    const int ready = ::poll(waiting.data(), waiting.size(), is_orphan_ ? kOrphanMs : -1);
    if (ready == 0 || (ready < 0 && errno != EINTR)) return false;
    if (waiting[0].revents != 0 && !obey()) return false;
    if (!is_cut_) forward(waiting);
    return true;
  }

  bool obey() {
    char command = 0;
    const bool is_there = ::read(control_, &command, 1) == 1;
    is_orphan_ = !is_there;
    if (is_there && command == kEnd) return false;
    is_cut_ = is_there && command == kCut;
    if (!is_cut_) pairs_.clear();
    return true;
  }

  void forward(const std::vector<pollfd>& waiting) {
    std::vector<ForwardedPair> left;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      auto& pair = pairs_[i];
      const bool near = waiting[2 + 2 * i].revents != 0, far = waiting[3 + 2 * i].revents != 0;
      if ((!near || forward_some(pair.near, pair.far)) && (!far || forward_some(pair.far, pair.near)))
        left.push_back(std::move(pair));
    }
    pairs_ = std::move(left);
    if (waiting[1].revents == 0) return;
    ForwardedPair made{accept_connection(listener_), connect_to(to_)};
    if (made.near.is_open() && made.far.is_open()) pairs_.push_back(std::move(made));
  }

  const Descriptor& listener_;
  int control_;
  drivers::TcpLine to_;
  std::vector<ForwardedPair> pairs_;
  bool is_cut_ = false, is_orphan_ = false;
};

/// Main function of the forwarder: keeps only its two descriptors, so that it holds no lock of its parent.
[[noreturn]] void forward_in_child(Descriptor listener, Descriptor control, const drivers::TcpLine& to) {
  constexpr int kListener = 100, kControl = 101;
  ::setsid();
  for (const int number : {SIGINT, SIGHUP, SIGTERM, SIGPIPE}) ::signal(number, SIG_IGN);
  ::dup2(listener.number(), kListener);
  ::dup2(control.number(), kControl);
  const Descriptor own(kListener);
  ::close_range(STDERR_FILENO + 1, kListener - 1, 0);
  ::close_range(kControl + 1, ~0U, 0);
  Forwarder(own, kControl, to).run();
  ::_exit(0);
}

}  // namespace

namespace {

/// Forwards to registers that another object uses, too.
class SharedRegisters final : public drivers::Registers {
 public:
  explicit SharedRegisters(std::shared_ptr<drivers::Registers> shared) : shared_(std::move(shared)) {}
  Result<std::vector<std::uint16_t>> read(drivers::ReadFunction function, std::uint16_t address,
                                          std::uint16_t count) override {
    return shared_->read(function, address, count);
  }
  Result<void> write(drivers::WriteFunction function, std::uint16_t address,
                     std::span<const std::uint16_t> words) override {
    return shared_->write(function, address, words);
  }
  void end_rest() override { shared_->end_rest(); }
  std::uint64_t breaks() const override { return shared_->breaks(); }

 private:
  std::shared_ptr<drivers::Registers> shared_;
};

}  // namespace

std::unique_ptr<drivers::Registers> connect_registers(const rig::RigFile& rig) {
  return make_registers(drivers::parse_line(rig.chamber_line).value(), rig.chamber_map);
}

std::unique_ptr<drivers::Chamber> connect_chamber(const rig::RigFile& rig) {
  return make_modbus_chamber(rig.chamber_map, connect_registers(rig));
}

ChamberConnection connect_with_registers(const rig::RigFile& rig) {
  std::shared_ptr<drivers::Registers> registers = connect_registers(rig);
  return {.registers = registers,
          .chamber = make_modbus_chamber(rig.chamber_map, std::make_unique<SharedRegisters>(registers))};
}

bool is_exclusive_line(const rig::RigFile& rig) {
  const auto line = drivers::parse_line(rig.chamber_line);
  return line && std::holds_alternative<drivers::SerialLine>(*line);
}

Result<DrivenChild> DrivenChild::start(const rig::RigFile& rig, const std::string& record, Celsius set_point) {
  auto child =
      std::make_unique<ChildProcess>([&](int to_parent) { drive_until_killed(rig, record, set_point, to_parent); });
  if (!child->has_begun()) return failure(FaultKind::refused, "child run", "the process could not be started");
  const auto line = read_child_line(child->output(), kDriveWithin);
  if (line == kDriving) return DrivenChild(std::move(child));
  if (!line.empty()) return failure(FaultKind::refused, "child run", line);
  // The end of its output precedes its end by a moment.
  const auto status = child->wait(kSecond);
  return failure(FaultKind::refused, "child run",
                 status ? describe_exit_status(*status) + " before it drove the chamber"
                        : "did not drive the chamber in " + format_duration(kDriveWithin));
}

Result<CuttableLine> CuttableLine::open(const drivers::TcpLine& to) {
  constexpr int kWaitingConnections = 16;
  auto listener = listen_on_tcp("127.0.0.1", 0, kWaitingConnections);
  if (!listener) return failure(std::move(listener.error()));
  const auto port = listening_port(*listener);
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    return failure(FaultKind::disconnected, "line", "the forwarder could not be started");
  Descriptor own(ends[0]), theirs(ends[1]);
  const auto pid = ::fork();
  if (pid == 0) forward_in_child(std::move(*listener), std::move(theirs), to);
  if (pid < 0) return failure(FaultKind::disconnected, "line", "the forwarder could not be started");
  return CuttableLine(std::move(own), pid, port);
}

CuttableLine::~CuttableLine() {
  if (!control_.is_open()) return;
  send(kEnd);
  (void)reap(pid_, std::chrono::seconds(1));
}

void CuttableLine::send(char command) { (void)write_all(control_.number(), {&command, 1}); }

void CuttableLine::cut() { send(kCut); }

void CuttableLine::restore() { send(kRestore); }

}  // namespace gyrotherm::prove
