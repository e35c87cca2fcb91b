#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "cli/commands/commands.h"
#include "twin/core/error.h"

// What other programs want to know of the command line, all of it out of the commands' own
// descriptions: completion for three shells, and the manual page.
namespace twin::cli {
namespace {

struct CompletionFlags {
  std::string format;
  const CLI::App* app = nullptr;
};

enum class Value { kNone, kFile, kFolder, kWord, kOther };

/// An option, as help shows it.
struct Described {
  std::string name{};        ///< "--out"; of a positional "scenario"
  std::string short_name{};  ///< "-h", or empty
  std::string text;
  std::string type{};  ///< "DIR"; empty: it takes no value
  Value value = Value::kNone;
  bool is_positional = false;
};

/// A command, or one of its own commands.
struct Command {
  std::string path;  ///< "", "run", "video check"
  std::string text;
  std::string footer;
  std::vector<Described> options;
  std::vector<const CLI::App*> commands;
};

Value ValueOf(std::string_view type) {
  if (type.find("FILE") != std::string_view::npos) return Value::kFile;
  if (type == "DIR") return Value::kFolder;
  return type.find('|') != std::string_view::npos ? Value::kWord : Value::kOther;
}

Described Describe(const CLI::Option& option) {
  Described described{.text = option.get_description()};
  described.is_positional = !option.nonpositional();
  described.name = described.is_positional ? option.get_name() : "--" + option.get_lnames().front();
  if (!option.get_snames().empty()) described.short_name = "-" + option.get_snames().front();
  if (option.get_items_expected_max() == 0) return described;
  described.type = option.get_type_name();
  described.value = ValueOf(described.type);
  return described;
}

/// All commands below and with `app`, each before its own.
void Collect(const CLI::App& app, const std::string& path, std::vector<Command>& commands) {
  const auto below = app.get_subcommands([](const CLI::App*) { return true; });
  Command command{path, app.get_description(), app.get_footer(), {}, {below.begin(), below.end()}};
  for (const CLI::Option* option : app.get_options()) command.options.push_back(Describe(*option));
  commands.push_back(std::move(command));
  for (const CLI::App* one : below) {
    Collect(*one, path.empty() ? one->get_name() : path + ' ' + one->get_name(), commands);
  }
}

std::string Replaced(std::string text, std::string_view what, std::string_view by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size()) {
    text.replace(at, what.size(), by);
  }
  return text;
}

/// Names of a command's own commands, and words of its positionals.
std::string WordsOf(const Command& command) {
  std::string words;
  for (const CLI::App* one : command.commands) words += one->get_name() + ' ';
  for (const Described& option : command.options) {
    if (option.is_positional && option.value == Value::kWord) {
      words += Replaced(option.type, "|", " ");
    }
  }
  return words;
}

std::string Bash(const std::vector<Command>& commands) {
  std::string paths;
  std::string cases;
  for (const Command& command : commands) {
    std::string flags;
    std::string values;
    std::string files;
    for (const Described& option : command.options) {
      if (option.is_positional) continue;
      flags += option.name + ' ';
      if (option.value == Value::kWord) {
        cases += fmt::format("    '{}/{}') words='{}' ;;\n", command.path, option.name,
                             Replaced(option.type, "|", " "));
      } else if (option.value == Value::kOther) {
        values += fmt::format("{}'{}/{}'", values.empty() ? "" : "|", command.path, option.name);
      } else if (option.value != Value::kNone) {
        files += fmt::format("{}'{}/{}'", files.empty() ? "" : "|", command.path, option.name);
      }
    }
    if (!values.empty()) cases += fmt::format("    {}) compopt +o default ;;\n", values);
    if (!files.empty()) cases += fmt::format("    {}) ;;\n", files);
    cases += fmt::format("    '{}/'*) words='{}' flags='{}' ;;\n", command.path, WordsOf(command),
                         flags);
    if (!command.path.empty())
      paths += fmt::format("{}'{}'", paths.empty() ? "" : "|", command.path);
  }
  return fmt::format(R"(_panda_twin() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} path='' words='' flags='' i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "${{path:+$path }}${{COMP_WORDS[i]}}" in
      {}) path="${{path:+$path }}${{COMP_WORDS[i]}}" ;;
    esac
  done
  case "$path/${{COMP_WORDS[COMP_CWORD-1]}}" in
{}  esac
  [[ $word == -* ]] && words=$flags
  COMPREPLY=($(compgen -W "$words" -- "$word"))
}}
complete -o default -F _panda_twin panda-twin
)",
                     paths, cases);
}

/// A text in single quotes, of zsh's _arguments and _describe.
std::string ZshText(const std::string& text) {
  std::string quoted = Replaced(text, "'", "'\\''");
  for (const char* const special : {"[", "]", ":"}) {
    quoted = Replaced(quoted, special, std::string("\\") + special);
  }
  return quoted;
}

std::string Zsh(const std::vector<Command>& commands) {
  std::string text = "#compdef panda-twin\n";
  for (const Command& command : commands) {
    text += fmt::format("\n_{}() {{\n", Replaced("panda-twin " + command.path, " ", "_"));
    text += "  local context state line\n  _arguments -C \\\n";
    for (const Described& option : command.options) {
      std::string action;
      if (option.value == Value::kFile) action = "_files";
      if (option.value == Value::kFolder) action = "_files -/";
      if (option.value == Value::kWord)
        action = fmt::format("({})", Replaced(option.type, "|", " "));
      const std::string value = fmt::format(":{}:{}", ZshText(option.type), action);
      text += option.is_positional
                  ? fmt::format("    '*{}' \\\n", value)
                  : fmt::format("    '{}[{}]{}' \\\n", option.name, ZshText(option.text),
                                option.value == Value::kNone ? "" : value);
    }
    if (command.commands.empty()) {
      text += "    && return\n}\n";
      continue;
    }
    text += "    '1: :->command' '*:: :->arguments' && return\n  case $state in\n    command)\n";
    text += "      local -a commands=(";
    for (const CLI::App* one : command.commands) {
      text += fmt::format(" '{}:{}'", one->get_name(), ZshText(one->get_description()));
    }
    text += " )\n      _describe command commands ;;\n";
    text += fmt::format("    arguments) _{}_$words[1] ;;\n  esac\n}}\n",
                        Replaced("panda-twin " + command.path, " ", "_"));
  }
  // The names of functions: _panda-twin_run, and of the program itself _panda-twin_.
  return text + "\n_panda-twin_ \"$@\"\n";
}

std::string Fish(const std::vector<Command>& commands) {
  const auto quoted = [](const std::string& text) {
    return fmt::format("'{}'", Replaced(Replaced(text, "\\", "\\\\"), "'", "\\'"));
  };
  std::string text = "complete -c panda-twin -n __fish_use_subcommand -f\n";
  for (const Command& command : commands) {
    std::string when =
        command.path.empty() ? "__fish_use_subcommand" : "__fish_seen_subcommand_from ";
    when += Replaced(command.path, " ", "; and __fish_seen_subcommand_from ");
    std::string names;
    for (const CLI::App* one : command.commands) names += ' ' + one->get_name();
    const std::string here = names.empty() || command.path.empty()
                                 ? when
                                 : when + "; and not __fish_seen_subcommand_from" + names;
    for (const CLI::App* one : command.commands) {
      text += fmt::format("complete -c panda-twin -n '{}' -f -a {} -d {}\n", here, one->get_name(),
                          quoted(one->get_description()));
    }
    for (const Described& option : command.options) {
      const bool is_word = option.value == Value::kWord;
      const std::string words = is_word ? " -a " + quoted(Replaced(option.type, "|", " ")) : "";
      if (option.is_positional) {
        if (is_word) text += fmt::format("complete -c panda-twin -n '{}' -f{}\n", when, words);
        continue;
      }
      const bool is_path = option.value == Value::kFile || option.value == Value::kFolder;
      text += fmt::format("complete -c panda-twin -n '{}' -l {}{}{} -d {}\n", when,
                          option.name.substr(2),
                          option.value == Value::kNone ? ""
                          : is_path                    ? " -r"
                                                       : " -x",
                          words, quoted(option.text));
    }
  }
  return text;
}

/// Text of a manual page: nothing in it is a request, and a dash is one that can be searched for.
std::string Roff(const std::string& text) {
  std::string escaped = Replaced(Replaced(text, "\\", "\\e"), "-", "\\-");
  for (const char* const request : {"\n.", "\n'"}) {
    escaped = Replaced(escaped, request, std::string("\n\\&") + request[1]);
  }
  return escaped;
}

std::string Man(const std::vector<Command>& commands) {
  std::string text = fmt::format(".TH PANDA\\-TWIN 1 \"\" \"panda\\-twin {}\"\n", TWIN_VERSION);
  for (const Command& command : commands) {
    const bool is_program = command.path.empty();
    const std::string name = Roff("panda-twin " + command.path);
    text += is_program ? fmt::format(
                             ".SH NAME\npanda\\-twin \\- {}\n.SH SYNOPSIS\n.B panda\\-twin\n"
                             ".I COMMAND\n[\\fIOPTIONS\\fR]\n.SH OPTIONS\n",
                             Roff(command.text))
                       : fmt::format(".SS {}\n{}\n", name, Roff(command.text));
    for (const Described& option : command.options) {
      text += fmt::format(".TP\n\\fB{}{}\\fR{}\n{}\n",
                          option.short_name.empty() ? "" : Roff(option.short_name) + ", ",
                          Roff(option.name),
                          option.type.empty() ? "" : fmt::format(" \\fI{}\\fR", Roff(option.type)),
                          Roff(option.text));
    }
    if (is_program) text += ".SH EXAMPLES AND EXIT CODES\n";
    if (!command.footer.empty()) text += fmt::format(".PP\n.EX\n{}\n.EE\n", Roff(command.footer));
    if (is_program) text += ".SH COMMANDS\n";
  }
  return text;
}

int Complete(const CompletionFlags& flags, const Program& /*program*/) {
  std::vector<Command> commands;
  Collect(*flags.app, "", commands);
  if (flags.format == "bash") {
    Say(stdout, Bash(commands));
  } else if (flags.format == "zsh") {
    Say(stdout, Zsh(commands));
  } else if (flags.format == "fish") {
    Say(stdout, Fish(commands));
  } else if (flags.format == "man") {
    Say(stdout, Man(commands));
  } else {
    throw InputError(fmt::format(
        "completion: there is none for \"{}\"; name bash, zsh, fish, or man", flags.format));
  }
  FinishOutput();
  return kOk;
}

constexpr const char* kCompletionFooter =
    R"(Where the package is installed, the shells find it by themselves. Else, in the shell's own start file:
  bash   source <(panda-twin completion bash)
  zsh    panda-twin completion zsh > FOLDER/_panda-twin, where FOLDER is in fpath
  fish   panda-twin completion fish | source)";

}  // namespace

void AddCompletion(CLI::App& app, Program& program) {
  const auto [completion, flags] =
      AddCommand(app, program, "completion",
                 "Print what makes a shell complete these commands, or the manual page", &Complete,
                 kCompletionFooter);
  flags.app = &app;
  Add(completion, "format bash|zsh|fish|man", flags.format,
      "For which shell; man: the manual page (roff)")
      ->required();
}

}  // namespace twin::cli
