#include "scenario/link_reader.h"

#include <string_view>

#include <fmt/format.h>

#include "scenario/section_readers.h"
#include "twin/core/error.h"

namespace twin::scenario {
namespace {

Duration ReadPart(const YamlNode& node) {
  return node.Time(Duration::zero(), kLongestDelay);
}

double ReadShare(const YamlNode& node) {
  return node.Quantity(Dimension::kPercent, 0, 100);
}

rt::NormalDelay ReadNormal(const YamlNode& node) {
  const YamlMap map = node.Map({"mean", "sigma"});
  return {ReadPart(map.Require("mean")), ReadPart(map.Require("sigma"))};
}

rt::LogNormalDelay ReadLogNormal(const YamlNode& node) {
  const YamlMap map = node.Map({"median", "sigma", "offset"});
  rt::LogNormalDelay delay;
  delay.median = map.Require("median").Time(Duration(1), kLongestDelay);
  delay.sigma = map.Require("sigma").Number(0, 5);
  IfGiven(map, "offset", [&](const YamlNode& n) { delay.offset = ReadPart(n); });
  return delay;
}

rt::GammaDelay ReadGamma(const YamlNode& node) {
  const YamlMap map = node.Map({"shape", "scale", "offset"});
  rt::GammaDelay delay;
  delay.shape = map.Require("shape").Number(0.01, 1e6);
  delay.scale = map.Require("scale").Time(Duration(1), kLongestDelay);
  IfGiven(map, "offset", [&](const YamlNode& n) { delay.offset = ReadPart(n); });
  return delay;
}

rt::EmpiricalDelay ReadHistogram(const YamlNode& node) {
  const YamlMap map = node.Map({"edges", "weights"});
  rt::EmpiricalDelay delay;
  for (const YamlNode& edge : map.Require("edges").Items()) {
    delay.edges.push_back(ReadPart(edge));
  }
  for (const YamlNode& weight : map.Require("weights").Items()) {
    delay.weights.push_back(weight.Number(0, 1e12));
  }
  return delay;
}

Delay::Law ReadLaw(const YamlNode& node) {
  if (node.IsScalar()) return rt::ConstantDelay{ReadPart(node)};
  const auto [kind, law] = node.OneOf({"constant", "normal", "log_normal", "gamma", "histogram"});
  if (kind == "constant") return rt::ConstantDelay{ReadPart(law)};
  if (kind == "normal") return ReadNormal(law);
  if (kind == "log_normal") return ReadLogNormal(law);
  if (kind == "gamma") return ReadGamma(law);
  return ReadHistogram(law);
}

GilbertElliottLoss ReadGilbertElliott(const YamlNode& node) {
  const YamlMap map = node.Map({"good_to_bad", "bad_to_good", "loss_good", "loss_bad"});
  GilbertElliottLoss loss;
  loss.good_to_bad = ReadShare(map.Require("good_to_bad"));
  loss.bad_to_good = ReadShare(map.Require("bad_to_good"));
  IfGiven(map, "loss_good", [&](const YamlNode& n) { loss.loss_good = ReadShare(n); });
  IfGiven(map, "loss_bad", [&](const YamlNode& n) { loss.loss_bad = ReadShare(n); });
  return loss;
}

ScriptedLoss ReadScripted(const YamlNode& node) {
  ScriptedLoss loss;
  for (const YamlNode& item : node.Items()) {
    const YamlMap map = item.Map({"at", "count"});
    const YamlNode at = map.Require("at");
    ScriptedLoss::Burst burst;
    burst.at = at.Time(Duration::zero(), kDay);
    if (burst.at % kCycle != Duration::zero()) {
      at.Fail("messages are 1 ms apart; give a whole number of ms");
    }
    burst.count = map.Require("count").Integer(1, 1'000'000);
    loss.bursts.push_back(burst);
  }
  return loss;
}

Loss::Law ReadLossLaw(const YamlNode& node) {
  if (node.IsScalar()) return IndependentLoss{ReadShare(node)};
  const auto [kind, law] = node.OneOf({"gilbert_elliott", "scripted"});
  if (kind == "scripted") return ReadScripted(law);
  return ReadGilbertElliott(law);
}

/// What a model finds wrong with parameters that are each in their range, at the place they stand.
template <typename Law>
Law Checked(const YamlNode& node, Law law) {
  try {
    (void)law.Model();
  } catch (const InputError& error) {
    node.Fail(error.what());
  }
  return law;
}

Duplication ReadDuplication(const YamlNode& node) {
  const YamlMap map = node.Map({"share", "delay"});
  Duplication duplication;
  duplication.share_percent = ReadShare(map.Require("share"));
  IfGiven(map, "delay", [&](const YamlNode& n) { duplication.delay = ReadDelay(n); });
  return duplication;
}

Reordering ReadReordering(const YamlNode& node) {
  const YamlMap map = node.Map({"share", "by"});
  Reordering reordering;
  reordering.share_percent = ReadShare(map.Require("share"));
  reordering.by = map.Require("by").Time(Duration::zero(), robot::kLongestOnTheWay);
  if (reordering.share_percent > 0 && reordering.by == Duration::zero()) {
    node.Fail("by is 0 s, which holds nothing back; give a time above 0, or a share of 0 %");
  }
  return reordering;
}

}  // namespace

Delay ReadDelay(const YamlNode& node) {
  return Checked(node, Delay{ReadLaw(node)});
}

Loss ReadLoss(const YamlNode& node) {
  return Checked(node, Loss{ReadLossLaw(node)});
}

void ReadDirection(const YamlMap& map, std::string_view name, DirectionSection& direction) {
  const auto key = [name](std::string_view what) { return fmt::format("{}_{}", name, what); };
  IfGiven(map, key("delay"), [&](const YamlNode& n) { direction.delay = ReadDelay(n); });
  IfGiven(map, key("loss"), [&](const YamlNode& n) { direction.loss = ReadLoss(n); });
  IfGiven(map, key("duplication"),
          [&](const YamlNode& n) { direction.duplication = ReadDuplication(n); });
  IfGiven(map, key("reordering"),
          [&](const YamlNode& n) { direction.reordering = ReadReordering(n); });
}

void ReadLink(const YamlNode& node, LinkSection& link) {
  const YamlMap map = node.Map({"state_delay", "state_loss", "state_duplication",
                                "state_reordering", "command_delay", "command_loss",
                                "command_duplication", "command_reordering", "d_INT"});
  ReadDirection(map, "state", link.state);
  ReadDirection(map, "command", link.command);
  IfGiven(map, "d_INT",
          [&](const YamlNode& n) { link.d_INT = n.Time(Duration::zero(), kCycle - Duration(1)); });
}

}  // namespace twin::scenario
