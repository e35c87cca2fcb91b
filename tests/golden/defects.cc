#include "golden/defects.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace twin::golden {
namespace {

constexpr const char* kHand = "panda_hand";
constexpr double kTwoMillimetres = 2e-3;

int IdOf(const mjModel& model, mjtObj kind, const char* name) {
  const int id = mj_name2id(&model, kind, name);
  if (id < 0) throw std::runtime_error(std::string("the model has no ") + name);
  return id;
}

/// The first body that moves freely: what is carried.
int FreeJoint(const mjModel& model) {
  for (int joint = 0; joint < model.njnt; ++joint) {
    if (model.jnt_type[joint] == mjJNT_FREE) return joint;
  }
  return -1;
}

void MoveHand(FaultyFilm& faulty) {
  faulty.model().body_pos[3 * IdOf(faulty.model(), mjOBJ_BODY, kHand)] += kTwoMillimetres;
}

/// Of one finger, the largest geom that is drawn.
void TakeAwayGeom(FaultyFilm& faulty) {
  mjModel& model = faulty.model();
  const int finger = IdOf(model, mjOBJ_BODY, "panda_leftfinger");
  int largest = -1;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    constexpr int kDrawnGroups = 3;
    if (model.geom_bodyid[geom] != finger || model.geom_group[geom] >= kDrawnGroups) continue;
    if (largest < 0 || model.geom_rbound[geom] > model.geom_rbound[largest]) largest = geom;
  }
  if (largest < 0) throw std::runtime_error("the finger has no geom that is drawn");
  model.geom_group[largest] = mjNGROUP - 1;
}

void TurnLightOff(FaultyFilm& faulty) {
  faulty.model().light_active[0] = 0;
}

void TurnCameras(FaultyFilm& faulty) {
  for (ViewPlan& view : faulty.plan().views) view.settings.view.orbit.azimuth_deg += 0.2;
}

/// What is in the frame `from(i)` is put in the place of frame i.
template <typename From>
void Rearrange(FaultyFilm& faulty, const From& from) {
  const std::vector<record::SceneRecord> whole = faulty.scenes();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const Time at = whole[i].at;
    faulty.scenes()[i] = whole[std::min(from(i), whole.size() - 1)];
    faulty.scenes()[i].at = at;
  }
}

void DropFrame(FaultyFilm& faulty) {
  const std::size_t middle = faulty.scenes().size() / 2;
  Rearrange(faulty, [middle](std::size_t i) { return i < middle ? i : i + 1; });
}

void ShiftByOneFrame(FaultyFilm& faulty) {
  Rearrange(faulty, [](std::size_t i) { return i + 1; });
}

void SinkObject(FaultyFilm& faulty) {
  const auto z =
      static_cast<std::size_t>(faulty.model().jnt_qposadr[FreeJoint(faulty.model())]) + 2;
  for (record::SceneRecord& scene : faulty.scenes()) scene.qpos[z] -= kTwoMillimetres;
}

void HideGoals(FaultyFilm& faulty) {
  faulty.film().goals.clear();
}

/// The arm where it was 20 ms ago, between two frames on a straight line.
void TrailArm(FaultyFilm& faulty) {
  constexpr double kLag = 0.02;
  const std::vector<record::SceneRecord> whole = faulty.scenes();
  for (int joint = 1; joint <= 7; ++joint) {
    const std::size_t q = faulty.AddressOf(("panda_joint" + std::to_string(joint)).c_str());
    for (std::size_t i = 1; i < whole.size(); ++i) {
      const double share = kLag / ToSeconds(whole[i].at - whole[i - 1].at);
      faulty.scenes()[i].qpos[q] +=
          std::min(share, 1.0) * (whole[i - 1].qpos[q] - whole[i].qpos[q]);
    }
  }
}

void Brighten(render::Image& image, std::size_t pixel) {
  constexpr int kStep = 3;
  for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
    image.rgb[i] = static_cast<std::uint8_t>(std::min(255, image.rgb[i] + kStep));
  }
}

void BrightenAll(Pictures& pictures) {
  for (ViewPictures& view : pictures.views) {
    for (render::Image& image : view.signatures) {
      for (std::size_t pixel = 0; pixel < image.Pixels(); ++pixel) Brighten(image, pixel);
    }
    for (KeyPicture& key : view.keys) {
      for (std::size_t pixel = 0; pixel < key.colour.Pixels(); ++pixel) Brighten(key.colour, pixel);
    }
  }
}

/// The key pictures only: small ones do not say whose colour they show.
void BrightenHand(Pictures& pictures) {
  const auto hand = std::find(pictures.bodies.begin(), pictures.bodies.end(), kHand);
  for (ViewPictures& view : pictures.views) {
    for (KeyPicture& key : view.keys) {
      for (std::size_t pixel = 0; pixel < key.colour.Pixels(); ++pixel) {
        if (key.bodies.body[pixel] == hand - pictures.bodies.begin()) Brighten(key.colour, pixel);
      }
    }
  }
}

}  // namespace

FaultyFilm::FaultyFilm(const render::Film& film, const PicturePlan& plan)
    : model_(mj_copyModel(nullptr, film.model)),
      film_(film),
      plan_(plan),
      fps_(film.snapshots->fps()) {
  film_.model = model_.get();
  for (std::size_t i = 0; i < film.snapshots->size(); ++i) {
    scenes_.push_back(film.snapshots->scene(i));
  }
}

std::size_t FaultyFilm::AddressOf(const char* joint) const {
  return static_cast<std::size_t>(model_->jnt_qposadr[IdOf(*model_, mjOBJ_JOINT, joint)]);
}

Pictures FaultyFilm::Take(const std::vector<std::size_t>& keys) {
  render::Snapshots snapshots(fps_, static_cast<std::size_t>(model_->nq));
  for (const record::SceneRecord& scene : scenes_) snapshots.Append(scene);
  film_.snapshots = &snapshots;
  return TakePictures(film_, plan_, keys);
}

const std::vector<Defect>& Defects() {
  static const std::vector<Defect> kDefects{
      {.name = "gripper 2 mm off", .in_film = MoveHand},
      {.name = "one geom missing (a finger's)", .in_film = TakeAwayGeom},
      {.name = "light off", .in_film = TurnLightOff},
      {.name = "colour +3/255", .in_pictures = BrightenAll},
      {.name = "colour +3/255, of the hand alone", .in_pictures = BrightenHand},
      {.name = "camera 0.2 deg off", .in_film = TurnCameras},
      {.name = "one frame dropped", .in_film = DropFrame},
      {.name = "clip shifted by one frame", .in_film = ShiftByOneFrame},
      {.name = "object 2 mm in the table",
       .applies = [](const render::Film& film) { return FreeJoint(*film.model) >= 0; },
       .in_film = SinkObject},
      {.name = "ghost missing",
       .applies = [](const render::Film& film) { return !film.goals.empty(); },
       .in_film = HideGoals},
      {.name = "arm trailing 20 ms", .in_film = TrailArm}};
  return kDefects;
}

}  // namespace twin::golden
