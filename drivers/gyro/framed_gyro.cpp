#include "drivers/gyro/framed_gyro.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "drivers/gyro/frame_sum.hpp"
#include "drivers/line/deadline.hpp"

namespace gyrotherm {

namespace {

constexpr std::size_t kChunk = 4096;

class FramedGyro final : public Gyro {
 public:
  FramedGyro(FrameFormat format, std::unique_ptr<ByteStream> line, Duration within)
      : format_(std::move(format)), line_(std::move(line)), within_(within), decoder_(format_), sum_(format_) {}

  Result<void> open() override { return line_->write({}, within_); }
  Result<PulseCount> read(Duration expected) override;

 private:
  [[nodiscard]] Result<bool> take_chunk(Duration within, FrameTally& tally);
  [[nodiscard]] bool covers(const FrameTally& tally, Duration expected) const;
  [[nodiscard]] Result<PulseCount> verdict(const FrameTally& tally, Duration expected) const;
  [[nodiscard]] bool counts_false_bytes() const;
  void start_afresh();
  [[nodiscard]] std::string place() const { return "gyro " + format_.name; }

  FrameFormat format_;
  std::unique_ptr<ByteStream> line_;
  Duration within_;
  FrameDecoder decoder_;
  FrameSum sum_;
};

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
  while (const auto frame = decoder_.take()) sum_.add(*frame, tally);
  const auto false_bytes = decoder_.rejected_bytes() - rejected;
  if (!first && counts_false_bytes())
    tally.lost = std::max(tally.lost, lost + (false_bytes + format_.length - 1) / format_.length);
  return *size == kChunk;
}

Result<PulseCount> FramedGyro::verdict(const FrameTally& tally, Duration expected) const {
  if (tally.lost > 0) return failure(FaultKind::corrupted, place(), fmt::format("{} frames lost", tally.lost));
  if (tally.bad > 0)
    return failure(FaultKind::out_of_range, place(), fmt::format("{} frames are marked bad by the gyro", tally.bad));
  if (tally.frames == 0) return PulseCount{};
  const auto interval = sum_.has_clock() ? tally.interval : expected;
  return PulseCount{sum_.counts(tally, interval), interval};
}

Result<PulseCount> FramedGyro::read(Duration expected) {
  FrameTally tally;
  const Deadline deadline(within_);
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

std::unique_ptr<Gyro> make_framed_gyro(FrameFormat format, std::unique_ptr<ByteStream> line, Duration within) {
  return std::make_unique<FramedGyro>(std::move(format), std::move(line), within);
}

}  // namespace gyrotherm
