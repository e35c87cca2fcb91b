#include "twin/scenario/link_section.h"

#include <utility>

#include <fmt/format.h>

#include "scenario/sections.h"
#include "twin/core/error.h"
#include "twin/teleop/teleoperator_config.h"

namespace twin::scenario {

using enum Dimension;

namespace {

constexpr Duration kLongest = std::chrono::seconds(10);

Value Part(Duration& part) {
  return TimeSpan(part, Duration::zero(), kLongest);
}

Value Share(double& percent) {
  return Quantity(percent, kPercent, 0, 100);
}

faults::LossModel Make(const IndependentLoss& loss) {
  return faults::LossModel(faults::IndependentLoss{loss.percent / 100});
}

faults::LossModel Make(const GilbertElliottLoss& loss) {
  return faults::LossModel(faults::GilbertElliottLoss{
      loss.good_to_bad / 100, loss.bad_to_good / 100, loss.loss_good / 100, loss.loss_bad / 100});
}

faults::LossModel Make(const ScriptedLoss& loss) {
  faults::ScriptedLoss script;
  for (const ScriptedLoss::Burst& burst : loss.bursts) {
    if (burst.at < Duration::zero() || burst.at % kCycle != Duration::zero()) {
      throw InputError(fmt::format(
          "{} ns is no time of a message; they are 1 ms apart, so give a whole number of ms",
          burst.at.count()));
    }
    script.runs.push_back({static_cast<std::uint64_t>(burst.at / kCycle), burst.count});
  }
  return faults::LossModel(std::move(script));
}

}  // namespace

static void Describe(Map& map, faults::NormalDelay& law) {
  map.Require("mean", Part(law.mean), "Mean before the part below 0 is cut off.");
  map.Require("sigma", Part(law.sigma), "Standard deviation before that.");
}

static void Describe(Map& map, faults::LogNormalDelay& law) {
  map.Require("median", TimeSpan(law.median, Duration(1), kLongest),
              "Median of the log-normal part.");
  map.Require("sigma", Number(law.sigma, 0, 5), "Standard deviation of its logarithm.");
  map.Add("offset", Part(law.offset), "Least delay.");
}

static void Describe(Map& map, faults::GammaDelay& law) {
  map.Require("shape", Number(law.shape, 0.01, 1e6), "1 gives the exponential distribution.");
  map.Require("scale", TimeSpan(law.scale, Duration(1), kLongest), "Mean over shape.");
  map.Add("offset", Part(law.offset), "Least delay.");
}

static void Describe(Map& map, faults::EmpiricalDelay& law) {
  map.Require("edges", List(law.edges, Part), "Edges of the bins, rising.");
  map.Require("weights", List(law.weights, [](double& weight) { return Number(weight, 0, 1e12); }),
              "Weight of each bin; the delay is uniform within a bin.");
}

static void Describe(Map& map, GilbertElliottLoss& law) {
  map.Require("good_to_bad", Share(law.good_to_bad), "Probability per message.");
  map.Require("bad_to_good", Share(law.bad_to_good),
              "Probability per message; 100 % over it is the mean length of a burst.");
  map.Add("loss_good", Share(law.loss_good), "Loss in the good state.");
  map.Add("loss_bad", Share(law.loss_bad), "Loss in the bad state.");
}

static void Describe(Map& map, ScriptedLoss::Burst& burst) {
  map.Require("at", TimeSpan(burst.at, Duration::zero(), kDay),
              "First lost message: 1 ms counts for one message.")
      .Then([&burst](const YamlNode& at) {
        if (burst.at % kCycle == Duration::zero()) return;
        at.Fail("messages are 1 ms apart; give a whole number of ms");
      });
  map.Require("count", Integer(burst.count, 1, 1'000'000), "Messages lost in a row.");
}

static void Describe(Map& map, Duplication& duplication) {
  map.Before([&duplication](const YamlNode& /*node*/) { duplication = {}; });
  map.Require("share", Share(duplication.share_percent), "Share of all messages.");
  map.Add("delay", DelayOf(duplication.delay), "Delay of the second after the first.");
}

static void Describe(Map& map, Reordering& reordering) {
  map.Require("share", Share(reordering.share_percent), "Share of all messages.");
  map.Require("by", TimeSpan(reordering.by, Duration::zero(), robot::kLongestOnTheWay),
              "How long a message is held back, so that later ones overtake it.");
}

Value DelayOf(Delay& delay) {
  const Value constant = Alternative<faults::ConstantDelay>(
      delay.law, [](faults::ConstantDelay& d) { return Part(d.value); });
  const auto describe = [&law = delay.law, constant](Map& map) {
    map.Add("constant", constant, "Always the same.");
    map.Add("normal", Alternative<faults::NormalDelay>(law), "Normal, without its part below 0.");
    map.Add("log_normal", Alternative<faults::LogNormalDelay>(law),
            "Offset and a log-normal part, as scheduling and queues look like.");
    map.Add("gamma", Alternative<faults::GammaDelay>(law), "Offset and a gamma-distributed part.");
    map.Add("histogram", Alternative<faults::EmpiricalDelay>(law), "What was measured.");
    map.ExactlyOne();
  };
  const auto is_constant = [&delay] {
    return std::holds_alternative<faults::ConstantDelay>(delay.law);
  };
  return Defined("delay", "Drawn anew for every message, wake-up or computation.",
                 Validated(Either(constant, Section(describe), is_constant),
                           [&delay] { (void)delay.Model(); }));
}

Value LossOf(Loss& loss) {
  const Value independent = Alternative<IndependentLoss>(
      loss.law, [](IndependentLoss& one) { return Share(one.percent); });
  const auto describe = [&law = loss.law](Map& map) {
    map.Add("gilbert_elliott", Alternative<GilbertElliottLoss>(law),
            "Bursts: a good and a bad state, drawn anew per message.");
    map.Add("scripted",
            Alternative<ScriptedLoss>(law,
                                      [](ScriptedLoss& script) {
                                        return List(script.bursts,
                                                    [](auto& burst) { return SectionOf(burst); });
                                      }),
            "Exactly these messages.");
    map.ExactlyOne();
  };
  const auto is_independent = [&loss] { return std::holds_alternative<IndependentLoss>(loss.law); };
  return Defined("loss", "Which messages never arrive: each with this probability, or bursts.",
                 Validated(Either(independent, Section(describe), is_independent),
                           [&loss] { (void)loss.Model(); }));
}

void DescribeDirection(Map& map, const std::string& name, DirectionSection& direction) {
  map.Add(name + "_delay", DelayOf(direction.delay), "Time on the way.");
  map.Add(name + "_loss", LossOf(direction.loss), "Messages that never arrive.");
  map.Add(name + "_duplication", SectionOf(direction.duplication),
          "Messages that arrive a second time.");
  map.Add(name + "_reordering",
          Validated(SectionOf(direction.reordering),
                    [&reordering = direction.reordering] {
                      if (reordering.share_percent == 0 || reordering.by > Duration::zero()) return;
                      throw InputError(
                          "by is 0 s, which holds nothing back; give a time above 0, or a share of "
                          "0 %");
                    }),
          "Messages that are held back.");
}

void Describe(Map& map, LinkSection& link) {
  DescribeDirection(map, "state", link.state);
  DescribeDirection(map, "command", link.command);
  map.Add("d_INT", TimeSpan(link.d_INT, Duration::zero(), kCycle - Duration(1)),
          "How long before the robot's cycle a command must have arrived.");
}

void Describe(Map& map, OperatorSection& section, Place& place) {
  map.Require("device", Text(section.device), "Name in the registry of devices.").At(place);
  map.Add("parameters", Parameters(section.parameters), "Parameters of the device.")
      .OmitIf(section.parameters.empty());
  map.Add("settings", Parameters(section.settings), "How the operator leads; see teleop.")
      .OmitIf(section.settings.empty());
  DescribeDirection(map, "to_robot", section.to_robot);
  DescribeDirection(map, "from_robot", section.from_robot);
}

faults::DelayModel Delay::Model() const {
  return std::visit([](const auto& parameters) { return faults::DelayModel(parameters); }, law);
}

/// Equal delays are written alike.
bool Delay::operator==(const Delay& other) const {
  Delay a = *this;
  Delay b = other;
  return law.index() == other.law.index() && DelayOf(a).write(-1) == DelayOf(b).write(-1);
}

faults::LossModel Loss::Model() const {
  return std::visit([](const auto& parameters) { return Make(parameters); }, law);
}

faults::DirectionConfig MakeDirection(const DirectionSection& section) {
  faults::DirectionConfig config;
  config.delay = section.delay.Model();
  config.loss = section.loss.Model();
  config.duplication = section.duplication.share_percent / 100;
  config.duplicate_delay = section.duplication.delay.Model();
  config.reordering = section.reordering.share_percent / 100;
  config.reorder_by = section.reordering.by;
  return config;
}

robot::LinkConfig MakeLink(const LinkSection& link) {
  robot::LinkConfig config;
  config.state = MakeDirection(link.state);
  config.command = MakeDirection(link.command);
  config.d_INT = link.d_INT;
  return config;
}

void OperatorSection::Validate() const {
  if (device.empty()) throw InputError("operator.device: names no device; give one");
  (void)MakeTeleoperator(*this);
  const teleop::WireConfig wire = MakeWire(*this);
  wire.to_robot.Validate("operator.to_robot");
  wire.from_robot.Validate("operator.from_robot");
}

teleop::TeleoperatorConfig MakeTeleoperator(const OperatorSection& section) {
  control::ParameterReader reader(section.settings, "operator.settings");
  const teleop::TeleoperatorConfig config = teleop::ReadTeleoperatorConfig(reader);
  reader.RefuseUnread();
  return config;
}

teleop::WireConfig MakeWire(const OperatorSection& section) {
  return {.to_robot = MakeDirection(section.to_robot),
          .from_robot = MakeDirection(section.from_robot)};
}

LinkSection LoadLink(const std::filesystem::path& path) {
  const YamlNode root = YamlNode::ParseFile(path.string());
  if (root.Member("motion")) return Load(path).link;
  LinkSection link;
  Map map;
  map.Require("link", SectionOf(link));
  map.Read(root);
  return link;
}

LinkSection ParseLink(const std::string& text, const std::filesystem::path& file) {
  LinkSection link;
  SectionOf(link).read(YamlNode::Parse(text, file.string()));
  return link;
}

}  // namespace twin::scenario
