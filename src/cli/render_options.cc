#include "cli/render_options.h"

#include <fmt/format.h>

#include <functional>
#include <string>
#include <utility>

#include "cli/data_options.h"
#include "twin/core/error.h"
#include "twin/replay/comparison.h"
#include "twin/replay/layout.h"

namespace twin::cli {
namespace {

constexpr const char* kRenderFooter =
    R"(Whatever is not said is as the scenario's section render has it, so that `render LOG --out a.mp4` makes the run's own
video again, frame by frame. Of a log without scenes (hardware, the ideal plant) the arm moves as it was measured.
A frame shows what was recorded first at or after its instant; nothing between is made up.
  panda-twin render out/canonical --out slow.mp4 --speed 0.25 --from 2 --to 4 --camera track:panda_hand
  panda-twin render out/a out/b --out both.mp4 --compare ghost    the second arm translucent in the first's picture
  panda-twin render out/demo --out frame.png --at 3.2 --inset gripper --overlays text,forces,limits
  panda-twin render out/compliance --out grid.png --layout grid      the four cases, each where the arm is furthest off
  panda-twin render out/pick_and_place --out strip.png --layout strip  six plans above, carried out below
  panda-twin render out/plan_and_execute --out triple.png --layout triple  initial, plan, final
Two runs go side by side by their own time; one that has ended stays as it was. split is twice as wide as --size.)";

/// A text that something can be made of. @param read  throws InputError to say why not.
CLI::Validator Readable(std::function<void(const std::string&)> read) {
  const auto check = [read = std::move(read)](const std::string& text) {
    try {
      read(text);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  return CLI::Validator(check, "", "");
}

/// A number in a range; CLI::Range lets NaN pass.
CLI::Validator Within(double low, double high) {
  const std::string range = fmt::format("[{} - {}]", low, high);
  const auto check = [=](const std::string& text) {
    double value = 0;
    const bool number = CLI::detail::lexical_cast(text, value);
    return number && value >= low && value <= high
               ? std::string()
               : fmt::format("{} is no number in {}", text, range);
  };
  return CLI::Validator(check, "FLOAT in " + range, "");
}

/// Of a run, s: within eleven days.
CLI::Validator Instant() {
  return Within(0, 1e6);
}

void AddPicture(CLI::App& app, FilmFlags& flags) {
  app.add_option("--camera", flags.camera,
                 "A camera of the scene by its name, orbit, track:BODY, or gripper")
      ->type_name("CAMERA");
  app.add_option("--azimuth", flags.azimuth_deg, "orbit, track: direction in which it looks")
      ->type_name("DEG");
  app.add_option("--elevation", flags.elevation_deg, "orbit, track: negative looks down")
      ->type_name("DEG");
  app.add_option("--distance", flags.distance, "orbit, track: from what it looks at")
      ->type_name("M");
  app.add_option("--lookat", flags.lookat, "orbit: point of the world; track: from the body")
      ->expected(3)
      ->type_name("X Y Z");
  app.add_option("--turn", flags.turn_deg, "orbit, track: turns so fast, by the run's time")
      ->type_name("DEG/S");
  app.add_option("--inset", flags.insets,
                 "A picture within the picture, such as gripper@bottom_left; may be repeated; none")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->check(Readable([](const std::string& text) {
        if (text != "none") static_cast<void>(InsetFromText(text, {}));
      }))
      ->type_name("CAMERA[@CORNER]");
  app.add_option("--overlays", flags.overlays,
                 "What is drawn over it, of text, goal, trace, forces, contacts, limits; none")
      ->check(Readable([](const std::string& text) { static_cast<void>(OverlaysFromText(text)); }))
      ->type_name("LIST");
  app.add_option("--size", flags.size, "Of the picture, pixels, even")
      ->check(Readable([](const std::string& text) {
        render::RenderSettings settings;
        SetSizeFromText(text, settings);
      }))
      ->type_name("WxH");
}

}  // namespace

CLI::App* AddRender(CLI::App& app, RenderFlags& flags) {
  CLI::App* render = app.add_subcommand("render", "Draw a recorded run, or two beside each other");
  render->add_option("log", flags.log, "Log of a run, or its folder of results")
      ->required()
      ->type_name("FILE|DIR");
  CLI::Option* second = render->add_option("second", flags.second, "Of another run, to compare");
  second->type_name("FILE|DIR");
  render
      ->add_option("--out", flags.out,
                   "Video (.mp4, or .mkv without loss), folder/ of pictures, or a .png with --at "
                   "or --layout")
      ->required()
      ->type_name("FILE");
  AddPicture(*render, flags.film);
  render->add_option("--speed", flags.speed, "Seconds of the run in a second of the film")
      ->check(Within(0.01, 100))
      ->capture_default_str()
      ->type_name("X");
  render->add_option("--fps", flags.fps, "Frames per second of the film")
      ->check(CLI::Range(1, 240))
      ->type_name("N");
  render->add_option("--from", flags.from, "Begin at this time of the run")
      ->check(Instant())
      ->type_name("S");
  render->add_option("--to", flags.until, "End at this time of the run")
      ->check(Instant())
      ->type_name("S");
  render->add_option("--at", flags.at, "One picture, of this time of the run")
      ->check(Instant())
      ->type_name("S");
  render
      ->add_option("--compare", flags.compare,
                   "Two runs: split (side by side), ghost, or difference (red where they differ)")
      ->check(Readable(
          [](const std::string& text) { static_cast<void>(replay::ComparisonFromName(text)); }))
      ->capture_default_str()
      ->needs(second)
      ->type_name("HOW");
  render
      ->add_option("--tolerance", flags.tolerance,
                   "difference: how far a channel may be off, of 255 (16)")
      ->check(CLI::Range(0, 254))
      ->needs(second)
      ->type_name("N");
  render->add_option("--layout", flags.layout, "A page of pictures: grid, strip or triple")
      ->check(Readable(
          [](const std::string& text) { static_cast<void>(replay::LayoutFromName(text)); }))
      ->type_name("NAME");
  render->add_flag("--quiet", flags.quiet, "No progress; notes and errors only");
  AddDataFlags(*render, flags.data);
  render->footer(kRenderFooter);
  return render;
}

}  // namespace twin::cli
