#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "loaded_model_library.h"
#include "model_samples.h"
#include "support/realtime_guard.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/model/model_library.h"

// The library as a file that is found, sent and loaded.
namespace twin::model::model_library_file_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

void Write(const fs::path& file, const std::string& content) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << content;
}

/// The text of the EnvironmentError that the call throws; empty when it throws none.
template <typename Call>
std::string ErrorOf(Call call) {
  try {
    call();
  } catch (const EnvironmentError& error) {
    return error.what();
  }
  return {};
}

class ModelLibraryFileTest : public testing::Test {
 protected:
  /// As libfranka does: the bytes into a file of its own, loaded for all to see, deleted at once.
  [[nodiscard]] std::unique_ptr<LoadedModelLibrary> Receive(const fs::path& served,
                                                            const std::string& name) const {
    const std::vector<std::byte> bytes = ReadModelLibrary(served);
    Write(folder_ / name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    auto library = std::make_unique<LoadedModelLibrary>(folder_ / name, RTLD_LAZY | RTLD_GLOBAL);
    fs::remove(folder_ / name);
    return library;
  }

  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

TEST_F(ModelLibraryFileTest, IsFoundBesideAnInstalledProgram) {
  const fs::path file = folder_ / "lib" / "panda-twin" / "libpanda_model.so";
  Write(file, "x");
  EXPECT_EQ(FindModelLibrary(folder_ / "bin" / "panda-twin"), file);
}

TEST_F(ModelLibraryFileTest, IsFoundInTheBuildFolder) {
  const fs::path file = folder_ / "lib" / "panda-twin" / "libpanda_model.so";
  Write(file, "x");
  EXPECT_EQ(FindModelLibrary(folder_ / "panda-twin"), file);
}

TEST_F(ModelLibraryFileTest, ThatOfThePlantIsAnotherFile) {
  const fs::path place = folder_ / "lib" / "panda-twin";
  Write(place / "libpanda_model.so", "x");
  Write(place / "libpanda_model_plant.so", "x");
  EXPECT_EQ(FindModelLibrary(folder_ / "panda-twin", ModelFigures::kPlant),
            place / "libpanda_model_plant.so");
}

// The places of this build, from a program at its top.
TEST_F(ModelLibraryFileTest, IsWhereTheBuildPutsIt) {
  const fs::path program = fs::path(TWIN_BINARY_DIR) / "panda-twin";
  EXPECT_EQ(FindModelLibrary(program), fs::path(TWIN_MODEL_LIBRARY));
  EXPECT_EQ(FindModelLibrary(program, ModelFigures::kPlant), fs::path(TWIN_MODEL_LIBRARY_PLANT));
}

TEST_F(ModelLibraryFileTest, SaysWhereItLookedWhenItIsMissing) {
  const std::string text = ErrorOf([&] { (void)FindModelLibrary(folder_ / "bin" / "panda-twin"); });
  EXPECT_THAT(text, HasSubstr((folder_ / "lib/panda-twin/libpanda_model.so").string()));
  EXPECT_THAT(text, HasSubstr((folder_ / "bin/lib/panda-twin/libpanda_model.so").string()));
  EXPECT_THAT(text, HasSubstr("build the target panda_model_library"));
}

TEST_F(ModelLibraryFileTest, AFolderOfThatNameIsNoLibrary) {
  fs::create_directories(folder_ / "lib" / "panda-twin" / "libpanda_model.so");
  EXPECT_THROW((void)FindModelLibrary(folder_ / "panda-twin"), EnvironmentError);
}

TEST_F(ModelLibraryFileTest, IsReadByteForByte) {
  const std::vector<std::byte> bytes = ReadModelLibrary(TWIN_MODEL_LIBRARY);
  std::ifstream file(TWIN_MODEL_LIBRARY, std::ios::binary);
  const std::string expected{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()), expected);
  EXPECT_LT(bytes.size(), kLargestModelLibrary);
}

TEST_F(ModelLibraryFileTest, WhatNoClientCouldLoadIsNotRead) {
  const auto read = [&] { (void)ReadModelLibrary(folder_ / "library.so"); };
  EXPECT_THAT(ErrorOf(read), HasSubstr("cannot be read"));
  for (const std::string& content : {std::string(), std::string("\x7f"),
                                     std::string("\x7f"
                                                 "EL"),
                                     std::string("no library")}) {
    Write(folder_ / "library.so", content);
    EXPECT_THAT(ErrorOf(read), HasSubstr("is no shared object")) << content;
  }
  Write(folder_ / "library.so",
        "\x7f"
        "ELF" +
            std::string(kLargestModelLibrary - 3, '\0'));
  EXPECT_THAT(ErrorOf(read), HasSubstr("has 65537 bytes"));
  Write(folder_ / "library.so",
        "\x7f"
        "ELF" +
            std::string(kLargestModelLibrary - 4, '\0'));
  EXPECT_EQ(ErrorOf(read), "");
}

// Two robots in one process: every library of a client is there for all to see, under the same
// names, and yet each must answer with figures of its own.
TEST_F(ModelLibraryFileTest, TwoInOneProcessDoNotMix) {
  const auto first = Receive(TWIN_MODEL_LIBRARY, "first.so");
  const auto plant = Receive(TWIN_MODEL_LIBRARY_PLANT, "plant.so");
  const auto again = Receive(TWIN_MODEL_LIBRARY, "again.so");
  const JointVector q = SampleOf(0).q;
  const JointMatrix M = ArmModel::Panda().MassMatrix(q, kHand);
  const JointMatrix M_plant = ArmModel::PandaPlant().MassMatrix(q, kHand);
  ASSERT_NE(M, M_plant);
  EXPECT_THAT(first->MassMatrix(q, kHand), testing::Pointwise(testing::DoubleNear(1e-12), M));
  EXPECT_THAT(plant->MassMatrix(q, kHand), testing::Pointwise(testing::DoubleNear(1e-12), M_plant));
  EXPECT_THAT(again->MassMatrix(q, kHand), testing::Pointwise(testing::DoubleNear(1e-12), M));
}

TEST_F(ModelLibraryFileTest, LoadsAgainAndAgain) {
  const JointVector expected = ArmModel::Panda().Gravity(kReady, kHand);
  for (int round = 0; round < 50; ++round) {
    EXPECT_THAT(Receive(TWIN_MODEL_LIBRARY, "library.so")->Gravity(kReady, kHand),
                testing::Pointwise(testing::DoubleNear(1e-12), expected));
  }
}

TEST_F(ModelLibraryFileTest, FourThreadsAtOnceGetWhatOneGets) {
  constexpr std::uint64_t kSamples = 2000;
  const LoadedModelLibrary library(TWIN_MODEL_LIBRARY);
  const auto all_of = [&](std::uint64_t i) {
    const auto [q, dq, ddq] = SampleOf(i);
    return std::tuple{library.MassMatrix(q, kLump),
                      library.Coriolis(q, dq, kLump),
                      library.Gravity(q, kLump, kTilted),
                      library.Pose(Frame::kEndEffector, q, kHandPose),
                      library.ZeroJacobian(Frame::kEndEffector, q, kHandPose),
                      library.BodyJacobian(Frame::kJoint5, q)};
  };
  std::vector<decltype(all_of(0))> expected;
  for (std::uint64_t i = 0; i < kSamples; ++i) expected.push_back(all_of(i));
  std::array<std::uint64_t, 4> same{};
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < same.size(); ++t) {
      threads.emplace_back([&, t] {
        for (std::uint64_t k = 0; k < kSamples; ++k) {
          const std::uint64_t i = (k + t * kSamples / same.size()) % kSamples;
          same[t] += all_of(i) == expected[i] ? 1 : 0;
        }
      });
    }
  }
  EXPECT_THAT(same, testing::Each(kSamples));
}

// Clients call it from their real-time thread, the first call included.
TEST_F(ModelLibraryFileTest, TakesNoMemory) {
  using MassMatrix = void (*)(const double*, const double*, double, const double*, double*);
  void* handle = dlopen(TWIN_MODEL_LIBRARY, RTLD_LAZY | RTLD_LOCAL);
  ASSERT_NE(handle, nullptr);
  const auto mass_matrix = reinterpret_cast<MassMatrix>(dlsym(handle, "M_NE"));
  ASSERT_NE(mass_matrix, nullptr);
  JointMatrix M{};
  const test::RealtimeGuard guard;
  for (int i = 0; i < 1000; ++i) {
    mass_matrix(kReady.data(), kHand.I.data(), kHand.m, kHand.F_x_C.data(), M.data());
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  dlclose(handle);
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_THAT(M, testing::Pointwise(testing::DoubleNear(1e-12),
                                    ArmModel::Panda().MassMatrix(kReady, kHand)));
}

}  // namespace
}  // namespace twin::model::model_library_file_test
