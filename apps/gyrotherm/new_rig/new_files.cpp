// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/new_rig/new_files.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <system_error>

#include "core/file.hpp"

namespace gyrotherm::app {
namespace {

class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_{};
};

/// Creates a file and sets `is_created` if it has to be removed after a failure.
Result<void> create_file(const NewFile& file, bool& is_created) {
  constexpr mode_t kReadable = 0644;
  const Descriptor descriptor(
      ::open(file.path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kReadable));
  if (!descriptor.is_open() && errno == EEXIST) return refuse_to_overwrite(file.path);
  is_created = descriptor.is_open();
  if (is_created && write_all(descriptor.number(), file.text) && ::fsync(descriptor.number()) == 0) return {};
  return failure(FaultKind::storage, file.path, "cannot be written: " + std::generic_category().message(errno));
}

}  // namespace

tl::unexpected<Fault> refuse_to_overwrite(const std::string& path) {
  return failure(FaultKind::usage, path, "exists already and is never overwritten; choose another name");
}

Result<void> create_files(const std::vector<NewFile>& files) {
  const BlockedSignals until_written;
  for (std::size_t i = 0; i < files.size(); ++i) {
    bool is_created = false;
    auto created = create_file(files[i], is_created);
    if (created) continue;
    if (is_created) ::unlink(files[i].path.c_str());
    for (std::size_t earlier = 0; earlier < i; ++earlier) ::unlink(files[earlier].path.c_str());
    return created;
  }
  return {};
}

}  // namespace gyrotherm::app
