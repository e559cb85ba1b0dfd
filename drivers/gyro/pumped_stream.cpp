#include "drivers/gyro/pumped_stream.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "core/process.hpp"

namespace gyrotherm {
namespace {

constexpr std::size_t kPumpedChunk = 16384, kMostWaiting = 1 << 20;
/// How long the line is waited for at once: a write comes after that.
constexpr Duration kTurn = std::chrono::milliseconds(20);

/// What the reader's thread is asked to write, and what came of it.
struct Errand {
  std::span<const std::byte> bytes;
  Duration within;
  std::optional<Result<void>> done;
};

class PumpedStream final : public ByteStream {
 public:
  explicit PumpedStream(std::unique_ptr<ByteStream> line) : line_(std::move(line)) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override;
  Result<void> write(std::span<const std::byte> bytes, Duration within) override;

 private:
  /// The first use opens the line.
  void begin();
  void pump(const std::stop_token& stop);
  void run_errand(std::unique_lock<std::mutex>& lock);
  void keep(std::span<const std::byte> bytes);

  std::unique_ptr<ByteStream> line_;  ///< the thread's own
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<std::byte> waiting_;
  std::optional<Fault> fault_;  ///< not told yet; the line rests until it is
  Errand* errand_ = nullptr;
  std::jthread thread_;  ///< last: it uses the others
};

void PumpedStream::begin() {
  if (!thread_.joinable()) thread_ = std::jthread([this](const std::stop_token& stop) { pump(stop); });
}

Result<std::size_t> PumpedStream::read(std::span<std::byte> buffer, Duration within) {
  begin();
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, within, [this] { return !waiting_.empty() || fault_; });
  if (!waiting_.empty()) {
    const auto size = std::min(buffer.size(), waiting_.size());
    std::copy_n(waiting_.begin(), size, buffer.begin());
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(size));
    return size;
  }
  if (!fault_) return failure(FaultKind::timeout, "", "nothing came");
  auto fault = std::move(*fault_);
  fault_.reset();
  changed_.notify_all();
  return failure(std::move(fault));
}

Result<void> PumpedStream::write(std::span<const std::byte> bytes, Duration within) {
  begin();
  Errand errand{bytes, within, {}};
  std::unique_lock lock(mutex_);
  errand_ = &errand;
  changed_.notify_all();
  changed_.wait(lock, [&] { return errand.done.has_value(); });
  return std::move(*errand.done);
}

void PumpedStream::run_errand(std::unique_lock<std::mutex>& lock) {
  Errand& errand = *std::exchange(errand_, nullptr);
  lock.unlock();
  auto done = line_->write(errand.bytes, errand.within);
  lock.lock();
  errand.done = std::move(done);
  changed_.notify_all();
}

void PumpedStream::keep(std::span<const std::byte> bytes) {
  if (waiting_.size() + bytes.size() > kMostWaiting) {
    waiting_.clear();
    fault_ = Fault{FaultKind::corrupted, "", "what came was not read for so long that it was dropped"};
    return;
  }
  waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
}

void PumpedStream::pump(const std::stop_token& stop) {
  block_signals();
  std::array<std::byte, kPumpedChunk> chunk;
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (errand_) {
      run_errand(lock);
      continue;
    }
    if (fault_) {
      changed_.wait(lock, stop, [this] { return !fault_ || errand_; });
      continue;
    }
    lock.unlock();
    const auto size = line_->read(chunk, kTurn);
    lock.lock();
    if (size)
      keep(std::span(chunk).first(*size));
    else if (size.error().kind != FaultKind::timeout)
      fault_ = size.error();
    if (size || fault_) changed_.notify_all();
  }
}

}  // namespace

std::unique_ptr<ByteStream> make_pumped(std::unique_ptr<ByteStream> line) {
  return std::make_unique<PumpedStream>(std::move(line));
}

}  // namespace gyrotherm
