// SPDX-License-Identifier: Apache-2.0
#include "apps/site/publisher.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/status.hpp"
#include "apps/site/archive.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::site {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxFolderDepth = 3;
constexpr Duration kRoundInterval = std::chrono::seconds(1);
/// Number of batches of a run that are sent in one turn.
constexpr int kBatchesPerTurn = 25;
/// Pause after a fault of a run, or after the store has refused a document. The reason may be removed in the meantime.
constexpr Duration kFaultPause = std::chrono::minutes(1);

bool is_store_fault(const Fault& fault) { return fault.where == kStore; }

/// Returns true if the fault is that the record is being written and has no live copy to read.
bool is_being_written(const Fault& fault) { return record::is_locked(fault) || fault.what == record::kBeingWritten; }

/// Returns the present states of the files. For a live copy, which grows, the state is only the identity of the file.
std::vector<FileState> read_states(const record::RecordFiles& files) {
  std::vector<FileState> states;
  for (const auto& file : files.parts)
    states.push_back(file.is_live_copy ? read_file_identity(file.path) : read_file_state(file.path));
  return states;
}

/// Fails like reading a record that is being written if the files have changed, so the next round tries again.
Result<void> check_unchanged(const record::RecordFiles& files, const std::vector<FileState>& states) {
  if (read_states(files) == states) return {};
  return failure(FaultKind::storage, files.parts.front().path, record::kBeingWritten);
}

Result<std::string> read_id(const record::RecordFiles& files) {
  return record::open_source(files.parts.back()).and_then([](record::Database database) {
    return database.query_text("SELECT value FROM meta WHERE key = 'id'");
  });
}

/// Adds a folder and its subfolders. Does not follow links.
void add_folders(const fs::path& folder, int depth, std::vector<std::string>& folders) {
  folders.push_back(folder.string());
  if (depth == kMaxFolderDepth) return;
  for (const auto& entry : list_folder(folder)) {
    std::error_code error;
    if (fs::is_directory(fs::symlink_status(entry, error))) add_folders(entry, depth + 1, folders);
  }
}

/// Returns the folders and their subfolders, to a depth of three.
std::vector<std::string> list_subfolders(const std::vector<std::string>& tops) {
  std::vector<std::string> folders;
  for (const auto& top : tops) add_folders(top, 0, folders);
  return folders;
}

/// Fails with bad_file if the folder is missing or cannot be read.
Result<void> check_folder(const std::string& folder) {
  const Descriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.is_open()) return {};
  return failure(FaultKind::bad_file, folder, fmt::format("{}; its runs are not sent", std::strerror(errno)));
}

std::uint64_t process_seed() {
  return static_cast<std::uint64_t>(since_boot().count()) ^ static_cast<std::uint64_t>(::getpid());
}

}  // namespace

Publisher::Publisher(SiteSettings settings, int stop, std::function<void(const std::string&)> report,
                     std::function<void(const Fault&)> report_fault)
    : settings_(std::move(settings)),
      limits_({.answer = settings_.longest_answer, .stop = stop}),
      report_(std::move(report)),
      report_fault_(std::move(report_fault)) {}

Result<void> Publisher::connect() {
  if (store_) return {};
  auto store = Store::open(settings_.store, limits_);
  if (!store) return failure(store.error());
  store_.emplace(std::move(*store));
  for (auto& [path, watched] : runs_)
    if (watched.run) watched.run->position.reset();
  return {};
}

void Publisher::disconnect(const Fault& why) {
  store_.reset();
  if (why.kind == FaultKind::interrupted || !reported_store_fault_.empty()) return;
  reported_store_fault_ = text(why);
  report_fault_(why);
}

void Publisher::find_files() {
  std::set<std::string> records;
  found_documents_.clear();
  for (const auto& folder : list_subfolders(settings_.folders)) {
    records.merge(record::list_records(folder));
    for (const auto& entry : list_folder(folder))
      if (entry.extension() == ".json") found_documents_.insert(entry.string());
  }
  for (const auto& path : records) runs_.try_emplace(path);
  std::erase_if(runs_, [&](const auto& entry) { return !records.contains(entry.first); });
  std::erase_if(documents_, [&](const auto& entry) { return !found_documents_.contains(entry.first); });
}

Result<void> Publisher::check_folders() const {
  for (const auto& folder : settings_.folders)
    if (auto readable = check_folder(folder); !readable) return readable;
  return {};
}

void Publisher::report_folders() {
  for (const auto& folder : settings_.folders) {
    const auto readable = check_folder(folder);
    if (!readable && !first_file_fault_) first_file_fault_ = readable.error();
    auto line = readable ? std::string() : text(readable.error());
    auto& reported = folder_faults_[folder];
    if (line == reported) continue;
    reported = std::move(line);
    if (!readable) report_fault_(readable.error());
  }
}

bool Publisher::report_file_fault(const Fault& fault, const std::string& path, std::string& reported) {
  if (is_store_fault(fault) && fault.kind != FaultKind::refused) return false;
  if (fault.kind == FaultKind::interrupted) return false;
  if (is_being_written(fault)) return true;
  if (!first_file_fault_) first_file_fault_ = fault;
  if (auto line = text(fault); line != reported) {
    reported = std::move(line);
    report_fault_({fault.kind, path, is_store_fault(fault) ? "refused by the store: " + fault.what : reported});
  }
  return true;
}

Result<void> Publisher::query_position(Run& run) {
  if (run.position) return {};
  auto position = store_->position(run.info.id);
  if (!position) return failure(position.error());
  if (!*position) {
    if (auto added = store_->add_run(run.info.id, settings_.rig, run_as_json(run.info)); !added) return added;
    position = RunPosition{.sent_segments = run.info.segments.size()};
  }
  run.position = **position;
  return {};
}

Result<void> Publisher::send_segments(Run& run) {
  if (!run.info.goal || !store_->has_growing_runs()) return {};
  if (run.position->sent_segments == run.info.segments.size()) return {};
  if (auto sent = store_->add_segments(run.info.id, segments_as_json(run.info)); !sent) return sent;
  run.position->sent_segments = run.info.segments.size();
  return {};
}

Result<Publisher::Backlog> Publisher::send_rows(const record::RecordFiles& files, Run& run) {
  auto batch = read_rows(files, run.channels, run.position->slot);
  for (int sent = 0; batch && batch->rows > 0; ++sent) {
    if (sent == kBatchesPerTurn) return Backlog::some;
    if (auto same = check_unchanged(files, run.states); !same) return failure(same.error());
    if (auto queued = store_->send_rows(run.info.id, *batch); !queued) return failure(queued.error());
    // The next batch is read while the server processes this one.
    const bool was_full = batch->rows == static_cast<std::size_t>(kBatchRows);
    const auto last = batch->last;
    auto next = was_full ? read_rows(files, run.channels, last) : Result<RowBatch>(RowBatch{});
    if (auto arrived = store_->await_rows(); !arrived) return failure(arrived.error());
    run.position->slot = last;
    batch = std::move(next);
  }
  if (!batch) return failure(batch.error());
  return Backlog::none;
}

Result<void> Publisher::send_events_and_gaps(const record::RecordFiles& files, Run& run) {
  for (;;) {
    const auto events = read_events(files, run.position->event);
    if (!events) return failure(events.error());
    if (events->rows == 0) break;
    if (auto same = check_unchanged(files, run.states); !same) return same;
    if (auto sent = store_->add_events(run.info.id, run.position->event, events->text); !sent) return sent;
    run.position->event = events->last;
  }
  for (;;) {
    const auto gaps = read_gaps(files, run.position->gap);
    if (!gaps) return failure(gaps.error());
    if (gaps->rows == 0) return {};
    if (auto same = check_unchanged(files, run.states); !same) return same;
    if (auto sent = store_->add_gaps(run.info.id, run.position->gap, gaps->text); !sent) return sent;
    run.position->gap = gaps->last;
  }
}

Result<void> Publisher::send_state(Run& run, const LiveState& now) {
  if (run.position->sent_state == now) return {};
  if (auto sent = store_->update_state(run.info.id, now); !sent) return sent;
  run.position->sent_state = now;
  return {};
}

Result<void> Publisher::end_run(const record::RecordFiles& files, Run& run) {
  if (run.position->is_closed()) return {};
  const auto end = read_end(run.info, files);
  if (!end) return failure(end.error());
  if (auto same = check_unchanged(files, run.states); !same) return same;
  if (!end->finished) return send_state(run, {.state = end->state, .cause = end->cause, .alarms = end->alarms});
  if (const auto verified = record::verify_record(files); !verified) return failure(verified.error());
  std::vector<RunFileDigest> digests;
  for (const auto& file : files.parts) {
    auto digest = compute_digest(file.path);
    if (!digest) return failure(digest.error());
    if (auto kept = archive(settings_.archive, *digest, limits_.stop); !kept) return kept;
    digests.push_back(std::move(*digest));
  }
  if (auto same = check_unchanged(files, run.states); !same) return same;
  if (auto finished = store_->finish_run(run.info.id, end_as_json(*end, digests)); !finished) return finished;
  run.position->finished = true;
  report_(fmt::format("{}: complete in the store, {} rows", files.path, end->rows));
  return {};
}

Result<Publisher::Backlog> Publisher::send_recorded(const record::RecordFiles& files, Run& run) {
  if (auto queried = query_position(run); !queried) return failure(queried.error());
  if (run.position->is_closed()) return Backlog::none;
  if (auto sent = send_segments(run); !sent) return failure(sent.error());
  const auto rows = send_rows(files, run);
  if (!rows || *rows == Backlog::some) return rows;
  return send_events_and_gaps(files, run).map([] { return Backlog::none; });
}

Result<void> Publisher::send_live_state(const std::optional<record::RunStatus>& status, Run& run) {
  if (!status || status->id != run.info.id) return {};
  return send_state(run, {.state = name(status->overview.state),
                          .cause = status->overview.cause,
                          .alarms = alarms_as_json(status->alarms)});
}

Result<bool> Publisher::open_run(const record::RecordFiles& files, bool is_written, WatchedRun& watched) {
  const auto identity = read_file_identity(files.path);
  auto states = read_states(files);
  // A record that replaced another one may have the same inode number, so the id is compared too.
  const auto id = read_id(files);
  if (!id) return failure(id.error());
  if (!watched.run || watched.run->file != identity || watched.run->info.id != *id) {
    const auto begun = record::has_begun(files);
    if (!begun) return failure(begun.error());
    if (is_written && !*begun) return false;
    auto info = record::read_source_info(files);
    if (!info) return failure(info.error());
    auto& run = watched.run.emplace(Run{.file = identity, .info = std::move(*info)});
    run.channels = stored_channels(run.info);
    run.history = record::find_named_history(run.info, files.path);
  } else if (watched.run->info.goal && !record::has_ended(watched.run->info)) {
    auto info = record::read_source_info(files);
    if (!info) return failure(info.error());
    watched.run->info.segments = std::move(info->segments);
    watched.run->info.added_blocks = std::move(info->added_blocks);
  }
  watched.run->states = std::move(states);
  return true;
}

Result<Publisher::Backlog> Publisher::send_run(const std::string& path, WatchedRun& watched) {
  watched.files = {.record = read_file_state(path),
                   .status = read_file_state(record::status_path(path)),
                   .live_copy = read_file_identity(record::live_copy_path(path))};
  if (watched.sent_files == watched.files || is_paused(watched)) return Backlog::none;
  watched.pause.reset();
  const auto status = record::read_fresh_status(path);
  const auto files = record::find_source_files(path, status.has_value());
  if (!files) return failure(files.error());
  const auto opened = open_run(*files, status.has_value(), watched);
  if (!opened) return failure(opened.error());
  if (!*opened) return Backlog::none;
  auto& run = *watched.run;
  const auto backlog = send_recorded(*files, run);
  if (!backlog || *backlog == Backlog::some) return backlog;
  const bool is_live = files->parts.front().is_live_copy;
  if (is_live) return send_live_state(status, run).map([] { return Backlog::none; });
  if (auto ended = end_run(*files, run); !ended) return failure(ended.error());
  watched.sent_files = watched.files;
  watched.reported_fault.clear();
  return Backlog::none;
}

bool Publisher::is_paused(const WatchedRun& watched) {
  const auto& pause = watched.pause;
  return pause && !pause->until.has_passed() && (!pause->files || *pause->files == watched.files);
}

void Publisher::pause_run(WatchedRun& watched, const Fault& fault) {
  if (is_being_written(fault)) return;
  const bool is_refused = is_store_fault(fault) && fault.kind == FaultKind::refused;
  watched.pause.emplace(Pause{.until = Deadline(kFaultPause)});
  if (!is_refused) watched.pause->files = watched.files;
  if (is_refused && watched.run) watched.run->position.reset();
}

Result<void> Publisher::send_document(const std::string& path) {
  const auto document = read_document(path);
  if (!document) return failure(document.error());
  if (!*document) return {};
  const auto there = store_->has_document(sha256((*document)->text));
  if (!there) return failure(there.error());
  if (*there) return {};
  if (auto added = store_->add_document(settings_.rig, **document); !added) return added;
  report_(fmt::format("{}: stored", path));
  return {};
}

Result<void> Publisher::send_if_due(WatchedFile& file, const std::string& path,
                                    const std::function<Result<void>()>& send) {
  // Read before the content, so a change in between is detected in the next round.
  const auto state = read_file_state(path);
  if (!file.is_due(state)) return {};
  const auto sent = send();
  if (!sent && !report_file_fault(sent.error(), path, file.reported_fault)) return sent;
  if (sent) file.reported_fault.clear();
  if (!sent && sent.error().kind == FaultKind::refused)
    file.note_refusal(state, kFaultPause);
  else
    file.note_done(state);
  return {};
}

Result<void> Publisher::send_check_standards() {
  if (!store_->has_check_standards()) return {};
  std::set<record::NamedHistory> named;
  for (const auto& [path, watched] : runs_)
    if (watched.run && watched.run->history) named.insert(*watched.run->history);
  for (const auto& one : named) {
    const auto path = one.find_path();
    if (path.empty()) continue;
    const auto send = [&] {
      return read_check_charts(one, path).and_then([&](const std::optional<CheckCharts>& charts) {
        if (!charts) return Result<void>();
        return store_->add_check_standard(settings_.rig, *charts).map([&] {
          report_(fmt::format("{}: stored", path));
        });
      });
    };
    if (auto sent = send_if_due(histories_[path], path, send); !sent) return sent;
  }
  return {};
}

Result<Publisher::Backlog> Publisher::run_round() {
  report_folders();
  find_files();
  if (auto connected = connect(); !connected) return failure(connected.error());
  auto backlog = Backlog::none;
  for (auto& [path, watched] : runs_) {
    const auto sent = send_run(path, watched);
    if (sent && *sent == Backlog::some) backlog = Backlog::some;
    if (sent) continue;
    if (!report_file_fault(sent.error(), path, watched.reported_fault)) return failure(sent.error());
    pause_run(watched, sent.error());
  }
  for (const auto& path : found_documents_)
    if (auto sent = send_if_due(documents_[path], path, [&] { return send_document(path); }); !sent)
      return failure(sent.error());
  if (auto sent = send_check_standards(); !sent) return failure(sent.error());
  if (!reported_store_fault_.empty() || !has_sent_) report_("sending to the store: " + store_->describe());
  reported_store_fault_.clear();
  has_sent_ = true;
  return backlog;
}

Result<void> Publisher::serve() {
  Backoff backoff(settings_.longest_wait, process_seed());
  for (;;) {
    const Deadline next(kRoundInterval);
    const auto sent = run_round();
    auto wait = next.left();
    if (sent) {
      backoff.reset();
      if (*sent == Backlog::some) wait = {};
    } else {
      if (sent.error().kind == FaultKind::interrupted) return {};
      const bool is_permanent = sent.error().kind == FaultKind::bad_file || sent.error().kind == FaultKind::usage;
      if (is_permanent && !has_sent_) return failure(sent.error());
      disconnect(sent.error());
      wait = backoff.next();
    }
    if (wait_until_ready(limits_.stop, POLLIN, Deadline(wait))) return {};
  }
}

Result<void> Publisher::send_once() {
  first_file_fault_.reset();
  for (;;) {
    const auto sent = run_round();
    if (!sent) return failure(sent.error());
    if (*sent == Backlog::none) return first_file_fault_ ? Result<void>(failure(*first_file_fault_)) : Result<void>();
  }
}

Result<std::vector<RunLag>> Publisher::read_lags() {
  find_files();
  if (auto connected = connect(); !connected) return failure(connected.error());
  std::vector<RunLag> lags;
  for (const auto& folder : settings_.folders)
    if (const auto readable = check_folder(folder); !readable)
      lags.push_back({.name = folder, .error = readable.error().what});
  for (const auto& [path, watched] : runs_) {
    auto& lag = lags.emplace_back(RunLag{.name = path});
    const auto fresh = record::read_fresh_status(path);
    const auto status = fresh ? Result<record::RunStatus>(*fresh) : record::read_status(path);
    if (!status) {
      lag.error = text(status.error());
      continue;
    }
    lag.slot_on_rig = status->slot;
    lag.state = name(status->overview.state);
    const auto position = store_->position(status->id);
    if (!position && position.error().kind != FaultKind::refused) return failure(position.error());
    if (!position) lag.error = text(position.error());
    if (!position || !*position) continue;
    lag.slot_in_store = (*position)->slot;
    lag.finished_in_store = (*position)->finished;
  }
  return lags;
}

}  // namespace gyrotherm::site
