/// The file system through which SQLite reads a record: it can read, and has no way to do anything else.
///
/// A record may come from anywhere. SQLite's own file system plays back a journal that lies beside a file, deletes the
/// journals that this one names, makes an index of a log, and folds a log in; this one opens files to read alone, makes
/// and removes none, and shows no journal. A log beside the file is read where it lies, its index kept in memory.
#pragma once

namespace gyrotherm {

/// Its name, for sqlite3_open_v2(); it is registered when it is first asked for. The connection must have
/// locking_mode EXCLUSIVE before its first statement. A file that a writer holds does not open (SQLITE_BUSY); while it
/// is open no writer can begin.
///
/// That is told by a lock of the open file itself (F_OFD_SETLK) on the bytes that SQLite locks (its "File Locking And
/// Concurrency"). Closing the file still drops the locks of a writer in this very process, as any close does: no record
/// may be opened that it writes (written_here.hpp).
[[nodiscard]] const char* reader_vfs();

}  // namespace gyrotherm
