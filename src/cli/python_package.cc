#include "cli/python_package.h"

#include <unistd.h>

#include <system_error>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::cli {
namespace {

// Also processes that it begins find the package.
constexpr const char* kEntry = R"(import importlib, os, sys
module, folder = sys.argv[1:3]
if os.path.isdir(folder):
    sys.path.append(folder)
    os.environ['PYTHONPATH'] = os.pathsep.join(filter(None, [os.environ.get('PYTHONPATH'), folder]))
try:
    main = importlib.import_module(f'panda_twin.{module}').main
except ImportError as error:
    print(f'panda-twin: error: {sys.executable} does not load the Python package panda_twin ({error}), which does this: '
          'pip install panda-twin, or name another Python in PANDA_TWIN_PYTHON', file=sys.stderr)
    sys.exit(4)
sys.exit(main(sys.argv[3:]))
)";

std::string PythonOf(const Host& host) {
  if (!host.python.empty()) return host.python;
  const std::filesystem::path own =
      host.executable.parent_path().parent_path().parent_path() / ".venv/bin/python";
  std::error_code error;
  return std::filesystem::exists(own, error) ? own.string() : "python3";
}

}  // namespace

void AddFlag(const char* flag, const std::string& value, std::vector<std::string>& words) {
  if (!value.empty()) words.push_back(fmt::format("{}={}", flag, value));
}

CLI::Option* HandedOver::Add(CLI::App& command, const std::string& form, const char* text) {
  return cli::Add(command, form, values_[form.substr(0, form.find(' '))], text);
}

std::vector<std::string> HandedOver::Words(const Program& program) const {
  std::vector<std::string> words = positionals;
  for (const auto& [flag, value] : values_) AddFlag(flag.c_str(), value, words);
  if (program.is_quiet()) words.emplace_back("--quiet");
  return words;
}

void BecomePython(const std::string& module, const std::vector<std::string>& words,
                  const Host& host) {
  const std::string python = PythonOf(host);
  const std::string folder = (host.executable.parent_path() / "python").string();
  std::vector<std::string> all{python, "-P", "-c", kEntry, module, folder};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> arguments;
  arguments.reserve(all.size() + 1);
  for (std::string& word : all) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execvp(arguments.front(), arguments.data());
  throw EnvironmentError(fmt::format("{}: {}; the Python package panda_twin does this", python,
                                     std::generic_category().message(errno)));
}

}  // namespace twin::cli
