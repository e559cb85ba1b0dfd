#include "acquisition/text_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace gyrotherm {

Result<std::string> read_text_file(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return failure(FaultKind::bad_file, path, "no such file");
  std::ifstream file(path, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(file), {});
  if (!file) return failure(FaultKind::bad_file, path, "the file could not be read");
  return text;
}

Result<void> replace_text_file(const std::string& path, std::string_view text) {
  const std::string temporary = path + ".new";
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file) return failure(FaultKind::storage, temporary, "the file could not be written");
  if (std::rename(temporary.c_str(), path.c_str()) == 0) return {};
  return failure(FaultKind::storage, path, std::strerror(errno));
}

}  // namespace gyrotherm
