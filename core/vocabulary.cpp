#include "core/vocabulary.hpp"

#include <filesystem>

#include "core/text_file.hpp"

namespace gyrotherm {

Result<NamedText> read_named(const TomlTable& table, const char* key, const std::string& file,
                             const std::optional<std::string>& known) {
  const auto name = table.text(key);
  NamedText named{.path = (std::filesystem::path(file).parent_path() / name).lexically_normal().string(),
                  .text = known.value_or("")};
  if (known) return named;
  auto text = read_text_file(named.path);
  if (!text) return failure(FaultKind::bad_file, table.place(key), text.error().where + " " + text.error().what);
  named.text = std::move(*text);
  return named;
}

}  // namespace gyrotherm
