/// The trace of gyrotherm-make-safe: a small text beside the record that says when it acted and whether the chamber
/// confirmed it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

inline constexpr std::string_view kMadeSafeSchema = "gyrotherm-made-safe/1";

struct MadeSafe {
  Duration at{};        ///< UTC since 1970
  std::string because;  ///< "the program that drove it has ended", …
  Celsius set_point;
  bool confirmed{};     ///< read back from the chamber
  std::string details;  ///< what the chamber said, or why it could not be reached
  bool operator==(const MadeSafe&) const = default;
};

/// "RUN.db" → "RUN.db.made-safe".
[[nodiscard]] std::string made_safe_path(const std::string& record);

[[nodiscard]] std::string to_text(const MadeSafe& trace);
/// Fails with bad_file if the text is not what to_text() writes; `file` is its place.
[[nodiscard]] Result<MadeSafe> parse_made_safe(std::string_view text, const std::string& file);

/// Replaces the trace of that record. Fails with storage.
[[nodiscard]] Result<void> leave_trace(const std::string& record, const MadeSafe& trace);
/// Returns nothing if gyrotherm-make-safe has left none. Fails with bad_file.
[[nodiscard]] Result<std::optional<MadeSafe>> read_trace(const std::string& record);

/// "made safe by the guard at 2026-01-01T00:00:00Z (…): the chamber was sent to 23 °C; …"
[[nodiscard]] std::string in_words(const MadeSafe& trace);

}  // namespace gyrotherm
