// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/byte_streams.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <libserialport.h>
#include <netinet/in.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/text.hpp"
#include "drivers/line/pauses.hpp"

namespace gyrotherm::drivers {

namespace {

/// A line that is a file descriptor. Opened at first use, and again after a failure.
class DescriptorStream : public ByteStream {
 public:
  Result<void> write(std::span<const std::byte> bytes, Duration within) override {
    if (auto opened = open(); !opened) return opened;
    const Deadline deadline(within);
    while (!bytes.empty()) {
      const auto size = write_some(bytes);
      if (size > 0) {
        bytes = bytes.subspan(static_cast<std::size_t>(size));
        continue;
      }
      if (size < 0 && !would_block()) return close_with_fault(std::strerror(errno));
      if (!deadline.has_passed() && wait_until_ready(line_.number(), POLLOUT, deadline)) continue;
      (void)close_with_fault("some bytes may have been sent");
      return failure(FaultKind::timeout, place(), fmt::format("could not send in {:.3f} s", to_seconds(within)));
    }
    return {};
  }

  void end_rest() override { backoff_.end_rest(); }

 protected:
  [[nodiscard]] Result<void> open() {
    if (line_.is_open()) return {};
    if (backoff_.left() > Duration::zero()) return failure(FaultKind::disconnected, place(), backoff_.message());
    return open_line();
  }

  /// Closes the line and returns the fault. Closing is necessary because poll() always reports a removed device as
  /// ready.
  [[nodiscard]] tl::unexpected<Fault> close_with_fault(std::string why) {
    line_.close();
    backoff_.note_failure(why);
    return failure(FaultKind::disconnected, place(), std::move(why));
  }

  [[nodiscard]] virtual std::string place() const = 0;

  Descriptor line_;
  Backoff backoff_;

 private:
  [[nodiscard]] virtual Result<void> open_line() = 0;
  /// Writes as many bytes as the system accepts. Returns their number, or -1 with errno set.
  [[nodiscard]] virtual ssize_t write_some(std::span<const std::byte> bytes) const = 0;
};

class TcpStream final : public DescriptorStream {
 public:
  TcpStream(TcpLine peer, Duration connect_within) : peer_(std::move(peer)), connect_within_(connect_within) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    if (auto opened = open(); !opened) return failure(std::move(opened.error()));
    const Deadline deadline(within);
    while (true) {
      const auto size = recv(line_.number(), buffer.data(), buffer.size(), 0);
      if (size > 0) {
        backoff_.note_success();
        return static_cast<std::size_t>(size);
      }
      if (size == 0) return close_with_fault("the peer closed the connection");
      if (!would_block()) return close_with_fault(std::strerror(errno));
      if (deadline.has_passed() || !wait_until_ready(line_.number(), POLLIN, deadline))
        return failure(FaultKind::timeout, place(), fmt::format("no data in {:.3f} s", to_seconds(within)));
    }
  }

 private:
  Result<void> open_line() override {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(peer_.port);
    if (inet_pton(AF_INET, peer_.host.c_str(), &address.sin_addr) != 1)
      return close_with_fault("the host is not a numeric IPv4 address");

    line_ = Descriptor(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (!line_.is_open()) return close_with_fault(std::strerror(errno));
    enable_dead_peer_detection(line_.number());
    if (::connect(line_.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return {};
    if (errno != EINPROGRESS) return close_with_fault(std::strerror(errno));
    if (!wait_until_ready(line_.number(), POLLOUT, Deadline(connect_within_)))
      return close_with_fault("no connection in time");
    int error = 0;
    socklen_t size = sizeof error;
    getsockopt(line_.number(), SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) return close_with_fault(std::strerror(error));
    return {};
  }

  ssize_t write_some(std::span<const std::byte> bytes) const override {
    return ::send(line_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  std::string place() const override { return fmt::format("tcp {}:{}", peer_.host, peer_.port); }

  TcpLine peer_;
  Duration connect_within_;
};

}  // namespace

std::unique_ptr<ByteStream> make_tcp_stream(const TcpLine& line, Duration connect_within) {
  return std::make_unique<TcpStream>(line, connect_within);
}

namespace {

namespace fs = std::filesystem;

struct FreePort {
  void operator()(sp_port* port) const {
    sp_close(port);
    sp_free_port(port);
  }
};
using Port = std::unique_ptr<sp_port, FreePort>;

struct FreeConfig {
  void operator()(sp_port_config* config) const { sp_free_config(config); }
};
using Config = std::unique_ptr<sp_port_config, FreeConfig>;

tl::unexpected<Fault> open_fault(std::string what) { return failure(FaultKind::disconnected, "", std::move(what)); }

std::string error_text(int error) {
  if (error == EACCES) return "permission denied; see \"gyrotherm devices\"";
  if (error == EBUSY) return "in use by another program";
  return std::strerror(error);
}

/// Returns the text of a libserialport error. For SP_ERR_FAIL, errno contains the reason.
std::string error_text(sp_return code) { return code == SP_ERR_FAIL ? error_text(errno) : "not a serial port"; }

/// Makes the port exclusive. TIOCEXCL excludes other processes; the lock excludes root and programs that opened the
/// port earlier.
Result<void> lock_port(int descriptor) {
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) return open_fault("in use by another program");
  if (ioctl(descriptor, TIOCEXCL) != 0) return open_fault(error_text(errno));
  return {};
}

constexpr sp_parity kParities[] = {SP_PARITY_NONE, SP_PARITY_ODD, SP_PARITY_EVEN};

std::optional<SerialFormat> read_port_format(sp_port* port) {
  sp_port_config* raw = nullptr;
  if (sp_new_config(&raw) != SP_OK) return {};
  const Config config(raw);
  SerialFormat found;
  sp_parity parity{};
  sp_cts cts{};
  if (sp_get_config(port, raw) != SP_OK || sp_get_config_baudrate(raw, &found.baud) != SP_OK ||
      sp_get_config_bits(raw, &found.data_bits) != SP_OK || sp_get_config_parity(raw, &parity) != SP_OK ||
      sp_get_config_stopbits(raw, &found.stop_bits) != SP_OK || sp_get_config_cts(raw, &cts) != SP_OK)
    return {};
  const auto* known = std::ranges::find(kParities, parity);
  if (known == std::end(kParities)) return {};
  found.parity = static_cast<SerialParity>(known - std::begin(kParities));
  found.rtscts = cts == SP_CTS_FLOW_CONTROL;
  return found;
}

Result<void> configure(sp_port* port, const SerialFormat& format) {
  const bool set = sp_set_baudrate(port, format.baud) == SP_OK && sp_set_bits(port, format.data_bits) == SP_OK &&
                   sp_set_parity(port, kParities[static_cast<std::size_t>(format.parity)]) == SP_OK &&
                   sp_set_stopbits(port, format.stop_bits) == SP_OK &&
                   sp_set_flowcontrol(port, format.rtscts ? SP_FLOWCONTROL_RTSCTS : SP_FLOWCONTROL_NONE) == SP_OK;
  if (!set) return open_fault(fmt::format("cannot be set to {}", text(format)));
  const auto found = read_port_format(port);
  if (found != format)
    return open_fault(
        fmt::format("set to {}, but the port reports {}", text(format), found ? text(*found) : "an unknown setting"));
  return {};
}

/// Sets what libserialport leaves unset. Keeps the modem lines active when the port is closed, because some instruments
/// reset when these lines drop. Checks the parity if there is one: a byte with a wrong parity is read as NUL, which is
/// part of no number.
void complete_settings(int descriptor) {
  termios settings{};
  if (tcgetattr(descriptor, &settings) != 0) return;
  settings.c_cflag &= ~static_cast<tcflag_t>(HUPCL);
  if ((settings.c_cflag & PARENB) != 0) settings.c_iflag |= INPCK;
  tcsetattr(descriptor, TCSANOW, &settings);
}

Result<Descriptor> open_port(const std::string& device, const SerialFormat& format) {
  sp_port* raw = nullptr;
  if (const auto found = sp_get_port_by_name(device.c_str(), &raw); found != SP_OK)
    return open_fault(error_text(found));
  const Port port(raw);
  if (const auto opened = sp_open(raw, SP_MODE_READ_WRITE); opened != SP_OK) return open_fault(error_text(opened));
  int handle = kNoDescriptor;
  sp_get_port_handle(raw, &handle);
  if (auto claimed = lock_port(handle); !claimed) return failure(std::move(claimed.error()));
  if (auto set = configure(raw, format); !set) return failure(std::move(set.error()));
  complete_settings(handle);
  tcflush(handle, TCIOFLUSH);
  return Descriptor(fcntl(handle, F_DUPFD_CLOEXEC, 0));  // sp_close() closes the original
}

/// Opens a pseudo-terminal, which libserialport does not support.
Result<Descriptor> open_pseudo_terminal(const std::string& device) {
  Descriptor line(open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!line.is_open()) return open_fault(error_text(errno));
  if (auto claimed = lock_port(line.number()); !claimed) return failure(std::move(claimed.error()));
  termios settings{};
  if (tcgetattr(line.number(), &settings) != 0) return open_fault(error_text(errno));
  cfmakeraw(&settings);
  if (tcsetattr(line.number(), TCSANOW, &settings) != 0) return open_fault(error_text(errno));
  tcflush(line.number(), TCIOFLUSH);
  return line;
}

std::string text_or_empty(const char* text) { return text == nullptr ? "" : text; }

class SerialStream final : public DescriptorStream {
 public:
  SerialStream(std::string device, const SerialFormat& format) : device_(std::move(device)), format_(format) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    if (auto opened = open(); !opened) return failure(std::move(opened.error()));
    const Deadline deadline(within);
    while (wait_until_ready(line_.number(), POLLIN, deadline)) {
      const auto size = ::read(line_.number(), buffer.data(), buffer.size());
      if (size > 0) {
        backoff_.note_success();
        return static_cast<std::size_t>(size);
      }
      if (size == 0) return close_with_fault("the port was removed");  // ready without data
      if (!would_block()) return close_with_fault(std::strerror(errno));
    }
    return failure(FaultKind::timeout, place(), fmt::format("no data in {:.3f} s", to_seconds(within)));
  }

 private:
  Result<void> open_line() override {
    auto opened = open_serial_port(device_, format_);
    if (!opened) return close_with_fault(std::move(opened.error().what));
    line_ = std::move(*opened);
    return {};
  }

  ssize_t write_some(std::span<const std::byte> bytes) const override {
    return ::write(line_.number(), bytes.data(), bytes.size());
  }
  std::string place() const override { return "serial " + device_; }

  std::string device_;
  SerialFormat format_;
};

}  // namespace

std::string stable_name(const std::string& device) {
  std::error_code none;
  const auto real = fs::canonical(device, none);
  for (const auto& link : list_folder("/dev/serial/by-id"))
    if (!real.empty() && fs::canonical(link, none) == real) return link.string();
  return {};
}

bool has_unstable_name(const std::string& device) {
  const auto ends_in_a_number = [&](std::string_view start) {
    return device.starts_with(start) && device.size() > start.size() &&
           device.find_first_not_of("0123456789", start.size()) == std::string::npos;
  };
  return ends_in_a_number("/dev/ttyUSB") || ends_in_a_number("/dev/ttyACM");
}

Result<Descriptor> open_serial_port(const std::string& device, const SerialFormat& format) {
  std::error_code missing;
  const auto real = fs::canonical(device, missing).string();
  if (missing) return open_fault("no such device");
  return real.starts_with("/dev/pts/") ? open_pseudo_terminal(real) : open_port(real, format);
}

std::vector<SerialPortFound> list_serial_ports() {
  std::vector<SerialPortFound> found;
  sp_port** ports = nullptr;
  if (sp_list_ports(&ports) != SP_OK) return found;
  for (auto** port = ports; *port != nullptr; ++port) {
    SerialPortFound entry{.device = text_or_empty(sp_get_port_name(*port)),
                          .description = text_or_empty(sp_get_port_description(*port)),
                          .serial = text_or_empty(sp_get_port_usb_serial(*port)),
                          .stable_name = {}};
    entry.stable_name = stable_name(entry.device);
    sp_get_port_usb_vid_pid(*port, &entry.vendor, &entry.product);
    found.push_back(std::move(entry));
  }
  sp_free_port_list(ports);
  std::ranges::sort(found, {}, &SerialPortFound::device);
  return found;
}

std::unique_ptr<ByteStream> make_serial_stream(std::string device, const SerialFormat& format) {
  return std::make_unique<SerialStream>(std::move(device), format);
}

namespace {

/// Maximum silence within an echo. A gateway may delay its second packet until the first is acknowledged.
constexpr Duration kEchoGap = std::chrono::milliseconds(250);

class EchoStream final : public ByteStream {
 public:
  EchoStream(std::unique_ptr<ByteStream> line, std::size_t most_stray_bytes, const Clock* clock)
      : line_(std::move(line)), most_stray_bytes_(most_stray_bytes), clock_(clock) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    if (after_echo_.empty()) return line_->read(buffer, within);
    const auto size = std::min(buffer.size(), after_echo_.size());
    const auto end = after_echo_.begin() + static_cast<std::ptrdiff_t>(size);
    std::copy(after_echo_.begin(), end, buffer.begin());
    after_echo_.erase(after_echo_.begin(), end);
    return size;
  }

  Result<void> write(std::span<const std::byte> bytes, Duration within) override {
    after_echo_.clear();
    const Deadline deadline(within, clock_);
    if (auto sent = line_->write(bytes, within); !sent || bytes.empty()) return sent;
    std::vector<std::byte> received;
    std::array<std::byte, 256> buffer;
    while (true) {
      const auto size = line_->read(buffer, std::min(kEchoGap, deadline.left()));
      if (!size && size.error().kind != FaultKind::timeout) return failure(size.error());
      if (!size) return echo_fault(received);
      received.insert(received.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*size));
      const auto echo = std::ranges::search(received, bytes);
      if (!echo.empty()) {
        after_echo_.assign(echo.end(), received.end());
        return {};
      }
      if (received.size() >= bytes.size() + most_stray_bytes_) return echo_fault(received);
    }
  }

  std::optional<Duration> arrival_time() const override { return line_->arrival_time(); }
  void end_rest() override { line_->end_rest(); }

 private:
  [[nodiscard]] static tl::unexpected<Fault> echo_fault(std::span<const std::byte> received) {
    constexpr std::size_t kLongestQuote = 80;
    if (received.empty())
      return failure(FaultKind::timeout, "", "no echo received; check the adapter, or remove \"echo\"");
    const std::string_view text(reinterpret_cast<const char*>(received.data()), received.size());
    return failure(FaultKind::corrupted, "",
                   fmt::format("the echo differs from the bytes sent; check the adapter, or remove \"echo\"; "
                               "received \"{}{}\"",
                               plain(text.substr(0, kLongestQuote)), text.size() > kLongestQuote ? "…" : ""));
  }

  std::unique_ptr<ByteStream> line_;
  /// Maximum number of bytes around the echo.
  std::size_t most_stray_bytes_;
  const Clock* clock_;
  /// Bytes that arrived after the echo, in the same reads.
  std::vector<std::byte> after_echo_;
};

}  // namespace

std::unique_ptr<ByteStream> make_echo_stream(std::unique_ptr<ByteStream> line, const Clock* clock,
                                             std::size_t most_stray_bytes) {
  return std::make_unique<EchoStream>(std::move(line), most_stray_bytes, clock);
}

}  // namespace gyrotherm::drivers
