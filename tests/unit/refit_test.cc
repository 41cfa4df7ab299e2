// A partition that is taken over, whatever has moved: the same bits as from a scene that is made
// anew.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "dacrt/dacrt.h"
#include "film.h"
#include "unit_test.h"

namespace dacrt::unit {
namespace {

// Few and many triangles, before and after all has been split, with calls of every length.
TEST(RefitTest, AWavingMeshIsTakenOverAndHasTheSameHits) {
  for (const uint32_t side : {4u, 30u, 90u}) {
    Film film(MakeSheets(3, side));
    film.Check(50);
    for (int frame = 0; frame < 6; ++frame) {
      SCOPED_TRACE("side " + std::to_string(side) + ", frame " + std::to_string(frame));
      Wave(film, static_cast<float>(frame));
      ASSERT_TRUE(film.Advance());
      film.Check(std::size_t{1} << (2 * frame));
      if (frame == 3) film.Check(20000);
    }
  }
}

TEST(RefitTest, ThreadsThatComeAtOnceFindTheSameHits) {
  Film film(MakeSheets(2, 100), 4);
  film.Check(5000);
  for (int frame = 0; frame < 10; ++frame) {
    Wave(film, static_cast<float>(frame));
    ASSERT_TRUE(film.Advance());
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) threads.emplace_back([&] { film.Check(3000); });
    for (std::thread& thread : threads) thread.join();
  }
}

TEST(RefitTest, AShearedMeshIsTakenOver) {
  Film film(MakeSheets(2, 60));
  film.Check(5000);
  film.ForEachVertex([](Float3& v) { v[0] += 0.2f * v[1]; });
  EXPECT_TRUE(film.Advance());
  film.Check(5000);
  for (int frame = 0; frame < 20; ++frame) {
    film.ForEachVertex([](Float3& v) { v[0] += 0.3f * v[1], v[2] += 0.3f * v[0]; });
    film.Advance();
    film.Check(1000);
  }
}

/// Sheets in which every triangle has vertices of its own, of which leaves keep one where several
/// are in one place: not in scenes of less than 16,384 triangles.
std::vector<Mesh> MakeTornSheets() {
  std::vector<Mesh> sheets = MakeSheets(2, 70);
  for (Mesh& mesh : sheets) {
    Mesh torn;
    torn.geometry_id = mesh.geometry_id;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      torn.Add(mesh.Corner(i, 0), mesh.Corner(i, 1), mesh.Corner(i, 2));
    }
    mesh = torn;
  }
  return sheets;
}

/// Moves each triangle of torn sheets its own way, the same one each time.
void Explode(Film& film, float step) {
  Random random(1);
  for (Mesh& mesh : film.meshes) {
    for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
      const Float3 away = random.Direction();
      for (std::size_t k = i; k < i + 3; ++k) {
        for (std::size_t axis = 0; axis < 3; ++axis) mesh.vertices[k][axis] += step * away[axis];
      }
    }
  }
  for (uint64_t& revision : film.revisions) ++revision;
}

// As long as its triangles stay together, and when they come apart by so little that it is taken
// over still.
TEST(RefitTest, ATornMeshHasTheSameHits) {
  Film film(MakeTornSheets());
  film.Check(20000);
  for (int frame = 0; frame < 4; ++frame) {
    Wave(film, static_cast<float>(frame));
    ASSERT_TRUE(film.Advance());
    film.Check(3000);
  }
  Explode(film, 0.0005f);
  ASSERT_TRUE(film.Advance());
  film.Check(3000);
}

TEST(RefitTest, AnExplodedMeshHasTheSameHits) {
  Film film(MakeTornSheets());
  film.Check(5000);
  for (int frame = 0; frame < 8; ++frame) {
    Explode(film, 0.02f);
    film.Advance();
    film.Check(3000);
  }
}

TEST(RefitTest, OneMeshOfMany) {
  Film film(MakeSheets(80, 8));
  film.Check(5000);
  for (std::size_t frame = 0; frame < 8; ++frame) {
    Mesh& mesh = film.meshes[37 * frame % film.meshes.size()];
    for (Float3& v : mesh.vertices) v[2] -= 0.02f;
    ++film.revisions[37 * frame % film.meshes.size()];
    ASSERT_TRUE(film.Advance());
    film.Check(2000);
  }
}

// Indices that change in place: the subsets hold the same triangles, wherever they are now.
TEST(RefitTest, IndicesThatChangeInPlaceHaveTheSameHits) {
  Film film(MakeSheets(1, 40));
  film.Check(5000);
  for (auto& triangle : film.meshes[0].triangles) std::swap(triangle[0], triangle[2]);
  for (std::size_t i = 0; i + 1 < 600; i += 2) {
    std::swap(film.meshes[0].triangles[i], film.meshes[0].triangles[i + 1]);
  }
  ++film.revisions[0];
  film.Advance();
  film.Check(2000);
}

// However often corners come apart, the memory stays what it was.
TEST(RefitTest, WhatIsLostComesBackWithANewPartition) {
  Film film(MakeSheets(1, 80));
  film.Check(100000);
  bool is_renewed = false;
  for (uint32_t frame = 0; frame < 60; ++frame) {
    Random random(frame);
    for (auto& triangle : film.meshes[0].triangles) {
      std::rotate(triangle.begin(), triangle.begin() + random.Below(3), triangle.end());
    }
    for (Float3& v : film.meshes[0].vertices) v[2] += random.Uniform(-0.01f, 0.01f);
    ++film.revisions[0];
    const std::size_t bytes = film.scene().KeptBytes();
    is_renewed |= !film.Advance();
    EXPECT_EQ(film.scene().KeptBytes(), bytes);
    film.Check(3000);
    EXPECT_LE(film.scene().KeptBytesUsed(), bytes);
  }
  EXPECT_TRUE(is_renewed);
}

}  // namespace
}  // namespace dacrt::unit
