#include "drivers/framed_gyro.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "drivers/deadline.hpp"

namespace gyrotherm {

namespace {

constexpr std::size_t kChunk = 4096;

std::uint64_t range_of(FieldType type) { return std::uint64_t{1} << 8 * byte_count(type); }

/// How far a counter of `range` values went from `before` to `now`.
std::uint64_t forward(std::uint64_t before, std::uint64_t now, std::uint64_t range) {
  return (now - before) & (range - 1);
}

/// The same for an up–down counter: the shorter way round.
std::int64_t signed_step(std::int64_t before, std::int64_t now, std::uint64_t range) {
  const auto step = forward(static_cast<std::uint64_t>(before), static_cast<std::uint64_t>(now), range);
  return static_cast<std::int64_t>(step) - (step < range / 2 ? 0 : static_cast<std::int64_t>(range));
}

/// What was seen since the last read.
struct Tally {
  std::int64_t pulses{};
  std::uint64_t ticks{};        ///< of the device's clock
  std::uint64_t frame_ticks{};  ///< between the last two frames
  std::uint64_t frames{};       ///< after the first one ever
  std::uint64_t lost{};
  std::uint64_t bad{};
};

class FramedGyro final : public Gyro {
 public:
  FramedGyro(FrameFormat format, std::unique_ptr<ByteStream> line, Duration within)
      : format_(std::move(format)), line_(std::move(line)), within_(within), decoder_(format_) {}

  Result<void> open() override { return line_->write({}, within_); }
  Result<PulseCount> read(Duration expected) override;

 private:
  [[nodiscard]] Result<bool> take_chunk(Duration within, Tally& tally);
  void count(const GyroFrame& frame, Tally& tally);
  [[nodiscard]] bool covers(const Tally& tally, Duration expected) const;
  [[nodiscard]] Duration device_time(std::uint64_t ticks) const;
  [[nodiscard]] Result<PulseCount> verdict(const Tally& tally, Duration expected) const;
  void start_afresh();
  [[nodiscard]] std::string place() const { return "gyro " + format_.name; }

  FrameFormat format_;
  std::unique_ptr<ByteStream> line_;
  Duration within_;
  FrameDecoder decoder_;
  std::optional<GyroFrame> newest_;
};

void FramedGyro::start_afresh() {
  decoder_ = FrameDecoder(format_);
  newest_.reset();
}

/// Adds what lies between the newest frame and this one, which becomes the newest.
void FramedGyro::count(const GyroFrame& frame, Tally& tally) {
  tally.bad += frame.good ? 0 : 1;
  const auto before = std::exchange(newest_, frame);
  if (!before) return;
  ++tally.frames;
  if (const auto* field = format_.find(FieldRole::sequence))
    tally.lost += forward(*before->sequence + 1, *frame.sequence, range_of(field->type));
  if (const auto* field = format_.find(FieldRole::timestamp)) {
    tally.frame_ticks = forward(*before->timestamp, *frame.timestamp, range_of(field->type));
    tally.ticks += tally.frame_ticks;
  }
  const auto* counter = format_.find(FieldRole::pulse_count);
  tally.pulses += counter ? signed_step(*before->pulses, *frame.pulses, range_of(counter->type)) : *frame.pulses;
}

Duration FramedGyro::device_time(std::uint64_t ticks) const {
  const auto* field = format_.find(FieldRole::timestamp);
  return field ? from_seconds(static_cast<double>(ticks) * field->unit_s) : Duration::zero();
}

/// Half a frame is near enough: the frame that is due next would overshoot by as much.
bool FramedGyro::covers(const Tally& tally, Duration expected) const {
  if (!format_.find(FieldRole::timestamp)) return tally.frames > 0;
  return tally.frames > 0 && device_time(tally.ticks) + device_time(tally.frame_ticks) / 2 >= expected;
}

/// Counts the frames of what has come; true if more may have come already.
Result<bool> FramedGyro::take_chunk(Duration within, Tally& tally) {
  std::array<std::byte, kChunk> chunk;
  const auto size = line_->read(chunk, within);
  if (!size) return failure(size.error());
  const auto rejected = decoder_.rejected_bytes();
  const bool first = !newest_;
  decoder_.feed(std::span(chunk).first(*size));
  while (const auto frame = decoder_.take()) count(*frame, tally);
  if (!first && !format_.find(FieldRole::sequence))
    tally.lost += (decoder_.rejected_bytes() - rejected + format_.length - 1) / format_.length;
  return *size == kChunk;
}

Result<PulseCount> FramedGyro::verdict(const Tally& tally, Duration expected) const {
  if (tally.lost > 0) return failure(FaultKind::corrupted, place(), fmt::format("{} frames lost", tally.lost));
  if (tally.bad > 0)
    return failure(FaultKind::out_of_range, place(), fmt::format("{} frames are marked bad by the gyro", tally.bad));
  if (tally.frames == 0) return PulseCount{};
  return PulseCount{tally.pulses, format_.find(FieldRole::timestamp) ? device_time(tally.ticks) : expected};
}

Result<PulseCount> FramedGyro::read(Duration expected) {
  Tally tally;
  const Deadline deadline(within_);
  const bool first = !newest_;
  bool enough = false;
  while (true) {
    const auto more = take_chunk(enough ? Duration::zero() : deadline.left(), tally);
    if (!more) {
      if (more.error().kind == FaultKind::timeout && (enough || tally.frames > 0)) return verdict(tally, expected);
      start_afresh();
      return failure(more.error());
    }
    enough = first ? newest_.has_value() : covers(tally, expected);
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
