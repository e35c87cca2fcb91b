#include "cli/data_options.h"

namespace twin::cli {

void AddDataFlags(CLI::App& app, DataFlags& flags) {
  app.add_option("--data", flags.models, "Folder of models, if not beside the program")
      ->type_name("DIR");
  app.add_option("--meshes", flags.meshes, "Folder panda_description with the robot's meshes")
      ->type_name("DIR");
}

}  // namespace twin::cli
