// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "content_store/anchor_store.h"
#include "tests/bench/anchors/city.h"
#include "tests/bench/anchors/raw_store.h"

namespace waymark::bench {

double SecondsSince(std::chrono::steady_clock::time_point begin);
/// Sorts the values, of which there is one.
double Quantile(std::vector<double>& values, double q);

/// Creates them and requires that all were new.
void CreateIn(content::AnchorStore& store, std::span<const content::AnchorRecord> records);

/// Two ways by hand: a row and no more, and all the facts that the store keeps.
struct ByHand {
  std::unique_ptr<RawStore> row, same;
};

/// Gives both as many anchors as the store has, numbered from 0 on: an index that still fits the
/// database's memory is another task than one that does not.
void Fill(const ByHand& by_hand, const City& city, std::uint64_t anchors, std::size_t group);

/// Prints how fast groups are created by the store and by hand. Rounds of all three, one after the
/// other in turning order, so that a busy machine slows all. Anchors are numbered from `next` on;
/// returns the next number.
std::uint64_t CompareCreates(content::AnchorStore& store, const ByHand& by_hand, const City& city,
                             std::uint64_t next, std::size_t group);

/// Prints how fast many threads create, each one after the other: they share commits.
std::uint64_t MeasureSingleCreates(content::AnchorStore& store, const City& city,
                                   std::uint64_t next, int threads);

}  // namespace waymark::bench
