#include <algorithm>
#include <cassert>
#include <utility>

#include "drivers/gyro/frame_format.hpp"
#include "drivers/gyro/frame_values.hpp"

namespace gyrotherm {

namespace {

constexpr std::size_t kTakenBytesWorthMoving = 4096;

/// What the bytes at one place are.
struct Finding {
  enum { nothing, more, frame } kind = nothing;  ///< no frame begins here; too few bytes to tell; a whole good one
  FrameView view{};
};

const FrameVariant* variant_of(const FrameFormat& format, std::uint32_t id) {
  const auto& all = format.variants;
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& variant) { return variant.id == id; });
  return found == all.end() ? nullptr : &*found;
}

Finding find_frame(const FrameFormat& format, std::span<const std::byte> bytes) {
  const auto known = std::min(format.sync.size(), bytes.size());
  if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(known), format.sync.begin())) return {};
  std::size_t head = format.sync.size();
  for (const auto& number : {format.id, format.length_at})
    if (number) head = std::max(head, number->offset + number->bytes);
  if (bytes.size() < head) return {.kind = Finding::more};

  const auto number = [&](const HeadNumber& at) {
    return static_cast<std::uint32_t>(load_bits(bytes.subspan(at.offset, at.bytes), at.big_endian));
  };
  FrameView view;
  std::size_t length = format.length;
  const FrameCheck* check = &format.check;
  if (format.length_at) {
    const auto told = std::size_t{number(*format.length_at)} + format.length_plus;
    if (told > format.length || told < head) return {};
    length = told;
  }
  if (format.id) {
    view.id = number(*format.id);
    const auto* variant = variant_of(format, *view.id);
    if (!variant && !format.variants.empty() && !format.length_at) return {};
    if (variant && variant->length != 0 && format.length_at && variant->length != length) return {};
    if (variant && variant->length != 0) length = variant->length;
    if (variant && variant->check) check = &*variant->check;
  }
  if (bytes.size() < length) return {.kind = Finding::more};
  view.bytes = bytes.first(length);
  if (!passes(*check, view.bytes) || is_refuted(format, view)) return {};
  return {.kind = Finding::frame, .view = std::move(view)};
}

bool follows(const FrameFormat& format, std::optional<std::uint32_t> before, std::optional<std::uint32_t> now) {
  const auto* field = format.find(FieldRole::sequence);
  if (!field || !before || !now) return true;
  const auto next = *before + field->step;
  return *now == (field->range == 0 ? next : next % field->range);
}

/// The first of `format.lock_frames` more that all fit, one behind the other.
Finding find_run(const FrameFormat& format, std::span<const std::byte> bytes) {
  auto first = find_frame(format, bytes);
  auto before = first;
  for (std::size_t i = 0, end = 0; i < format.lock_frames && before.kind == Finding::frame; ++i) {
    end += before.view.bytes.size();
    auto next = find_frame(format, bytes.subspan(end));
    if (next.kind == Finding::frame &&
        !follows(format, sequence_of(format, before.view), sequence_of(format, next.view)))
      return {};
    before = std::move(next);
  }
  return before.kind == Finding::frame ? first : Finding{.kind = before.kind};
}

}  // namespace

FrameDecoder::FrameDecoder(FrameFormat format) : format_(std::move(format)) {
  assert(format_.line || (format_.length > 0 && format_.sync.size() <= format_.length));
}

void FrameDecoder::feed(std::span<const std::byte> bytes) {
  if (begin_ == buffer_.size() || begin_ > kTakenBytesWorthMoving) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

void FrameDecoder::reject(std::size_t bytes) {
  begin_ += bytes;
  rejected_ += bytes;
  locked_ = false;
}

std::optional<GyroFrame> FrameDecoder::take() { return format_.line ? take_line() : take_bytes(); }

std::optional<GyroFrame> FrameDecoder::take_bytes() {
  while (begin_ < buffer_.size()) {
    const auto bytes = waiting();
    const bool tail = locked_ && !format_.tail.empty() && bytes.size() >= format_.tail.size() &&
                      std::equal(format_.tail.begin(), format_.tail.end(), bytes.begin());
    if (tail) {
      begin_ += format_.tail.size();
      continue;
    }
    const bool believed = locked_ || format_.lock_frames == 0;
    const auto found = believed ? find_frame(format_, bytes) : find_run(format_, bytes);
    if (found.kind == Finding::more) return std::nullopt;
    if (found.kind == Finding::nothing) {
      reject(1);
      continue;
    }
    const auto sequence = sequence_of(format_, found.view);
    if (format_.lock_frames > 0 && locked_ && !follows(format_, sequence_, sequence)) {
      locked_ = false;
      continue;
    }
    locked_ = true;
    sequence_ = sequence;
    begin_ += found.view.bytes.size();
    return decode_frame(format_, found.view, values_);
  }
  return std::nullopt;
}

std::optional<GyroFrame> FrameDecoder::take_line() {
  const auto& line = *format_.line;
  while (const auto end = find_terminator(line, waiting())) {
    const auto size = *end + line.terminator.size();
    const auto bytes = waiting().first(*end);
    const bool whole = locked_ || (!line.starts_with.empty() && format_.check.kind != CheckKind::none);
    FrameView view;
    if (auto words = split_line(line, format_.check, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}))
      view.words = std::move(*words);
    const bool fits = whole && size <= line.longest && !view.words.empty() && !is_refuted(format_, view);
    if (!fits) reject(size);
    begin_ += fits ? size : 0;
    locked_ = true;
    if (fits) return decode_frame(format_, view, values_);
  }
  if (waiting().size() > line.longest) reject(waiting().size() - line.longest);
  return std::nullopt;
}

std::vector<std::string> FrameDecoder::complaints() const {
  std::vector<std::string> found;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (!values_[i]) continue;
    if (format_.fields[i].role != FieldRole::status) continue;
    const bool fits = *values_[i] >= 0 && *values_[i] < 4294967296.0;
    const auto status = fits ? static_cast<std::uint32_t>(*values_[i]) : 0xFFFFFFFF;
    for (const auto& rule : format_.fields[i].rules)
      if ((status & rule.mask) != rule.good) found.push_back(rule.meaning);
  }
  return found;
}

}  // namespace gyrotherm
