// SPDX-License-Identifier: Apache-2.0
/// Scripts that let a shell complete a program's commands, options and values, made from CommandInfo. A script reads
/// the names of shipped files from `completion --names` when it needs them.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "apps/console/command.hpp"
#include "apps/console/command_info.hpp"

namespace gyrotherm::app {
namespace {

/// Replaces each `from` in the text by `to`.
std::string replace_all(std::string text, std::string_view from, std::string_view to) {
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

/// Quote text for bash and zsh, and for fish.
std::string shell_quoted(const std::string& text) { return "'" + replace_all(text, "'", "'\\''") + "'"; }
std::string fish_quoted(const std::string& text) {
  return "'" + replace_all(replace_all(text, "\\", "\\\\"), "'", "\\'") + "'";
}

std::string join_words(const std::vector<std::string>& words, const char* by = " ") {
  return fmt::format("{}", fmt::join(words, by));
}

/// Returns the name of a shell function: "gyrotherm-thermal" gives "_gyrotherm_thermal"; "__" and a subcommand follow
/// for each level. Shells accept the name, and no other program uses it.
std::string function_name(const CommandInfo& command, const char* prefix = "_") {
  std::string name = prefix + command.program;
  for (const auto& part : command.path) name += "__" + part;
  return replace_all(name, "-", "_");
}

std::vector<std::string> collect_names(const std::vector<CommandInfo>& commands) {
  std::vector<std::string> names;
  for (const auto& command : commands) names.push_back(command.path.back());
  return names;
}

std::vector<std::string> collect_names(const std::vector<OptionInfo>& options) {
  std::vector<std::string> names;
  for (const auto& option : options) names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

/// Calls `what` for a command and all commands below it.
void for_each_command(const CommandInfo& command, const std::function<void(const CommandInfo&)>& visit) {
  visit(command);
  for (const auto& subcommand : command.subcommands) for_each_command(subcommand, visit);
}

// ---- bash

/// Returns the argument for the script's _…_reply: "shipped RIG toml", "words coarse fine", "folders", "files db" or
/// "none".
std::string bash_reply_arguments(const OptionInfo& option) {
  if (!option.choices.empty()) return "words " + join_words(option.choices);
  const auto* kind = find_value_kind(option.value);
  if (kind == nullptr) return "none";
  if (kind->is_folder) return "folders";
  const auto endings = fmt::format("{}", fmt::join(kind->endings, " "));
  if (kind->shipped != nullptr) return fmt::format("shipped {} {}", kind->name, endings);
  return endings.empty() ? "files" : "files " + endings;
}

std::string bash_cases(const CommandInfo& command) {
  const auto path = join_words(command.path);
  std::string cases;
  for (const auto& option : command.options)
    if (!option.value.empty()) {
      std::vector<std::string> patterns;
      for (const auto& name : option.names) patterns.push_back(shell_quoted(path + "/" + name));
      cases +=
          fmt::format("    {}) offer={} ;;\n", join_words(patterns, " | "), shell_quoted(bash_reply_arguments(option)));
    }
  for (std::size_t i = 0; i < command.positionals.size(); ++i) {
    const auto position = command.positionals[i].repeats ? shell_quoted(path + "/") + "[0-9]*"
                                                         : shell_quoted(fmt::format("{}/{}", path, i + 1));
    cases += fmt::format("    {}) offer={} ;;\n", position, shell_quoted(bash_reply_arguments(command.positionals[i])));
  }
  return cases;
}

constexpr std::string_view kBash = R"bash(# bash completion of PROGRAM; made by: PROGRAM completion bash

# The commands below a command, and its options.
FUNCTION_words() {
  case $1 in
WORDS  esac
}

# What may stand as the value of an option, or at a place, of a command: "run/--rig", "run/1".
FUNCTION_offer() {
  offer=
  case $1 in
OFFERS  esac
}

FUNCTION_reply() {
  local names= ending kind=$1
  shift
  case $kind in
    none) return ;;
    words) names=$* ;;
    shipped)
      names=$("${COMP_WORDS[0]/#\~/$HOME}" completion --names "$1" 2>/dev/null)
      shift
      ;;
  esac
  local IFS=$'\n'
  COMPREPLY=($(compgen -W "${names// /$'\n'}" -- "$current"))
  [[ $kind == words ]] && return
  COMPREPLY+=($(compgen -d -- "$current"))
  compopt -o filenames 2>/dev/null
  [[ $kind == folders ]] && return
  if (($# == 0)); then
    COMPREPLY=($(compgen -f -- "$current"))
  else
    for ending; do COMPREPLY+=($(compgen -f -X "!*.$ending" -- "$current")); done
  fi
}

FUNCTION() {
  local current=${COMP_WORDS[COMP_CWORD]} command= place=1 awaited= offer= commands= options= word i
  COMPREPLY=()
  FUNCTION_words ""
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word=${COMP_WORDS[i]}
    if [[ $word == "=" ]]; then
      :
    elif [[ $awaited ]]; then
      awaited=
    elif [[ $word == -* ]]; then
      FUNCTION_offer "$command/$word"
      [[ $offer ]] && awaited=$word
    elif ((place == 1)) && [[ " $commands " == *" $word "* ]]; then
      command=${command:+$command }$word
      FUNCTION_words "$command"
    else
      ((++place))
    fi
  done
  [[ $current == "=" ]] && current=
  if [[ $awaited ]]; then
    FUNCTION_offer "$command/$awaited"
  elif [[ $current == -* ]]; then
    offer="words $options"
  else
    FUNCTION_offer "$command/$place"
    if ((place == 1)) && [[ $commands ]]; then
      FUNCTION_reply ${offer:-none}
      COMPREPLY+=($(compgen -W "$commands" -- "$current"))
      return
    fi
  fi
  FUNCTION_reply ${offer:-none}
}

complete -F FUNCTION PROGRAM
)bash";

// ---- zsh

/// Shortens a description for a list and removes characters that are special to _arguments.
std::string zsh_text(const std::string& description) {
  auto text = short_description(description);
  for (const char* special : {"[", "]", ":", "\\"}) text = replace_all(text, special, "");
  return text;
}

std::string zsh_action(const OptionInfo& option, const std::string& function) {
  if (!option.choices.empty()) return "(" + join_words(option.choices) + ")";
  const auto* kind = find_value_kind(option.value);
  if (kind == nullptr) return " ";
  if (kind->is_folder) return "_files -/";
  std::string pattern;
  if (kind->endings.size() == 1) pattern = fmt::format(" -g \"*.{}\"", kind->endings.front());
  if (kind->endings.size() > 1) pattern = fmt::format(" -g \"*.({})\"", fmt::join(kind->endings, "|"));
  // The leading blank keeps _arguments from changing the arguments of the call.
  if (kind->shipped != nullptr) return fmt::format(" {}__shipped {}{}", function, kind->name, pattern);
  return "_files" + pattern;
}

std::string zsh_specification(const OptionInfo& option, const std::string& function) {
  const auto text = zsh_text(option.description);
  const auto value =
      option.value.empty() ? "" : fmt::format(":{}:{}", zsh_text(option.value), zsh_action(option, function));
  const auto rest = fmt::format("{}[{}]{}", value.empty() ? "" : "=", text, value);
  const std::string again = option.repeats ? "*" : "";
  if (option.names.size() == 1) return shell_quoted(again + option.names.front() + rest);
  const auto others = option.repeats ? "'*'" : shell_quoted("(" + join_words(option.names) + ")");
  return fmt::format("{}{{{}}}{}", others, join_words(option.names, ","), shell_quoted(rest));
}

std::string zsh_function(const CommandInfo& command, const std::string& base) {
  const auto name = function_name(command);
  auto text = fmt::format("{}() {{\n", name);
  if (command.path.empty()) text += fmt::format("  {}__program=$words[1]\n", base);
  if (!command.subcommands.empty()) {
    text += "  local -a commands=(\n";
    for (const auto& subcommand : command.subcommands)
      text += fmt::format("    {}\n", shell_quoted(subcommand.path.back() + ":" + zsh_text(subcommand.description)));
    text += "  )\n  if ((CURRENT > 2)); then\n    case $words[2] in\n";
    for (const auto& subcommand : command.subcommands)
      text += fmt::format("      {}) shift words; ((CURRENT--)); {}; return ;;\n", subcommand.path.back(),
                          function_name(subcommand));
    text += "    esac\n  elif [[ $words[2] != -* ]]; then\n    _describe -t commands command commands\n  fi\n";
  }
  text += "  _arguments -S";
  for (const auto& option : command.options) text += " \\\n    " + zsh_specification(option, base);
  for (std::size_t i = 0; i < command.positionals.size(); ++i) {
    const auto& argument = command.positionals[i];
    const auto position = argument.repeats ? "*" : std::to_string(i + 1);
    text += " \\\n    " +
            shell_quoted(fmt::format("{}:{}:{}", position, zsh_text(argument.value), zsh_action(argument, base)));
  }
  return text + "\n}\n\n";
}

constexpr std::string_view kZsh = R"zsh(#compdef PROGRAM
# zsh completion of PROGRAM; made by: PROGRAM completion zsh

typeset -g FUNCTION__program

# Names of shipped files, and files: FUNCTION__shipped RIG -g "*.toml"
FUNCTION__shipped() {
  local -a names=(${(f)"$(_call_program names ${(q)FUNCTION__program} completion --names $1 2>/dev/null)"})
  shift
  compadd -a names
  _files "$@"
}

)zsh";

// ---- fish

std::string fish_arguments(const OptionInfo& option, const std::string& function) {
  if (!option.choices.empty()) return join_words(option.choices);
  const auto* kind = find_value_kind(option.value);
  if (kind == nullptr) return "";
  if (kind->is_folder) return "(__fish_complete_directories)";
  std::string text;
  if (kind->shipped != nullptr) text = fmt::format("({}_shipped {})", function, kind->name);
  if (!kind->endings.empty()) text += fmt::format(" ({}_files {})", function, fmt::join(kind->endings, " "));
  return text.empty() ? "(__fish_complete_path)" : text;
}

std::string fish_completions(const CommandInfo& command, const std::string& function) {
  const auto begin =
      fmt::format("complete -c {} -n {}", command.program,
                  fish_quoted(fmt::format("{}_at {}", function, shell_quoted(join_words(command.path)))));
  std::string text;
  for (const auto& subcommand : command.subcommands)
    text += fmt::format("{} -a {} -d {}\n", begin, subcommand.path.back(),
                        fish_quoted(short_description(subcommand.description)));
  for (const auto& option : command.options) {
    text += begin;
    for (const auto& name : option.names)
      text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    text += " -d " + fish_quoted(short_description(option.description));
    if (!option.value.empty()) text += " -x -a " + fish_quoted(fish_arguments(option, function));
    text += "\n";
  }
  for (const auto& argument : command.positionals)
    if (const auto values = fish_arguments(argument, function); !values.empty())
      text += fmt::format("{} -a {}\n", begin, fish_quoted(values));
  return text;
}

constexpr std::string_view kFish = R"fish(# fish completion of PROGRAM; made by: PROGRAM completion fish

# Whether the command that is being written is this one.
function FUNCTION_at
    set -l words (commandline -opc)
    set -e words[1]
    set -l path
    for word in $words
        string match -q -- '-*' $word; and break
        contains -- (string join ' ' $path $word) PATHS; or break
        set -a path $word
    end
    test "$path" = "$argv"
end

function FUNCTION_shipped
    set -l words (commandline -opc)
    command $words[1] completion --names $argv 2>/dev/null
end

# Folders, and files with these endings.
function FUNCTION_files
    set -l begun (string replace -r -- '^--[^=]*=' '' (commandline -ct))
    for file in (complete -C "FUNCTION_none "$begun)
        string match -rq '(/|\\.('(string join '|' $argv)'))$' -- (string split -f 1 -- \t $file); and echo $file
    end
end

complete -c PROGRAM -f
)fish";

std::string fill_template(std::string_view text, const CommandInfo& program, const char* prefix) {
  return replace_all(replace_all(std::string(text), "FUNCTION", function_name(program, prefix)), "PROGRAM",
                     program.program);
}

std::string bash_completion(const CommandInfo& program) {
  std::string words, offers;
  for_each_command(program, [&](const CommandInfo& command) {
    words += fmt::format("    {}) commands={} options={} ;;\n", shell_quoted(join_words(command.path)),
                         shell_quoted(join_words(collect_names(command.subcommands))),
                         shell_quoted(join_words(collect_names(command.options))));
    offers += bash_cases(command);
  });
  return replace_all(replace_all(fill_template(kBash, program, "_"), "WORDS  ", words + "  "), "OFFERS  ",
                     offers + "  ");
}

std::string zsh_completion(const CommandInfo& program) {
  auto text = fill_template(kZsh, program, "_");
  const auto base = function_name(program);
  for_each_command(program, [&](const CommandInfo& command) { text += zsh_function(command, base); });
  return text + fmt::format("{} \"$@\"\n", base);
}

std::string fish_completion(const CommandInfo& program) {
  const auto function = function_name(program, "__");
  std::string paths, lines;
  for_each_command(program, [&](const CommandInfo& command) {
    if (!command.path.empty()) paths += (paths.empty() ? "" : " ") + fish_quoted(join_words(command.path));
    lines += fish_completions(command, function);
  });
  return replace_all(fill_template(kFish, program, "__"), "PATHS", paths) + lines;
}

struct CompletionArguments {
  std::string shell, names;
};

Result<Exit> complete(Program& program, const CompletionArguments& options) {
  if (!options.names.empty()) {
    const auto* kind = find_value_kind(options.names);
    if (kind == nullptr || kind->shipped == nullptr)
      return failure(FaultKind::usage, "--names", fmt::format("\"{}\" has no shipped files", options.names));
    for (const auto& name : shipped_names(*kind->shipped)) program.console.print(name + "\n");
    return Exit::done;
  }
  if (options.shell.empty()) return failure(FaultKind::usage, "completion", "expected a shell: bash, zsh or fish");
  const auto commands = describe_commands(program.cli);
  program.console.print(options.shell == "bash"  ? bash_completion(commands)
                        : options.shell == "zsh" ? zsh_completion(commands)
                                                 : fish_completion(commands));
  return Exit::done;
}

}  // namespace

void add_completion(Program& program) {
  const auto options = std::make_shared<CompletionArguments>();
  const auto name = program.cli.get_name();
  auto& command = add_command(program, "completion",
                              "Prints a script that lets a shell complete commands, options, and names of profiles and "
                              "rigs.",
                              fmt::format("{} completion bash", name));
  command.add_option("shell", options->shell, "bash, zsh or fish")
      ->type_name("SHELL")
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command.add_option("--names", options->names, "names of the shipped files of a kind; used by these scripts")
      ->group("");
  command.callback([&program, options] { program.outcome = complete(program, *options); });
}

}  // namespace gyrotherm::app
