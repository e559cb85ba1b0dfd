#include "drivers/gyro/framed_gyro.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "drivers/gyro/frame_sum.hpp"
#include "drivers/line/deadline.hpp"

namespace gyrotherm {

namespace {

constexpr std::size_t kChunk = 4096;

/// A command's first line, for people.
std::string_view first_line(std::string_view text) { return text.substr(0, text.find_first_of("\r\n")); }

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
        sum_(format_) {}
  ~FramedGyro() override;
  FramedGyro(const FramedGyro&) = delete;
  FramedGyro& operator=(const FramedGyro&) = delete;

  Result<void> open() override;
  Result<void> take_origin() override;
  Result<PulseCount> read(Duration expected) override;
  FrameCount frames() const override { return frames_; }

 private:
  [[nodiscard]] Result<void> send(const GyroCommand& command);
  /// Nothing: a frame to count from, and no more.
  using MaybeCount = std::optional<PulseCount>;
  [[nodiscard]] Result<MaybeCount> take(Duration expected);
  [[nodiscard]] Result<MaybeCount> take(Duration expected, FrameTally& tally);
  [[nodiscard]] Result<bool> take_chunk(Duration within, FrameTally& tally);
  [[nodiscard]] bool covers(const FrameTally& tally, Duration expected) const;
  [[nodiscard]] Result<MaybeCount> verdict(const FrameTally& tally, Duration expected) const;
  [[nodiscard]] bool counts_false_bytes() const;
  void start_afresh();
  [[nodiscard]] std::string place() const { return "gyro " + format_.name; }

  FrameFormat format_;
  std::unique_ptr<ByteStream> line_;
  Duration within_;
  GyroCommands commands_;
  const Clock* clock_;
  bool open_ = false;
  FrameDecoder decoder_;
  FrameSum sum_;
  FrameCount frames_;
};

FramedGyro::~FramedGyro() {
  if (!open_) return;
  for (const auto& command : commands_.stop) (void)send(command);
}

/// What comes while it is waited for is no frame of this stream yet.
Result<void> FramedGyro::send(const GyroCommand& command) {
  if (auto sent = line_->write(std::as_bytes(std::span(command.send)), within_); !sent) return sent;
  std::string heard;
  std::array<std::byte, kChunk> chunk;
  for (const Deadline deadline(command.wait, clock_); !deadline.over();) {
    const auto size = line_->read(chunk, deadline.left());
    if (!size && size.error().kind == FaultKind::timeout) break;
    if (!size) return failure(size.error());
    heard.append(reinterpret_cast<const char*>(chunk.data()), *size);
    if (!command.reply.empty() && heard.find(command.reply) != std::string::npos) return {};
  }
  if (command.reply.empty()) return {};
  const auto waited = std::chrono::duration_cast<std::chrono::milliseconds>(command.wait);
  return failure(
      FaultKind::timeout, place(),
      fmt::format("no reply \"{}\" to \"{}\" in {} ms", command.reply, first_line(command.send), waited.count()));
}

Result<void> FramedGyro::open() {
  if (auto alive = line_->write({}, within_); !alive || open_) return alive;
  for (const auto& command : commands_.start)
    if (auto done = send(command); !done) return done;
  open_ = true;
  if (!commands_.start.empty()) start_afresh();
  return {};
}

void FramedGyro::start_afresh() {
  decoder_ = FrameDecoder(format_);
  sum_ = FrameSum(format_);
}

/// Half a frame is near enough: the frame that is due next would overshoot by as much.
bool FramedGyro::covers(const FrameTally& tally, Duration expected) const {
  if (!sum_.has_clock()) return tally.frames > 0;
  return tally.frames > 0 && tally.interval + tally.frame / 2 >= expected;
}

/// Where neither a sequence nor the device's time tells of lost frames, or where so few counts do that a gap may hide.
bool FramedGyro::counts_false_bytes() const {
  const bool timed = format_.rate_hz > 0 && sum_.has_clock();
  return format_.lock_frames > 0 || (!format_.find(FieldRole::sequence) && !timed);
}

/// Counts the frames of what has come; true if more may have come already.
Result<bool> FramedGyro::take_chunk(Duration within, FrameTally& tally) {
  std::array<std::byte, kChunk> chunk;
  const auto size = line_->read(chunk, within);
  if (!size) return failure(size.error());
  const auto rejected = decoder_.rejected_bytes();
  const bool first = !sum_.has_origin();
  const auto lost = tally.lost;
  decoder_.feed(std::span(chunk).first(*size));
  while (const auto frame = decoder_.take()) {
    sum_.add(*frame, tally);
    ++frames_.seen;
  }
  const auto false_bytes = decoder_.rejected_bytes() - rejected;
  if (!first && counts_false_bytes())
    tally.lost = std::max(tally.lost, lost + (false_bytes + format_.length - 1) / format_.length);
  return *size == kChunk;
}

Result<FramedGyro::MaybeCount> FramedGyro::verdict(const FrameTally& tally, Duration expected) const {
  if (tally.lost > 0) return failure(FaultKind::corrupted, place(), fmt::format("{} frames lost", tally.lost));
  if (tally.bad > 0)
    return failure(FaultKind::out_of_range, place(), fmt::format("{} frames are marked bad by the gyro", tally.bad));
  if (tally.frames == 0) return std::nullopt;
  const auto interval = sum_.has_clock() ? tally.interval : expected;
  return PulseCount{sum_.counts(tally, interval), interval};
}

Result<void> FramedGyro::take_origin() {
  return take(kSecond).map([](const MaybeCount&) {});
}

Result<PulseCount> FramedGyro::read(Duration expected) {
  const auto count = take(expected);
  if (!count) return failure(count.error());
  if (!*count)
    return failure(FaultKind::corrupted, place(), "its count begins anew; what it counted before is not known");
  return **count;
}

Result<FramedGyro::MaybeCount> FramedGyro::take(Duration expected) {
  if (!open_ && !commands_.start.empty())
    if (auto opened = open(); !opened) return failure(std::move(opened.error()));
  FrameTally tally;
  auto count = take(expected, tally);
  frames_.lost += tally.lost;
  frames_.bad += tally.bad;
  const auto kind = count ? FaultKind::corrupted : count.error().kind;
  if (kind == FaultKind::timeout || kind == FaultKind::disconnected) open_ = false;
  return count;
}

Result<FramedGyro::MaybeCount> FramedGyro::take(Duration expected, FrameTally& tally) {
  const Deadline deadline(within_, clock_);
  const bool first = !sum_.has_origin();
  bool enough = false;
  while (true) {
    const auto more = take_chunk(enough ? Duration::zero() : deadline.left(), tally);
    if (!more) {
      if (more.error().kind == FaultKind::timeout && (enough || tally.frames > 0)) return verdict(tally, expected);
      start_afresh();
      return failure(more.error());
    }
    enough = first ? sum_.has_origin() : covers(tally, expected);
    if (enough && !*more) return verdict(tally, expected);
    if (!deadline.over()) continue;
    if (tally.frames > 0) return verdict(tally, expected);
    start_afresh();
    return failure(FaultKind::corrupted, place(), "bytes come, but no good frame");
  }
}

}  // namespace

std::unique_ptr<Gyro> make_framed_gyro(FrameFormat format, std::unique_ptr<ByteStream> line, Duration within,
                                       GyroCommands commands, const Clock* clock) {
  return std::make_unique<FramedGyro>(std::move(format), std::move(line), within, std::move(commands), clock);
}

}  // namespace gyrotherm
