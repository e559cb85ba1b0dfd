// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/text_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "core/deadline.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::size_t kLongestFrame = 4096;
constexpr unsigned char kHighBit = 0x80;

std::string check_characters(const TextFrame& form, std::string_view data) {
  if (form.checksum == FrameChecksum::none) return {};
  if (form.checksum == FrameChecksum::exclusive_or) {
    unsigned char all = 0;
    for (const char byte : data) all ^= static_cast<unsigned char>(byte);
    return {static_cast<char>(form.high_bit ? all | kHighBit : all)};
  }
  unsigned sum = static_cast<unsigned char>(form.begin);
  for (const char byte : data) sum += static_cast<unsigned char>(byte);
  return fmt::format("{:02X}", (form.checksum == FrameChecksum::sum ? sum : 0U - sum) & 0xFFU);
}

std::size_t check_size(const TextFrame& form) {
  if (form.checksum == FrameChecksum::none) return 0;
  return form.checksum == FrameChecksum::exclusive_or ? 1 : 2;
}

/// Returns whether the check byte may be any byte, such as the start or end byte.
bool has_any_check_byte(const TextFrame& form) {
  return form.checksum == FrameChecksum::exclusive_or && !form.high_bit;
}

class FramedStream final : public ByteStream {
 public:
  FramedStream(std::unique_ptr<ByteStream> line, const TextFrame& form, const Clock* clock)
      : line_(std::move(line)), form_(form), clock_(clock) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override {
    const Deadline deadline(within, clock_);
    while (ready_.empty()) {
      std::array<std::byte, 256> bytes;
      const auto size = line_->read(bytes, deadline.left());
      if (!size && size.error().kind == FaultKind::timeout)
        if (auto taken = take_frames(false); !taken) return failure(std::move(taken.error()));
      if (!size) return size;
      received_.append(reinterpret_cast<const char*>(bytes.data()), *size);
      if (auto taken = take_frames(true); !taken) return failure(std::move(taken.error()));
    }
    const auto size = std::min(buffer.size(), ready_.size());
    std::ranges::copy(std::as_bytes(std::span(ready_).first(size)), buffer.begin());
    ready_.erase(0, size);
    return size;
  }

  Result<void> write(std::span<const std::byte> bytes, Duration within) override {
    received_.clear();
    const auto frame = to_frame(form_, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    return line_->write(std::as_bytes(std::span(frame)), within);
  }

  void end_rest() override { line_->end_rest(); }

 private:
  /// Returns the text of the frame that ends at `end`, or nothing if it is not valid.
  [[nodiscard]] std::optional<std::string> find_text(std::size_t end) const {
    const auto bytes = std::string_view(received_).substr(0, end + 1);
    auto begin = bytes.rfind(form_.begin);
    const bool may_be_check = has_any_check_byte(form_) && begin != std::string::npos && begin + 1 == end && begin > 0;
    if (may_be_check) begin = bytes.rfind(form_.begin, begin - 1);
    return begin == std::string::npos ? std::nullopt : from_frame(form_, bytes.substr(begin));
  }

  /// Takes the complete frames. An end byte that is the last byte received may be a check byte that the end byte
  /// follows; unless nothing `follows`, the frame is then not complete.
  Result<void> take_frames(bool follows) {
    for (auto end = received_.find(form_.end); end != std::string::npos; end = received_.find(form_.end)) {
      const bool has_begin = received_.rfind(form_.begin, end) != std::string::npos;
      auto text = has_begin ? find_text(end) : std::nullopt;
      if (has_begin && !text && has_any_check_byte(form_)) {
        const auto next = end + 1;
        if (next == received_.size() && follows) break;
        if (next < received_.size() && received_[next] == form_.end) text = find_text(next);
        if (text) end = next;
      }
      received_.erase(0, end + 1);
      if (!has_begin) continue;
      if (!text) return failure(FaultKind::corrupted, "", "wrong checksum in the answer");
      ready_ += *text + frame_terminator(form_);
    }
    if (received_.size() <= kLongestFrame) return {};
    received_.clear();
    return failure(FaultKind::corrupted, "",
                   fmt::format("no end of frame in {} bytes; check the link settings", kLongestFrame));
  }

  std::unique_ptr<ByteStream> line_;
  TextFrame form_;
  const Clock* clock_;
  std::string received_, ready_;
};

}  // namespace

std::string describe_ambiguity(const TextFrame& form) {
  if (form.begin == form.end) return "the start and end byte are the same, so that the end of a frame cannot be found";
  if (has_any_check_byte(form) && form.end == '\0')
    return "with the end byte 0, the check byte of \"xor\" may end a frame that is one byte too short";
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  const bool has_digits = form.checksum == FrameChecksum::negated_sum || form.checksum == FrameChecksum::sum;
  for (const char byte : {form.begin, form.end})
    if (has_digits && kDigits.find(byte) != std::string_view::npos)
      return fmt::format("the byte {}, the digit {}, occurs in the checksum too", static_cast<int>(byte), byte);
  return {};
}

char frame_terminator(const TextFrame& form) {
  return form.high_bit ? static_cast<char>(static_cast<unsigned char>(form.end) | kHighBit) : form.end;
}

std::string to_frame(const TextFrame& form, std::string_view text) {
  std::string data(text);
  if (form.high_bit)
    for (char& byte : data) byte = static_cast<char>(static_cast<unsigned char>(byte) | kHighBit);
  return form.begin + data + check_characters(form, data) + form.end;
}

std::optional<std::string> from_frame(const TextFrame& form, std::string_view frame) {
  const auto check = check_size(form);
  if (frame.size() < 2 + check || frame.front() != form.begin || frame.back() != form.end) return std::nullopt;
  const auto data = frame.substr(1, frame.size() - 2 - check);
  if (frame.substr(1 + data.size(), check) != check_characters(form, data)) return std::nullopt;
  std::string text(data);
  if (form.high_bit)
    for (char& byte : text) {
      if ((static_cast<unsigned char>(byte) & kHighBit) == 0) return std::nullopt;
      byte = static_cast<char>(static_cast<unsigned char>(byte) & ~kHighBit);
    }
  return text;
}

std::unique_ptr<ByteStream> make_framed_stream(std::unique_ptr<ByteStream> line, const TextFrame& form,
                                               const Clock* clock) {
  return std::make_unique<FramedStream>(std::move(line), form, clock);
}

}  // namespace gyrotherm::drivers
