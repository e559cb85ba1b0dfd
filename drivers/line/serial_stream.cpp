#include "drivers/line/serial_stream.hpp"

#include <fmt/format.h>

#include <cstring>
#include <utility>

#include "drivers/line/backoff.hpp"
#include "drivers/line/descriptor.hpp"
#include "drivers/line/serial_port.hpp"

namespace gyrotherm {

namespace {

class SerialStream final : public ByteStream {
 public:
  SerialStream(std::string device, const SerialFormat& format) : device_(std::move(device)), format_(format) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override;
  Result<void> write(std::span<const std::byte> bytes, Duration within) override;

 private:
  [[nodiscard]] Result<void> open();
  [[nodiscard]] std::string place() const { return "serial " + device_; }
  [[nodiscard]] tl::unexpected<Fault> broken(std::string why);

  std::string device_;
  SerialFormat format_;
  Descriptor port_;
  Backoff backoff_;
};

/// A port that is gone stays ready for ever, so it is closed at once.
tl::unexpected<Fault> SerialStream::broken(std::string why) {
  port_.close();
  backoff_.failed();
  return failure(FaultKind::disconnected, place(), std::move(why));
}

Result<void> SerialStream::open() {
  if (port_.is_open()) return {};
  if (backoff_.left() > Duration::zero()) return failure(FaultKind::disconnected, place(), backoff_.words());
  auto opened = open_serial_port(device_, format_);
  if (!opened) return broken(std::move(opened.error().what));
  port_ = std::move(*opened);
  return {};
}

Result<std::size_t> SerialStream::read(std::span<std::byte> buffer, Duration within) {
  if (auto opened = open(); !opened) return failure(std::move(opened.error()));
  const Deadline deadline(within);
  while (ready(port_.number(), POLLIN, deadline)) {
    const auto size = ::read(port_.number(), buffer.data(), buffer.size());
    if (size > 0) {
      backoff_.succeeded();
      return static_cast<std::size_t>(size);
    }
    if (size == 0) return broken("the port is gone");  // ready, and nothing there: its other end hung up
    if (!would_block()) return broken(std::strerror(errno));
  }
  return failure(FaultKind::timeout, place(), fmt::format("nothing came in {:.3f} s", to_seconds(within)));
}

Result<void> SerialStream::write(std::span<const std::byte> bytes, Duration within) {
  if (auto opened = open(); !opened) return opened;
  const Deadline deadline(within);
  while (!bytes.empty()) {
    const auto size = ::write(port_.number(), bytes.data(), bytes.size());
    if (size > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(size));
      continue;
    }
    if (size < 0 && !would_block()) return broken(std::strerror(errno));
    if (!deadline.over() && ready(port_.number(), POLLOUT, deadline)) continue;
    (void)broken("a part may have been sent");
    return failure(FaultKind::timeout, place(), fmt::format("could not send in {:.3f} s", to_seconds(within)));
  }
  return {};
}

}  // namespace

std::unique_ptr<ByteStream> make_serial_stream(std::string device, const SerialFormat& format) {
  return std::make_unique<SerialStream>(std::move(device), format);
}

}  // namespace gyrotherm
