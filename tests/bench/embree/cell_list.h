// Which cells of the matrix a setting measures, and what of them.
#pragma once

#include <string>
#include <vector>

#include "embree_results.h"

namespace dacrt::bench {

/// A part of the matrix: every combination of these.
struct Block {
  std::vector<std::string> scenes;
  std::vector<std::string> geometries;
  std::vector<std::string> isas;
  std::vector<std::string> kinds;
  std::vector<std::string> sizes;
  std::vector<int> threads;
};

/// A few minutes, with cells for every goal. Scenes that are not in the folder are left out.
std::vector<Block> ShortBlocks(const std::string& folder, const std::vector<int>& threads);

/// Hours.
std::vector<Block> FullBlocks(const std::string& folder, const std::vector<int>& threads);

/// Every cell of the blocks once; those that are measured together follow each other. Rays of four
/// a pixel are left out where calls do not hold whole pictures.
std::vector<Cell> CellsOf(const std::vector<Block>& blocks);

/// Whether the cells have the same scene, geometry, instruction set and threads.
bool AreMeasuredTogether(const Cell& a, const Cell& b);

/// Whether the cell is also measured on scenes that no rays have seen.
bool MeasuresOneShot(const Cell& cell);

/// Whether its rays are those that memory is measured with.
bool MeasuresMemory(const Cell& cell);

/// primary, shadow, ambient, diffuse: what means are taken over.
const std::vector<std::string>& MainKinds();

}  // namespace dacrt::bench
