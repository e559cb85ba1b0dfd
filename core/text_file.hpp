/// Whole files, read or replaced. Whoever reads may be handed anything under a name, and whoever writes may find that
/// somebody else has put something there: neither waits for a pipe, reads a device, or writes through a link.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/descriptor.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Bytes of what people write, and of what stands beside a record; and of a table, a model, a report.
inline constexpr std::size_t kLargestText = 4'000'000, kLargestTable = 256'000'000;

enum class Links { followed, refused };

/// An open file that is a regular one.
struct RegularFile {
  Descriptor descriptor;
  std::uint64_t size{};  ///< bytes, when it was opened
};

/// Opens a file to read it; nothing is waited for. Fails with bad_file if it is not there, cannot be read, or is no
/// regular file: a pipe, a device, a folder; with Links::refused also if the last part of the path is a link.
[[nodiscard]] Result<RegularFile> open_regular_file(const std::string& path, Links links = Links::followed);

/// All of an open file, from its start; `path` names it in faults. Fails with bad_file if it has more than `most`
/// bytes, cannot be read, or has more or fewer bytes than it said: it changes, or is made while it is read, as /proc
/// is.
[[nodiscard]] Result<std::string> read_whole(const RegularFile& file, const std::string& path,
                                             std::size_t most = kLargestText);

/// Both in one. Fails like them.
[[nodiscard]] Result<std::string> read_text_file(const std::string& path, std::size_t most = kLargestText);
/// Nothing if there is no file of that name; a link that leads nowhere is one that cannot be read.
[[nodiscard]] Result<std::optional<std::string>> read_text_file_if_any(const std::string& path,
                                                                       std::size_t most = kLargestText,
                                                                       Links links = Links::followed);

/// Replaces a file that the user named, as a whole: written under a new name in the same folder, synced, renamed; a
/// link's target is replaced, the link stays. Mode 0644, less what the umask takes. Fails with storage, also where the
/// path is a device, a pipe or a folder.
[[nodiscard]] Result<void> replace_text_file(const std::string& path, std::string_view text);

enum class Syncing { awaited, not_awaited };

/// Replaces a file of our own that stands beside a record: as above, but what stands under the name itself is replaced,
/// a link as well, and never followed. Mode 0640. `syncing`: whether file and folder are synced before this returns;
/// what need not outlive the machine need not wait for it. Fails with storage.
[[nodiscard]] Result<void> replace_own_file(const std::string& path, std::string_view text,
                                            Syncing syncing = Syncing::awaited);

}  // namespace gyrotherm
