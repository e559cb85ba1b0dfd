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
#include "acquisition/exchange/guess.hpp"
#include "acquisition/exchange/increment_columns.hpp"
#include "acquisition/exchange/netcdf_table.hpp"
#include "acquisition/exchange/row_order.hpp"
#include "acquisition/exchange/row_pipe.hpp"
#include "acquisition/exchange/simulation_mark.hpp"
#include "acquisition/exchange/text_table.hpp"
#include "acquisition/exchange/ulog.hpp"
#include "acquisition/record/chain.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/schema.hpp"
#include "core/clock.hpp"
#include "core/count_text.hpp"
#include "core/sha256.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

using record::GyroKind, record::RunFile, record::RunInfo, record::SampleRow;

/// Fails with bad_file if the file has another format than the map states. Without this check, the reader would report
/// the first unexpected byte instead.
Result<void> check_format(Bytes& bytes, FileFormat format) {
  const auto is = detect_format(bytes);
  if (!is) return failure(is.error());
  if (*is == FileFormat::text || *is == format) return {};
  return failure(FaultKind::bad_file, bytes.name(),
                 fmt::format("the file is {}, the map reads {}; expected format = \"{}\" in [file]", name(*is),
                             name(format), name(*is)));
}

Findings make_findings(Notes notes) { return {.notes = std::move(notes)}; }

Result<Findings> read_by_format(Bytes bytes, const ImportMap& map, const TakeRow& take) {
  if (auto fits = check_format(bytes, map.format); !fits) return failure(fits.error());
  if (map.format == FileFormat::ulog) return read_ulog(std::move(bytes), map, take).map(make_findings);
  if (map.format == FileFormat::dataflash) return read_dataflash(std::move(bytes), map, take).map(make_findings);
  return read_text_table(std::move(bytes), map, take);
}

/// Reads the rows of a file and returns the findings about it.
using ReadRows = std::function<Result<Findings>(const TakeRow& take)>;

/// The results of reading a file.
struct FileResults {
  explicit FileResults(const ImportMap& map) : tally(map) {}
  ChannelTally tally;
  Findings findings{};
  std::size_t rows{}, rows_left_out{}, repeated_times{};
  std::optional<Duration> step{};  ///< usual spacing of the file's rows
};

/// Fails with bad_file, without a position, if the rows to be combined are farther apart than the interval that
/// combines them. A deviation of 5 % is accepted, because the clock of a logger may be inaccurate. A few rows have no
/// usual spacing.
Result<void> check_every(Duration every, Duration usual, std::size_t rows) {
  constexpr double kTolerance = 0.05;
  constexpr std::size_t kFewestRows = 20;
  if (rows < kFewestRows || to_seconds(usual) <= (1 + kTolerance) * to_seconds(every)) return {};
  return failure(FaultKind::bad_file, "",
                 fmt::format("the rows are {:g} s apart, every = \"{:g} s\" does not combine any of them; expected a "
                             "longer interval, or no every",
                             to_seconds(usual), to_seconds(every)));
}

/// Reads a file and passes on the rows of the record. Messages of a log may be out of order within a stretch, so they
/// are passed directly to the grouping. Other rows are put in order first. `name` is the file's name in faults of rows
/// that were held back until the end of the file.
Result<void> read_foreign(const ReadRows& read, const std::string& name, const ImportMap& map, const TakeImported& take,
                          FileResults& file) {
  const bool in_stretches = map.every > Duration{};
  const bool is_log = map.format == FileFormat::ulog || map.format == FileFormat::dataflash;
  const bool skips_ordering = is_log && in_stretches;
  Grouping grouping(map, take);
  Spacing spacing(map, [&](const ImportedRow& row) -> Result<void> {
    file.step = row.usual;
    if (!in_stretches) return take(row);
    return check_every(map.every, row.usual, file.rows).and_then([&] { return grouping.push(row); });
  });
  RowOrder order(map, [&](const ForeignRow& row) { return spacing.push(row); });
  const IncrementColumns increments(map);
  std::vector<double> numbers;
  Duration previous{};
  auto findings = read([&](const ForeignRow& row) -> Result<void> {
    numbers.assign(row.numbers.begin(), row.numbers.end());
    if (auto checked = increments.check(numbers); !checked) return checked;
    if (auto possible = file.tally.push(row.time, numbers); !possible) return possible;
    if (file.rows > 0 && row.time == previous) ++file.repeated_times;
    previous = row.time;
    ++file.rows;
    if (skips_ordering) return grouping.push({.time = row.time, .utc = row.utc, .numbers = numbers});
    return order.push({row.time, row.utc, numbers});
  });
  if (!findings) return failure(findings.error());
  auto finished = order.finish().and_then([&] { return spacing.finish(); }).and_then([&] { return grouping.finish(); });
  if (!finished && finished.error().where.empty()) finished.error().where = name;
  if (!finished) return finished;
  if (2 * order.skipped_rows() > file.rows)
    return failure(FaultKind::bad_file, name,
                   fmt::format("the times go back in {} of {} rows, so most rows would be left out; sort the rows by "
                               "time, or check unit and order of [time]",
                               order.skipped_rows(), file.rows));
  file.findings = std::move(*findings);
  file.rows_left_out = order.skipped_rows() + grouping.skipped_rows();
  order.note(file.findings.notes);
  if (grouping.skipped_rows() > 0) file.findings.notes.push_back(describe_rows_left_out(grouping.skipped_rows()));
  return {};
}

Result<void> read_path(const std::string& path, const ImportMap& map, const TakeImported& take, FileResults& file) {
  const auto read = [&](const TakeRow& row) -> Result<Findings> {
    if (map.format == FileFormat::netcdf) return read_netcdf(path, map, row).map([] { return Findings(); });
    auto bytes = Bytes::open(path);
    return bytes ? read_by_format(std::move(*bytes), map, row) : failure(bytes.error());
  };
  return read_foreign(read, path, map, take, file);
}

/// Describes the import as a run. Its id depends only on the file and the map.
Result<RunInfo> make_run_info(const ImportMap& map, const std::string& path, const std::string& program_version) {
  const auto file = plain(std::filesystem::path(path).filename().string());
  const auto digest = record::file_digest(path);
  if (!digest) return failure(digest.error());
  auto virtual_instruments = read_simulation_mark(path, map.format);
  if (!virtual_instruments) return failure(virtual_instruments.error());
  constexpr std::size_t kDigits = 32;  // size of a run's id
  RunInfo info;
  info.id = sha256(*digest + map.text).substr(0, kDigits);
  info.program_version = program_version;
  info.profile_name = file;
  info.rig_name = map.name;
  info.rig_text = map.text;
  info.imported = true;
  info.virtual_instruments = std::move(*virtual_instruments);
  info.thermometers = make_channels(map, "imported from " + file);
  info.units = map.units;
  return info;
}

/// Counts the gaps between the rows of a file.
class GapCounter {
 public:
  explicit GapCounter(const ImportMap& map) : is_grouped_(map.every > Duration{}) {}

  void add(std::int64_t slot, const ImportedRow& row) {
    limit_ = is_grouped_ ? row.usual : kGapInUsualSteps * row.usual;
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
  [[nodiscard]] std::string describe() const {
    return fmt::format("{} longer than {:g} s, {:g} s in all; the first, of {:g} s, after row {}",
                       format_count(count_, "gap"), to_seconds(limit_), to_seconds(total_), to_seconds(first_),
                       first_after_);
  }

 private:
  bool is_grouped_;
  Duration before_{}, limit_{}, total_{}, first_{};
  std::size_t count_{};
  std::int64_t first_after_{};
};

/// Lists the values of at most 100 channels on one line.
std::string describe_values(const std::vector<ChannelSummary>& channels) {
  constexpr std::size_t kMaxListedChannels = 100;
  std::string text = "values of the file: ";
  for (std::size_t i = 0; i < std::min(channels.size(), kMaxListedChannels); ++i)
    text += (i > 0 ? "; " : "") + describe(channels[i]);
  if (channels.size() > kMaxListedChannels)
    text += fmt::format("; and {} more channels", channels.size() - kMaxListedChannels);
  return text;
}

/// The record under construction. It is created at the first row, because that row may contain the start time.
class ImportedRecord {
 public:
  ImportedRecord(std::string path, const ImportMap& map, RunInfo info)
      : path_(std::move(path)), map_(map), increments_(map), info_(std::move(info)), gaps_(map) {}

  Result<void> insert(const ImportedRow& imported) {
    constexpr std::int64_t kRowsOfATransaction = 100'000;
    if (!file_)
      if (auto begun = begin(imported); !begun) return begun;
    if (taken_ > record::kMaxSlots)
      return failure(FaultKind::bad_file, "",
                     fmt::format("more than {} rows, expected fewer, or every = \"1 s\" in [time]", record::kMaxSlots));
    gaps_.add(taken_, imported);
    take(imported, rows_[waiting_++]);
    last_ = imported.time;
    usual_ = imported.usual;
    ++taken_;
    if (waiting_ == rows_.size())
      if (auto written = write_waiting(); !written) return written;
    if (taken_ % kRowsOfATransaction != 0) return {};
    return write_rest().and_then([&] { return commit(); }).and_then([&] { return file_->begin(); });
  }

  Result<ImportSummary> finish(const FileResults& file) {
    if (!file_) return failure(FaultKind::bad_file, "", "the file has no row, expected at least one");
    ImportSummary summary{.rows = static_cast<std::size_t>(taken_),
                          .file_rows = file.rows,
                          .lines_left_out = file.findings.lines_left_out,
                          .rows_left_out = file.rows_left_out,
                          .repeated_times = file.repeated_times,
                          .span = last_,
                          .step = usual_,
                          .file_step = file.rows - file.repeated_times > 1 ? file.step : std::nullopt,
                          .started = first_utc_,
                          .gaps = gaps_.count(),
                          .notes = file.findings.notes,
                          .channels = file.tally.channels(file.findings.missing)};
    auto lines = summary.notes;
    if (gaps_.count() > 0) lines.insert(lines.begin(), gaps_.describe());
    lines.push_back(describe_values(summary.channels));
    auto done = write_rest();
    for (const std::string& note : lines)
      if (done) done = file_->insert_event(taken_ - 1, {{last_, {}}, EventKind::note, note});
    done = done.and_then([&] { return commit(); }).and_then([&] { return file_->finish(); });
    file_.reset();
    if (done) done = record::write_manifest(path_, {path_});
    if (!done) return failure(done.error());
    return summary;
  }

  [[nodiscard]] std::int64_t rows() const { return taken_; }
  [[nodiscard]] Duration span() const { return last_; }
  [[nodiscard]] std::optional<Duration> started() const { return first_utc_; }

  /// Removes an incomplete record.
  void remove() {
    if (!begun_) return;
    [[maybe_unused]] const auto written = all_written();
    file_.reset();
    for (const char* suffix : {"", "-wal", "-journal", "-shm"}) ::unlink((path_ + suffix).c_str());
  }

 private:
  Result<void> begin(const ImportedRow& first) {
    first_utc_ = first.utc;
    info_.started_utc = first.utc.value_or(Duration{});
    auto file = RunFile::create_at_once(path_, info_);
    if (!file) return failure(file.error());
    begun_ = true;
    file_ = std::move(*file);
    constexpr std::size_t kMaxWaiting = 2048, kMaxCellsWaiting = 1 << 17;
    const auto columns = record::SampleColumns(info_).count();
    rows_.assign(std::clamp<std::size_t>(kMaxCellsWaiting / columns, 1, kMaxWaiting), record::empty_row(info_));
    return file_->begin();
  }

  /// Starts to write the waiting rows in another thread and returns. The other thread also blocks signals. If no thread
  /// is available, all_written() writes them.
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
    for (std::size_t i = 0; i < row.units.size(); ++i) {
      const auto since_row_before = map_.counts_increments(i) ? imported.interval : imported.usual;
      row.units[i].interval = increments_.counting_time(i, imported.numbers, since_row_before);
      for (double& number : row.units[i].rotation) number = *numbers++;
    }
    auto column = map_.value_columns.begin();
    for (auto& unit : row.units)
      for (double& number : unit.values) number = scaled(*column++);
  }

  std::string path_;
  const ImportMap& map_;
  IncrementColumns increments_;
  RunInfo info_;
  std::optional<RunFile> file_{};
  bool begun_ = false;
  /// Reused rows; the first `waiting_` of them wait for the record.
  std::vector<SampleRow> rows_{};
  std::size_t waiting_{};
  record::ChainedSamples chained_{}, written_{};
  std::future<Result<void>> writing_{};  ///< writes `written_`
  std::int64_t taken_{};
  Duration last_{};  ///< time of the last row
  Duration usual_{};
  std::optional<Duration> first_utc_{};
  GapCounter gaps_;
};

/// Returns the difference of two durations, or the least difference modulo `period` if that is not 0.
Duration find_difference(Duration one, Duration other, Duration period) {
  const Duration difference = std::chrono::abs(one - other);
  if (period == Duration{}) return difference;
  const Duration part = difference % period;
  return std::min(part, period - part);
}

/// Fails if another column of dates or times of day has another duration than the map's time. A column of times of day
/// is compared modulo one day. Its tolerance includes a change to summer time, but is a small part of a day.
Result<void> check_span(const std::string& path, const Findings& findings, Duration span) {
  constexpr double kRelativeTolerance = 0.02;
  constexpr Duration kAbsoluteTolerance = std::chrono::minutes(1), kMaxClockTolerance = std::chrono::minutes(65);
  const Duration period = findings.other_period;
  const auto agrees = [&](Duration other) {
    const Duration most = std::max(span, other);
    Duration tolerance = std::max(kAbsoluteTolerance, from_seconds(kRelativeTolerance * to_seconds(most)));
    if (period > Duration{}) tolerance = std::min(tolerance, kMaxClockTolerance);
    return find_difference(span, other, period) <= tolerance;
  };
  if (findings.other_spans.empty() || std::ranges::any_of(findings.other_spans, agrees)) return {};
  return failure(
      FaultKind::bad_file, path,
      fmt::format("the rows span {} by the map's [time], but {}{} by column \"{}\"; expected the same, or other_clocks "
                  "= \"ignore\" in [time]",
                  format_duration(span), format_duration(findings.other_spans.front()),
                  period > Duration{} ? " and any number of days" : "", plain(findings.other_clock)));
}

/// Fails, or adds notes, if the imported rows suggest that the map does not fit the file.
Result<void> judge(const std::string& path, const ImportMap& map, const ImportedRecord& made,
                   std::optional<Duration> utc, FileResults& file) {
  constexpr std::size_t kMinRowsToJudge = 20;
  constexpr double kMaxRowRate_hz = 2000;
  constexpr Duration kLongestUsualStep = std::chrono::seconds(90);
  const auto rows = static_cast<std::size_t>(made.rows());
  if (map.every > Duration{} && rows == 1 && file.rows >= kMinRowsToJudge)
    return failure(
        FaultKind::bad_file, path,
        fmt::format("all {} rows fall into one interval of {:g} s: is the unit in [time] right? Expected rows "
                    "in at least two intervals",
                    file.rows, to_seconds(map.every)));
  if (auto fits = check_span(path, file.findings, made.span()); !fits) return fits;
  if (auto judged = file.tally.judge(path, file.findings.missing, file.findings.notes); !judged) return judged;
  const double rate = made.span() > Duration{} ? static_cast<double>(file.rows) / to_seconds(made.span()) : 0;
  if (file.rows >= kMinRowsToJudge && rate > kMaxRowRate_hz)
    file.findings.notes.push_back(fmt::format("{:.0f} rows per second: is the unit in [time] right?", rate));
  if (file.rows >= kMinRowsToJudge && file.step && *file.step > kLongestUsualStep)
    file.findings.notes.push_back(
        fmt::format("the rows are {:g} s apart: is the unit in [time] right?", to_seconds(*file.step)));
  if (utc && made.started() && *made.started() > *utc + std::chrono::hours(24))
    file.findings.notes.push_back(fmt::format("the first row is dated {}, in the future", civil_time(*made.started())));
  return {};
}

}  // namespace

Result<Notes> read_foreign_text(std::string_view text, const std::string& name, const ImportMap& map,
                                const TakeImported& take) {
  FileResults file(map);
  const auto read = [&](const TakeRow& row) { return read_by_format(Bytes(text, name), map, row); };
  return read_foreign(read, name, map, take, file).map([&] { return file.findings.notes; });
}

Result<Notes> read_foreign_file(const std::string& path, const ImportMap& map, const TakeImported& take) {
  FileResults file(map);
  return read_path(path, map, take, file).map([&] { return file.findings.notes; });
}

Result<ImportSummary> import_record(const std::string& path, const std::string& map_path,
                                    const std::string& record_path, const std::string& program_version,
                                    const std::function<bool()>& may_continue, std::optional<Duration> utc) {
  const auto map = load_import_map(map_path);
  if (!map) return failure(map.error());
  auto info = make_run_info(*map, path, program_version);
  if (!info) return failure(info.error());
  ImportedRecord made(record_path, *map, std::move(*info));
  RowPipe writing([&](const ImportedRow& row) { return made.insert(row); });
  FileResults file(*map);
  file.tally.refuse_impossible();
  const auto take = [&](const ImportedRow& row) -> Result<void> {
    if (!may_continue()) return failure(FaultKind::interrupted, path, "stopped; nothing is left of " + record_path);
    return writing.push(row);
  };
  auto read = read_path(path, *map, take, file);
  if (auto written = writing.finish(); !written && read) read = failure(written.error());
  if (read) read = judge(path, *map, made, utc, file);
  auto summary = read ? made.finish(file) : Result<ImportSummary>(failure(read.error()));
  if (!summary) made.remove();
  return summary;
}

}  // namespace gyrotherm::exchange
