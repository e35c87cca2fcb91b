#include <array>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "cli/commands/commands.h"
#include "twin/core/error.h"

// Completion for three shells and the manual page: Mustache templates in src/cli/texts, filled from
// the commands' own descriptions.
namespace twin::cli {
namespace {

using kainjow::mustache::data;

struct CompletionFlags {
  std::string format;
  const CLI::App* app = nullptr;
};

std::string Replaced(const std::string& text, std::string_view what, std::string_view by) {
  std::string result;
  std::size_t begin = 0;
  for (std::size_t at = 0; (at = text.find(what, begin)) != std::string::npos;) {
    result.append(text, begin, at - begin).append(by);
    begin = at + what.size();
  }
  return result.append(text, begin);
}

/// A text in single quotes, of zsh's _arguments and _describe.
std::string ZshText(const std::string& text) {
  std::string quoted = Replaced(text, "'", "'\\''");
  for (const char* const special : {"[", "]", ":"}) {
    quoted = Replaced(quoted, special, std::string("\\") + special);
  }
  return quoted;
}

/// A text in fish's single quotes.
std::string FishText(const std::string& text) {
  return Replaced(Replaced(text, "\\", "\\\\"), "'", "\\'");
}

/// Text of a manual page: nothing in it is a request, and a dash is one that can be searched for.
std::string Roff(const std::string& text) {
  std::string escaped = Replaced(Replaced(text, "\\", "\\e"), "-", "\\-");
  for (const char* const request : {"\n.", "\n'"}) {
    escaped = Replaced(escaped, request, std::string("\n\\&") + request[1]);
  }
  return escaped;
}

struct Format {
  std::string_view name;
  std::string (*escape)(const std::string&);  ///< of the template's {{texts}}
};
constexpr std::array<Format, 4> kFormats{
    {{"bash", &FishText}, {"zsh", &ZshText}, {"fish", &FishText}, {"man", &Roff}}};

/// False for an empty text, so that templates leave out its section.
data TextData(const std::string& text) {
  return text.empty() ? data(false) : data(text);
}

/// An option, as help shows it. @param values, files  of bash: get the pattern of an option whose
/// value is free, or a path.
data OptionData(const CLI::Option& option, const std::string& path, std::string& values,
                std::string& files) {
  const bool is_positional = !option.nonpositional();
  const std::string name = is_positional ? option.get_name() : option.get_lnames().front();
  const bool has_value = option.get_items_expected_max() != 0;
  const std::string type = has_value ? option.get_type_name() : std::string();
  const bool is_file = type.find("FILE") != std::string::npos;
  const bool is_folder = type == "DIR";
  const bool is_path = is_file || is_folder;
  const bool is_word = !is_path && type.find('|') != std::string::npos;
  if (!is_positional && has_value && !is_word) {
    std::string& patterns = is_path ? files : values;
    patterns += fmt::format("{}'{}/--{}'", patterns.empty() ? "" : "|", path, name);
  }
  data of;
  of.set("name", is_positional ? name : "--" + name);
  of.set("long", name);
  of.set("short", TextData(option.get_snames().empty() ? "" : "-" + option.get_snames().front()));
  of.set("text", option.get_description());
  of.set("type", TextData(type));
  of.set("words", Replaced(type, "|", " "));
  of.set("is_positional", is_positional);
  of.set("is_flag", !is_positional);
  of.set("has_value", has_value);
  of.set("is_file", is_file);
  of.set("is_folder", is_folder);
  of.set("is_path", is_path);
  of.set("is_word", is_word);
  of.set("is_text", has_value && !is_path && !is_word);
  return of;
}

/// Adds `app` and all commands below it, each before its own. @param path  "", "run", "video
/// check".
void Collect(const CLI::App& app, const std::string& path, data& commands) {
  const auto below = app.get_subcommands([](const CLI::App*) { return true; });
  data own(data::type::list);
  for (const CLI::App* one : below) {
    data command("name", one->get_name());
    command.set("text", one->get_description());
    own.push_back(command);
  }
  data options(data::type::list);
  std::string values;
  std::string files;
  for (const CLI::Option* option : app.get_options()) {
    options.push_back(OptionData(*option, path, values, files));
  }
  data command("path", path);
  command.set("function", path.empty() ? "panda-twin" : Replaced("panda-twin " + path, " ", "_"));
  command.set("when", path.empty() ? std::string("__fish_use_subcommand")
                                   : "__fish_seen_subcommand_from " +
                                         Replaced(path, " ", "; and __fish_seen_subcommand_from "));
  command.set("is_program", path.empty());
  command.set("text", app.get_description());
  command.set("footer", TextData(app.get_footer()));
  command.set("options", options);
  command.set("values", TextData(values));
  command.set("files", TextData(files));
  command.set("has_commands", !below.empty());
  command.set("commands", own);
  commands.push_back(command);
  for (const CLI::App* one : below) {
    Collect(*one, path.empty() ? one->get_name() : path + ' ' + one->get_name(), commands);
  }
}

/// The paths of all commands below, as a pattern of bash.
std::string PathsOf(const data& commands) {
  std::string paths;
  for (const data& command : commands.list_value()) {
    const std::string& path = command.get("path")->string_value();
    if (!path.empty()) paths += fmt::format("{}'{}'", paths.empty() ? "" : "|", path);
  }
  return paths;
}

int Complete(const CompletionFlags& flags, const Program& /*program*/) {
  const auto* const format = std::ranges::find(kFormats, flags.format, &Format::name);
  if (format == kFormats.end()) {
    throw InputError(fmt::format(
        "completion: there is none for \"{}\"; name bash, zsh, fish, or man", flags.format));
  }
  data commands(data::type::list);
  Collect(*flags.app, "", commands);
  data all("version", TWIN_VERSION);
  all.set("paths", PathsOf(commands));
  all.set("commands", commands);
  kainjow::mustache::mustache script{std::string(TextOf("completion." + flags.format))};
  script.set_custom_escape(format->escape);
  Say(stdout, script.render(all));
  FinishOutput();
  return kOk;
}

}  // namespace

void AddCompletion(CLI::App& app, Program& program) {
  const auto [completion, flags] =
      AddCommand(app, program, "completion",
                 "Print what makes a shell complete these commands, or the manual page", &Complete);
  flags.app = &app;
  Add(completion, "format bash|zsh|fish|man", flags.format,
      "For which shell; man: the manual page (roff)")
      ->required();
}

}  // namespace twin::cli
