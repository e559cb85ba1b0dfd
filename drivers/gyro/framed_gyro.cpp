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

constexpr Vocabulary<SerialParity, 3> kParityWords{
    {{"none", SerialParity::none}, {"even", SerialParity::even}, {"odd", SerialParity::odd}}};

SerialFormat read_port(const TomlTable& table) {
  SerialFormat port;
  port.baud = whole<int>(table, "baud", 50, 20'000'000);
  port.data_bits = whole<int>(table, "data_bits", 5, 8, 8);
  port.parity = one_of(kParityWords, table, "parity", "none");
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
  if (parsed->has("identity")) stream.identity = read_question(parsed->table("identity"));
  stream.settings = read_settings(*parsed, stream.start, stream.frame);
  if (parsed->has("largest_bias_deg_per_h"))
    stream.largest_bias_deg_per_h = std::max(0.0, parsed->number("largest_bias_deg_per_h"));
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  return stream;
}

namespace {

constexpr std::size_t kPumpedChunk = 16384, kMostWaiting = 1 << 20;
/// Maximum duration of one read from the line. A write is delayed by up to this time.
constexpr Duration kTurn = std::chrono::milliseconds(20);

/// Returns the steady time including suspended time, because a gyro's clock runs while the host is suspended.
[[nodiscard]] Duration steady_time() { return since_boot(); }

/// A write that the reading thread executes, and its result.
struct Errand {
  std::span<const std::byte> bytes;
  Duration within;
  std::optional<Result<void>> done;
};

class PumpedStream final : public ByteStream {
 public:
  explicit PumpedStream(std::unique_ptr<ByteStream> line) : line_(std::move(line)) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    begin();
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, within, [this] { return !waiting_.empty() || fault_; });
    if (!waiting_.empty()) {
      const auto size = std::min(buffer.size(), waiting_.size());
      std::copy_n(waiting_.begin(), size, buffer.begin());
      waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(size));
      came_ = newest_;
      return size;
    }
    if (!fault_) return failure(FaultKind::timeout, "", "no data");
    auto fault = std::move(*fault_);
    fault_.reset();
    changed_.notify_all();
    return failure(std::move(fault));
  }

  Result<void> write(std::span<const std::byte> bytes, Duration within) override {
    begin();
    Errand errand{bytes, within, {}};
    std::unique_lock lock(mutex_);
    errand_ = &errand;
    changed_.notify_all();
    changed_.wait(lock, [&] { return errand.done.has_value(); });
    return std::move(*errand.done);
  }

  std::optional<Duration> came() const override { return came_; }

 private:
  /// Starts the thread, which opens the line.
  void begin() {
    if (!thread_.joinable()) thread_ = std::jthread([this](const std::stop_token& stop) { pump(stop); });
  }

  void pump(const std::stop_token& stop) {
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
      const auto came = steady_time();
      lock.lock();
      if (size)
        keep(std::span(chunk).first(*size), came);
      else if (size.error().kind != FaultKind::timeout)
        fault_ = size.error();
      if (size || fault_) changed_.notify_all();
    }
  }

  void run_errand(std::unique_lock<std::mutex>& lock) {
    Errand& errand = *std::exchange(errand_, nullptr);
    lock.unlock();
    auto done = line_->write(errand.bytes, errand.within);
    lock.lock();
    errand.done = std::move(done);
    changed_.notify_all();
  }

  void keep(std::span<const std::byte> bytes, Duration came) {
    if (waiting_.size() + bytes.size() > kMostWaiting) {
      waiting_.clear();
      fault_ = Fault{FaultKind::corrupted, "", "received bytes were dropped because they were not read in time"};
      return;
    }
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
    newest_ = came;
  }

  std::unique_ptr<ByteStream> line_;  ///< used by the thread only
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<std::byte> waiting_;
  Duration newest_{};             ///< arrival of the newest byte
  std::optional<Duration> came_;  ///< used by the caller only
  /// Fault that is not reported yet. The line is not read until it is reported.
  std::optional<Fault> fault_;
  Errand* errand_ = nullptr;
  std::jthread thread_;  ///< last member: uses the others
};

}  // namespace

std::unique_ptr<ByteStream> make_buffered_stream(std::unique_ptr<ByteStream> line) {
  return std::make_unique<PumpedStream>(std::move(line));
}

namespace {

constexpr std::size_t kChunk = 4096;
/// Maximum excess of the gyro's time between two rounds over the host's time between two reads.
constexpr Duration kMostAhead = std::chrono::seconds(1);

/// The bytes received in one read.
class HeardBytes {
 public:
  void begin() { *this = {}; }
  void add(std::span<const std::byte> bytes) {
    for (const auto byte : bytes.first(std::min(bytes.size(), kFirst - std::min(kFirst, all_))))
      first_ += fmt::format("{}{:02X}", first_.empty() ? "" : " ", static_cast<unsigned>(byte));
    all_ += bytes.size();
  }
  [[nodiscard]] std::size_t size() const { return all_; }
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  static constexpr std::size_t kFirst = 16;
  std::size_t all_{};
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
    if (auto alive = line_->write({}, within_); !alive || open_) return alive;
    for (const auto& command : commands_.start)
      if (auto done = send(command); !done) return done;
    open_ = true;
    if (!commands_.start.empty()) start_afresh();
    return {};
  }

  Result<void> wait_for_origin() override {
    takes_origin_ = true;
    auto taken = take(kSecond);
    takes_origin_ = false;
    return taken.map([](const MaybeCount&) {});
  }

  Result<GyroCount> read(Duration expected) override {
    auto count = take(expected);
    if (!count) return failure(count.error());
    if (!*count) return failure(FaultKind::corrupted, place(), "its counter restarted; the counts before are lost");
    return std::move(**count);
  }

  FrameCount frames() const override { return frames_; }

  std::uint64_t breaks() const override { return breaks_; }

  Result<std::string> identify() override {
    if (!commands_.identity) return std::string();
    const auto answer = query_identity(*commands_.identity, *line_, within_, clock_);
    start_afresh();
    if (!answer) return failure(answer.error());
    if (answer->empty() && has_identity_)
      return failure(FaultKind::timeout, place(),
                     fmt::format("no answer to \"{}\"", first_line(commands_.identity->send)));
    has_identity_ = !answer->empty();
    return answer->empty() ? std::string() : fmt::format("{} {}", format_.name, *answer);
  }

 private:
  [[nodiscard]] Result<void> send(const GyroCommand& command) {
    auto sent = send_command(command, format_, *line_, within_, clock_);
    if (!sent && sent.error().where.empty()) sent.error().where = place();
    return sent;
  }

  /// Count of a read; empty if the frames of the read only provide the origin.
  using MaybeCount = std::optional<GyroCount>;

  [[nodiscard]] Result<MaybeCount> take(Duration expected) {
    if (!open_ && !commands_.start.empty())
      if (auto opened = open(); !opened) return failure(std::move(opened.error()));
    FrameTally tally;
    means_.begin();
    heard_.begin();
    rejected_before_ = decoder_.rejected_bytes();
    auto count = take(expected, tally);
    frames_.lost += tally.lost;
    frames_.bad += tally.bad;
    const auto kind = count ? FaultKind::corrupted : count.error().kind;
    if (kind == FaultKind::timeout || kind == FaultKind::disconnected) open_ = false;
    return count;
  }

  [[nodiscard]] Result<MaybeCount> take(Duration expected, FrameTally& tally) {
    const Deadline deadline(within_, clock_);
    const bool first = !sum_.has_origin();
    const auto seen = frames_.seen;
    bool enough = false;
    while (true) {
      const auto more = take_chunk(enough ? Duration::zero() : deadline.left(), tally);
      if (!more) {
        if (more.error().kind == FaultKind::timeout && (enough || tally.rounds > 0)) return conclude(tally, first);
        const auto what =
            more.error().kind == FaultKind::timeout ? explain_missing_count(frames_.seen - seen) : std::string();
        start_afresh();
        if (what.empty()) return failure(more.error());
        open_ = false;  // the gyro may have restarted
        return failure(FaultKind::corrupted, place(), what);
      }
      enough = first ? sum_.has_origin() : covers(tally, expected);
      if (enough && !*more) return conclude(tally, first);
      if (!deadline.over()) continue;
      if (tally.rounds > 0) return conclude(tally, first);
      const auto what = explain_missing_count(frames_.seen - seen);
      start_afresh();
      open_ = false;
      return failure(FaultKind::corrupted, place(), what.empty() ? "no complete frame" : what);
    }
  }

  /// Explains why a read produced no count: no frame has all axes, or the bytes are not frames. Returns an empty text
  /// if fewer bytes than a frame arrived and none was rejected. `frames` is the number of frames in the read.
  [[nodiscard]] std::string explain_missing_count(std::uint64_t frames) const {
    const auto wait_s = to_seconds(within_);
    if (frames > 0)
      return fmt::format("{} frames received in {:.1f} s, but none with all axes: is another message selected?", frames,
                         wait_s);
    const auto rejected = decoder_.rejected_bytes() - rejected_before_;
    if (rejected == 0 && heard_.size() < format_.length) return {};
    return fmt::format(
        "{} bytes received in {:.1f} s, but no frame of this stream ({} bytes rejected; first bytes: {}): check "
        "the baud rate and the stream file",
        heard_.size(), wait_s, rejected, heard_.first());
  }

  /// Decodes the available bytes. Returns true if more bytes may be available already.
  [[nodiscard]] Result<bool> take_chunk(Duration within, FrameTally& tally) {
    std::array<std::byte, kChunk> chunk;
    const auto size = line_->read(chunk, within);
    if (!size) return failure(size.error());
    const auto came = clock_ ? clock_->now().since_start : line_->came().value_or(steady_time());
    const auto rejected = decoder_.rejected_bytes();
    const bool first = !sum_.has_origin();
    const auto lost = tally.lost;
    const auto rounds = tally.rounds;
    heard_.add(std::span(chunk).first(*size));
    decoder_.feed(std::span(chunk).first(*size));
    while (const auto* frame = decoder_.take()) {
      if (auto differ = decoder_.differing_settings()) differing_settings_ = std::move(*differ);
      if (sum_.has_origin()) means_.add(*frame);
      sum_.add(*frame, tally);
      ++frames_.seen;
    }
    if (tally.rounds > rounds || (first && sum_.has_origin())) came_ = came;
    const auto false_bytes = decoder_.rejected_bytes() - rejected;
    if (!first && counts_false_bytes())
      tally.lost = std::max(tally.lost, lost + (false_bytes + format_.length - 1) / format_.length);
    return *size == kChunk;
  }

  /// Returns whether the read is long enough. If the device has a clock, up to half a round may be missing, because the
  /// next round would exceed `expected` by at least as much. If not, half of `expected` by the host's clock is enough.
  /// A short read can then compensate for a late one before it, and every interval is long compared with the delays of
  /// the line.
  [[nodiscard]] bool covers(const FrameTally& tally, Duration expected) const {
    if (tally.rounds == 0) return false;
    if (sum_.has_clock()) return tally.interval + tally.round / 2 >= expected;
    return arrivals_.passed(came_) >= expected / 2;
  }

  /// Properties of the frames of one read.
  struct Findings {
    std::string other_rate{};
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

  /// Ends a read: evaluates its frames, prepares the next read, and returns the count or the fault. `first` means that
  /// the frames contain the origin. Sets `tally.lost` to the number of lost frames.
  [[nodiscard]] Result<MaybeCount> conclude(FrameTally& tally, bool first) {
    const auto found = judge(tally, first);
    tally.lost = found.lost;
    prepare_next_read(found, tally, first);
    if (auto fault = fault_of(found)) return failure(std::move(*fault));
    return count_frames(tally, first);
  }

  [[nodiscard]] Findings judge(const FrameTally& tally, bool first) const {
    Findings found{.other_rate = steady_other_rate(),
                   .time_jumped = !first && tally.longest > came_ - came_before_ + kMostAhead,
                   .is_disordered = tally.disordered,
                   .lost = tally.lost,
                   .bad = tally.bad};
    // No losses: another frame rate, a gap before the origin, a jump of the only clock that shows gaps.
    const bool jump_hides_losses = found.time_jumped && !format_.find(FieldRole::sequence);
    if (!found.other_rate.empty() || takes_origin_ || jump_hides_losses) found.lost = 0;
    return found;
  }

  /// Sets the origin of the next read. If the gyro may have restarted, the next read sends the start commands.
  void prepare_next_read(const Findings& found, const FrameTally& tally, bool first) {
    came_before_ = came_;
    const bool is_doubtful = found.has_gap() || found.bad > 0;
    if (is_doubtful) sum_.drop_round();
    if (first || is_doubtful) arrivals_.count_from(came_);
    if (first || found.has_gap())
      pace_.count_from(came_);
    else
      pace_.add(tally.interval, came_);
    if (!found.may_have_restarted()) return;
    ++breaks_;
    open_ = open_ && commands_.start.empty();
  }

  /// Returns the most severe fault of the frames of a read, or nothing if they can be counted.
  [[nodiscard]] std::optional<Fault> fault_of(const Findings& found) const {
    const auto fault = [this](FaultKind kind, std::string what) { return Fault{kind, place(), std::move(what)}; };
    if (!differing_settings_.empty())
      return fault(FaultKind::mismatch, fmt::format("{}", fmt::join(differing_settings_, "; ")));
    if (!found.other_rate.empty()) return fault(FaultKind::mismatch, found.other_rate);
    if (found.is_disordered)
      return fault(FaultKind::corrupted,
                   "a frame was received twice, or its frame counter restarted; the number of lost frames is unknown");
    if (found.time_jumped) return fault(FaultKind::corrupted, "its clock jumped: it was set or restarted");
    if (found.lost > 0)
      return fault(FaultKind::corrupted,
                   fmt::format("{} frames lost{}", found.lost,
                               sum_.steps().is_always_other() ? ", or it is set to another rate" : ""));
    if (found.bad > 0)
      return fault(FaultKind::out_of_range, fmt::format("{} frames are marked bad by the gyro", found.bad));
    if (auto why = other_time(); !why.empty()) return fault(FaultKind::mismatch, std::move(why));
    return std::nullopt;
  }

  /// Returns the count of frames without a fault, or nothing if they only provide the origin. Without a device clock,
  /// the first read has no interval, because the host only knows the arrival time of the newest frame.
  [[nodiscard]] Result<MaybeCount> count_frames(const FrameTally& tally, bool first) {
    if (tally.rounds == 0) return std::nullopt;
    if (sum_.has_clock()) return count_of(tally, tally.interval);
    if (first) return std::nullopt;
    return count_by_host_clock(tally);
  }

  /// Describes the frame rate if the steps between frames are constant and differ from the described ones. Otherwise
  /// returns an empty text.
  [[nodiscard]] std::string steady_other_rate() const {
    const auto step = sum_.steps().other_step();
    if (!step) return {};
    if (format_.rate_hz <= 0) return fmt::format("its frame counter advances by {:g} times the described step", *step);
    return other_rate(format_.rate_hz / *step);
  }

  [[nodiscard]] std::string other_rate(double rate_hz) const {
    return fmt::format(
        "it sends {:.1f} frames a second, its description says {:g}; set the unit, or rate_hz in the rig file's [gyro]",
        rate_hz, format_.rate_hz);
  }

  /// Describes a difference between the gyro's and the host's time; empty if they agree. For time stamps, a factor of
  /// two or more is a difference. A wrong unit changes the time by a factor of ten or more, and a simulated gyro may
  /// deviate by less.
  [[nodiscard]] std::string other_time() const {
    constexpr double kOtherUnit = 2;
    const auto pace = pace_.other_pace();
    if (!pace || !sum_.has_clock()) return {};
    if (format_.clocked_by_sequence) return other_rate(*pace * format_.rate_hz);
    if (std::max(*pace, 1 / *pace) < kOtherUnit) return {};
    return fmt::format("{:.3g} s of its time stamps pass per second; check their unit in the stream file", *pace);
  }

  [[nodiscard]] Result<MaybeCount> count_by_host_clock(const FrameTally& tally) {
    if (const auto interval = arrivals_.next(tally.rounds, came_)) return count_of(tally, *interval);
    restart_count();
    return failure(
        FaultKind::corrupted, place(),
        fmt::format("{} frames do not match the time in which they arrived: some were lost or late", tally.rounds));
  }

  [[nodiscard]] GyroCount count_of(const FrameTally& tally, Duration interval) const {
    return {sum_.counts(tally, interval), interval, means_.values()};
  }

  /// Returns whether rejected bytes count as lost frames: neither the sequence nor the device's time shows losses, or a
  /// lock replaces the sync.
  [[nodiscard]] bool counts_false_bytes() const {
    const bool timed = format_.rate_hz > 0 && sum_.has_clock();
    return format_.lock_frames > 0 || (!format_.find(FieldRole::sequence) && !timed);
  }

  void start_afresh() {
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
  bool takes_origin_ = false;
  bool has_identity_ = false;  ///< has sent its identity before
  std::uint64_t breaks_ = 0;
  HeardBytes heard_;  ///< in this read
  /// Rejected bytes before this read.
  std::uint64_t rejected_before_{};
  /// Differences in the newest configuration message.
  std::vector<std::string> differing_settings_;
  FrameDecoder decoder_;
  FrameSum sum_;
  FrameMeans means_;
  /// Arrival of the newest round, by the host's clock.
  Duration came_{};
  /// Arrival of the last round of the previous read.
  Duration came_before_{};
  /// Used if the format has no device clock.
  HostInterval arrivals_;
  /// Used if the format has a device clock.
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
