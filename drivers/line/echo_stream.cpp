// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/echo_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>
#include <vector>

#include "core/deadline.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::size_t kMostStray = 8;  ///< bytes before the echo
/// A gateway may hold the second packet of an echo back until the first is acknowledged.
constexpr Duration kLongestGap = std::chrono::milliseconds(250);

class EchoStream final : public ByteStream {
 public:
  EchoStream(std::unique_ptr<ByteStream> line, const Clock* clock) : line_(std::move(line)), clock_(clock) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    if (behind_echo_.empty()) return line_->read(buffer, within);
    const auto size = std::min(buffer.size(), behind_echo_.size());
    const auto end = behind_echo_.begin() + static_cast<std::ptrdiff_t>(size);
    std::copy(behind_echo_.begin(), end, buffer.begin());
    behind_echo_.erase(behind_echo_.begin(), end);
    return size;
  }

  Result<void> write(std::span<const std::byte> bytes, Duration within) override {
    behind_echo_.clear();
    const Deadline deadline(within, clock_);
    if (auto sent = line_->write(bytes, within); !sent || bytes.empty()) return sent;
    std::vector<std::byte> came;
    std::array<std::byte, 256> buffer;
    while (true) {
      const auto size = line_->read(buffer, std::min(kLongestGap, deadline.left()));
      if (!size && size.error().kind != FaultKind::timeout) return failure(size.error());
      if (!size) return no_echo(came.size(), bytes.size());
      came.insert(came.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*size));
      const auto echo = std::ranges::search(came, bytes);
      if (!echo.empty()) {
        behind_echo_.assign(echo.end(), came.end());
        return {};
      }
      if (came.size() >= bytes.size() + kMostStray)
        return failure(FaultKind::corrupted, "", "something else came back than what was sent; \"echo\" expects it");
    }
  }

  std::optional<Duration> came() const override { return line_->came(); }
  void end_rest() override { line_->end_rest(); }

 private:
  [[nodiscard]] static tl::unexpected<Fault> no_echo(std::size_t came, std::size_t sent) {
    if (came == 0)
      return failure(FaultKind::timeout, "",
                     "what was sent did not come back; \"echo\" expects an adapter that echoes");
    return failure(FaultKind::corrupted, "",
                   fmt::format("{} bytes came back where {} were sent; \"echo\" expects the same", came, sent));
  }

  std::unique_ptr<ByteStream> line_;
  const Clock* clock_;
  std::vector<std::byte> behind_echo_;  ///< arrived together with the echo
};

}  // namespace

std::unique_ptr<ByteStream> make_echo_stream(std::unique_ptr<ByteStream> line, const Clock* clock) {
  return std::make_unique<EchoStream>(std::move(line), clock);
}

}  // namespace gyrotherm::drivers
