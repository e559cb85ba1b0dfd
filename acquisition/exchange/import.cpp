// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/import.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <future>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "acquisition/exchange/dataflash.hpp"
#include "acquisition/exchange/netcdf_table.hpp"
#include "acquisition/exchange/row_pipe.hpp"
#include "acquisition/exchange/text_table.hpp"
#include "acquisition/exchange/ulog.hpp"
#include "acquisition/record/chain.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/schema.hpp"
#include "core/sha256.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

using record::GyroKind, record::RunFile, record::RunInfo, record::SampleRow;

/// A file that another reader is for: its map is told so, rather than where the first byte of it is no text.
Result<void> check_format(Bytes& bytes, FileFormat format) {
  constexpr std::size_t kBeginning = 16;
  const auto beginning = bytes.ahead(kBeginning);
  if (!beginning) return failure(beginning.error());
  const auto is = is_ulog(*beginning)        ? std::optional(FileFormat::ulog)
                  : is_dataflash(*beginning) ? std::optional(FileFormat::dataflash)
                  : is_netcdf(*beginning)    ? std::optional(FileFormat::netcdf)
                                             : std::nullopt;
  if (!is || *is == format) return {};
  return failure(FaultKind::bad_file, bytes.name(),
                 fmt::format("the file is {}, the map reads {}; expected format = \"{}\" in [file]", name(*is),
                             name(format), name(*is)));
}

Result<Notes> read_by_format(Bytes bytes, const ImportMap& map, const TakeRow& take) {
  if (auto fits = check_format(bytes, map.format); !fits) return failure(fits.error());
  if (map.format == FileFormat::ulog) return read_ulog(std::move(bytes), map, take);
  if (map.format == FileFormat::dataflash) return read_dataflash(std::move(bytes), map, take);
  return read_text_table(std::move(bytes), map, take).map([] { return Notes(); });
}

void note_left_out(Notes& notes, std::size_t rows) {
  if (rows > 0) notes.push_back(fmt::format("{} rows whose time was not after the row before were left out", rows));
}

/// What the map makes of each column's number must be one: infinity is no value of a record.
class Scales {
 public:
  explicit Scales(const ImportMap& map) {
    const auto add = [&](const ColumnName& column, double scale, double offset) {
      scales_.push_back({column.name.empty() ? std::to_string(column.number) : plain(column.name), scale, offset});
    };
    for (const auto& [column, scale, offset] : map.thermometer_columns) add(column, scale, offset);
    auto column = map.axis_columns.begin();
    for (const auto& unit : map.units)
      for (const auto& axis : unit.axes) add(*column++, axis.scale, 0);
    for (const auto& [of, scale, offset] : map.value_columns) add(of, scale, offset);
  }

  [[nodiscard]] Result<void> check(const ForeignRow& row) const {
    for (std::size_t i = 0; i < scales_.size(); ++i) {
      const auto& [name, scale, offset] = scales_[i];
      if (!std::isinf(row.numbers[i] * scale + offset)) continue;
      return failure(
          FaultKind::bad_file, "",
          fmt::format("{:g} of column \"{}\" is beyond all numbers by the map's scale {:g}, expected a smaller one",
                      row.numbers[i], name, scale));
    }
    return {};
  }

 private:
  struct Scale {
    std::string name;
    double scale{}, offset{};
  };
  std::vector<Scale> scales_{};  ///< per column of the map
};

/// Hands the rows of a file to whoever takes them; returns what was passed over.
using ReadRows = std::function<Result<Notes>(const TakeRow& take)>;

/// A log's messages come out of order within a stretch: they go there at once.
Result<Notes> read_log_in_stretches(const ReadRows& read, const ImportMap& map, const TakeImported& take) {
  Grouping grouping(map, take);
  const Scales scales(map);
  auto notes = read([&](const ForeignRow& row) {
    return scales.check(row).and_then(
        [&] { return grouping.push({.time = row.time, .utc = row.utc, .numbers = row.numbers}); });
  });
  if (!notes) return notes;
  if (auto finished = grouping.finish(); !finished) return failure(finished.error());
  note_left_out(*notes, grouping.left_out());
  return notes;
}

Result<Notes> read_foreign(const ReadRows& read, const ImportMap& map, const TakeImported& take) {
  const bool in_stretches = map.every > Duration{};
  const bool is_log = map.format == FileFormat::ulog || map.format == FileFormat::dataflash;
  if (is_log && in_stretches) return read_log_in_stretches(read, map, take);
  Grouping grouping(map, take);
  Spacing spacing(map, [&](const ImportedRow& row) { return in_stretches ? grouping.push(row) : take(row); });
  const Scales scales(map);
  auto notes =
      read([&](const ForeignRow& row) { return scales.check(row).and_then([&] { return spacing.push(row); }); });
  if (!notes) return notes;
  const auto finished = spacing.finish().and_then([&] { return grouping.finish(); });
  if (!finished) return failure(finished.error());
  note_left_out(*notes, spacing.left_out());
  return notes;
}

/// The id of an import depends on its input alone.
Result<RunInfo> describe(const ImportMap& map, const std::string& path, const std::string& program_version) {
  const auto file = plain(std::filesystem::path(path).filename().string());
  const auto digest = record::file_digest(path);
  if (!digest) return failure(digest.error());
  constexpr std::size_t kDigits = 32;  // of the id of a run
  RunInfo info;
  info.id = sha256(*digest + map.text).substr(0, kDigits);
  info.program_version = program_version;
  info.profile_name = file;
  info.rig_name = map.name;
  info.rig_text = map.text;
  info.imported = true;
  info.thermometers = channels_of(map, "imported from " + file);
  info.units = map.units;
  return info;
}

/// Where a file misses rows.
class Silences {
 public:
  explicit Silences(const ImportMap& map) : is_grouped_(map.every > Duration{}) {}

  void pass(std::int64_t slot, const ImportedRow& row) {
    limit_ = is_grouped_ ? row.usual : kUsualStepsOfASilence * row.usual;
    if (slot > 0 && row.time - before_ > limit_) {
      const Duration silence = row.time - before_;
      if (count_++ == 0) {
        first_ = silence;
        first_after_ = slot - 1;
      }
      total_ += silence;
    }
    before_ = row.time;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::string described() const {
    return fmt::format("{} gaps longer than {:g} s, {:g} s in all; the first, of {:g} s, after row {}", count_,
                       to_seconds(limit_), to_seconds(total_), to_seconds(first_), first_after_);
  }

 private:
  bool is_grouped_;
  Duration before_{}, limit_{}, total_{}, first_{};
  std::size_t count_{};
  std::int64_t first_after_{};
};

/// The record that is being made; it begins with the first row, which may know when that was.
class ImportedRecord {
 public:
  ImportedRecord(std::string path, const ImportMap& map, RunInfo info)
      : path_(std::move(path)), map_(map), info_(std::move(info)), silences_(map) {}

  Result<void> insert(const ImportedRow& imported) {
    constexpr std::int64_t kRowsOfATransaction = 100'000;
    if (!file_)
      if (auto begun = begin(imported); !begun) return begun;
    if (taken_ > record::kMostSlots)
      return failure(
          FaultKind::bad_file, "",
          fmt::format("more than {} rows, expected fewer, or every = \"1 s\" in [time]", record::kMostSlots));
    silences_.pass(taken_, imported);
    take(imported, rows_[waiting_++]);
    last_ = imported.time;
    ++taken_;
    if (waiting_ == rows_.size())
      if (auto written = write_waiting(); !written) return written;
    if (taken_ % kRowsOfATransaction != 0) return {};
    return write_rest().and_then([&] { return commit(); }).and_then([&] { return file_->begin(); });
  }

  Result<ImportSummary> finish(const Notes& notes) {
    auto told = notes;
    if (silences_.count() > 0) told.insert(told.begin(), silences_.described());
    if (!file_) return failure(FaultKind::bad_file, "", "the file has no row, expected at least one");
    auto done = write_rest();
    for (const std::string& note : told)
      if (done) done = file_->insert_event(taken_ - 1, {{last_, {}}, EventKind::note, note});
    done = done.and_then([&] { return commit(); }).and_then([&] { return file_->finish(); });
    file_.reset();
    if (done) done = record::write_manifest(path_, 1);
    if (!done) return failure(done.error());
    return ImportSummary{static_cast<std::size_t>(taken_), last_, silences_.count(), notes};
  }

  /// Leaves nothing of a record that was begun.
  void remove() {
    if (!begun_) return;
    [[maybe_unused]] const auto written = all_written();
    file_.reset();
    for (const char* suffix : {"", "-wal", "-journal", "-shm"}) ::unlink((path_ + suffix).c_str());
  }

 private:
  Result<void> begin(const ImportedRow& first) {
    info_.started_utc = first.utc.value_or(Duration{});
    auto file = RunFile::create_at_once(path_, info_);
    if (!file) return failure(file.error());
    begun_ = true;
    file_ = std::move(*file);
    constexpr std::size_t kMostWaiting = 2048, kMostCellsWaiting = 1 << 17;
    const auto columns = record::SampleColumns(info_).count();
    rows_.assign(std::clamp<std::size_t>(kMostCellsWaiting / columns, 1, kMostWaiting), record::empty_row(info_));
    return file_->begin();
  }

  /// Returns while they are being written, by a thread that hears no signal, as this one does not. Where there is none
  /// to be had, they are when all_written() asks.
  Result<void> write_waiting() {
    chain_waiting();
    if (auto before = all_written(); !before) return before;
    std::swap(chained_, written_);
    writing_ = std::async(std::launch::async | std::launch::deferred, [this] { return file_->write(written_); });
    return {};
  }

  Result<void> write_rest() {
    chain_waiting();
    return all_written().and_then([&] { return file_->write(chained_); });
  }

  void chain_waiting() { file_->chain(std::span(rows_).first(std::exchange(waiting_, 0)), chained_); }

  Result<void> all_written() { return writing_.valid() ? writing_.get() : Result<void>(); }

  Result<void> commit() {
    return file_->replace_frames({}).and_then([&] { return file_->commit(); });
  }

  void take(const ImportedRow& imported, SampleRow& row) const {
    auto numbers = imported.numbers.begin();
    const auto scaled = [&](const ImportMap::ScaledColumn& column) {
      return *numbers++ * column.scale + column.offset;
    };
    row.slot = taken_;
    row.monotonic = imported.time;
    row.utc = imported.utc;
    for (std::size_t i = 0; i < row.thermometers_c.size(); ++i)
      row.thermometers_c[i] = scaled(map_.thermometer_columns[i]);
    for (auto& unit : row.units) {
      unit.interval = imported.interval;
      for (double& number : unit.rotation) number = *numbers++;
    }
    auto column = map_.value_columns.begin();
    for (auto& unit : row.units)
      for (double& number : unit.values) number = scaled(*column++);
  }

  std::string path_;
  const ImportMap& map_;
  RunInfo info_;
  std::optional<RunFile> file_{};
  bool begun_ = false;
  std::vector<SampleRow> rows_{};  ///< made once; the first of them hold those that wait for the record
  std::size_t waiting_{};
  record::ChainedSamples chained_{}, written_{};
  std::future<Result<void>> writing_{};  ///< of the latter
  std::int64_t taken_{};
  Duration last_{};  ///< time of the last that was taken
  Silences silences_;
};

}  // namespace

Result<Notes> read_foreign_text(std::string_view text, const std::string& name, const ImportMap& map,
                                const TakeImported& take) {
  return read_foreign([&](const TakeRow& row) { return read_by_format(Bytes(text, name), map, row); }, map, take);
}

Result<Notes> read_foreign_file(const std::string& path, const ImportMap& map, const TakeImported& take) {
  const auto read = [&](const TakeRow& row) -> Result<Notes> {
    if (map.format == FileFormat::netcdf) return read_netcdf(path, map, row).map([] { return Notes(); });
    auto bytes = Bytes::open(path);
    return bytes ? read_by_format(std::move(*bytes), map, row) : failure(bytes.error());
  };
  return read_foreign(read, map, take);
}

Result<ImportSummary> import_record(const std::string& path, const std::string& map_path,
                                    const std::string& record_path, const std::string& program_version,
                                    const std::function<bool()>& goes_on) {
  const auto map = load_import_map(map_path);
  if (!map) return failure(map.error());
  auto info = describe(*map, path, program_version);
  if (!info) return failure(info.error());
  ImportedRecord made(record_path, *map, std::move(*info));
  RowPipe writing([&](const ImportedRow& row) { return made.insert(row); });
  auto notes = read_foreign_file(path, *map, [&](const ImportedRow& row) -> Result<void> {
    if (!goes_on()) return failure(FaultKind::interrupted, path, "stopped; nothing is left of " + record_path);
    return writing.push(row);
  });
  if (auto written = writing.finish(); !written && notes) notes = failure(written.error());
  auto summary = notes ? made.finish(*notes) : Result<ImportSummary>(failure(notes.error()));
  if (!summary) made.remove();
  return summary;
}

}  // namespace gyrotherm::exchange
