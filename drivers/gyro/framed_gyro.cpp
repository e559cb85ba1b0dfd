// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/framed_gyro.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/deadline.hpp"
#include "core/process.hpp"
#include "core/toml_reader.hpp"
#include "drivers/gyro/frame_sum.hpp"
#include "drivers/gyro/host_time.hpp"

namespace gyrotherm::drivers {

namespace {

constexpr Vocabulary<SerialParity, 3> kParityKeywords{
    {{"none", SerialParity::none}, {"even", SerialParity::even}, {"odd", SerialParity::odd}}};

SerialFormat read_port(const TomlTable& table) {
  SerialFormat port;
  port.baud = whole<int>(table, "baud", 50, 20'000'000);
  port.data_bits = whole<int>(table, "data_bits", 5, 8, 8);
  port.parity = one_of(kParityKeywords, table, "parity", "none");
  port.stop_bits = whole<int>(table, "stop_bits", 1, 2, 1);
  return port;
}

}  // namespace

Result<GyroStream> parse_gyro_stream(std::string_view text, const std::string& file,
                                     const std::vector<std::string>& axes, std::optional<double> rate_hz) {
  const auto parsed = TomlTable::parse(text, file);
  if (!parsed) return failure(parsed.error());
  GyroStream stream;
  stream.text = text;
  (void)parsed->choice("schema", {"gyrotherm-gyro-stream/1"});
  stream.name = parsed->text("name");
  stream.vendor = parsed->text("vendor");
  stream.source = parsed->text("source");
  stream.confidence = parsed->choice("confidence", {"verified", "manual", "secondary"});
  stream.port = read_port(parsed->table("port"));
  stream.frame = read_frame_format(parsed->table("frame"), axes, rate_hz);
  stream.start = read_commands(*parsed, "start", stream.frame);
  stream.stop = read_commands(*parsed, "stop", stream.frame);
  if (parsed->has("identity")) stream.identity = read_identity_query(parsed->table("identity"));
  stream.settings = read_settings(*parsed, stream.start, stream.frame);
  if (parsed->has("largest_bias_deg_per_h"))
    stream.largest_bias_deg_per_h = std::max(0.0, parsed->number("largest_bias_deg_per_h"));
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  return stream;
}

namespace {

constexpr std::size_t kReadSize = 16384, kMaxUnread = 1 << 20;
/// Timeout of one read from the line. It may delay a write by this time.
constexpr Duration kReadTimeout = std::chrono::milliseconds(20);

/// Returns a time that includes suspension, because the gyro's clock runs while the host is suspended.
[[nodiscard]] Duration steady_time() { return since_boot(); }

/// A write to be executed by the reading thread, and its result.
struct WriteRequest {
  std::span<const std::byte> bytes;
  Duration within;
  std::optional<Result<void>> result;
};

class BufferedStream final : public ByteStream {
 public:
  explicit BufferedStream(std::unique_ptr<ByteStream> line) : line_(std::move(line)) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    start_thread();
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, within, [this] { return !unread_.empty() || fault_; });
    if (!unread_.empty()) {
      const auto size = std::min(buffer.size(), unread_.size());
      std::copy_n(unread_.begin(), size, buffer.begin());
      unread_.erase(unread_.begin(), unread_.begin() + static_cast<std::ptrdiff_t>(size));
      read_arrival_ = newest_arrival_;
      return size;
    }
    if (!fault_) return failure(FaultKind::timeout, "", "no data");
    auto fault = std::move(*fault_);
    fault_.reset();
    changed_.notify_all();
    return failure(std::move(fault));
  }

  Result<void> write(std::span<const std::byte> bytes, Duration within) override {
    start_thread();
    WriteRequest request{bytes, within, {}};
    std::unique_lock lock(mutex_);
    request_ = &request;
    changed_.notify_all();
    changed_.wait(lock, [&] { return request.result.has_value(); });
    return std::move(*request.result);
  }

  std::optional<Duration> arrival_time() const override { return read_arrival_; }

 private:
  /// Starts the thread, which opens the line.
  void start_thread() {
    if (!thread_.joinable())
      thread_ = std::jthread([this](const std::stop_token& stop) { read_line_until_stopped(stop); });
  }

  void read_line_until_stopped(const std::stop_token& stop) {
    block_signals();
    std::array<std::byte, kReadSize> chunk;
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      if (request_) {
        run_write(lock);
        continue;
      }
      if (fault_) {
        changed_.wait(lock, stop, [this] { return !fault_ || request_; });
        continue;
      }
      lock.unlock();
      const auto size = line_->read(chunk, kReadTimeout);
      const auto arrival = steady_time();
      lock.lock();
      if (size)
        store(std::span(chunk).first(*size), arrival);
      else if (size.error().kind != FaultKind::timeout)
        fault_ = size.error();
      if (size || fault_) changed_.notify_all();
    }
  }

  void run_write(std::unique_lock<std::mutex>& lock) {
    WriteRequest& request = *std::exchange(request_, nullptr);
    lock.unlock();
    auto result = line_->write(request.bytes, request.within);
    lock.lock();
    request.result = std::move(result);
    changed_.notify_all();
  }

  void store(std::span<const std::byte> bytes, Duration arrival) {
    if (unread_.size() + bytes.size() > kMaxUnread) {
      unread_.clear();
      fault_ = Fault{FaultKind::corrupted, "", "received bytes were dropped because they were not read in time"};
      return;
    }
    unread_.insert(unread_.end(), bytes.begin(), bytes.end());
    newest_arrival_ = arrival;
  }

  std::unique_ptr<ByteStream> line_;  ///< used by the thread only
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<std::byte> unread_;
  Duration newest_arrival_{};  ///< arrival of the newest unread byte
  /// Arrival of the newest byte that read() returned. Only the calling thread uses it.
  std::optional<Duration> read_arrival_;
  /// Fault that read() has not reported yet. The line is not read while there is one.
  std::optional<Fault> fault_;
  WriteRequest* request_ = nullptr;
  std::jthread thread_;  ///< declared last: uses all members above
};

}  // namespace

std::unique_ptr<ByteStream> make_buffered_stream(std::unique_ptr<ByteStream> line) {
  return std::make_unique<BufferedStream>(std::move(line));
}

namespace {

constexpr std::size_t kChunk = 4096;
/// Maximum by which the gyro's time between two rounds may exceed the host's time between two reads.
constexpr Duration kMostAhead = std::chrono::seconds(1);

/// The bytes received in one read.
class ReceivedBytes {
 public:
  void clear() { *this = {}; }
  void add(std::span<const std::byte> bytes) {
    for (const auto byte : bytes.first(std::min(bytes.size(), kFirst - std::min(kFirst, size_))))
      first_ += fmt::format("{}{:02X}", first_.empty() ? "" : " ", static_cast<unsigned>(byte));
    size_ += bytes.size();
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  static constexpr std::size_t kFirst = 16;
  std::size_t size_{};
  std::string first_;  ///< in hexadecimal
};

class FramedGyro final : public Gyro {
 public:
  FramedGyro(FrameFormat format, std::unique_ptr<ByteStream> line, Duration within, GyroCommands commands,
             const Clock* clock)
      : format_(std::move(format)),
        line_(std::move(line)),
        within_(within),
        commands_(std::move(commands)),
        clock_(clock),
        decoder_(format_),
        sum_(format_),
        means_(format_),
        arrivals_(format_.rate_hz > 0),
        pace_(format_.rate_hz) {}
  ~FramedGyro() override;
  FramedGyro(const FramedGyro&) = delete;
  FramedGyro& operator=(const FramedGyro&) = delete;

  Result<void> open() override {
    if (auto alive = line_->write({}, within_); !alive) return at_place(std::move(alive.error()));
    if (open_) return {};
    for (const auto& command : commands_.start)
      if (auto done = send(command); !done) return done;
    open_ = true;
    if (!commands_.start.empty()) reset_stream();
    return {};
  }

  Result<void> wait_for_origin() override {
    is_waiting_for_origin_ = true;
    auto taken = read_count(kSecond);
    is_waiting_for_origin_ = false;
    return taken.map([](const MaybeCount&) {});
  }

  Result<GyroCount> read(Duration expected) override {
    auto count = read_count(expected);
    if (!count) return failure(count.error());
    if (!*count) return failure(FaultKind::corrupted, place(), "the count starts again; the counts before it are lost");
    return std::move(**count);
  }

  FrameCount frames() const override { return frames_; }

  std::uint64_t breaks() const override { return breaks_; }

  Result<std::string> identify() override {
    if (!commands_.identity) return std::string();
    const auto answer = query_identity(*commands_.identity, *line_, within_, clock_);
    reset_stream();
    if (!answer) return at_place(answer.error());
    if (answer->empty() && has_identity_)
      return failure(FaultKind::timeout, place(),
                     fmt::format("no answer to \"{}\"", first_line(commands_.identity->send)));
    has_identity_ = !answer->empty();
    return answer->empty() ? std::string() : fmt::format("{} {}", format_.name, *answer);
  }

 private:
  [[nodiscard]] Result<void> send(const GyroCommand& command) {
    auto sent = send_command(command, format_, *line_, within_, clock_);
    if (!sent) return at_place(std::move(sent.error()));
    return sent;
  }

  /// Returns the fault with the name of the gyro, unless it names its place.
  [[nodiscard]] tl::unexpected<Fault> at_place(Fault fault) const {
    if (fault.where.empty()) fault.where = place();
    return failure(std::move(fault));
  }

  /// Count of one read; empty if the read only received the origin, from which the next read counts.
  using MaybeCount = std::optional<GyroCount>;

  [[nodiscard]] Result<MaybeCount> read_count(Duration expected) {
    const bool starts = !open_ && !commands_.start.empty();
    if (starts)
      if (auto opened = open(); !opened) return failure(std::move(opened.error()));
    FrameTally tally;
    means_.clear();
    received_.clear();
    rejected_before_ = decoder_.rejected_bytes();
    auto count = collect_frames(expected, tally);
    frames_.lost += tally.lost;
    frames_.bad += tally.bad;
    const auto kind = count ? FaultKind::corrupted : count.error().kind;
    // The frame that confirmed the start is not counted. At a low rate the next one arrives after this read.
    if (kind == FaultKind::timeout && starts) return count;
    if (kind == FaultKind::timeout || kind == FaultKind::disconnected) open_ = false;
    return count;
  }

  [[nodiscard]] Result<MaybeCount> collect_frames(Duration expected, FrameTally& tally) {
    const Deadline deadline(within_, clock_);
    const bool first = !sum_.has_origin();
    const auto seen_before = frames_.seen;
    bool is_complete = false;
    while (true) {
      const auto more = read_chunk(is_complete ? Duration::zero() : deadline.left(), tally);
      if (!more) {
        if (more.error().kind == FaultKind::timeout && (is_complete || tally.rounds > 0))
          return finish_read(tally, first);
        const auto what =
            more.error().kind == FaultKind::timeout ? explain_missing_count(frames_.seen - seen_before) : std::string();
        reset_stream();
        if (what.empty()) return at_place(more.error());
        open_ = false;  // the gyro may have restarted
        return failure(FaultKind::corrupted, place(), what);
      }
      is_complete = first ? sum_.has_origin() : is_long_enough(tally, expected);
      if (is_complete && !*more) return finish_read(tally, first);
      if (!deadline.has_passed()) continue;
      if (tally.rounds > 0) return finish_read(tally, first);
      const auto what = explain_missing_count(frames_.seen - seen_before);
      reset_stream();
      open_ = false;
      return failure(FaultKind::corrupted, place(), what.empty() ? "no complete frame" : what);
    }
  }

  /// Explains why a read produced no count: no frame has all axes, or the bytes are not frames. Returns an empty text
  /// if fewer bytes than a frame arrived and none was rejected. `frames` is the number of frames in the read.
  [[nodiscard]] std::string explain_missing_count(std::uint64_t frames) const {
    const auto wait_s = to_seconds(within_);
    if (frames > 0)
      return fmt::format("{} frames received in {:.1f} s, but none with all axes; check which messages the gyro sends",
                         frames, wait_s);
    const auto rejected = decoder_.rejected_bytes() - rejected_before_;
    if (rejected == 0 && received_.size() < format_.length) return {};
    return fmt::format(
        "{} bytes received in {:.1f} s, but no frame of this stream ({} bytes rejected; first bytes: {}): check "
        "the baud rate and the stream file",
        received_.size(), wait_s, rejected, received_.first());
  }

  /// Decodes the available bytes. Returns true if more bytes may be available already.
  [[nodiscard]] Result<bool> read_chunk(Duration within, FrameTally& tally) {
    std::array<std::byte, kChunk> chunk;
    const auto size = line_->read(chunk, within);
    if (!size) return failure(size.error());
    const auto arrival = clock_ ? clock_->now().since_start : line_->arrival_time().value_or(steady_time());
    const auto rejected = decoder_.rejected_bytes();
    const bool first = !sum_.has_origin();
    const auto lost = tally.lost;
    const auto rounds = tally.rounds;
    received_.add(std::span(chunk).first(*size));
    decoder_.feed(std::span(chunk).first(*size));
    while (const auto* frame = decoder_.take()) {
      if (auto differ = decoder_.differing_settings()) differing_settings_ = std::move(*differ);
      if (sum_.has_origin()) means_.add(*frame);
      sum_.add(*frame, tally);
      ++frames_.seen;
    }
    if (tally.rounds > rounds || (first && sum_.has_origin())) newest_arrival_ = arrival;
    const auto rejected_bytes = decoder_.rejected_bytes() - rejected;
    if (!first && are_rejected_bytes_losses())
      tally.lost = std::max(tally.lost, lost + (rejected_bytes + format_.length - 1) / format_.length);
    return *size == kChunk;
  }

  /// Returns whether the frames cover enough of `expected`. With a device clock, up to half a round may be missing,
  /// because the next round would exceed `expected` by at least as much. Without one, half of `expected` by the host's
  /// clock is enough: a short read can then compensate for a late one before it, and the interval is still long
  /// compared with the delays of the line.
  [[nodiscard]] bool is_long_enough(const FrameTally& tally, Duration expected) const {
    if (tally.rounds == 0) return false;
    if (sum_.has_clock()) return tally.interval + tally.round / 2 >= expected;
    return arrivals_.time_since_start(newest_arrival_) >= expected / 2;
  }

  /// Irregularities in the frames of one read.
  struct Findings {
    /// Message about a deviating frame rate; empty if there is none.
    std::string rate_mismatch{};
    /// The device's time jumped ahead of the host's.
    bool time_jumped{};
    bool is_disordered{};  ///< see FrameTally
    std::uint64_t lost{};
    std::uint64_t bad{};
    /// Returns whether the gyro may have been restarted or exchanged.
    [[nodiscard]] bool may_have_restarted() const { return is_disordered || time_jumped; }
    /// Returns whether the interval since the previous read is unknown.
    [[nodiscard]] bool has_gap() const { return lost > 0 || may_have_restarted(); }
  };

  /// Evaluates the frames of a read, prepares the next read, and returns the count or the fault. `first` is true if the
  /// frames contain the origin. Sets `tally.lost` to the number of lost frames.
  [[nodiscard]] Result<MaybeCount> finish_read(FrameTally& tally, bool first) {
    const auto found = evaluate(tally, first);
    tally.lost = found.lost;
    prepare_next_read(found, tally, first);
    if (auto fault = find_fault(found)) return failure(std::move(*fault));
    return count_frames(tally, first);
  }

  [[nodiscard]] Findings evaluate(const FrameTally& tally, bool first) const {
    Findings found{.rate_mismatch = find_rate_mismatch(),
                   .time_jumped = !first && tally.longest > newest_arrival_ - previous_arrival_ + kMostAhead,
                   .is_disordered = tally.is_disordered,
                   .lost = tally.lost,
                   .bad = tally.bad};
    // Not counted as losses: a different frame rate, a gap before the origin, a jump of the only clock that shows gaps.
    const bool jump_hides_losses = found.time_jumped && !format_.find(FieldRole::sequence);
    if (!found.rate_mismatch.empty() || is_waiting_for_origin_ || jump_hides_losses) found.lost = 0;
    return found;
  }

  /// Sets the origin of the next read. If the gyro may have restarted, the next read sends the start commands.
  void prepare_next_read(const Findings& found, const FrameTally& tally, bool first) {
    previous_arrival_ = newest_arrival_;
    const bool has_flaw = found.has_gap() || found.bad > 0;
    if (has_flaw) sum_.drop_round();
    if (first || has_flaw) arrivals_.start_at(newest_arrival_);
    if (first || found.has_gap())
      pace_.start_at(newest_arrival_);
    else
      pace_.add(tally.interval, newest_arrival_);
    if (found.bad > 0 && sum_.has_bad_reference()) restart_count();
    if (!found.may_have_restarted()) return;
    ++breaks_;
    open_ = open_ && commands_.start.empty();
  }

  /// Returns the most severe fault of the frames of a read, or nothing if they can be counted.
  [[nodiscard]] std::optional<Fault> find_fault(const Findings& found) const {
    const auto fault = [this](FaultKind kind, std::string what) { return Fault{kind, place(), std::move(what)}; };
    if (!differing_settings_.empty())
      return fault(FaultKind::mismatch, fmt::format("{}", fmt::join(differing_settings_, "; ")));
    if (!found.rate_mismatch.empty()) return fault(FaultKind::mismatch, found.rate_mismatch);
    if (found.is_disordered)
      return fault(FaultKind::corrupted,
                   "a frame was received twice or the frame counter restarted; the number of lost frames is unknown");
    if (found.time_jumped)
      return fault(FaultKind::corrupted, "the device clock jumped: it was set, or the gyro restarted");
    if (found.lost > 0)
      return fault(FaultKind::corrupted,
                   fmt::format("{} frames lost{}", found.lost,
                               sum_.steps().has_constant_deviation() ? ", or the unit is set to another rate" : ""));
    if (found.bad > 0)
      return fault(FaultKind::out_of_range, fmt::format("{} frames are marked bad by the gyro", found.bad));
    if (auto text = find_time_mismatch(); !text.empty()) return fault(FaultKind::mismatch, std::move(text));
    return std::nullopt;
  }

  /// Returns the count of frames without a fault, or nothing if they only provide the origin. Without a device clock,
  /// the first read has no interval, because the host only knows the arrival time of the newest frame.
  [[nodiscard]] Result<MaybeCount> count_frames(const FrameTally& tally, bool first) {
    if (tally.rounds == 0) return std::nullopt;
    if (sum_.has_clock()) return make_count(tally, tally.interval);
    if (first) return std::nullopt;
    return count_by_host_clock(tally);
  }

  /// Returns a message if the steps between frames are constant but differ from the described step, otherwise an empty
  /// text.
  [[nodiscard]] std::string find_rate_mismatch() const {
    const auto step = sum_.steps().find_deviating_step();
    if (!step) return {};
    if (format_.rate_hz <= 0) return fmt::format("the frame counter advances by {:g} times the described step", *step);
    return rate_mismatch_text(format_.rate_hz / *step);
  }

  [[nodiscard]] std::string rate_mismatch_text(double rate_hz) const {
    return fmt::format(
        "sends {:.1f} frames per second, but its stream file states {:g}; set the unit, or rate_hz in [gyro] of the "
        "rig file",
        rate_hz, format_.rate_hz);
  }

  /// Returns a message if the gyro's time passes faster or slower than the host's, otherwise an empty text. Time stamps
  /// must differ by a factor of at least two: a wrong unit changes the time by a factor of ten or more, and the time of
  /// a simulated gyro may deviate by less than two.
  [[nodiscard]] std::string find_time_mismatch() const {
    constexpr double kLeastFactor = 2;
    const auto pace = pace_.find_deviating_pace();
    if (!pace || !sum_.has_clock()) return {};
    if (format_.clocked_by_sequence) return rate_mismatch_text(*pace * format_.rate_hz);
    if (std::max(*pace, 1 / *pace) < kLeastFactor) return {};
    return fmt::format("the time stamps advance by {:.3g} s per second; check their unit in the stream file", *pace);
  }

  [[nodiscard]] Result<MaybeCount> count_by_host_clock(const FrameTally& tally) {
    if (const auto interval = arrivals_.next(tally.rounds, newest_arrival_)) return make_count(tally, *interval);
    restart_count();
    return failure(
        FaultKind::corrupted, place(),
        fmt::format("{} frames do not match the time in which they arrived: some were lost or late", tally.rounds));
  }

  [[nodiscard]] GyroCount make_count(const FrameTally& tally, Duration interval) const {
    return {sum_.counts(tally, interval), interval, means_.values()};
  }

  /// Returns whether rejected bytes must be counted as lost frames. They must if neither a sequence nor the device's
  /// time shows losses, or if `lock_frames` replaces a sync.
  [[nodiscard]] bool are_rejected_bytes_losses() const {
    const bool timed = format_.rate_hz > 0 && sum_.has_clock();
    return format_.lock_frames > 0 || (!format_.find(FieldRole::sequence) && !timed);
  }

  void reset_stream() {
    decoder_ = FrameDecoder(format_);
    differing_settings_.clear();
    restart_count();
  }

  /// Discards the origin; the next read waits for a new one.
  void restart_count() {
    sum_ = FrameSum(format_);
    arrivals_ = HostInterval(format_.rate_hz > 0);
  }

  [[nodiscard]] std::string place() const { return "gyro " + format_.name; }

  FrameFormat format_;
  std::unique_ptr<ByteStream> line_;
  Duration within_;
  GyroCommands commands_;
  const Clock* clock_;
  bool open_ = false;
  bool is_waiting_for_origin_ = false;
  bool has_identity_ = false;  ///< sent its identity before
  std::uint64_t breaks_ = 0;
  ReceivedBytes received_;  ///< bytes of the current read
  /// Rejected bytes before this read.
  std::uint64_t rejected_before_{};
  /// Settings of the unit that differ from the description, as of the newest configuration message.
  std::vector<std::string> differing_settings_;
  FrameDecoder decoder_;
  FrameSum sum_;
  FrameMeans means_;
  /// Arrival of the newest round, by the host's clock.
  Duration newest_arrival_{};
  /// Arrival of the last round of the previous read.
  Duration previous_arrival_{};
  /// Measures the intervals if the format has no device clock.
  HostInterval arrivals_;
  /// Compares the device clock, if there is one, with the host's clock.
  FramePace pace_;
  FrameCount frames_;
};

FramedGyro::~FramedGyro() {
  if (!open_) return;
  for (const auto& command : commands_.stop) (void)send(command);
}

}  // namespace

std::unique_ptr<Gyro> make_framed_gyro(FrameFormat format, std::unique_ptr<ByteStream> line, Duration within,
                                       GyroCommands commands, const Clock* clock) {
  return std::make_unique<FramedGyro>(std::move(format), std::move(line), within, std::move(commands), clock);
}

}  // namespace gyrotherm::drivers
