// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/world/canvas.h"

namespace waymark::simulator {

/// Rows and columns of the sheets below.
inline constexpr int kSheetCells = 16;

/// A sheet of small pictures: the upper half boards (wood, metal, stone, leaves), the lower half
/// signs with words.
Canvas PaintOrnamentSheet(Random random);
/// A sheet of plain paints and cloths, nearly without detail; dark ones in the first quarter.
Canvas PaintPlainSheet(Random random);
/// 4 m x 4 m of wall without windows, and of roof tiles, both to be repeated.
Canvas PaintSideWall(Random random);
Canvas PaintRoof(Random random);

}  // namespace waymark::simulator
