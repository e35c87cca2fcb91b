#include "twin/golden/approval.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::golden {
namespace {

Rendering HashesOf(const Pictures& pictures) {
  Rendering hashes;
  for (const ViewPictures& view : pictures.views) hashes.push_back(view.hashes);
  return hashes;
}

bool HaveSameKeys(const Pictures& a, const Pictures& b) {
  return std::equal(a.views.begin(), a.views.end(), b.views.begin(), b.views.end(),
                    [](const ViewPictures& x, const ViewPictures& y) {
                      return std::equal(x.keys.begin(), x.keys.end(), y.keys.begin(), y.keys.end(),
                                        [](const KeyPicture& k, const KeyPicture& l) {
                                          return k.frame == l.frame;
                                        });
                    });
}

/// Compares; nullopt if the two cannot be compared.
std::optional<Comparison> TryCompare(const Golden& old, const Evidence& evidence) {
  if (old.pictures.frames == evidence.pictures->frames &&
      !HaveSameKeys(old.pictures, *evidence.pictures)) {
    return std::nullopt;
  }
  try {
    return Compare(old, evidence);
  } catch (const InputError&) {  // views, sizes or interval differ
    return std::nullopt;
  }
}

Golden Anew(const Evidence& evidence) {
  Golden golden;
  golden.pictures = *evidence.pictures;
  golden.states = {evidence.states};
  golden.renderings = {HashesOf(golden.pictures)};
  for (ViewPictures& view : golden.pictures.views) view.hashes.clear();
  return golden;
}

/// Adds new hashes of states and frames to the old golden. @returns a description of the additions.
std::string AddHashes(const Comparison& comparison, const Evidence& evidence, Golden& golden) {
  std::string added;
  if (!comparison.gates[static_cast<std::size_t>(Gate::kStates)].passed) {
    golden.states.push_back(evidence.states);
    added = "a hash of the states";
  }
  if (!comparison.gates[static_cast<std::size_t>(Gate::kHashes)].passed) {
    golden.renderings.push_back(HashesOf(*evidence.pictures));
    added += added.empty() ? "hashes of the frames" : ", hashes of the frames";
  }
  return added;
}

}  // namespace

Approved Approve(const std::optional<Golden>& old, const Evidence& evidence,
                 const std::string& reason, const std::string& version) {
  TWIN_CHECK(evidence.pictures != nullptr);
  if (std::all_of(reason.begin(), reason.end(), [](char c) { return c == ' ' || c == '\t'; })) {
    throw InputError("an approval needs a reason: say why the new pictures are right");
  }
  std::optional<Comparison> comparison;
  if (old) comparison = TryCompare(*old, evidence);
  if (comparison && comparison->verdict == Verdict::kSame) return {*old, false};

  Approved approved;
  std::string changed = old ? "pictures of other views or times" : "all";
  if (comparison && comparison->passed()) {
    approved.golden = *old;
    changed = AddHashes(*comparison, evidence, approved.golden);
  } else {
    if (comparison) changed = "pictures; " + Describe(*comparison, *evidence.pictures);
    approved.golden = Anew(evidence);
    if (old) approved.golden.approvals = old->approvals;
  }
  approved.golden.approvals.push_back({reason, changed, version});
  return approved;
}

GoldensLock::GoldensLock(const std::filesystem::path& goldens)
    : descriptor_(::open(goldens.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0) {
    throw EnvironmentError(fmt::format("{}: cannot be opened ({})", goldens.string(),
                                       std::generic_category().message(errno)));
  }
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(descriptor_);
  throw EnvironmentError(fmt::format(
      "another approval writes into {}; wait for it, and approve then", goldens.string()));
}

GoldensLock::~GoldensLock() {
  ::close(descriptor_);
}

}  // namespace twin::golden
