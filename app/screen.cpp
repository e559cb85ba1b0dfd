#include "app/screen.hpp"

#include <fmt/format.h>

#include <utility>

namespace gyrotherm {

std::string Screen::erase() {
  const auto open = std::exchange(lines_open_, 0);
  if (open == 0) return {};
  return (open > 1 ? fmt::format("\033[{}A", open - 1) : std::string()) + "\r\033[J";
}

std::string Screen::message(std::string_view text) { return erase() + std::string(text); }

std::string Screen::picture(const std::vector<std::string>& lines) {
  auto text = erase() + fmt::format("{}", fmt::join(lines, "\n"));
  lines_open_ = lines.size();
  return text;
}

std::string cut_to(const std::string& line, std::size_t width) {
  std::size_t characters = 0;
  for (std::size_t i = 0; i < line.size(); ++i)
    if ((static_cast<unsigned char>(line[i]) & 0xC0) != 0x80 && characters++ == width) return line.substr(0, i);
  return line;
}

}  // namespace gyrotherm
