#include "cli/commands/commands.h"
#include "twin/scenario/scenario.h"

namespace twin::cli {
namespace {

struct SchemaFlags {
  bool keys = false;  ///< the table of keys instead
};

int Schema(const SchemaFlags& flags, const Program& /*program*/) {
  Say(stdout, flags.keys ? scenario::KeyTable() : scenario::JsonSchema());
  FinishOutput();
  return kOk;
}

}  // namespace

void AddSchema(CLI::App& app, Program& program) {
  const auto [schema, flags] = AddCommand(
      app, program, "schema",
      "Print the JSON Schema of scenario files, by which editors complete and check them", &Schema);
  schema.add_flag("--keys", flags.keys, "Print the table of all keys instead (Markdown)");
}

}  // namespace twin::cli
