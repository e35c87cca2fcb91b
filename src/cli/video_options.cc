#include "cli/video_options.h"

namespace twin::cli {
namespace {

constexpr const char* kVideoFooter =
    R"(A case is a file <goldens>/<case>.yaml: a scenario, a lab, a seed, and some views, each as a scenario's render section;
what was approved of it is in the folder <goldens>/<case>. Hashes of states and frames tell what changed, physics
or rendering; whether pictures differ is decided by what shows: another processor or rasteriser is no failure.
  panda-twin video check                          run all cases, compare, say what differs; a page when something does
  panda-twin video check CASE --log out/run       a recorded run instead of a new one
  panda-twin video report                         the page whatever comes of it
  panda-twin video approve CASE --reason "..."    what the case looks like now is right
Exit codes: 1 pictures differ from those approved; others as ever.)";

CLI::App* AddDeed(CLI::App& video, VideoFlags& flags, VideoDeed deed, const char* name,
                  const char* text) {
  CLI::App* app = video.add_subcommand(name, text);
  app->add_option("cases", flags.cases,
                  deed == VideoDeed::kApprove ? "Which" : "Which (default: all there are)")
      ->type_name("CASE...")
      ->required(deed == VideoDeed::kApprove);
  app->add_option("--goldens", flags.goldens, "Folder of cases and of what was approved")
      ->type_name("DIR")
      ->capture_default_str();
  app->add_option("--log", flags.log, "One case: a recorded run instead of a new one")
      ->type_name("FILE|DIR");
  app->add_option("--out", flags.out, "Folder of the runs' results and of report.html")
      ->type_name("DIR")
      ->capture_default_str();
  app->add_flag("--quiet", flags.quiet, "Errors only");
  app->add_option("--data", flags.data.models, "Folder of models, if not beside the program")
      ->type_name("DIR");
  app->add_option("--meshes", flags.data.meshes, "Folder panda_description with the meshes")
      ->type_name("DIR");
  app->parse_complete_callback([&flags, deed] { flags.deed = deed; });
  return app;
}

}  // namespace

CLI::App* AddVideo(CLI::App& app, VideoFlags& flags) {
  CLI::App* video =
      app.add_subcommand("video", "Compare the pictures of runs with those that were approved");
  video->require_subcommand(1);
  CLI::App* check = AddDeed(*video, flags, VideoDeed::kCheck, "check",
                            "Compare, and fail when something looks different");
  CLI::App* approve = AddDeed(*video, flags, VideoDeed::kApprove, "approve",
                              "Keep what the cases look like now as right");
  CLI::App* report = AddDeed(*video, flags, VideoDeed::kReport, "report",
                             "Compare, and write the page whatever comes of it");
  for (CLI::App* deed : {check, report}) {
    deed->add_option("--junit", flags.junit, "Write what came of the cases for machines, as XML")
        ->type_name("FILE");
  }
  approve->add_option("--reason", flags.reason, "Why they are right; it is kept")
      ->type_name("TEXT")
      ->required();
  video->footer(kVideoFooter);
  return video;
}

}  // namespace twin::cli
