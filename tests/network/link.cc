// SPDX-License-Identifier: Apache-2.0
#include "tests/network/link.h"

#include <algorithm>

namespace waymark::network {

std::optional<Instant> Link::Carry(std::size_t bytes, Instant now) {
  if (!begin_) begin_ = now;
  ++counters_.packets;
  counters_.bytes += bytes;
  if (is_cut_ || IsOut(now) || Draw(0, 1) < LossAt(now)) {
    ++counters_.lost;
    return std::nullopt;
  }
  Instant out = now;
  if (options_.rate_bps > 0) {
    const Instant start = std::max(now, free_);
    if (start - now > options_.queue) {
      ++counters_.dropped;
      return std::nullopt;
    }
    const std::chrono::duration<double> busy(8 * static_cast<double>(bytes) / options_.rate_bps);
    free_ = start + std::chrono::duration_cast<Instant::duration>(busy);
    out = free_;
  }
  const std::chrono::duration<double, std::micro> jitter(options_.jitter);
  out += options_.delay + std::chrono::duration_cast<Instant::duration>(jitter * Draw(-1, 1));
  if (Draw(0, 1) >= options_.overtaking) last_ = out = std::max(out, last_);
  return out;
}

bool Link::IsOut(Instant now) const {
  if (options_.outage_every.count() <= 0) return false;
  const auto into = (now - *begin_) % options_.outage_every;
  return into >= options_.outage_every - options_.outage;
}

double Link::LossAt(Instant now) {
  if (options_.worst_loss <= options_.loss) return options_.loss;
  const std::int64_t second =
      std::chrono::duration_cast<std::chrono::seconds>(now - *begin_).count();
  if (second != loss_second_) {
    loss_second_ = second;
    loss_ = Draw(options_.loss, options_.worst_loss);
  }
  return loss_;
}

}  // namespace waymark::network
