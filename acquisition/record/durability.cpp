#include "acquisition/record/durability.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace gyrotherm {
namespace {

struct Setting {
  const char* pragma;
  const char* value;
  const char* read_back;
};

/// FULL, so that a commit is on the disk when it returns. The log is folded in by the writer: SQLite's own way would
/// hide its failure.
constexpr std::array kDurable{
    Setting{"journal_mode", "WAL", "wal"},
    Setting{"synchronous", "FULL", "2"},
    Setting{"wal_autocheckpoint", "0", "0"},
};
constexpr Setting kExclusive{"locking_mode", "EXCLUSIVE", "exclusive"};
/// On its way out of WAL mode SQLite writes the first page anew, of which only bytes 18 to 99 differ: a disk that
/// writes sectors whole has the old page or the new one, and both are read. So the journal of that stays in memory.
/// Into WAL mode it goes while the file is empty.
constexpr Setting kNoJournal{"journal_mode", "MEMORY", "memory"};

Result<void> apply(Database& database, const Setting& setting, const std::string& path) {
  if (const auto set = database.ask(fmt::format("PRAGMA {} = {}", setting.pragma, setting.value)); !set)
    return failure(set.error());
  const auto now = database.ask(fmt::format("PRAGMA {}", setting.pragma));
  if (!now) return failure(now.error());
  if (*now == setting.read_back) return {};
  return failure(FaultKind::storage, path,
                 fmt::format("SQLite keeps {} at \"{}\", expected \"{}\"", setting.pragma, *now, setting.read_back));
}

}  // namespace

Result<void> make_new_file(const std::string& path) {
  constexpr mode_t kForTheGroup = 0640;  // of its log too, which SQLite makes like it
  const int file = ::open(path.c_str(), O_CREAT | O_EXCL | O_NOFOLLOW | O_WRONLY | O_CLOEXEC, kForTheGroup);
  if (file < 0 && errno == EEXIST)
    return failure(FaultKind::storage, path, "exists already, and a record is never overwritten");
  if (file < 0) return failure(FaultKind::storage, path, std::strerror(errno));
  ::close(file);
  return {};
}

Result<void> claim(Database& database, const std::string& path) { return apply(database, kExclusive, path); }

Result<void> keep_no_journal(Database& database, const std::string& path) { return apply(database, kNoJournal, path); }

Result<void> make_durable(Database& database, const std::string& path) {
  for (const Setting& setting : kDurable)
    if (auto applied = apply(database, setting, path); !applied) return applied;
  return {};
}

}  // namespace gyrotherm
