// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/bench/session/walker.h"

namespace waymark::bench {

/// One measurement: a crowd that walked for a while.
struct Row {
  std::string layout;
  int phones = 0;
  double join_s = 0;
  double delivered = 0;  ///< share of the frames that were due
  double age_p50_ms = 0, age_p99_ms = 0;
  double leg_p50_ms = 0, leg_p99_ms = 0;
  double poses_per_s = 0, bytes_per_s = 0;                          ///< to one phone
  double server_cores = 0, gateway_cores = 0, generator_cores = 0;  ///< processor time per time
  double server_mib = 0, gateway_mib = 0;
};

/// Fills in what the phones heard. Everybody walks with three others who report between any two
/// frames, so one is due to every phone in every period, also in one that the server was too busy
/// for.
void Summarise(const Walked& walked, double frame_hz, Row& row);

void PrintHead();
void Print(const Row& row);
/// How each figure grows with the phones of a layout: the exponents of power laws fitted to it.
void PrintGrowth(const std::vector<Row>& rows);
/// Writes rows as comma-separated values, and latency and bytes against phones as SVG. Say whether
/// they could be written.
bool WriteCsv(const std::vector<Row>& rows, const std::string& path);
bool WritePlot(const std::vector<Row>& rows, const std::string& path);

}  // namespace waymark::bench
