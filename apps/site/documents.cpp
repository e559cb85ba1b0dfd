// SPDX-License-Identifier: Apache-2.0
#include "apps/site/documents.hpp"

#include <array>
#include <filesystem>

#include "core/file.hpp"
#include "core/json.hpp"
#include "core/text.hpp"

namespace gyrotherm::site {
namespace {

constexpr std::array kKinds{"calibration", "model", "report"};
constexpr std::size_t kLargestDocument = 32'000'000;

}  // namespace

Result<std::optional<Document>> read_document(const std::string& path) {
  auto text = read_text_file(path, kLargestDocument);
  if (!text) return failure(text.error());
  constexpr bool kNoExceptions = false;
  const auto json = Json::parse(*text, nullptr, kNoExceptions);
  if (!json.is_object() || !json.contains("schema") || !json["schema"].is_string() || !is_utf8(*text))
    return std::nullopt;
  const auto schema = json["schema"].get<std::string>();
  for (const std::string kind : kKinds)
    if (schema.starts_with("gyrotherm-" + kind + "/"))
      return Document{.kind = kind, .name = std::filesystem::path(path).filename().string(), .text = std::move(*text)};
  return std::nullopt;
}

}  // namespace gyrotherm::site
