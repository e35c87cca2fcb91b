#include "plant/meshes.h"

#include <cmath>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plant/plant_fixture.h"
#include "twin/core/error.h"

namespace twin::plant::plant_mesh_import_test {
namespace {

/// A tetrahedron with corners at the origin and the unit vectors, and a second one lifted by 2 in
/// z; `up` is the file's up axis; two materials of the same red and one of another.
std::string Collada(const std::string& up, const std::string& second_colour) {
  const auto effect = [](const std::string& id, const std::string& colour) {
    return "<effect id=\"e" + id +
           "\"><profile_COMMON><technique sid=\"t\"><lambert><diffuse><color>" + colour +
           "</color></diffuse></lambert></technique></profile_COMMON></effect>";
  };
  const auto material = [](const std::string& id) {
    return "<material id=\"m" + id + "\"><instance_effect url=\"#e" + id + "\"/></material>";
  };
  const auto geometry = [](const std::string& id, const std::string& z) {
    return "<geometry id=\"g" + id + "\"><mesh><source id=\"p" + id + "\"><float_array id=\"a" +
           id + "\" count=\"12\">0 0 " + z + " 1 0 " + z + " 0 1 " + z + " 0 0 " +
           (z == "0" ? "1" : "3") + "</float_array><technique_common><accessor source=\"#a" + id +
           "\" count=\"4\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" "
           "type=\"float\"/><param name=\"Z\" "
           "type=\"float\"/></accessor></technique_common></source>"
           "<vertices id=\"v" +
           id + "\"><input semantic=\"POSITION\" source=\"#p" + id +
           "\"/></vertices><triangles count=\"4\" material=\"s\"><input semantic=\"VERTEX\" "
           "source=\"#v" +
           id +
           "\" offset=\"0\"/><p>0 2 1 0 1 3 1 2 3 0 3 2</p></triangles></mesh>"
           "</geometry>";
  };
  const auto node = [](const std::string& id) {
    return "<node><instance_geometry url=\"#g" + id +
           "\"><bind_material><technique_common><instance_material symbol=\"s\" target=\"#m" + id +
           "\"/></technique_common></bind_material></instance_geometry></node>";
  };
  return "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
         "version=\"1.4.1\"><asset><unit name=\"meter\" meter=\"1\"/><up_axis>" +
         up + "</up_axis></asset><library_effects>" + effect("1", "1 0 0 1") +
         effect("2", second_colour) + "</library_effects><library_materials>" + material("1") +
         material("2") + "</library_materials><library_geometries>" + geometry("1", "0") +
         geometry("2", "2") +
         "</library_geometries><library_visual_scenes><visual_scene id=\"s\">" + node("1") +
         node("2") +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene>"
         "</COLLADA>";
}

double HighestZ(const std::vector<MeshPart>& parts) {
  double z = 0;
  for (const MeshPart& part : parts) {
    for (std::size_t i = 2; i < part.vertices.size(); i += 3)
      z = std::max<double>(z, part.vertices[i]);
  }
  return z;
}

TEST(MeshImportTest, SplitsByColour) {
  const auto parts = ImportVisualMesh(Collada("Z_UP", "0 0 1 1"), "two.dae");
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].faces.size(), 12u);
  EXPECT_EQ(parts[1].faces.size(), 12u);
  const std::vector<Colour> colours{parts[0].colour, parts[1].colour};
  EXPECT_THAT(colours, testing::UnorderedElementsAre(Colour{1, 0, 0, 1}, Colour{0, 0, 1, 1}));
}

TEST(MeshImportTest, JoinsMaterialsThatLookTheSame) {
  const auto parts = ImportVisualMesh(Collada("Z_UP", "1 0 0 1"), "two.dae");
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].faces.size(), 24u);
}

TEST(MeshImportTest, IgnoresTheUpAxis) {
  EXPECT_EQ(HighestZ(ImportVisualMesh(Collada("Z_UP", "0 0 1 1"), "a.dae")), 3);
  EXPECT_EQ(HighestZ(ImportVisualMesh(Collada("Y_UP", "0 0 1 1"), "a.dae")), 3);
}

TEST(MeshImportTest, GivesUnitNormals) {
  for (const MeshPart& part : ImportVisualMesh(Collada("Z_UP", "0 0 1 1"), "two.dae")) {
    ASSERT_EQ(part.normals.size(), part.vertices.size());
    for (std::size_t i = 0; i < part.normals.size(); i += 3) {
      EXPECT_NEAR(std::hypot(part.normals[i], part.normals[i + 1], part.normals[i + 2]), 1, 1e-6);
    }
  }
}

TEST(MeshImportTest, CollisionMeshSharesItsCorners) {
  const MeshPart part = ImportCollisionMesh(Collada("Z_UP", "0 0 1 1"), "two.dae");
  EXPECT_EQ(part.vertices.size(), 24u);  // two tetrahedra of four corners
  EXPECT_TRUE(part.normals.empty());
}

TEST(MeshImportTest, MshStartsWithItsCounts) {
  const MeshPart part = ImportCollisionMesh(Collada("Z_UP", "0 0 1 1"), "two.dae");
  const std::string msh = EncodeMsh(part);
  int counts[4];
  std::memcpy(counts, msh.data(), sizeof(counts));
  EXPECT_THAT(counts, testing::ElementsAre(8, 0, 0, 8));
  EXPECT_EQ(msh.size(), sizeof(counts) + 8 * 3 * sizeof(float) + 8 * 3 * sizeof(int));
}

TEST(MeshImportTest, NamesAFileItCannotRead) {
  const std::string message = MessageOf<InputError>(
      [] { (void)ImportVisualMesh("<COLLADA><asset>", "models/broken.dae"); });
  EXPECT_THAT(message, testing::HasSubstr("models/broken.dae: not a readable mesh"));
}

}  // namespace
}  // namespace twin::plant::plant_mesh_import_test
