// SPDX-License-Identifier: Apache-2.0
/// A disk that hangs, for a program that is started with this in LD_PRELOAD: as long as the file is there that
/// GYROTHERM_HANG names, no sync comes back; as long as that of GYROTHERM_HANG_STATUS is there, no status file is put
/// in its place.
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
