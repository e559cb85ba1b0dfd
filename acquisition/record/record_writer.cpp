// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/record_writer.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/decision.hpp"

namespace gyrotherm::record {
namespace {

/// Returns the last instant in the entries, or `otherwise` if they have none.
Instant last_instant(std::span<const EntryPointer> entries, Instant otherwise) {
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    if (const auto& row = (*entry)->sample) return {row->monotonic, row->utc.value_or(Duration{})};
    if (!(*entry)->events.empty()) return (*entry)->events.back().at;
  }
  return otherwise;
}

Result<void> insert_all(RunFile& file, std::span<const EntryPointer> entries) {
  Result<void> done;
  for (const auto& entry : entries)
    if (done) done = file.insert(*entry);
  return done;
}

}  // namespace

bool RecordWriter::is_temporary(const Fault& fault) { return is_full(fault) || is_locked(fault); }

void RecordWriter::give_up(const Fault& why) {
  failed_ = why.what;
  file_->leave_untouched();
  const auto found = file_->interference();
  if (found) {
    damage_ = found->description;
    spoiled_ = spoiled_ || !found->is_log_only;
  }
  if (found && !found->is_log_only && found->kind == Interference::Kind::taken_away)
    nameless_ = std::move(file_);
  else
    left_ = std::move(file_);
  file_.reset();
  locked_ = 0;
}

/// Keeps the file after a temporary failure, and abandons it after any other. Returns the fault in both cases.
Result<void> RecordWriter::handle_failure(Fault fault) {
  locked_ = is_locked(fault) ? locked_ + 1 : 0;
  if (is_temporary(fault) && locked_ < options_.longest_locked) {
    if (const auto rolled_back = file_->roll_back(); rolled_back) return failure(std::move(fault));
  }
  give_up(fault);
  return failure(std::move(fault));
}

void RecordWriter::keep(std::span<const EntryPointer> entries) {
  kept_.insert(kept_.end(), entries.begin(), entries.end());
  for (const auto& entry : entries)
    if (!entry->segments.empty() || std::ranges::any_of(entry->events, is_decision))
      add_block(info_, static_cast<std::size_t>(entry->events.front().about.segment.value_or(0)), entry->segments,
                entry->events.front().about.channel);
  while (kept_.size() > options_.most_rows || (!kept_.empty() && kept_.front()->slots() == 0)) kept_.pop_front();
}

Result<void> RecordWriter::write_transaction(std::span<const EntryPointer> entries, const FrameCount& frames) {
  return file_->begin()
      .and_then([&] { return insert_all(*file_, entries); })
      .and_then([&] { return file_->replace_frames(frames); })
      .and_then([&] { return file_->commit(); });
}

Result<void> RecordWriter::fill_part(RunFile& file, const Continuation& continuation,
                                     std::span<const EntryPointer> entries) {
  const std::vector<EntryPointer> kept(kept_.begin(), kept_.end());
  if (nameless_) {
    const auto in_memory_from = kept.empty() ? acknowledged_ + 1 : kept.front()->first;
    if (auto copied = file.copy_rows(nameless_->database(), in_memory_from); !copied) return copied;
  }
  Event event{last_instant(entries, last_instant(kept, {})), EventKind::fault,
              fmt::format("the record continues in {}, with the rows from slot {} on: {}",
                          std::filesystem::path(part_path(path_, continuation.part)).filename().string(),
                          continuation.from, continuation.cause)};
  // Event numbers rise over all files, even if no earlier event is copied.
  event.number = last_event_ + 1;
  return insert_all(file, kept).and_then([&] { return file.insert_event(acknowledged_, event); });
}

/// Returns the first slot of the next part: the first slot of the previous part if that part can still be read,
/// otherwise the first slot in memory.
std::int64_t RecordWriter::first_to_account_for() {
  if (nameless_)
    if (const auto continued = read_continuation(nameless_->database()); continued)
      return *continued ? (*continued)->from : 0;
  return kept_.empty() ? acknowledged_ + 1 : kept_.front()->first;
}

Result<void> RecordWriter::begin_part(std::span<const EntryPointer> entries, const FrameCount& frames) {
  const Continuation continuation{.part = next_part(path_, options_.part),
                                  .before = std::filesystem::path(part_path(path_, options_.part)).filename().string(),
                                  .from = first_to_account_for(),
                                  .cause = failed_};
  const auto path = part_path(path_, continuation.part);
  auto file = RunFile::create(path, info_, continuation);
  if (!file) return failure(file.error());
  auto filled = file->begin()
                    .and_then([&] { return fill_part(*file, continuation, entries); })
                    .and_then([&] { return file->replace_frames(frames); })
                    .and_then([&] { return file->commit(); });
  if (!filled) {
    file->leave_untouched();
    file = failure(filled.error());
    for (const char* suffix : {"", "-wal"}) ::unlink((path + suffix).c_str());
    if (nameless_ && !is_temporary(filled.error())) nameless_.reset();  // its rows cannot be read
    return filled;
  }
  nameless_.reset();
  left_.reset();
  file_ = std::move(*file);
  options_.part = continuation.part;
  from_ = continuation.from;
  return {};
}

Result<void> RecordWriter::write(std::span<const EntryPointer> entries, const FrameCount& frames) {
  if (!file_)
    if (auto begun = begin_part(entries, frames); !begun) return begun;
  if (auto done = write_transaction(entries, frames); !done) return handle_failure(done.error());
  locked_ = 0;
  frames_ = frames;
  keep(entries);
  last_event_ = std::max(last_event_, file_->last_event());
  if (!entries.empty()) acknowledged_ = entries.back()->last;
  // The rows are durable even if the checkpoint fails. After a failure that persists, abandon this file.
  if (const auto folded = file_->checkpoint_log(); !folded && !is_temporary(folded.error())) give_up(folded.error());
  return {};
}

Result<void> RecordWriter::finish() {
  if (!file_)
    if (auto begun = begin_part({}, frames_); !begun) return begun;
  auto finished = file_->finish();
  if (!finished && file_->interference()) {
    give_up(finished.error());
    if (auto begun = begin_part({}, frames_); !begun) return begun;
    finished = file_->finish();
  }
  if (!finished) return finished;
  file_.reset();
  return spoiled_ ? Result<void>{} : close_record(path_, options_.part);
}

}  // namespace gyrotherm::record
