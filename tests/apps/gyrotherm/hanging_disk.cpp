// SPDX-License-Identifier: Apache-2.0
/// Library for LD_PRELOAD that simulates a hanging disk. While the file named by GYROTHERM_HANG exists, no sync
/// returns. While the file named by GYROTHERM_HANG_STATUS exists, no status file is renamed into its position.
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace {

void wait_while_hanging(const char* variable = "GYROTHERM_HANG") {
  constexpr unsigned kLookUs = 10'000;
  const char* file = std::getenv(variable);
  while (file != nullptr && ::access(file, F_OK) == 0) ::usleep(kLookUs);
}

}  // namespace

extern "C" int renameat(int from_folder, const char* from, int to_folder, const char* to) {
  if (std::string_view(to).ends_with(".status")) wait_while_hanging("GYROTHERM_HANG_STATUS");
  return static_cast<int>(::syscall(SYS_renameat2, from_folder, from, to_folder, to, 0));
}

extern "C" int fsync(int file) {
  wait_while_hanging();
  return static_cast<int>(::syscall(SYS_fsync, file));
}

extern "C" int fdatasync(int file) {
  wait_while_hanging();
  return static_cast<int>(::syscall(SYS_fdatasync, file));
}
