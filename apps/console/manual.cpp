// SPDX-License-Identifier: Apache-2.0
/// Manual pages. Names, synopsis and options come from CommandInfo, prose from docs/man. The build makes the pages with
/// the hidden command `gyrotherm manual`.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/console/command.hpp"
#include "apps/console/command_info.hpp"
#include "core/file.hpp"

namespace gyrotherm::app {
namespace {

/// Content of a page that is not part of CommandInfo: prose of docs/man, release date and version of the program.
struct ManualText {
  std::string prose;  ///< description paragraphs, then sections
  std::string date;   ///< release date, "2026-11-21"
  std::string version;
};

/// Escapes text for roff: backslashes and hyphens are printed literally, and no line is taken for a request.
std::string escape_roff(std::string_view text) {
  std::string escaped;
  bool begins_line = true;
  for (const char character : text) {
    if (begins_line && (character == '.' || character == '\'')) escaped += "\\&";
    if (character == '\\')
      escaped += "\\e";
    else if (character == '-')
      escaped += "\\-";
    else
      escaped += character;
    begins_line = character == '\n';
  }
  return escaped;
}

std::string bold(std::string_view text) { return "\\fB" + escape_roff(text) + "\\fP"; }
std::string italic(std::string_view text) { return "\\fI" + escape_roff(text) + "\\fP"; }

std::string upper_case(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char letter) { return static_cast<char>(std::toupper(letter)); });
  return text;
}

/// Returns the command as it is typed, such as "gyrotherm report sign".
std::string full_name(const CommandInfo& command) {
  return command.path.empty() ? command.program : fmt::format("{} {}", command.program, fmt::join(command.path, " "));
}

/// Returns the name of the manual page, such as "gyrotherm-report".
std::string page_name(const CommandInfo& command) {
  return command.path.empty() ? command.program : command.program + "-" + command.path.front();
}

std::string format_value(const OptionInfo& option) {
  if (option.choices.empty()) return italic(option.value);
  std::string text;
  for (const auto& choice : option.choices) text += (text.empty() ? "" : " | ") + bold(choice);
  return text;
}

/// Returns the command with its required arguments and options; all other options are shown as "[options]".
std::string format_synopsis(const CommandInfo& command) {
  auto text = bold(full_name(command));
  for (const auto& argument : command.positionals) {
    auto shown = italic(argument.value) + (argument.is_repeatable ? " …" : "");
    text += argument.is_required ? " " + shown : " [" + shown + "]";
  }
  for (const auto& option : command.options)
    if (option.is_required) text += " " + bold(option.names.back()) + " " + format_value(option);
  return text + " [" + italic("options") + "]\n";
}

std::string format_option(const OptionInfo& option) {
  std::string names;
  for (const auto& name : option.names) names += (names.empty() ? "" : ", ") + bold(name);
  if (option.names.empty())
    names = italic(option.value);
  else if (!option.value.empty())
    names += " " + format_value(option);
  return fmt::format(".TP\n{}\n{}{}\n", names, escape_roff(option.description),
                     !option.names.empty() && option.is_repeatable ? "; may be given several times" : "");
}

/// Returns true for an option that every command has. Such options are listed last.
bool is_common(const OptionInfo& option) {
  const auto& name = option.names.back();
  return name == "--help" || name == "--json" || name == "--verbose" || name == "--quiet" || name == "--version";
}

std::string format_options(const CommandInfo& command) {
  std::string text, common;
  for (const auto& argument : command.positionals) text += format_option(argument);
  for (const auto& option : command.options) (is_common(option) ? common : text) += format_option(option);
  return text + common;
}

/// Formats a description, whose paragraphs are separated by empty lines. Line breaks inside a paragraph are kept.
std::string format_paragraphs(const std::string& description) {
  std::string text;
  for (std::size_t at = 0; at < description.size();) {
    const auto ends = std::min(description.find("\n\n", at), description.size());
    const auto paragraph = description.substr(at, ends - at);
    std::string shown = escape_roff(paragraph);
    for (auto line = shown.find('\n'); line != std::string::npos; line = shown.find('\n', line + 5))
      shown.replace(line, 1, "\n.br\n");
    text += (text.empty() ? "" : ".PP\n") + shown + "\n";
    at = ends + 2;
  }
  return text;
}

std::string format_example(const CommandInfo& command) {
  return command.example.empty() ? "" : fmt::format(".PP\n.EX\n{}\n.EE\n", escape_roff(command.example));
}

/// Formats `text` as bold and *text* as italic. No other character is special.
std::string format_inline(std::string_view line) {
  std::string shown;
  std::string_view left = line;
  while (!left.empty()) {
    const auto mark = left.find_first_of("`*");
    const auto ends = mark == std::string_view::npos ? mark : left.find(left[mark], mark + 1);
    if (ends == std::string_view::npos) return shown + escape_roff(left);
    shown += escape_roff(left.substr(0, mark));
    const auto words = left.substr(mark + 1, ends - mark - 1);
    shown += left[mark] == '`' ? bold(words) : italic(words);
    left.remove_prefix(ends + 1);
  }
  return shown;
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Converts prose of docs/man: "# SECTION", "## Part", paragraphs, a term above the lines ": …" that explain it, and
/// lines indented by four blanks, which are printed literally.
std::string prose_to_roff(const std::string& prose) {
  const auto lines = split_lines(prose);
  std::string page;
  // A paragraph begins; the line is part of a code block.
  bool is_new = false, is_code = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto& line = lines[i];
    const bool indented = line.starts_with("    ");
    if (is_code && !indented) page += ".EE\n.RE\n";
    if (!is_code && indented) page += ".PP\n.RS 4\n.EX\n";
    is_code = indented;
    const bool is_term = i + 1 < lines.size() && lines[i + 1].starts_with(": ");
    if (line.empty()) {
      is_new = true;
    } else if (line.starts_with("# ")) {
      page += ".SH " + line.substr(2) + "\n";
    } else if (line.starts_with("## ")) {
      page += ".SS " + escape_roff(line.substr(3)) + "\n";
    } else if (indented) {
      page += escape_roff(line.substr(4)) + "\n";
    } else if (line.starts_with(": ")) {
      page += format_inline(line.substr(2)) + "\n";
    } else if (is_term) {
      page += ".TP\n" + format_inline(line) + "\n";
    } else {
      const bool follows_heading = i == 0 || (i > 1 && lines[i - 2].starts_with("#") && lines[i - 1].empty());
      page += (is_new && !follows_heading ? ".PP\n" : "") + format_inline(line) + "\n";
    }
    if (!line.empty()) is_new = false;
  }
  return page + (is_code ? ".EE\n.RE\n" : "");
}

/// Prose of a page in roff: text before the first section, the sections, and SEE ALSO, which must be the last one.
struct Sections {
  std::string first, middle, see_also;
};

Sections split_sections(const std::string& prose) {
  const auto begins = std::min(prose.starts_with("# ") ? 0 : prose.find("\n# "), prose.size());
  const auto last = std::max(begins, std::min(prose.find("# SEE ALSO"), prose.size()));
  return {prose_to_roff(prose.substr(0, begins)), prose_to_roff(prose.substr(begins, last - begins)),
          prose_to_roff(prose.substr(last))};
}

std::string page_header(const std::string& name, const ManualText& text) {
  return fmt::format(".\\\" SPDX-License-Identifier: Apache-2.0\n.TH {} 1 {} \"gyrotherm {}\" \"gyrotherm\"\n.nh\n",
                     escape_roff(upper_case(name)), text.date, text.version);
}

/// Returns the short description of a command, without the program's name at its start.
std::string command_purpose(const CommandInfo& command) {
  auto text = short_description(command.description);
  return text.starts_with(command.program + " ") ? text.substr(command.program.size() + 1) : text;
}

/// Lists the subcommands. The page of gyrotherm refers to a separate page per subcommand; all other pages describe
/// their subcommands completely.
std::string format_subcommands(const CommandInfo& command) {
  if (command.subcommands.empty()) return {};
  std::string text = ".SH COMMANDS\n";
  const bool have_pages = command.path.empty() && command.program == "gyrotherm";
  for (const auto& subcommand : command.subcommands)
    text += have_pages ? fmt::format(".TP\n.BR {} (1)\n{}\n", escape_roff(page_name(subcommand)),
                                     escape_roff(short_description(subcommand.description)))
                       : fmt::format(".SS {}\n{}.PP\n{}{}{}", escape_roff(full_name(subcommand)),
                                     format_synopsis(subcommand), format_paragraphs(subcommand.description),
                                     format_example(subcommand), format_options(subcommand));
  return text;
}

std::string exit_status_section() {
  std::string text = ".SH EXIT STATUS\n";
  for (const auto& [exit, meaning] : kExitMeanings)
    text += fmt::format(".TP\n.B {}\n{}\n", static_cast<int>(exit), escape_roff(meaning));
  return text;
}

/// Returns the page of a command and its subcommands. The sections of the prose are between the options and the exit
/// status; SEE ALSO is at the end.
std::string manual_page(const CommandInfo& command, const ManualText& text) {
  const auto prose = split_sections(text.prose);
  auto page = page_header(page_name(command), text) +
              fmt::format(".SH NAME\n{} \\- {}\n.SH SYNOPSIS\n{}.SH DESCRIPTION\n{}{}", escape_roff(page_name(command)),
                          escape_roff(command_purpose(command)), format_synopsis(command),
                          format_paragraphs(command.description), prose.first.empty() ? "" : ".PP\n" + prose.first);
  if (const auto entries = format_options(command); !entries.empty()) page += ".SH OPTIONS\n" + entries;
  return page + format_subcommands(command) + prose.middle + exit_status_section() + prose.see_also;
}

/// Returns a page of prose only, for a program that parses its command line itself.
std::string manual_page(const std::string& name, const ManualText& text) {
  return page_header(name, text) + prose_to_roff(text.prose);
}

struct ManualArguments {
  std::string command, prose, date, name;
};

Result<Exit> print_page(Program& program, const ManualArguments& options) {
  auto prose = options.prose.empty() ? Result<std::string>("") : read_text_file(options.prose);
  if (!prose) return failure(prose.error());
  const ManualText text{.prose = std::move(*prose), .date = options.date, .version = GYROTHERM_VERSION};
  if (!options.name.empty()) {
    program.console.print(manual_page(options.name, text));
    return Exit::done;
  }
  const auto commands = describe_commands(program.cli);
  const CommandInfo* selected = options.command.empty() ? &commands : nullptr;
  for (const auto& command : commands.subcommands)
    if (command.path.back() == options.command) selected = &command;
  if (selected == nullptr)
    return failure(FaultKind::usage, "manual", fmt::format("unknown command \"{}\"", options.command));
  program.console.print(manual_page(*selected, text));
  return Exit::done;
}

}  // namespace

void add_manual(Program& program) {
  const auto options = std::make_shared<ManualArguments>();
  auto& command = add_command(program, "manual", "Prints the manual page of a command in the macros of man(7).",
                              "gyrotherm manual run --prose docs/man/gyrotherm-run.md");
  command.group("");
  command.add_option("command", options->command, "command to describe (default: the program itself)");
  command.add_option("--prose", options->prose, "file with the text of the page");
  command.add_option("--name", options->name, "name of a page without options, for a program with its own parser");
  command.add_option("--date", options->date, "release date, such as 2026-11-21");
  command.callback([&program, options] { program.outcome = print_page(program, *options); });
}

}  // namespace gyrotherm::app
