// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/chain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <sstream>
#include <utility>
#include <variant>
#include <vector>

#include "acquisition/record/decision.hpp"
#include "acquisition/record/row.hpp"
#include "acquisition/record/schema.hpp"
#include "acquisition/record/status.hpp"
#include "core/file.hpp"

namespace gyrotherm::record {

void RowChain::begin(std::string_view table) {
  row_.assign(reinterpret_cast<const char*>(head_.data()), head_.size());
  add(table);
}

void RowChain::add_bits(char type, std::uint64_t bits) {
  static_assert(std::endian::native == std::endian::little, "the bytes of a number are hashed least first");
  char bytes[1 + sizeof bits];
  bytes[0] = type;
  std::memcpy(bytes + 1, &bits, sizeof bits);
  row_.append(bytes, sizeof bytes);
}

void RowChain::add_integer(std::int64_t value) { add_bits('i', static_cast<std::uint64_t>(value)); }

void RowChain::add(double value) {
  constexpr double kLargest = 0x1p63;  // larger than any SQLite integer
  if (std::isnan(value)) return add(std::monostate());
  if (std::abs(value) < kLargest)
    if (const auto whole = static_cast<std::int64_t>(value); value == static_cast<double>(whole))
      return add_integer(whole);
  add_bits('r', std::bit_cast<std::uint64_t>(value));
}

void RowChain::add(std::string_view value) {
  add_bits('t', value.size());
  row_ += value;
}

std::int64_t RowChain::end() {
  thread_local Sha256 hash;
  hash.add(row_);
  head_ = hash.digest();
  std::int64_t beginning{};
  std::memcpy(&beginning, head_.data(), sizeof beginning);
  return beginning;
}

void chain_segment(RowChain& chain, std::size_t position, const RunInfo::SegmentInfo& segment) {
  chain.add(position);
  chain.add(segment.name);
  chain.add(segment.hold);
  chain.add(segment.target.value);
  chain.add(segment.rate.value);
  chain.add(segment.cycle);
  chain.add(segment.prompt);
  chain.add(segment.unit.off);
  chain.add(segment.unit.turned);
}

Result<std::string> file_digest(const std::string& path, std::uint64_t most) {
  const auto file = open_regular_file(path);
  if (!file) return failure(file.error());
  if (file->size > most) return failure(FaultKind::bad_file, path, fmt::format("has more than {} bytes", most));
  Sha256 hash;
  std::array<char, 65536> piece;
  for (std::uint64_t left = file->size; left > 0;) {
    const auto count = read_some(file->descriptor.number(), piece.data(), std::min<std::uint64_t>(piece.size(), left));
    if (count < 0) return failure(FaultKind::bad_file, path, std::string("cannot be read: ") + std::strerror(errno));
    if (count == 0) return failure(FaultKind::bad_file, path, "cannot be read: it became shorter while it was read");
    hash.add({piece.data(), static_cast<std::size_t>(count)});
    left -= static_cast<std::uint64_t>(count);
  }
  return hex(hash.digest());
}

std::string manifest_path(const std::string& record_path) { return record_path + ".sha256"; }

Result<void> write_manifest(const std::string& record_path, const std::vector<std::string>& files) {
  std::string text;
  for (const auto& file : files)
    for (const char* suffix : {"", "-wal"}) {
      const auto path = file + suffix;
      if (!path_exists(path)) continue;
      const auto hash = file_digest(path);
      if (!hash) return failure(FaultKind::storage, hash.error().where, hash.error().what);
      text += fmt::format("{}  {}\n", *hash, name_in_folder(path));
    }
  return replace_own_file(manifest_path(record_path), text);
}

namespace {

/// The position of the name in a line of a manifest: 64 digits of the digest, two blanks, the name.
constexpr std::size_t kDigestDigits = 64, kNameOffset = 66;

/// Parses a manifest into names and digests, in the order of the manifest. Returns nothing if the text is not a
/// manifest.
std::optional<std::vector<std::pair<std::string, std::string>>> parse_manifest(const std::string& text) {
  std::vector<std::pair<std::string, std::string>> files;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.size() <= kNameOffset) return std::nullopt;
    files.emplace_back(name_in_folder(line.substr(kNameOffset)), line.substr(0, kDigestDigits));
  }
  return files;
}

/// Returns the present name of a file after the record `was` was renamed to `now` together with all its files. Returns
/// the name of any other file unchanged.
std::string name_after_rename(const std::string& file, const std::string& old_name, const std::string& now) {
  constexpr std::string_view kLog = "-wal";
  if (file.ends_with(kLog))
    return name_after_rename(file.substr(0, file.size() - kLog.size()), old_name, now).append(kLog);
  if (file == old_name) return now;
  const auto name = part_name(file);
  return name && name->record == old_name ? part_path(now, name->part) : file;
}

}  // namespace

Result<std::optional<Manifest>> check_manifest(const std::string& record_path) {
  const auto refuse = [&](const char* why) { return failure(FaultKind::bad_file, manifest_path(record_path), why); };
  const auto text = read_text_file_if_any(manifest_path(record_path));
  if (!text) return failure(text.error());
  if (!*text) return std::nullopt;
  auto lines = parse_manifest(**text);
  if (!lines) return refuse("is not a manifest");
  const auto folder = std::filesystem::path(record_path).parent_path();
  const auto own = name_in_folder(record_path);
  const auto is_named = [&] {
    return std::ranges::any_of(*lines, [&](const auto& line) { return line.first == own; });
  };
  // The first line names the record's own file, under its name at the time of closing.
  const auto old_name = lines->empty() || is_named() ? own : lines->front().first;
  if (old_name != own)
    for (auto& [name, digest] : *lines) name = name_after_rename(name, old_name, own);
  if (!is_named()) return refuse("does not name the record");
  Manifest files;
  for (const auto& [name, digest] : *lines) {
    const auto path = (folder / name).string();
    const auto hash = file_digest(path);
    if (!hash) return failure(hash.error());
    if (*hash != digest && path_exists((folder / old_name).string()) && old_name != own)
      return failure(FaultKind::bad_file, manifest_path(record_path),
                     fmt::format("is the manifest of {}, which is in the same folder", old_name));
    if (*hash != digest) return failure(FaultKind::bad_file, path, "has changed since the run was closed");
    files.emplace(name, *hash);
  }
  for (const auto& [name, digest] : files)
    if (const auto log = name + "-wal"; !files.contains(log) && path_exists((folder / log).string()))
      return failure(FaultKind::bad_file, (folder / log).string(), "did not exist when the run was closed");
  return files;
}

namespace {

void add_columns(RowChain& chain, const Statement& row, int columns) {
  for (int column = 0; column < columns; ++column) std::visit([&](auto value) { chain.add(value); }, row.cell(column));
}

/// Iterates over the rows of one table in chain order. The last column is the link of the chain. `key` is the index of
/// the column with the slot. `rank` orders the tables within one slot.
class Cursor {
 public:
  Cursor(Statement query, const char* table, int key, int rank)
      : query_(std::move(query)), table_(table), key_(key), rank_(rank) {}

  Result<void> advance() {
    const auto more = query_.step();
    if (!more) return failure(more.error());
    at_end_ = !*more;
    return {};
  }
  [[nodiscard]] std::pair<std::int64_t, int> position() const {
    if (at_end_) return {std::numeric_limits<std::int64_t>::max(), rank_};
    return {query_.integer(key_), rank_};
  }
  [[nodiscard]] bool at_end() const { return at_end_; }
  [[nodiscard]] const Statement& row() const { return query_; }
  [[nodiscard]] const char* table() const { return table_; }
  /// Returns whether the stored link of the row matches the chain. `add_more` adds the values that the row covers in
  /// addition to its columns.
  [[nodiscard]] bool fits(RowChain& chain, const std::function<void()>& add_more) const {
    const int last = query_.columns() - 1;
    chain.begin(table_);
    add_columns(chain, query_, last);
    add_more();
    return query_.integer(last) == chain.end();
  }
  [[nodiscard]] std::string name() const {
    return fmt::format("{} {} of second {}", table_, query_.text(0), query_.integer(key_));
  }

 private:
  Statement query_;
  const char* table_;
  int key_;
  int rank_;
  bool at_end_{};
};

/// Opens a cursor per table. The ranks give the order in which the rows of a second are written: the sample or the gap,
/// the missing readings, the events.
Result<std::vector<Cursor>> open_cursors(Database& database, const RunInfo& info) {
  struct Table {
    const char* name;
    int key;
    int rank;
    std::string query;
  };
  const std::array tables{
      Table{"sample", 0, 0, fmt::format("SELECT {}, chain FROM sample ORDER BY slot", SampleColumns(info).names())},
      Table{"gap", 1, 0, "SELECT first, last, cause, chain FROM gap ORDER BY first"},
      Table{"fault", 1, 1, "SELECT id, slot, channel, kind, \"where\", what, chain FROM fault ORDER BY id"},
      Table{"event", 1, 2, fmt::format("SELECT id, {}, chain FROM event ORDER BY id", column_names(event_columns()))}};
  std::vector<Cursor> cursors;
  for (const auto& table : tables) {
    auto query = database.prepare(table.query);
    if (!query) return failure(query.error());
    cursors.emplace_back(std::move(*query), table.name, table.key, table.rank);
    if (auto first = cursors.back().advance(); !first) return failure(first.error());
  }
  return cursors;
}

Result<void> add_rows(RowChain& chain, Database& database, std::string_view table, std::string_view sql) {
  return database.each_row(sql, [&](const Statement& row) {
    chain.begin(table);
    add_columns(chain, row, row.columns());
    chain.end();
  });
}

tl::unexpected<Fault> broken_chain(const std::string& path, std::string_view what) {
  return failure(FaultKind::bad_file, path, fmt::format("{} does not match the hash chain", what));
}

/// The values of the chain that are stored outside the rows.
struct Seals {
  std::string start;
  std::string head;  ///< empty: no rows yet
  std::int64_t seen{}, lost{}, bad{};
  /// The final hash; empty if the run is not finished.
  std::string end;
  /// The table of frames has only one row.
  bool is_single = false;
};

Result<Seals> read_seals(Database& database) {
  const auto row = database.first_row(
      "SELECT (SELECT value FROM meta WHERE key = 'chain_start'), (SELECT value FROM meta WHERE key = 'chain_end'),"
      " (SELECT head FROM frames), (SELECT seen FROM frames), (SELECT lost FROM frames), (SELECT bad FROM frames),"
      " NOT EXISTS(SELECT 1 FROM frames WHERE id <> 1)");
  if (!row) return failure(row.error());
  assert(*row && "a query without a table has a row");
  return Seals{.start = std::string((*row)->text(0)),
               .head = std::string((*row)->text(2)),
               .seen = (*row)->integer(3),
               .lost = (*row)->integer(4),
               .bad = (*row)->integer(5),
               .end = std::string((*row)->text(1)),
               .is_single = (*row)->integer(6) != 0};
}

Result<void> each_cursor(Database& database, const RunInfo& info, const std::function<Result<void>(Cursor&)>& use) {
  auto cursors = open_cursors(database, info);
  if (!cursors) return failure(cursors.error());
  for (;;) {
    Cursor* next = &cursors->front();
    for (Cursor& cursor : *cursors)
      if (cursor.position() < next->position()) next = &cursor;
    if (next->at_end()) return {};
    if (auto used = use(*next); !used) return used;
    if (auto advanced = next->advance(); !advanced) return advanced;
  }
}

/// The segments that each decision adds, by the number of its event.
class AddedSegments {
 public:
  [[nodiscard]] static Result<AddedSegments> read(Database& database, const RunInfo& info) {
    AddedSegments all(info);
    if (!info.goal) return all;
    const auto described = count_described_segments(database);
    if (!described) return failure(described.error());
    // A decision adds the segments up to the first one of the next decision.
    auto sql = fmt::format("SELECT id, segment FROM event WHERE {} AND segment >= {} ORDER BY id DESC", kIsDecision,
                           *described);
    auto end = info.segments.size();
    const auto done = database.each_row(sql, [&](const Statement& row) {
      const auto first = static_cast<std::size_t>(row.integer(1));
      all.by_event_[row.integer(0)] = {first, end};
      end = std::min(first, end);
    });
    if (!done) return failure(done.error());
    const auto positions = database.query_integer("SELECT max(position) + 1 FROM segment", 0);
    if (!positions) return failure(positions.error());
    const bool is_complete = *positions == std::ssize(info.segments);
    // No decision accounts for segments between the description and the first decision.
    if (!is_complete || end != std::min(*described, info.segments.size()))
      return failure(FaultKind::bad_file, database.path(), "the segments of the run do not match the hash chain");
    return all;
  }

  void add_to(RowChain& chain, std::int64_t event) const {
    const auto found = by_event_.find(event);
    if (found == by_event_.end()) return;
    for (auto i = found->second.first; i < found->second.second; ++i) chain_segment(chain, i, info_.segments[i]);
  }

 private:
  explicit AddedSegments(const RunInfo& info) : info_(info) {}
  const RunInfo& info_;
  std::map<std::int64_t, std::pair<std::size_t, std::size_t>> by_event_;
};

Result<CheckedChain> walk(Database& database, const std::string& path, const RunInfo& info, const Digest& start) {
  CheckedChain checked{.chain = RowChain(start)};
  const auto added = AddedSegments::read(database, info);
  if (!added) return failure(added.error());
  const auto walked = each_cursor(database, info, [&](Cursor& at) -> Result<void> {
    const auto add_more = [&] {
      if (std::string_view(at.table()) == "event") added->add_to(checked.chain, at.row().integer(0));
    };
    if (!at.fits(checked.chain, add_more)) return broken_chain(path, fmt::format("{}, or an earlier row,", at.name()));
    ++checked.rows;
    return {};
  });
  if (!walked) return failure(walked.error());
  return checked;
}

Result<Verified> verify_part(const Part& part) {
  auto database = open_part(part);
  if (!database) return failure(database.error());
  const auto checked = check_chain(*database, part.path);
  if (!checked) return failure(checked.error());
  return is_finished(*database).map(
      [&](bool finished) { return Verified{.rows = checked->rows, .files = 1, .finished = finished}; });
}

}  // namespace

Result<Digest> description_hash(Database& database) {
  const auto described = count_described_segments(database);
  if (!described) return failure(described.error());
  RowChain chain;
  const auto added =
      add_rows(chain, database, "meta",
               "SELECT key, value FROM meta WHERE key NOT IN ('outcome', 'chain_start', 'chain_end') ORDER BY key")
          .and_then([&] { return add_rows(chain, database, "channel", "SELECT * FROM channel ORDER BY position"); })
          .and_then([&] { return add_rows(chain, database, "unit", "SELECT * FROM unit ORDER BY position"); })
          .and_then([&] { return add_rows(chain, database, "axis", "SELECT * FROM axis ORDER BY unit, position"); })
          .and_then([&] {
            return add_rows(chain, database, "unit_value", "SELECT * FROM unit_value ORDER BY unit, position");
          })
          .and_then([&] {
            return add_rows(chain, database, "segment",
                            fmt::format("SELECT * FROM segment WHERE position < {} ORDER BY position", *described));
          })
          .and_then(
              [&] { return add_rows(chain, database, "list", "SELECT * FROM list ORDER BY name, of, position"); });
  if (!added) return failure(added.error());
  return chain.head();
}

Result<void> each_chained_row(Database& database, const RunInfo& info, const UseRow& use) {
  return each_cursor(database, info, [&](Cursor& at) { return use(at.table(), at.position().first, at.row()); });
}

Digest end_hash(RowChain chain, std::int64_t seen, std::int64_t lost, std::int64_t bad) {
  chain.begin("end");
  chain.add(seen);
  chain.add(lost);
  chain.add(bad);
  chain.end();
  return chain.head();
}

Result<CheckedChain> check_chain(Database& database, const std::string& path) {
  const auto info = read_run_info(database);
  if (!info) return failure(info.error());
  const auto seals = read_seals(database);
  if (!seals) return failure(seals.error());
  const auto start = description_hash(database);
  if (!start) return failure(start.error());
  if (hex(*start) != seals->start) return broken_chain(path, "the description of the run");
  if (!seals->is_single) return broken_chain(path, "the frame count");
  auto checked = walk(database, path, *info, *start);
  if (!checked) return checked;
  const auto head = hex(checked->chain.head());
  if (head != (seals->head.empty() ? seals->start : seals->head)) return broken_chain(path, "the end of the record");
  const auto finished = is_finished(database);
  if (!finished) return failure(finished.error());
  const auto end = *finished ? hex(end_hash(checked->chain, seals->seen, seals->lost, seals->bad)) : std::string();
  if (end != seals->end) return broken_chain(path, "the outcome of the run");
  return checked;
}

Result<Verified> verify_files(const RecordFiles& files) {
  if (files.lost)
    return failure(FaultKind::bad_file, files.lost->where,
                   fmt::format("{}; the run continues in {}", files.lost->what, files.follows_lost));
  Verified all;
  for (const auto& part : files.parts) {
    const auto more = verify_part(part);
    if (!more) return more;
    all = {.rows = all.rows + more->rows, .files = all.files + 1, .finished = more->finished};
  }
  const auto manifest = check_manifest(files.path);
  if (!manifest) return failure(manifest.error());
  all.manifest = manifest->has_value();
  if (all.manifest) all.digest = (*manifest)->at(name_in_folder(files.path));
  for (const auto& part : files.parts)
    if (all.manifest && !(*manifest)->contains(name_in_folder(part.path)))
      return failure(FaultKind::bad_file, part.path, "did not exist when the run was closed");
  return all;
}

Result<Verified> verify_record(const RecordFiles& files) {
  auto all = verify_files(files);
  if (!all) return all;
  const auto lost = lost_end(files);
  if (!lost) return failure(lost.error());
  if (*lost) return failure(FaultKind::bad_file, files.path, describe(**lost));
  return all;
}

Result<Verified> verify_record(const std::string& path) {
  return find_record_files(path).and_then([](const RecordFiles& files) { return verify_record(files); });
}

Result<void> close_record(const std::string& path, int last_part) {
  if (last_part == 1) return write_manifest(path, {path});
  const auto files = find_record_files(path);
  if (!files) return failure(files.error());
  if (auto whole = verify_record(*files); !whole) return failure(whole.error());
  std::vector<std::string> paths;
  for (const auto& part : files->parts) paths.push_back(part.path);
  return write_manifest(path, paths);
}

}  // namespace gyrotherm::record
