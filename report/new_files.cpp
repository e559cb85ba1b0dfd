// SPDX-License-Identifier: Apache-2.0
#include "report/new_files.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>

#include "core/file.hpp"

namespace gyrotherm::report {

Result<void> replace_all(const std::string& folder, const std::vector<NewFile>& files) {
  const auto beside = [&](const NewFile& file) { return folder + "/" + file.name + ".new"; };
  Result<void> done;
  std::vector<NewFile> written;
  for (const NewFile& file : files) {
    if (done = replace_text_file(beside(file), file.bytes); !done) break;
    written.push_back(file);
  }
  for (const NewFile& file : written) {
    std::error_code error;
    const std::string path = folder + "/" + file.name;
    if (done) std::filesystem::rename(beside(file), path, error);
    if (error) done = failure(FaultKind::storage, path, "cannot be written: " + error.message());
    if (!done) std::filesystem::remove(beside(file), error);
  }
  const Descriptor place(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (place.is_open()) ::fsync(place.number());
  return done;
}

}  // namespace gyrotherm::report
