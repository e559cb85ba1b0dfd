// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {
namespace {

std::span<const std::byte> text_bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

bool is_check_text_valid(const FrameCheck& check, std::string_view covered, std::string_view digits) {
  const auto from = static_cast<std::size_t>(check.from);
  if (digits.size() != 2 * byte_count(check) || covered.size() <= from) return false;
  std::uint32_t stored{};
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), stored, 16);
  if (error != std::errc{} || end != digits.data() + digits.size()) return false;
  return stored == compute_check_value(check, text_bytes(covered.substr(from)));
}

std::vector<std::string_view> split_tokens(const LineFormat& format, std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t begin = 0; begin <= line.size();) {
    const auto end = std::min(line.find_first_of(format.separators, begin), line.size());
    if (end > begin || !format.merges) words.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

/// Splits a line into its tokens. Returns no tokens if the header has a different number of tokens than described.
std::vector<std::string_view> split_with_header(const LineFormat& format, std::string_view line) {
  if (format.header_words == 0) return split_tokens(format, line);
  const auto end = line.find(format.header_end);
  if (end == std::string_view::npos) return {};
  auto words = split_tokens(format, line.substr(0, end));
  if (words.size() != format.header_words) return {};
  const auto others = split_tokens(format, line.substr(end + format.header_end.size()));
  words.insert(words.end(), others.begin(), others.end());
  return words;
}

/// Returns the position of the first terminator.
std::optional<std::size_t> find_terminator(const LineFormat& format, std::span<const std::byte> bytes) {
  const auto wanted = text_bytes(format.terminator);
  const auto found = std::search(bytes.begin(), bytes.end(), wanted.begin(), wanted.end());
  if (found == bytes.end()) return std::nullopt;
  return static_cast<std::size_t>(found - bytes.begin());
}

/// Splits a line, given without its terminator, into tokens that refer to `line`. Returns nothing if its start or
/// number of tokens differs from the format, or if the check fails.
std::optional<std::vector<std::string_view>> split_line(const LineFormat& format, const FrameCheck& check,
                                                        std::string_view line) {
  if (!line.starts_with(format.starts_with)) return std::nullopt;
  if (check.kind != CheckKind::none) {
    const auto mark = line.rfind(format.mark);
    if (mark == std::string_view::npos) return std::nullopt;
    if (!is_check_text_valid(check, line.substr(0, mark), line.substr(mark + format.mark.size()))) return std::nullopt;
    line = line.substr(0, mark);
  }
  auto words = split_with_header(format, line);
  if (words.size() != format.words) return std::nullopt;
  if (!format.starts_with.empty() && words.front() != format.starts_with) return std::nullopt;
  return words;
}

/// A complete frame, as bytes or tokens in the caller's buffer.
struct FrameView {
  std::span<const std::byte> bytes{};
  std::vector<std::string_view> words{};
  std::optional<std::uint32_t> id{};
};

constexpr double kMaxTime = 9.2e18;  // below 2^63

/// Returns the lower 32 bits of a status, those that the masks of its rules can select.
std::uint32_t status_bits(const RawValue& raw) { return static_cast<std::uint32_t>(raw.whole); }

void apply_status(const FrameField& field, std::uint32_t status, GyroFrame& frame) {
  bool good = (status & field.mask) == field.good, flagged = !good;
  for (const auto& rule : field.rules) {
    if (is_satisfied(rule, status)) continue;
    flagged = true;
    good = good && rule.verdict != StatusMeaning::invalid;
  }
  frame.good = frame.good && good;
  frame.flagged = frame.flagged || flagged;
}

std::optional<std::uint64_t> timestamp_counts(const FrameField& field, const RawValue& raw) {
  if (!raw.is_real) return static_cast<std::uint64_t>(raw.whole);
  const double counts = apply_scale(field, raw) / field.unit_s;
  if (!(counts >= 0 && counts < kMaxTime)) return std::nullopt;
  return static_cast<std::uint64_t>(std::llround(counts));
}

void store_gyro(const FrameField& field, const RawValue& raw, double value, GyroFrame& frame) {
  auto& axis = frame.axes[field.slot];
  if (!raw.is_real) axis.pulses = raw.whole;
  if (std::isfinite(value)) axis.value = value;
  frame.good = frame.good && std::isfinite(value);
}

void store_field(const FrameField& field, const RawValue& raw, double value, GyroFrame& frame) {
  switch (field.role) {
    case FieldRole::pulse_count:
    case FieldRole::increment:
    case FieldRole::rate:
    case FieldRole::integrated_angle: store_gyro(field, raw, value, frame); break;
    case FieldRole::sequence: frame.sequence = sequence_number(field, raw); break;
    case FieldRole::timestamp: frame.timestamp = timestamp_counts(field, raw); break;
    case FieldRole::status: apply_status(field, status_bits(raw), frame); break;
    case FieldRole::temperature:
    case FieldRole::value:
      if (is_housekeeping(field) && std::isfinite(value)) frame.values[field.slot] = value;
      break;
    case FieldRole::other_axis: break;
  }
}

/// Returns the raw value of a field, or nothing if this message does not contain it or the token is not a number.
std::optional<RawValue> find_raw(const FrameField& field, const FrameView& view) {
  if (!is_in_message(field, view.id)) return std::nullopt;
  if (!is_word(field.type)) return read_raw(field, view.bytes);
  const auto word = static_cast<std::size_t>(field.offset);
  return word < view.words.size() ? parse_token(field, view.words[word]) : std::nullopt;
}

std::optional<std::uint32_t> find_sequence(const FrameFormat& format, const FrameView& view) {
  for (const auto& field : format.fields)
    if (field.role == FieldRole::sequence)
      if (const auto raw = find_raw(field, view)) return sequence_number(field, *raw);
  return std::nullopt;
}

/// Returns true if a status rule with the verdict `reject` is broken, or if a numeric token is not a number.
bool is_rejected(const FrameFormat& format, const FrameView& view) {
  for (const auto& field : format.fields) {
    const auto raw = find_raw(field, view);
    if (!raw && is_word(field.type)) return true;
    if (!raw || field.role != FieldRole::status) continue;
    for (const auto& rule : field.rules)
      if (rule.verdict == StatusMeaning::reject && !is_satisfied(rule, status_bits(*raw))) return true;
  }
  return false;
}

/// Decodes a frame into `frame`, whose lists have the size of the format's, and in the format's order every scaled
/// field into `all` and the bits of every status into `statuses`.
void decode_frame(const FrameFormat& format, const FrameView& view, GyroFrame& frame,
                  std::vector<std::optional<double>>& all, std::vector<std::optional<std::uint32_t>>& statuses) {
  std::fill(frame.axes.begin(), frame.axes.end(), AxisReading{});
  std::fill(frame.values.begin(), frame.values.end(), std::nullopt);
  frame.id = view.id;
  frame.sequence.reset();
  frame.timestamp.reset();
  frame.good = true;
  frame.flagged = false;
  const auto sequence = find_sequence(format, view);
  all.assign(format.fields.size(), std::nullopt);
  statuses.assign(format.fields.size(), std::nullopt);
  for (std::size_t i = 0; i < format.fields.size(); ++i) {
    const auto& field = format.fields[i];
    if (field.every > 1 && (!sequence || *sequence % field.every != field.turn)) continue;
    const auto raw = find_raw(field, view);
    if (!raw) continue;
    const bool is_status = field.role == FieldRole::status;
    all[i] = is_status ? raw->number(is_signed(field.type)) : apply_scale(field, *raw);
    if (is_status) statuses[i] = status_bits(*raw);
    store_field(field, *raw, *all[i], frame);
  }
}

constexpr std::size_t kMinBytesToMove = 4096;

/// Result of examining the bytes at one position.
struct Finding {
  /// No frame begins here; more bytes are needed; or a complete, valid frame.
  enum { nothing, more, frame } kind = nothing;
  FrameView view{};
};

const FrameVariant* find_variant(const FrameFormat& format, std::uint32_t id) {
  const auto& all = format.variants;
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& variant) { return variant.id == id; });
  return found == all.end() ? nullptr : &*found;
}

Finding find_frame(const FrameFormat& format, std::span<const std::byte> bytes) {
  const auto known = std::min(format.sync.size(), bytes.size());
  if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(known), format.sync.begin())) return {};
  const auto head = format.head_size();
  if (bytes.size() < head) return {.kind = Finding::more};

  const auto number = [&](const HeadNumber& at) {
    return static_cast<std::uint32_t>(load_bits(bytes.subspan(at.offset, at.bytes), at.big_endian));
  };
  FrameView view;
  std::size_t length = format.length;
  const FrameCheck* check = &format.check;
  if (format.length_at) {
    const auto stated_length = std::size_t{number(*format.length_at)} + format.length_plus;
    if (stated_length > format.length || stated_length < head) return {};
    length = stated_length;
  }
  if (format.id) {
    view.id = number(*format.id);
    const auto* variant = find_variant(format, *view.id);
    if (!variant && !format.variants.empty() && !format.length_at) return {};
    if (variant && variant->length != 0 && format.length_at && variant->length != length) return {};
    if (variant && variant->length != 0) length = variant->length;
    if (variant && variant->check) check = &*variant->check;
  }
  if (bytes.size() < length) return {.kind = Finding::more};
  view.bytes = bytes.first(length);
  if (!has_valid_check(*check, view.bytes) || is_rejected(format, view)) return {};
  return {.kind = Finding::frame, .view = std::move(view)};
}

bool is_next_frame(const FrameFormat& format, std::optional<std::uint32_t> before, std::optional<std::uint32_t> now) {
  const auto* field = format.find(FieldRole::sequence);
  if (!field || !before || !now) return true;
  const auto next = *before + field->step;
  return *now == (field->range == 0 ? next : next % field->range);
}

/// Finds a frame that is followed by `format.lock_frames` consecutive matching frames.
Finding find_run(const FrameFormat& format, std::span<const std::byte> bytes) {
  auto first = find_frame(format, bytes);
  auto before = first;
  for (std::size_t i = 0, end = 0; i < format.lock_frames && before.kind == Finding::frame; ++i) {
    end += before.view.bytes.size();
    auto next = find_frame(format, bytes.subspan(end));
    if (next.kind == Finding::frame &&
        !is_next_frame(format, find_sequence(format, before.view), find_sequence(format, next.view)))
      return {};
    before = std::move(next);
  }
  return before.kind == Finding::frame ? first : Finding{.kind = before.kind};
}

}  // namespace

FrameDecoder::FrameDecoder(FrameFormat format) : format_(std::move(format)) {
  assert(format_.line || (format_.length > 0 && format_.sync.size() <= format_.length));
  frame_.axes.resize(format_.axes.size());
  frame_.values.resize(format_.values().size());
  for (const auto& field : format_.fields)
    for (const auto& rule : field.rules) has_settings_ = has_settings_ || rule.verdict == StatusMeaning::mismatch;
}

void FrameDecoder::feed(std::span<const std::byte> bytes) {
  if (begin_ == buffer_.size() || begin_ > kMinBytesToMove) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

void FrameDecoder::reject(std::size_t bytes) {
  begin_ += bytes;
  rejected_ += bytes;
  is_locked_ = false;
}

const GyroFrame* FrameDecoder::take() { return format_.line ? take_line() : take_bytes(); }

const GyroFrame* FrameDecoder::take_bytes() {
  while (begin_ < buffer_.size()) {
    const auto bytes = unread();
    const bool has_tail = is_locked_ && !format_.tail.empty() && bytes.size() >= format_.tail.size() &&
                          std::equal(format_.tail.begin(), format_.tail.end(), bytes.begin());
    if (has_tail) {
      begin_ += format_.tail.size();
      continue;
    }
    const bool accepts_single_frame = is_locked_ || format_.lock_frames == 0;
    const auto found = accepts_single_frame ? find_frame(format_, bytes) : find_run(format_, bytes);
    if (found.kind == Finding::more) return nullptr;
    if (found.kind == Finding::nothing) {
      reject(1);
      continue;
    }
    const auto sequence = find_sequence(format_, found.view);
    if (format_.lock_frames > 0 && is_locked_ && !is_next_frame(format_, sequence_, sequence)) {
      is_locked_ = false;
      continue;
    }
    is_locked_ = true;
    sequence_ = sequence;
    begin_ += found.view.bytes.size();
    decode_frame(format_, found.view, frame_, values_, statuses_);
    return &frame_;
  }
  return nullptr;
}

const GyroFrame* FrameDecoder::take_line() {
  const auto& line = *format_.line;
  while (const auto end = find_terminator(line, unread())) {
    const auto size = *end + line.terminator.size();
    const auto bytes = unread().first(*end);
    const bool is_complete = is_locked_ || (!line.starts_with.empty() && format_.check.kind != CheckKind::none);
    FrameView view;
    if (auto words = split_line(line, format_.check, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}))
      view.words = std::move(*words);
    const bool fits = is_complete && size <= line.longest && !view.words.empty() && !is_rejected(format_, view);
    if (!fits) reject(size);
    begin_ += fits ? size : 0;
    is_locked_ = true;
    if (!fits) continue;
    decode_frame(format_, view, frame_, values_, statuses_);
    return &frame_;
  }
  if (unread().size() > line.longest) reject(unread().size() - line.longest);
  return nullptr;
}

std::vector<std::string> FrameDecoder::broken_rules() const {
  std::vector<std::string> found;
  for (std::size_t i = 0; i < statuses_.size(); ++i) {
    if (!statuses_[i]) continue;
    for (const auto& rule : format_.fields[i].rules)
      if (!is_satisfied(rule, *statuses_[i])) found.push_back(rule.meaning);
  }
  return found;
}

std::optional<std::vector<std::string>> FrameDecoder::differing_settings() const {
  std::optional<std::vector<std::string>> found;
  for (std::size_t i = 0; has_settings_ && i < statuses_.size(); ++i) {
    if (!statuses_[i]) continue;
    for (const auto& rule : format_.fields[i].rules) {
      if (rule.verdict != StatusMeaning::mismatch) continue;
      if (!found) found.emplace();
      if (!is_satisfied(rule, *statuses_[i])) found->push_back(rule.meaning);
    }
  }
  return found;
}

}  // namespace gyrotherm::drivers
