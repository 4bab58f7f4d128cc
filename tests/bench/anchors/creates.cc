// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/anchors/creates.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <thread>

#include "mapping/base/check.h"
#include "tests/bench/anchors/processor.h"
#include "tests/bench/anchors/raw_store.h"

namespace waymark::bench {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double Quantile(std::vector<double>& values, double q) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(q * static_cast<double>(values.size())))];
}

void CreateIn(content::AnchorStore& store, std::span<const content::AnchorRecord> records) {
  for (const auto& outcome : store.CreateMany(records)) {
    CHECK(outcome.ok() && std::holds_alternative<content::AnchorRecord>(*outcome), "{}",
          outcome.ok() ? "conflict" : ToString(outcome.error()));
  }
}

namespace {

/// Figures of some rounds: of the store, of the same facts by hand, of a bare row by hand.
using Figures = std::array<std::vector<double>, 3>;

/// Median of the rounds' ratios.
double Ratio(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < a.size(); ++i) ratios.push_back(a[i] / b[i]);
  return Quantile(ratios, 0.5);
}

void PrintFigures(std::size_t group, const Figures& rates, Figures processor_us) {
  const auto median = [](std::vector<double> values) { return Quantile(values, 0.5); };
  fmt::print(
      "durable creates in groups of {}: store {:.0f}/s; the same facts by hand {:.0f}/s, ratio "
      "{:.2f}; a bare row by hand {:.0f}/s, ratio {:.2f}. Processor of all for one: {:.0f}, "
      "{:.0f}, "
      "{:.0f} us. Medians of {} rounds\n",
      group, median(rates[0]), median(rates[1]), Ratio(rates[0], rates[1]), median(rates[2]),
      Ratio(rates[0], rates[2]), median(processor_us[0]), median(processor_us[1]),
      median(processor_us[2]), rates[0].size());
  std::fflush(stdout);
}

/// Two ways by hand.
struct ByHand {
  std::unique_ptr<RawStore> row, same;
};

ByHand OpenByHand(const std::string& location) {
  if (content::IsPostgresLocation(location)) {
    return {OpenRawPostgres(location, Facts::kRow), OpenRawPostgres(location, Facts::kSame)};
  }
  return {OpenRawSqlite(location + ".row", Facts::kRow),
          OpenRawSqlite(location + ".same", Facts::kSame)};
}

void Fill(const ByHand& by_hand, const City& city, std::uint64_t anchors, std::size_t group) {
  for (RawStore* store : {by_hand.same.get(), by_hand.row.get()}) {
    for (std::uint64_t first = store->Count(); first < anchors; first += group) {
      store->Create(city.Group(first, std::min<std::uint64_t>(group, anchors - first)));
    }
  }
}

std::uint64_t CompareCreates(content::AnchorStore& store, const ByHand& by_hand, const City& city,
                             std::uint64_t next, std::size_t group) {
  constexpr std::size_t kRounds = 25;  // a disk is moody
  const std::size_t groups = std::clamp<std::size_t>(8192 / group, 1, 64);
  Figures rates, processor_us;
  for (std::size_t round = 0; round < kRounds; ++round) {
    const auto records = city.Group(next, group * groups);
    const double count = static_cast<double>(records.size());
    next += records.size();
    for (std::size_t turn = 0; turn < 3; ++turn) {
      const std::size_t who = (round + turn) % 3;
      const double processor_s = ProcessorSeconds();
      const auto begin = Clock::now();
      for (std::size_t g = 0; g < groups; ++g) {
        const auto some = std::span(records).subspan(g * group, group);
        if (who == 0) CreateIn(store, some);
        if (who == 1) by_hand.same->Create(some);
        if (who == 2) by_hand.row->Create(some);
      }
      rates[who].push_back(count / SecondsSince(begin));
      processor_us[who].push_back(1e6 * (ProcessorSeconds() - processor_s) / count);
    }
  }
  PrintFigures(group, rates, processor_us);
  return next;
}

std::uint64_t MeasureSingleCreates(content::AnchorStore& store, const City& city,
                                   std::uint64_t next, int threads) {
  constexpr std::uint64_t kEach = 100;
  const auto records = city.Group(next, kEach * static_cast<std::uint64_t>(threads));
  std::vector<double> times_ms(records.size());
  const auto begin = Clock::now();
  {
    std::vector<std::jthread> workers;
    for (int t = 0; t < threads; ++t) {
      workers.emplace_back([&, t] {
        for (std::uint64_t i = 0; i < kEach; ++i) {
          const std::size_t n = static_cast<std::size_t>(t) * kEach + i;
          const auto start = Clock::now();
          CHECK(store.Create(records[n]).ok());
          times_ms[n] = 1e3 * SecondsSince(start);
        }
      });
    }
  }
  const double seconds = SecondsSince(begin);
  fmt::print("durable creates one by one, {} threads: {:.0f}/s, p50 {:.2f} ms, p99 {:.2f} ms\n",
             threads, static_cast<double>(records.size()) / seconds, Quantile(times_ms, 0.5),
             Quantile(times_ms, 0.99));
  return next + records.size();
}

}  // namespace

void MeasureCreates(content::AnchorStore& store, const std::string& location, const City& city,
                    std::uint64_t anchors, std::size_t group, std::size_t fill_group) {
  const ByHand by_hand = OpenByHand(location);
  Fill(by_hand, city, anchors, fill_group);
  std::uint64_t next = anchors + (std::uint64_t{1} << 40);  // numbers that nobody has
  for (const std::size_t size : {std::size_t{16}, std::size_t{64}, group}) {
    next = CompareCreates(store, by_hand, city, next, size);
  }
  for (const int threads : {1, 16, 64}) next = MeasureSingleCreates(store, city, next, threads);
}

}  // namespace waymark::bench
