#pragma once

#include <mujoco/mujoco.h>

#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "twin/golden/pictures.h"
#include "twin/render/film.h"
#include "twin/render/snapshots.h"

// Faults that are put into a film on purpose, to see that the gates find them.
namespace twin::golden {

/// A film of its own, with a copy of the model and of all frames, and how it is drawn.
class FaultyFilm {
 public:
  /// A film without a fault. @param film  of the run; may go afterwards.
  FaultyFilm(const render::Film& film, const PicturePlan& plan);

  [[nodiscard]] mjModel& model() { return *model_; }
  [[nodiscard]] render::Film& film() { return film_; }
  [[nodiscard]] PicturePlan& plan() { return plan_; }
  /// The frames, to be changed. The instants belong to the places: a frame that is put elsewhere
  /// is drawn with the time of where it is, so that no text gives it away.
  [[nodiscard]] std::vector<record::SceneRecord>& scenes() { return scenes_; }

  /// The address of a joint's positions. @throws std::runtime_error when there is none.
  [[nodiscard]] std::size_t AddressOf(const char* joint) const;

  [[nodiscard]] Pictures Take(const std::vector<std::size_t>& keys);

 private:
  struct Free {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
  };
  std::unique_ptr<mjModel, Free> model_;
  render::Film film_;
  PicturePlan plan_;
  int fps_;
  std::vector<record::SceneRecord> scenes_;
};

struct Defect {
  std::string_view name;
  /// Whether a film can have it. Empty: any can.
  std::function<bool(const render::Film&)> applies{};
  /// Puts it in before the pictures are taken; may be empty.
  std::function<void(FaultyFilm&)> in_film{};
  /// Puts it into pictures that were taken; may be empty.
  std::function<void(Pictures&)> in_pictures{};
};

/// All of them.
[[nodiscard]] const std::vector<Defect>& Defects();

}  // namespace twin::golden
