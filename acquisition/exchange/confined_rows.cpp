// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/confined_rows.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>
#include <string_view>
#include <vector>

#include "acquisition/exchange/foreign_time.hpp"
#include "acquisition/record/row.hpp"
#include "core/child_process.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {
namespace {

// A message is its kind, the size of its content in 8 bytes, and the content: many rows, a text, a fault, or nothing at
// the end.
enum class MessageKind : char { rows = 'R', text = 'T', fault = 'F', end = 'E' };
constexpr std::size_t kMessageHead = 1 + sizeof(std::uint64_t), kLargestRows = 1 << 18, kLargestText = 1 << 16;

/// The fixed part of a row. Its numbers follow.
struct RowHead {
  std::int64_t time_ns{}, utc_ns{};
  std::int64_t has_utc{};
};

std::size_t size_of_row(std::size_t columns) { return sizeof(RowHead) + columns * sizeof(double); }

/// Sends rows from the child process.
class RowWriter {
 public:
  explicit RowWriter(int line) : line_(line) {}

  void add(const ForeignRow& row) {
    const RowHead head{row.time.count(), row.utc.value_or(Duration{}).count(), row.utc.has_value()};
    rows_.append(reinterpret_cast<const char*>(&head), sizeof head);
    rows_.append(reinterpret_cast<const char*>(row.numbers.data()), row.numbers.size_bytes());
    if (rows_.size() + size_of_row(row.numbers.size()) > kLargestRows) send();
  }
  void send() {
    if (!rows_.empty()) write(MessageKind::rows, rows_);
    rows_.clear();
  }
  void write(MessageKind kind, std::string_view content) const {
    const std::uint64_t size = content.size();
    std::string message(1, static_cast<char>(kind));
    message.append(reinterpret_cast<const char*>(&size), sizeof size).append(content);
    if (!write_all(line_, message)) ::_exit(1);  // the parent has ended
  }
  void write(const Fault& fault) const {
    write(MessageKind::fault, std::string(1, static_cast<char>(fault.kind)) + fault.where + '\0' + fault.what);
  }

 private:
  int line_;
  std::string rows_{};
};

void read_in_child(int line, const ReadInSteps& read, const ReadingLimits& limits) {
  RowWriter writer(line);
  const auto done = read(
      [&](const ForeignRow& row) -> Result<void> {
        writer.add(row);
        return {};
      },
      [&] { limit_processor_time(limits.processor_time); });
  writer.send();
  done ? writer.write(MessageKind::end, "") : writer.write(done.error());
}

void read_text_in_child(int line, const ReadTextInSteps& read, const ReadingLimits& limits) {
  const RowWriter writer(line);
  const auto text = read([&] { limit_processor_time(limits.processor_time); });
  if (!text) return writer.write(text.error());
  writer.write(MessageKind::text, std::string_view(*text).substr(0, kLargestText));
  writer.write(MessageKind::end, "");
}

/// Receives rows in the parent process. Messages of the child are untrusted, like the file.
class RowReader {
 public:
  RowReader(const std::string& path, const std::string& library, std::size_t columns, const TakeRow& take,
            const ReadingLimits& limits, ChildProcess& child)
      : path_(path), library_(library), take_(take), limits_(limits), child_(child), numbers_(columns) {}

  Result<void> read() {
    while (true) {
      std::array<char, kMessageHead> head{};
      if (auto got = fill(head.data(), head.size()); !got) return got;
      std::uint64_t size = 0;
      std::memcpy(&size, head.data() + 1, sizeof size);
      const auto kind = static_cast<MessageKind>(head[0]);
      if (size > std::max(kLargestRows + size_of_row(numbers_.size()), kLargestText)) return malformed_message();
      content_.resize(size);
      if (auto got = fill(content_.data(), size); !got) return got;
      if (kind == MessageKind::end && size == 0) return {};
      if (kind == MessageKind::fault) return fault();
      if (kind == MessageKind::text) {
        text_ = content_;
        continue;
      }
      if (kind != MessageKind::rows) return malformed_message();
      if (auto taken = take_rows(); !taken) return taken;
    }
  }
  /// Returns the text that the child sent.
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  tl::unexpected<Fault> read_failure(const std::string& what) const {
    return failure(FaultKind::bad_file, path_, fmt::format("cannot be read: {} {}", library_, what));
  }
  tl::unexpected<Fault> malformed_message() const {
    return read_failure("sent an invalid message; the file may have corrupted its memory");
  }

  Result<void> fill(char* bytes, std::size_t size) {
    while (size > 0) {
      if (!wait_until_ready(child_.output(), POLLIN, Deadline(limits_.silence)))
        return read_failure(fmt::format("returned no row for {:g} s", to_seconds(limits_.silence)));
      const auto got = read_some(child_.output(), bytes, size);
      if (got <= 0) return read_failure(end_reason());
      bytes += got;
      size -= static_cast<std::size_t>(got);
    }
    return {};
  }

  /// Returns the reason why the child ended before its last message.
  std::string end_reason() {
    const auto status = child_.wait(std::chrono::seconds(10));
    if (!status) return "closed its output but did not exit";
    if (WIFEXITED(*status) && WEXITSTATUS(*status) == kOutOfMemoryExitCode)
      return fmt::format("needs more than {} MiB of memory", limits_.memory_bytes >> 20);
    if (WIFSIGNALED(*status) && WTERMSIG(*status) == SIGXCPU)
      return fmt::format("needs more than {} s of processor time for one step", limits_.processor_time.count());
    if (WIFSIGNALED(*status) && WTERMSIG(*status) == SIGXFSZ) return "tried to write a file";
    return describe_exit_status(*status) + " while reading the file";
  }

  Result<void> fault() const {
    const auto end_of_where = content_.find('\0', 1);
    const auto kind = content_.empty() ? -1 : content_.front();
    if (end_of_where == std::string::npos || kind < 0 || kind > static_cast<int>(FaultKind::usage))
      return malformed_message();
    return failure(static_cast<FaultKind>(kind), content_.substr(1, end_of_where - 1),
                   content_.substr(end_of_where + 1));
  }

  Result<void> take_rows() {
    const std::size_t row_size = size_of_row(numbers_.size());
    if (content_.empty() || content_.size() % row_size != 0) return malformed_message();
    for (std::size_t at = 0; at < content_.size(); at += row_size, ++row_) {
      RowHead head;
      std::memcpy(&head, content_.data() + at, sizeof head);
      if (!numbers_.empty())
        std::memcpy(numbers_.data(), content_.data() + at + sizeof head, numbers_.size() * sizeof(double));
      ForeignRow row{.time = Duration(head.time_ns), .numbers = numbers_};
      if (head.has_utc != 0) row.utc = Duration(head.utc_ns);
      if (row.time < -kLongestForeignTime || row.time > kLongestForeignTime ||
          (row.utc && !record::is_possible_time(*row.utc)))
        return malformed_message();
      auto taken = take_(row);
      if (!taken && taken.error().where.empty()) taken.error().where = fmt::format("{}: row {}", path_, row_);
      if (!taken) return taken;
    }
    return {};
  }

  const std::string& path_;
  const std::string& library_;
  const TakeRow& take_;
  const ReadingLimits& limits_;
  ChildProcess& child_;
  std::vector<double> numbers_;
  std::string content_{}, text_{};
  std::size_t row_{};
};

tl::unexpected<Fault> no_process_failure(const std::string& path) {
  return failure(FaultKind::storage, path, "no process can be started for the library that reads it");
}

}  // namespace

Result<void> read_confined(const std::string& path, const std::string& library, std::size_t columns,
                           const ReadInSteps& read, const TakeRow& take, const ReadingLimits& limits) {
  ChildProcess child([&](int line) { read_in_child(line, read, limits); }, Confinement{limits.memory_bytes});
  if (!child.has_begun()) return no_process_failure(path);
  return RowReader(path, library, columns, take, limits, child).read();
}

Result<std::string> read_text_confined(const std::string& path, const std::string& library, const ReadTextInSteps& read,
                                       const ReadingLimits& limits) {
  ChildProcess child([&](int line) { read_text_in_child(line, read, limits); }, Confinement{limits.memory_bytes});
  if (!child.has_begun()) return no_process_failure(path);
  const TakeRow no_rows = [](const ForeignRow&) { return Result<void>(); };
  RowReader reader(path, library, 0, no_rows, limits, child);
  return reader.read().map([&] { return reader.text(); });
}

}  // namespace gyrotherm::exchange
